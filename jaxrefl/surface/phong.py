"""Phong's local model, in the form of OpenGL that JHU gives."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..geometry import Hit
from ..params import param, pytree
from ..safe import exp_log_power
from ..vec import Vec3, dot, normalize, reflect
from .protocol import Local, Weights

HIGHLIGHTS = ("half_vector", "mirror")


def phong_lobe(n: Vec3, wi: Vec3, wo: Vec3, shininess: Any) -> Float[Array, ""]:
    """Phong's lobe max(0, R . V)^n, with R the mirror direction of the light.

    Source: JHU, "Specular Component" (without the clamp there, S31).
    """
    return exp_log_power(dot(reflect(wi, n), wo), shininess)


def blinn_lobe(n: Vec3, wi: Vec3, wo: Vec3, shininess: Any) -> Float[Array, ""]:
    """Blinn's lobe max(0, H . N)^n, H = (L + V) / |L + V|; 0 at L = -V, where H does not exist (S34).

    With the same n twice as wide as Phong's lobe at its half maximum: n_Blinn = 4 n_Phong look alike (S26). Source:
    JHU, "Local Illumination Equation".
    """
    return exp_log_power(dot(normalize(wi + wo), n), shininess)


@pytree
class Phong:
    """Local illumination E_m + I_a k_a + sum_j f_j S_j (I_dj k_d (L . N) + I_sj k_s (H . N)^n), and no ray goes on.

    Diffuse and specular light both need N . L > 0, which no slide says in a formula (S31). ``highlight`` is
    "half_vector", (H . N)^n, or "mirror", (R . V)^n. Nothing bounds k_a + k_d + k_s (S32). The diffuse part is
    Lambert's law with irradiance pi I_d (S20-S22). Source: JHU, "Local Illumination Equation"; Bui Tuong Phong 1975.
    """

    k_d: Any = param("[0, inf)", spectral=True, default=0.7, doc="diffuse coefficient")
    k_s: Any = param("[0, inf)", spectral=True, default=0.0, doc="specular coefficient")
    shininess: Any = param("[0, inf)", default=50.0, doc="exponent n")
    k_a: Any = param("[0, inf)", spectral=True, default=0.0, doc="ambient coefficient")
    emission: Any = param("[0, inf)", spectral=True, default=0.0, doc="E_m")
    highlight: str = dataclasses.field(default="half_vector", metadata={"static": True, "choices": HIGHLIGHTS})

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Diffuse and specular response, gated at N . L > 0."""
        cos_theta_i = dot(hit.n, wi)
        lit = cos_theta_i > 0
        lobe = blinn_lobe if self.highlight == "half_vector" else phong_lobe
        highlight = jnp.where(lit, lobe(hit.n, wi, hit.wo, self.shininess), 0.0)
        return Local(self.k_d * jnp.where(lit, cos_theta_i, 0.0), self.k_s * highlight)

    def weights(self, hit: Hit) -> Weights:
        """Everything is local."""
        return Weights(emitted=self.emission, ambient=self.k_a)
