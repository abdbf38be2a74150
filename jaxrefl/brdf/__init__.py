"""Reflection models: pure functions f(wi, wo) in 1/sr, cosine not included, in the local frame (z is the normal).

A model is a class decorated with `jaxrefl.params.pytree`, with fields made by `jaxrefl.params.param` and one method
``__call__(wi, wo) -> (C,)``; ``mirror(cos_theta_o)`` and ``through(cos_theta_o)`` are its delta parts, ``chart`` and
``kinks()`` tell the integrals where it is peaked and kinked, if it has any of these. There is no base class: a user's
own model is a few lines in the user's own file.
"""

from .coat import CoatedLambert as CoatedLambert
from .coat import Slab as Slab
from .combine import Mix as Mix
from .combine import Scaled as Scaled
from .d3d9 import D3D9 as D3D9
from .d3d9 import D3D9Repaired as D3D9Repaired
from .diffuse import EON as EON
from .diffuse import AshikhminShirleyDiffuse as AshikhminShirleyDiffuse
from .diffuse import Burley as Burley
from .diffuse import OrenNayar as OrenNayar
from .lambert import Lambert as Lambert
from .phong import BlinnPhong as BlinnPhong
from .phong import LiteralPhong as LiteralPhong
from .phong import ModifiedPhong as ModifiedPhong
from .planetary import LommelSeeliger as LommelSeeliger
from .planetary import Minnaert as Minnaert
from .protocol import BRDF as BRDF
