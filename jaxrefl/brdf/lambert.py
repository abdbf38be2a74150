"""The ideal diffuse reflector."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..sampling import Sample, cosine_hemisphere
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

    def sample(self, wo: Vec3, u1: Array, u2: Array, u_lobe: Array) -> Sample:
        """Cosine-weighted direction: every weight is rho. ``u_lobe`` is not used, there is one lobe."""
        (rho,) = floats(self.rho)
        wi = cosine_hemisphere(u1, u2)
        return Sample(wi, jnp.where(wo.z < 0, jnp.zeros_like(rho), rho), self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float[Array, ""]:
        """Density cos theta_i / pi of `sample`, 1/sr."""
        return jnp.where(wi.z < 0, 0.0, wi.z / jnp.pi)
