"""Dispersion: from a vacuum wavelength to the complex index n + i k of a medium, as differentiable pytrees.

    glass = Sellmeier(b=[1.03961212, 0.231792344, 1.01046945], c=[0.00600069867, 0.0200179144, 103.560653])
    n, k = glass(587.5618)

A model is any callable that takes ``wavelength_nm`` and returns an `Index`; those here are pytrees whose coefficients
are leaves. Wavelengths are nanometres, of any shape; the coefficients of closed forms are in micrometres, as they are
published. n and k are those of the medium against vacuum (catalogues of glass: against air); `relative` divides two.

A model knows its range or has none. Outside it a concrete wavelength is an error that names the range; a traced one
(under `jit`, `grad` or `vmap`) is held to the nearer end, with derivative 0, and `in_range` tells which ones were.
"""

from .closed import Cauchy as Cauchy
from .closed import Constant as Constant
from .closed import Devore as Devore
from .closed import Polynomial as Polynomial
from .closed import Sellmeier as Sellmeier
from .closed import WithExtinction as WithExtinction
from .derived import LINES_NM as LINES_NM
from .derived import abbe_number as abbe_number
from .derived import group_index as group_index
from .derived import normal_reflectance as normal_reflectance
from .fit import Fit as Fit
from .fit import fit_drude_lorentz as fit_drude_lorentz
from .index import Index as Index
from .index import from_permittivity as from_permittivity
from .index import relative as relative
from .limits import Model as Model
from .limits import in_range as in_range
from .lorentz import HC_EV_NM as HC_EV_NM
from .lorentz import DrudeLorentz as DrudeLorentz
from .numbered import NumberedFormula as NumberedFormula
from .numbered import from_formula as from_formula
from .table import Tabulated as Tabulated
