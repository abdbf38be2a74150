"""Fresnel's equations: exact (`exact`), approximated (`approximate`), averaged over the hemisphere (`average`).

Every function is a scalar formula that broadcasts over its arguments.
"""

from .approximate import d3d9 as d3d9
from .approximate import f82_tint as f82_tint
from .approximate import gulbrandsen as gulbrandsen
from .approximate import gulbrandsen_inverse as gulbrandsen_inverse
from .approximate import lazanyi as lazanyi
from .approximate import schlick as schlick
from .approximate import schlick_dielectric as schlick_dielectric
from .average import average_d3d9 as average_d3d9
from .average import average_dielectric as average_dielectric
from .average import average_schlick as average_schlick
from .exact import Amplitudes as Amplitudes
from .exact import amplitudes as amplitudes
from .exact import brewster_angle as brewster_angle
from .exact import conductor as conductor
from .exact import conductor_sp as conductor_sp
from .exact import cos_theta_t as cos_theta_t
from .exact import critical_angle as critical_angle
from .exact import dielectric as dielectric
from .exact import dielectric_sp as dielectric_sp
from .exact import f0_conductor as f0_conductor
from .exact import f0_dielectric as f0_dielectric
from .exact import transmittance_sp as transmittance_sp
