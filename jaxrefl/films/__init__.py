"""Thin films: coherent layers between two half-spaces (`film`), and thick layers without interference (`incoherent`).

Scalar formulas that broadcast, over arrays whose first axis is that of the layers.
"""

from .coherent import Film as Film
from .coherent import Phases as Phases
from .coherent import absorbed as absorbed
from .coherent import ellipsometry as ellipsometry
from .coherent import film as film
from .coherent import phases as phases
from .given import stack as stack
from .incoherent import Powers as Powers
from .incoherent import incoherent as incoherent
