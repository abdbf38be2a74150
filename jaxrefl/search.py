"""The search: which primitive a ray meets first, and whether anything stands between a point and a light.

Both are for ONE ray, run over numbers without derivatives, and loop over the primitives. A backend that fused the loop
into what uses its result would compute it again for each user (measured: a fifth of the time of a picture).
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from .geometry import Hit, Ray, Remedy
from .scene import is_shared
from .stage import Kind, Near, Stage, at
from .vec import Vec3, dot

UNROLLED = 5  # primitives per turn of the search
SELECTED = 16  # a stack of up to so many is searched by selection, a larger one by an index


class Origin(NamedTuple):
    """Where a ray starts."""

    left: Array
    """Number of the primitive it leaves, which is not tested; -1 for none."""
    chord: Array
    """Where it meets that primitive again from the inside; inf for never."""


class Found(NamedTuple):
    """What a search found, without derivatives."""

    code: Array
    """2 x number of the primitive in the scene, + 1 for the far root of a sphere; negative for nothing."""

    @property
    def id(self) -> Array:
        """Number of the primitive, -1 for nothing."""
        return self.code >> 1

    @property
    def far(self) -> Array:
        """Whether it is the far root."""
        return (self.code & 1) == 1


def pick(models: Any, ids: tuple[int, ...], found: Array) -> Any:
    """Of a stack the model whose number was found; any of them if it is not in the stack."""
    if len(ids) > SELECTED:
        index = np.zeros(max(ids) + 1, np.int32)
        index[list(ids)] = np.arange(len(ids))
        return at(models, jnp.asarray(index)[jnp.clip(found, 0, max(ids))])

    def select(x: Any) -> Any:
        if is_shared(x):
            return x
        value = x[0]
        for i, number in enumerate(ids[1:], 1):
            value = jnp.where(found == number, x[i], value)
        return value

    return jax.tree.map(select, models, is_leaf=is_shared)


def is_among(ids: tuple[int, ...], found: Array) -> Array:
    """Whether the primitive found is one of a stack."""
    if ids == tuple(range(ids[0], ids[-1] + 1)):
        return (found >= ids[0]) & (found <= ids[-1])
    if len(ids) > SELECTED:
        table = np.zeros(max(ids) + 1, bool)
        table[list(ids)] = True
        return (found >= 0) & (found <= max(ids)) & jnp.asarray(table)[jnp.clip(found, 0, max(ids))]
    return functools.reduce(operator.or_, [found == number for number in ids])


def elsewhere(x: Array) -> Origin:
    """Origin of a ray that starts on no primitive, such as a camera ray; x is any number of the ray."""
    return Origin(jnp.full_like(x, -1, jnp.int32), jnp.full_like(x, jnp.inf))


def leaving(hit: Hit, found: Found, direction: Vec3, inside: Array, remedy: Remedy) -> Origin:
    """Origin of a ray that leaves a hit, to the inside of the primitive or not."""
    left = jnp.where(remedy.skip, found.id, -1)
    chord = lax.stop_gradient(hit.diameter * jnp.abs(dot(hit.n, direction)))
    return Origin(left, jnp.where(inside & (left >= 0) & jnp.isfinite(hit.diameter), chord, jnp.inf))


def closest_hit(scene: Stage, ray: Ray, origin: Origin, remedy: Remedy) -> Found:
    """Nearest primitive; of equal distances the lower number wins.

    The loop carries distance and code as the two parts of one complex number: two results would be two kernels, each of
    which computes everything (measured: 2.5 times slower). A part holds a code up to 2^24 exactly in float32. Within a
    kind the numbers rise, so that the first of equal distances is the lower number.
    """
    ray, origin, t_min = lax.stop_gradient((ray, origin, jnp.asarray(remedy.t_min, ray.origin.x.dtype)))
    dtype = ray.origin.x.dtype
    own = jnp.where(jnp.isfinite(origin.chord), 2 * origin.left + 1, -2).astype(dtype)
    best = lax.complex(origin.chord, own)
    nothing = lax.complex(jnp.full_like(origin.chord, jnp.inf), jnp.full_like(origin.chord, -2))
    for kind in scene.kinds:
        shapes, ids = lax.stop_gradient(kind.shape), jnp.asarray(kind.ids, jnp.int32)

        def nearer(i: Array, best: Array, shapes: Any = shapes, ids: Array = ids) -> Array:
            root = at(shapes, i).roots(ray, t_min)
            code = (2 * ids[i]).astype(dtype)
            t = jnp.where(ids[i] != origin.left, root.t, jnp.inf)
            return jnp.where(t < best.real, lax.complex(t, jnp.where(root.far, code + 1, code)), best)

        other = _over(kind, nearer, nothing)
        tie = (other.real == best.real) & (other.imag >= 0) & (other.imag < best.imag)
        best = jnp.where((other.real < best.real) | tie, other, best)
    return Found(best.imag.astype(jnp.int32))


def is_blocked(scene: Stage, ray: Ray, origin: Origin, distance: Array, remedy: Remedy) -> Array:
    """Whether anything stands between the origin of a ray and a distance."""
    ray, origin, distance, t_min = lax.stop_gradient(
        (ray, origin, distance, jnp.asarray(remedy.t_min, ray.origin.x.dtype))
    )
    distance *= 1 - 8 * jnp.finfo(distance.dtype).eps  # a light on a surface is not behind it
    blocked = origin.chord < distance
    for kind in scene.kinds:
        shapes, ids = lax.stop_gradient(kind.shape), jnp.asarray(kind.ids, jnp.int32)

        def test(i: Array, blocked: Array, shapes: Any = shapes, ids: Array = ids) -> Array:
            return blocked | (at(shapes, i).blocks(ray, t_min, distance) & (ids[i] != origin.left))

        blocked = _over(kind, test, blocked)
    return blocked & (t_min < distance)


def _over(kind: Kind, test: Callable[[Array, Array], Array], value: Array) -> Array:
    """Value after ``test(place, value)`` of every primitive of a kind that is near.

    How many turns it takes is hidden from the compiler, which would make one turn part of whatever uses the value.
    """
    n = len(kind.ids)
    if n == 1:  # one test is cheap enough to be done twice
        return test(jnp.int32(0), value)
    order, number = kind.near or Near(jnp.arange(n, dtype=jnp.int32), jnp.int32(n))
    several = min(UNROLLED, n)

    def turn(i: Array, value: Array) -> Array:
        for k in range(several):  # past the end, others or the last once more: they change nothing
            value = test(order[jnp.minimum(i * several + k, n - 1)], value)
        return value

    return lax.fori_loop(0, lax.optimization_barrier((number + several - 1) // several), turn, value)
