"""The D3D9Client model as a reflection model, and a repaired form of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from .. import fresnel
from ..d3d9 import max_norm, total_reflection
from ..params import floats, param, pytree
from ..safe import safe_divide
from ..vec import Vec3
from .common import above


@pytree
class _Layer:
    """Parameters and mirror part of either form."""

    diffuse: Any = param("[0, 1]", spectral=True, default=1.0, doc="d, diffuse colour")
    metallic: Any = param("[0, 1]", spectral=True, default=0.0, doc="lambda, reflectivity colour")
    r0: Any = param("[0, 1]", default=0.04, doc="R0, offset")
    m: Any = param("[0, 1]", default=0.96, doc="m, multiplier; R0 + m above 1 reflects more than it receives")
    p: Any = param("[0, inf)", default=5.0, doc="p, exponent")
    specular: Any = param("[0, 1]", spectral=True, default=1.0, doc="s, colour of the Fresnel reflection")

    def _reflectance(self, mu: Array) -> Array:
        return fresnel.d3d9(mu, self.r0, self.m, self.p)

    def mirror(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """lambda (1 - R) + s R, eq (5)."""
        return total_reflection(self.metallic, self._reflectance(cos_theta_o), 1.0, self.specular)


@pytree
class D3D9(_Layer):
    """Diffuse d (1 - |lambda|) / pi beside the mirror part lambda (1 - R) + s R, R = R0 + m (1 - cos theta)^p.

    By (6) the base is not dimmed by what the layer reflects: with d = 1 the albedo is 1 + (1 - lambda) R, up to 2 at
    grazing. With ``sun_fresnel`` the base is multiplied by 1 - R of the light, (8): a beam is then conserved, and the
    model is not reciprocal. |lambda| is the largest channel (S3). Source: D3D9 (3)-(6), (8).
    """

    sun_fresnel: bool = dataclasses.field(default=False, metadata={"static": True})

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        diffuse, metallic = floats(self.diffuse, self.metallic)
        base = diffuse * (1 - max_norm(metallic)) / jnp.pi
        return above(wi, wo, base * (1 - self._reflectance(jnp.abs(wi.z)) if self.sun_fresnel else jnp.ones_like(wi.z)))


@pytree
class D3D9Repaired(_Layer):
    """D3D9 with the base between two Fresnel factors: f = d (1 - lambda)(1 - R(wi))(1 - R(wo)) / (pi (1 - <R>)).

    The same parameters and mirror part. Reciprocal, and for R0 + m <= 1 the albedo is at most 1, exactly 1 for d = 1,
    s = 1: <R> = R0 + 2 m / ((p + 1)(p + 2)) is the average of R. lambda counts per channel, no norm is needed.
    """

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        diffuse, metallic = floats(self.diffuse, self.metallic)
        lit, seen = (1 - self._reflectance(jnp.abs(mu)) for mu in (wi.z, wo.z))
        average = fresnel.average_d3d9(self.r0, self.m, self.p)
        return above(wi, wo, diffuse * (1 - metallic) * safe_divide(lit * seen, jnp.pi * (1 - average)))
