"""Which primitives a batch of rays can reach: those that touch its beam, a cone around it.

Rays that start together, such as those of a patch of a picture, meet few of many primitives; the search runs over those
alone. What is kept is never too little, so it finds the same.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from .geometry import Ray
from .stage import Kind, Near, Stage, at
from .vec import Vec3, dot, norm, normalize

MANY = 32  # of fewer primitives, or for fewer rays, all are tested: to find out which would cost as much
MARGIN = 4e-3  # share of the distance by which a ball is taken for larger: more than a float32 cosine is wrong by


class Beam(NamedTuple):
    """Rays that start in a ball, in directions within a cone."""

    center: Vec3
    radius: Array
    axis: Vec3
    cos: Array
    """Cosine of the half angle of the cone; only a positive one says anything."""

    def touches(self, center: Vec3, radius: Array) -> Array:
        """Whether a ray may meet a ball; True also where a number is NaN."""
        way = center - self.center
        distance = norm(way)
        size = radius + self.radius + MARGIN * distance
        cos = jnp.minimum(self.cos, 1.0)
        # seen from the center the ball is a cone, too; the axes of the two are farther apart than their half angles
        cos_ball = jnp.sqrt(jnp.maximum(distance * distance - size * size, 0.0))  # times distance, like size, its sine
        apart = dot(way, self.axis) < cos * cos_ball - jnp.sqrt(1 - cos * cos) * size
        return ~((cos > 0) & (distance > size) & apart)


def beam(ray: Ray, alive: Array) -> Beam:
    """Beam of those rays of a batch, (N,), that are alive.

    Its axis is the mean of the first and the last of them: of a patch of a picture, of opposite corners.
    """
    number = jnp.arange(alive.size, dtype=jnp.int32)
    ends = _least(jnp.where(alive, number, alive.size - 1)), -_least(jnp.where(alive, -number, 0))
    first, last = (jax.tree.map(lambda x, i=i: x[i], ray) for i in ends)
    center, axis = (first.origin + last.origin) * 0.5, normalize(first.direction + last.direction)
    away = ray.origin - center
    far = -_least(jnp.where(alive, -dot(away, away), 0.0))
    # after many bounces a direction may be longer than 1 by more than one rounding
    cos = jnp.where(alive, dot(ray.direction, axis) / norm(ray.direction), 1.0)
    return Beam(center, jnp.sqrt(far), axis, _least(cos))


def reached(scene: Stage, ray: Ray, alive: Array) -> Stage:
    """The scene as the rays of a batch that are alive may meet it."""
    worth = [len(kind.ids) >= MANY and hasattr(kind.shape, "ball") for kind in scene.kinds]
    if alive.size < MANY or not any(worth):
        return scene
    around = beam(*lax.stop_gradient((ray, alive)))
    kinds = [_reached(kind, around) if big else kind for kind, big in zip(scene.kinds, worth, strict=True)]
    return scene._replace(kinds=tuple(kinds))


def _reached(kind: Kind, around: Beam) -> Kind:
    shapes: Any = lax.stop_gradient(kind.shape)
    balls = jax.vmap(lambda i: jax.tree.map(jnp.asarray, at(shapes, i).ball()))(jnp.arange(len(kind.ids)))
    may = around.touches(*balls)
    # of a hundred flags a sort is 3 times faster than `blocks.first`, which is for the thousands of a tile
    return kind._replace(near=Near(jnp.argsort(~may, stable=True), jnp.sum(may)))


def _least(x: Array) -> Array:
    """Smallest number of (N,), NaN if there is one; in columns, because one alone is not done in a vector unit.

    There are MANY rays at least, and so a row.
    """
    whole = x.size // MANY * MANY
    columns = jnp.min(x[:whole].reshape(-1, MANY), axis=0)
    return jnp.min(jnp.concatenate([columns, x[whole:]]))
