"""Albedos: integrals of a reflection model over the hemisphere."""

from __future__ import annotations

from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from .brdf.protocol import BRDF
from .params import checked
from .quadrature import HemisphereRule, integrate
from .vec import Vec3


@checked(cos_theta_o="[0, 1]")
def hemispherical_directional_albedo(
    brdf: BRDF, cos_theta_o: Float[ArrayLike, ""], rule: HemisphereRule
) -> Float[Array, "*C"]:
    """Hemispherical-directional albedo rho_hd(wo) = int f(wi, wo) cos theta_i dwi.

    Args:
        brdf: reflection model, f(wi, wo) in 1/sr.
        cos_theta_o: cosine of the direction of view, [0, 1]; the view lies in the x-z plane.
        rule: from `jaxrefl.quadrature.hemisphere_rule`.

    Returns:
        (C,) or scalar: the radiance seen in a uniform environment of radiance 1; > 1 creates energy.

    Differentiable in the model's parameters and, through the model, in cos_theta_o.
    Source: LAMBERT-FRESNEL, rho_hd(omega_o).
    """
    wo = Vec3.from_spherical(cos_theta_o, 0.0)
    return integrate(lambda wi: brdf(wi, wo) * wi.z, rule)
