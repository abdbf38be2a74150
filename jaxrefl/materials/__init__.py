"""Measured complex indices of named materials, by wavelength, each with where it comes from.

    gold = material("Au")                    # the first of its sources
    n, k = gold(jnp.linspace(400, 700, 81))
    material("gold", source="McPeak")        # another measurement
    print(gold.citation, gold.range_nm, spread("Au").reflectance)

A `Material` is a dispersion model, see `jaxrefl.dispersion`. Convention n + i k, k >= 0.
"""

from .database import from_database as from_database
from .file import from_csv as from_csv
from .named import Material as Material
from .named import Provenance as Provenance
from .named import material as material
from .named import materials as materials
from .named import provenance as provenance
from .spread import Spread as Spread
from .spread import computed_spread as computed_spread
from .spread import spread as spread
