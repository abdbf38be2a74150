"""Phong's lobe and Blinn's: as JHU and OpenGL have them, and as reflection models."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..safe import safe_divide
from ..sampling import Sample, power_lobe
from ..vec import Vec3
from .common import above, from_mirror, from_normal

HIGHLIGHTS = ("mirror", "half_vector")


def lobe(away: Array, shininess: Array) -> Float[Array, ""]:
    """max(0, cos)^n of 1 - cos, 0 behind the lobe for n = 0 too."""
    before, last = away < 1, 1 - float(jnp.finfo(away.dtype).epsneg)
    # the compiler may evaluate ``before`` twice and come to two answers by a rounding; at ``last`` either is right
    return jnp.where(before, jnp.exp(shininess * jnp.log1p(-jnp.where(before, away, last))), 0.0)


@pytree
class ModifiedPhong:
    """Modified Phong f = k_s (n + 2) / (2 pi) max(0, R . V)^n.

    Reciprocal. The albedo is k_s at normal incidence, k_s cos theta for n -> inf, and never above k_s.
    Source: Lafortune and Willems 1994; Arvo 1995 for the albedo.
    """

    chart = "mirror"
    k_s: Any = param("[0, 1]", spectral=True, default=1.0, doc="albedo at normal incidence")
    shininess: Any = param("[0, inf)", default=10.0, doc="exponent n")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        k_s, n = floats(self.k_s, self.shininess)
        return above(wi, wo, k_s * ((n + 2) / (2 * jnp.pi) * lobe(from_mirror(wi, wo), n)))

    def sample(self, wo: Vec3, u1: Array, u2: Array, u_lobe: Array) -> Sample:
        """Direction in the lobe, below the surface too, with the weight 0 there. ``u_lobe`` is not used."""
        k_s, n = floats(self.k_s, self.shininess)
        wi = power_lobe(Vec3(-wo.x, -wo.y, wo.z), n, u1, u2)
        return Sample(wi, above(wi, wo, k_s * ((n + 2) / (n + 1) * wi.z)), self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float[Array, ""]:
        """Density (n + 1) / (2 pi) (R . V)^n of `sample`, 1/sr; over the sphere it integrates to 1."""
        (n,) = floats(self.shininess)
        return (n + 1) / (2 * jnp.pi) * lobe(from_mirror(wi, wo), n)


@pytree
class BlinnPhong:
    """Blinn-Phong f = k_s (n + 2)(n + 4) / (8 pi (2^(-n/2) + n)) (N . H)^n, whose albedo at normal incidence is k_s.

    Reciprocal; the albedo falls with the angle. Of the factors in circulation (n + 8) / (8 pi) is an approximation of
    this one and (n + 2) / (2 pi) belongs to a distribution of normals. Source: Giesen 2009.
    """

    chart = "half"
    k_s: Any = param("[0, 1]", spectral=True, default=1.0, doc="albedo at normal incidence")
    shininess: Any = param("[0, inf)", default=10.0, doc="exponent n")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        k_s, n = floats(self.k_s, self.shininess)
        scale = (n + 2) / (8 * jnp.pi) * ((n + 4) / (jnp.exp2(-0.5 * n) + n))
        return above(wi, wo, k_s * (scale * lobe(from_normal(wi, wo), n)))


@pytree
class LiteralPhong:
    """What JHU and OpenGL display, as an effective BRDF: k_d / pi + k_s lobe / (pi cos theta_i).

    The light of intensity I gives the irradiance pi I cos theta_i, so that white Lambert shows I. ``highlight`` is
    "mirror", (R . V)^n (Phong 1975), or "half_vector", (N . H)^n (OpenGL). The highlight has no cosine: f diverges at
    grazing light, f(wi, wo) / f(wo, wi) = cos theta_o / cos theta_i, and the flux ratio of a beam exceeds 1.
    Source: JHU, "Local Illumination Equation".
    """

    k_d: Any = param("[0, inf)", spectral=True, default=0.0, doc="diffuse coefficient")
    k_s: Any = param("[0, inf)", spectral=True, default=1.0, doc="specular coefficient")
    shininess: Any = param("[0, inf)", default=10.0, doc="exponent n")
    highlight: str = dataclasses.field(default="mirror", metadata={"static": True, "choices": HIGHLIGHTS})

    @property
    def chart(self) -> str:
        """Where the lobe is."""
        return "mirror" if self.highlight == "mirror" else "half"

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        k_d, k_s, n = floats(self.k_d, self.k_s, self.shininess)
        away = from_mirror if self.highlight == "mirror" else from_normal
        highlight = safe_divide(lobe(away(wi, wo), n), wi.z)
        return above(wi, wo, (k_d + k_s * highlight) / jnp.pi)
