"""A drop of water: the rainbow out of traced rays and their derivatives."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax
from jaxtyping import Float

from ..geometry import Ray, Sphere
from ..params import checked
from ..scene import Object, Scene
from ..surface import Dielectric
from ..trace import follow
from ..vec import Vec3

STEPS = 60  # of bisection: an interval below 1e-18


class Rainbow(NamedTuple):
    """Where many rays leave a drop together."""

    impact: Array
    """Distance of the ray from the axis of the drop, over its radius."""
    deflection: Array
    """Angle between the ray that comes and the ray that goes, radians, counted through all turns."""
    radius: Array
    """Angle of the bow around the antisolar point, radians."""


def drop(eta: Float[Array, ""]) -> Scene:
    """Sphere of an index, radius 1."""
    return Scene({"drop": Object(Sphere(Vec3(0.0, 0.0, 0.0), 1.0), Dielectric(eta))})


@functools.partial(jax.jit, static_argnames="branches")
def _deflection(impact: Array, eta: Array, branches: str) -> Array:
    zero = jnp.zeros_like(impact)
    ray = Ray(Vec3(impact, zero, zero - 2), Vec3(zero, zero, zero + 1))
    out = follow(drop(eta), ray, branches).direction
    return jnp.mod(jnp.arctan2(-out.x, out.z), 2 * jnp.pi)


@checked(impact="(0, 1)", eta="(1, inf)")
def deflection(impact: Float[Array, ""], eta: Float[Array, ""], branches: str = "TRT") -> Float[Array, ""]:
    """Angle by which a ray is turned that follows some branches through a sphere, traced.

    Args:
        impact: () distance of the ray from the axis over the radius of the sphere, (0, 1).
        eta: () index of the sphere over the outside, (1, inf).
        branches: letters R and T, see `jaxrefl.trace.follow`; "TRT" is the primary bow, "TRRT" the secondary one.

    Returns:
        radians, [0, 2 pi): the turn modulo whole turns.

    Raises:
        ValueError: a value out of its range; another letter.

    Differentiable in impact and eta. One ray; map it with `jax.vmap`.
    """
    return _deflection(jnp.asarray(impact, float), jnp.asarray(eta, float), branches)


@checked(eta="(1, inf)")
def rainbow(eta: Float[Array, ""], reflections: int = 1) -> Rainbow:
    """Rainbow of a drop: the ray of least deflection, found where the derivative of the traced one vanishes.

    Args:
        eta: () index of the drop over the outside, (1, inf), and below reflections + 1, where the bow closes.
        reflections: inside the drop; 1 is the primary bow, 2 the secondary one; static.

    Returns:
        impact, deflection and radius of the bow; for 1 and 2 reflections the radius is the angle from the antisolar
        point.

    Raises:
        ValueError: a value out of its range.

    Differentiable in eta: at an extreme the slope is that of the deflection for the impact held.
    """
    if reflections not in (1, 2):
        raise ValueError(f"reflections = {reflections!r} must be 1 or 2")
    branches, eta = "T" + "R" * reflections + "T", jnp.asarray(eta, float)
    slope = jax.grad(functools.partial(_deflection, branches=branches))

    def halve(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
        middle = 0.5 * (ends[0] + ends[1])
        falls = slope(middle, lax.stop_gradient(eta)) < 0
        return jnp.where(falls, middle, ends[0]), jnp.where(falls, ends[1], middle)

    one = jnp.ones_like(eta)
    low, high = lax.fori_loop(0, STEPS, halve, (0.01 * one, (1 - 1e-6) * one))
    impact = lax.stop_gradient(0.5 * (low + high))
    turned = _deflection(impact, eta, branches)
    return Rainbow(impact, turned, jnp.abs(jnp.pi - turned))
