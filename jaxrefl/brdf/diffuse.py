"""Rough diffuse models: Oren-Nayar, EON, Burley."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..safe import safe_divide, safe_power, safe_sqrt
from ..vec import Vec3, dot
from .common import above, positive, tangential

_C1 = 0.5 - 2 / (3 * jnp.pi)
_C2 = 2 / 3 - 28 / (15 * jnp.pi)


@pytree
class OrenNayar:
    """Qualitative Oren-Nayar f = rho / pi (A + B max(0, cos dphi) sin alpha tan beta).

    A = 1 - sigma^2 / (2 (sigma^2 + 0.33)), B = 0.45 sigma^2 / (sigma^2 + 0.09), alpha and beta the larger and the
    smaller angle. Reciprocal; the albedo exceeds rho at grazing incidence (1.005 rho at sigma = 0.3), and f diverges
    where both directions graze. Source: Oren and Nayar, SIGGRAPH 1994, eq 30.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="diffuse reflectance of a facet")
    sigma: Any = param("[0, 1.5708]", unit="rad", default=0.3, doc="standard deviation of the facets' slope angle")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        rho, sigma = floats(self.rho, self.sigma)
        s2 = sigma * sigma
        a, b = 1 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09)
        # cos dphi sin alpha tan beta = sin theta_i sin theta_o cos dphi / max(mu_i, mu_o): no azimuth is needed
        rough = safe_divide(positive(tangential(wi, wo)), jnp.where(wi.z > wo.z, wi.z, wo.z))
        return above(wi, wo, rho / jnp.pi * (a + b * rough))


def _g_fon(mu: Array) -> Array:
    """G_F = sin (theta - sin cos) + 2/3 (tan (1 - sin^3) - sin), in a form that is finite at both ends."""
    sine = safe_sqrt((1 - mu) * (1 + mu))
    theta = jnp.arctan2(sine, mu)
    bracket = sine * mu * (1 + sine + sine * sine) / (1 + sine)
    return sine * (theta - sine * mu) + 2 / 3 * (bracket - sine)


@pytree
class EON:
    """Energy-preserving Oren-Nayar: Fujii's lobe and a multiple-scattering lobe that restores what it loses.

    f = (rho / pi) A (1 + r s / t) + (rho_ms / pi) (1 - E_i)(1 - E_o) / (1 - <E>), A = 1 / (1 + (1/2 - 2/(3 pi)) r).
    Reciprocal; the albedo is rho E + rho_ms (1 - E), exactly 1 for rho = 1.
    Source: Portsmouth, Kutz and Hill, JCGT 14(1), 2025.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="single-scattering reflectance")
    roughness: Any = param("[0, 1]", default=0.5, doc="r")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        rho, r = floats(self.rho, self.roughness)
        s = tangential(wi, wo)
        larger = jnp.where(wi.z > wo.z, wi.z, wo.z)
        a = 1 / (1 + _C1 * r)
        single = 1 + r * jnp.where(s > 0, safe_divide(s, larger), s)
        lost_average = a * r * (_C1 - _C2)  # 1 - <E>; of 1 - E = A r (c1 - G / pi) the factors A r cancel
        rho_ms = rho * rho * (1 - lost_average) / (1 - rho * lost_average)
        multiple = a * r * (_C1 - _g_fon(wi.z) / jnp.pi) * (_C1 - _g_fon(wo.z) / jnp.pi) / (_C1 - _C2)
        return above(wi, wo, (rho * (a * single) + rho_ms * multiple) / jnp.pi)


@pytree
class Burley:
    """Disney's diffuse f = rho / pi (1 + (F90 - 1)(1 - mu_i)^5)(1 + (F90 - 1)(1 - mu_o)^5).

    F90 = 1/2 + 2 roughness cos^2 theta_d. Reciprocal; with a rough surface the albedo exceeds rho near grazing.
    Source: Burley, SIGGRAPH course 2012.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="base colour")
    roughness: Any = param("[0, 1]", default=0.5, doc="roughness")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        rho, roughness = floats(self.rho, self.roughness)
        excess = roughness * (1 + dot(wi, wo)) - 0.5  # 2 cos^2 theta_d = 1 + wi . wo
        lit, seen = (1 + excess * safe_power(1 - mu, 5) for mu in (wi.z, wo.z))
        return above(wi, wo, rho / jnp.pi * (lit * seen))


def _darkening(x: Array) -> Array:
    """1 - (1 - x)^5, to full accuracy at grazing angles too."""
    return x * (5 - x * (10 - x * (10 - x * (5 - x))))


@pytree
class AshikhminShirleyDiffuse:
    """Diffuse part 28 rho / (23 pi) (1 - f0)(1 - (1 - mu_i / 2)^5)(1 - (1 - mu_o / 2)^5) of Ashikhmin and Shirley.

    Reciprocal; the albedo is rho (1 - f0)(1 - (1 - mu / 2)^5). Source: Ashikhmin and Shirley, JGT 5(2), 2000.
    """

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="diffuse reflectance")
    f0: Any = param("[0, 1]", spectral=True, default=0.0, doc="reflectance of the specular layer at normal incidence")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        rho, f0 = floats(self.rho, self.f0)
        lit, seen = (_darkening(0.5 * mu) for mu in (wi.z, wo.z))
        return above(wi, wo, 28 / (23 * jnp.pi) * rho * (1 - f0) * (lit * seen))
