"""What several models have in common."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..vec import Vec3


def above(wi: Vec3, wo: Vec3, value: Array) -> Array:
    """A value where both directions are above the surface, 0 elsewhere."""
    return jnp.where((wi.z < 0) | (wo.z < 0), jnp.zeros_like(value), value)


def from_mirror(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """1 - R . V, R the mirror direction of one and V the other: half the square of their distance.

    Accurate at the peak of a lobe, where a cosine would have lost what tells it from 1.
    """
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z - wo.z
    return 0.5 * (x * x + y * y + z * z)


def from_normal(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """1 - H . N for directions above the surface, accurate as `from_mirror`; 1 at wi = -wo, where H does not exist."""
    x, y, z = wi.x + wo.x, wi.y + wo.y, positive(wi.z + wo.z)
    length2 = x * x + y * y + z * z
    safe = length2 > 0
    length = jnp.sqrt(jnp.where(safe, length2, 1.0))
    x, y, z = x / length, y / length, z / length
    return jnp.where(safe, (x * x + y * y) / (1 + z), 1.0)


def tangential(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """sin theta_i sin theta_o cos(phi_i - phi_o), which needs no azimuth."""
    return wi.x * wo.x + wi.y * wo.y


def positive(x: Array) -> Array:
    """max(0, x) whose derivative at a tie is one-sided."""
    return jnp.where(x > 0, x, 0.0)
