"""From the unit square to the hemisphere: directions with a density, what a ``sample`` returns; places in a pixel."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
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


def sample_position(seed: Any, x: Any, y: Any, sample: Any) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Place of a sample in its pixel, in [0, 1): a function of these four integers alone.

    The first two dimensions of Sobol's sequence, scrambled per pixel: of the first 2^k samples one lies in each of the
    2^k equal boxes of any shape.
    """
    key = functools.reduce(jax.random.fold_in, (x, y), jax.random.key(seed))
    scramble = jax.random.bits(key, (2,), jnp.uint32)
    index, first, second = jnp.asarray(sample, jnp.uint32), jnp.uint32(0), jnp.uint32(0)
    direction = np.uint32(1 << 31)
    for bit in range(32):
        digit = (index >> bit) & 1
        first = first ^ (digit * np.uint32(1 << (31 - bit)))
        second = second ^ (digit * direction)
        direction ^= direction >> np.uint32(1)
    unit = 2.0**-24
    return tuple(((u ^ s) >> 8).astype(jnp.float32) * unit for u, s in ((first, scramble[0]), (second, scramble[1])))
