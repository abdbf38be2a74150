"""What several models have in common."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..vec import Vec3


def above(wi: Vec3, wo: Vec3, value: Array) -> Array:
    """A value where both directions are above the surface, 0 elsewhere."""
    return jnp.where((wi.z < 0) | (wo.z < 0), jnp.zeros_like(value), value)


def cos_mirror(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """R . V, the cosine between the mirror direction of one and the other."""
    return wi.z * wo.z - wi.x * wo.x - wi.y * wo.y


def cos_half(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """H . N; 0 at wi = -wo, where H does not exist."""
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    length2 = x * x + y * y + z * z
    safe = length2 > 0
    return jnp.where(safe, z / jnp.sqrt(jnp.where(safe, length2, 1.0)), 0.0)


def tangential(wi: Vec3, wo: Vec3) -> Float[Array, ""]:
    """sin theta_i sin theta_o cos(phi_i - phi_o), which needs no azimuth."""
    return wi.x * wo.x + wi.y * wo.y


def positive(x: Array) -> Array:
    """max(0, x) whose derivative at a tie is one-sided."""
    return jnp.where(x > 0, x, 0.0)


def held(cosine: Array) -> Array:
    """A cosine of unit vectors, which rounding may push out of [-1, 1], held there."""
    return jnp.where(cosine > 1, 1.0, jnp.where(cosine < -1, -1.0, cosine))
