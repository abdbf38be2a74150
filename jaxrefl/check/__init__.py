"""Numeric validation, the content of `jaxrefl check`: the library against the oracle table that is shipped with it.

The rows are in the data file ``jaxrefl/data/oracles.json``: decimal strings of 20 digits, computed without this library
at 40 (section J: by colour-science, in double precision). No oracle number stands in the code. For each block of the
file there is one evaluator, a small function that computes, vectorised over the rows, the columns of the block from its
inputs:

    table           reads the file, holds the evaluators, compares
    numerics        slopes, minima
    interface       A, B: dielectrics and conductors
    approximations  C: Schlick's family, fits, extrema
    albedos, films  E: albedos of the models, a coated glass
    colours         J: colours of measured metals
    energy          D, E, G: averages, the Lambertian pi, the D3D9 furnace, Phong as displayed
    bounces         H: the bounce series
    pictures, rays, edges
                    I: scenes, by tracing rays through them

A value must agree to the block's rtol or 1e-13, whichever is larger, a derivative to 1e-11; where an evaluator says so,
less.
"""

from . import albedos, approximations, bounces, colours, edges, energy, films, interface, pictures, rays  # noqa: F401  # each registers its evaluators
from .table import Row as Row
from .table import block_names as block_names
from .table import evaluate as evaluate
from .table import run as run
from .table import select as select
