"""From the unit square to the hemisphere: directions with a density, and what a model's ``sample`` returns."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from .params import floats
from .safe import safe_sqrt
from .vec import Vec3


class Sample(NamedTuple):
    """Direction drawn by a model."""

    wi: Vec3
    weight: Array
    """f |cos theta_i| / pdf, (C,) or scalar; 0 below the surface."""
    pdf: Array
    """Density of wi, 1/sr; over the whole sphere where a lobe reaches below the surface."""


def cosine_hemisphere(u1: Float[ArrayLike, ""], u2: Float[ArrayLike, ""]) -> Vec3:
    """Direction above the surface with the density cos theta / pi; azimuth 2 pi u1, cos theta = sqrt(1 - u2)."""
    u1, u2 = floats(u1, u2)
    phi, sine = 2 * jnp.pi * u1, safe_sqrt(u2)
    return Vec3(sine * jnp.cos(phi), sine * jnp.sin(phi), safe_sqrt(1 - u2))


def tangents(axis: Vec3) -> tuple[Vec3, Vec3]:
    """Two unit vectors that make a right-handed frame with a unit axis. Source: Duff et al., JCGT 6(1), 2017."""
    sign = jnp.where(axis.z < 0, -1.0, 1.0)
    a = -1 / (sign + axis.z)
    b = axis.x * axis.y * a
    one = jnp.ones_like(b)
    return (
        Vec3(one + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        Vec3(b, sign + axis.y * axis.y * a, -axis.y),
    )


def power_lobe(axis: Vec3, exponent: Float[ArrayLike, ""], u1: Float[ArrayLike, ""], u2: Float[ArrayLike, ""]) -> Vec3:
    """Direction at an angle beta < 90 degrees from a unit axis, with the density (n + 1) / (2 pi) cos^n beta.

    u2 in [0, 1); the sine comes from 1 - cos, so that a narrow lobe keeps its digits.
    """
    exponent, u1, u2 = floats(exponent, u1, u2)
    logarithm = jnp.log1p(-u2) / (exponent + 1)
    cosine, rest = jnp.exp(logarithm), -jnp.expm1(logarithm)
    sine, phi = safe_sqrt(rest * (1 + cosine)), 2 * jnp.pi * u1
    t, s = tangents(axis)
    return t * (sine * jnp.cos(phi)) + s * (sine * jnp.sin(phi)) + axis * cosine
