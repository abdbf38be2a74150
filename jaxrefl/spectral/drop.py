"""A drop of water: the rainbow out of traced rays and their derivatives."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax
from jaxtyping import Float

from ..geometry import Ray, Sphere
from ..params import Interval, checked, floats, require
from ..scene import Object, Scene
from ..surface import Dielectric
from ..trace import follow
from ..vec import Vec3

STEPS = 60  # of bisection: an interval below 1e-17


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
    gone = (out.x == 0) & (out.z == 0)
    turned = jnp.mod(jnp.arctan2(-out.x, jnp.where(gone, 1.0, out.z)), 2 * jnp.pi)
    return jnp.where(gone, jnp.nan, turned)


@checked(impact="(0, 1)", eta="(1, 1000]")
def deflection(impact: Float[Array, ""], eta: Float[Array, ""], branches: str = "TRT") -> Float[Array, ""]:
    """Angle by which a ray is turned that follows some branches through a sphere, traced.

    Args:
        impact: () distance of the ray from the axis over the radius of the sphere, (0, 1).
        eta: () index of the sphere over the outside, (1, 1000].
        branches: letters R and T, see `jaxrefl.trace.follow`; "TRT" is the primary bow, "TRRT" the secondary one.

    Returns:
        radians, [0, 2 pi): the turn modulo whole turns; NaN if the branches miss the sphere or meet total reflection.

    Raises:
        ValueError: a value out of its range; another letter.

    Differentiable in impact and eta. One ray; map it with `jax.vmap`.
    """
    return _deflection(*floats(impact, eta), branches)


def rainbow(eta: Float[Array, ""], reflections: int = 1) -> Rainbow:
    """Rainbow of a drop: the ray of least deflection, found where the derivative of the traced one vanishes.

    Args:
        eta: () index of the drop over the outside, (1, reflections + 1): above, the bow is closed.
        reflections: inside the drop; 1 is the primary bow, 2 the secondary one; static.

    Returns:
        impact, deflection and radius of the bow; for 1 and 2 reflections the radius is the angle from the antisolar
        point.

    Raises:
        ValueError: a value out of its range.

    The first derivatives of deflection and radius in eta are those of the traced ray, the impact held, as they are at
    an extreme. The impact itself has none (0), and so second derivatives of the angles are not the true ones.
    """
    if reflections not in (1, 2):
        raise ValueError(f"reflections = {reflections!r} must be 1 or 2")
    require("eta", eta, Interval.parse(f"(1, {reflections + 1})"))
    branches, (eta,) = "T" + "R" * reflections + "T", floats(eta)
    slope = jax.grad(functools.partial(_deflection, branches=branches))

    def halve(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
        middle = 0.5 * (ends[0] + ends[1])  # an angle of incidence
        falls = slope(jnp.sin(middle), lax.stop_gradient(eta)) < 0
        return jnp.where(falls, middle, ends[0]), jnp.where(falls, ends[1], middle)

    low, high = lax.fori_loop(0, STEPS, halve, (jnp.zeros_like(eta), jnp.full_like(eta, jnp.pi / 2)))
    impact = lax.stop_gradient(jnp.sin(0.5 * (low + high)))
    turned = _deflection(impact, eta, branches)
    return Rainbow(impact, turned, jnp.abs(jnp.pi - turned))
