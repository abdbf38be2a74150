"""Smooth interfaces: a coat on a diffuse base, and a slab."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from .. import fresnel
from ..params import floats, param, pytree
from ..safe import safe_divide
from ..vec import Vec3
from .common import above


@pytree
class CoatedLambert:
    """Smooth dielectric over Lambert, all reflections inside the coat summed.

    f = rho (1 - F(theta_i))(1 - F(theta_o)) / (pi n^2 (1 - rho F_in)) beside the mirror part F; F_in is the average
    reflectance from inside. Reciprocal; the albedo is F + (1 - F) rho (1 - F_in) / (1 - rho F_in), exactly 1 for
    rho = 1: the conserving, reciprocal counterpart of D3D9 (6) and (8). Source: Saunderson 1942; Wolff 1994.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="reflectance of the base")
    eta: Any = param("[1, inf)", default=1.5, doc="index of the coat")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        rho, eta = floats(self.rho, self.eta)
        lit, seen = (1 - fresnel.dielectric(jnp.abs(mu), eta) for mu in (wi.z, wo.z))
        # n^2 (1 - rho F_in), with 1 - F_in = (1 - F_out) / n^2 by reversal: nothing is lost where F_in is almost 1
        kept = eta * eta * (1 - rho) + rho * (1 - fresnel.average_dielectric(eta))
        return above(wi, wo, rho / kept * (lit * seen / jnp.pi))

    def mirror(self, cos_theta_o: Array) -> Float[Array, ""]:
        """Reflectance F of the coat."""
        return fresnel.dielectric(cos_theta_o, self.eta)


@pytree
class Slab:
    """Plane-parallel plate without interference: R and T of all its internal reflections, averaged over polarisations.

    Per polarisation T = (1 - F)^2 tau / (1 - F^2 tau^2), R = F + F tau T, tau = exp(-depth / cos theta_t). Nothing is
    scattered: f = 0. Averaging F before the sum, instead of R and T after it, is wrong (0.164 for 0.152 at 60 degrees).
    """

    eta: Any = param("[1, inf)", default=1.5, doc="index of the plate")
    depth: Any = param("[0, inf)", spectral=True, default=0.0, doc="optical depth across it, sigma_a times thickness")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        (depth,) = floats(self.depth)
        return jnp.zeros_like(depth) * wi.z

    def _both(self, cos_theta: Array) -> tuple[Array, Array]:
        depth, eta, mu = floats(self.depth, self.eta, cos_theta)
        way = safe_divide(depth, fresnel.cos_theta_t(mu, eta))  # no plate at all at grazing incidence for eta = 1
        tau, lost = jnp.exp(-way), -jnp.expm1(-way)
        r, t = jnp.zeros_like(way), jnp.zeros_like(way)
        for f in fresnel.dielectric_sp(mu, eta):
            enters = 1 - f
            one = safe_divide(enters * enters * tau, (enters + f * lost) * (1 + f * tau))
            r, t = r + 0.5 * (f + f * tau * one), t + 0.5 * one
        return r, t

    def mirror(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Reflectance of the plate."""
        return self._both(cos_theta_o)[0]

    def through(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Transmittance of the plate; the ray leaves parallel to how it came."""
        return self._both(cos_theta_o)[1]
