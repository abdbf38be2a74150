"""The ideal diffuse reflector."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..vec import Vec3


@pytree
class Lambert:
    """Lambertian BRDF f = rho / pi.

    The pi is the integral of cos theta over the hemisphere: f constant and int f cos theta = rho leave no other
    choice. rho is the hemispherical-directional albedo and, f being reciprocal, the directional-hemispherical and the
    bihemispherical one as well (the source uses rho_hd and R for all three, S42). Source: LAMBERT-FRESNEL, f_r = R /
    pi.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="diffuse reflectance")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        (rho,) = floats(self.rho)
        return jnp.where((wi.z < 0) | (wo.z < 0), jnp.zeros_like(rho), rho / jnp.pi)
