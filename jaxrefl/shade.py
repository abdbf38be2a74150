"""Search, visibility and local illumination: everything that happens at one hit.

All functions are for ONE ray. The search and the shadow test run over numbers without derivatives, as a loop over the
primitives that carries the nearest one; the loop is never unrolled, because a backend that fuses it into its consumers
would compute it again for each of them.
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

from .geometry import Hit, Point, Ray, Remedy, hit_of, spawn
from .scene import Kind, Stage, is_shared
from .surface import Weights
from .vec import Vec3, dot, where


SELECTED = 16  # a stack of up to so many is searched by selection, a larger one by an index


class Origin(NamedTuple):
    """Where a ray starts: the primitive it leaves, -1 for none, and whether it runs into the inside of it."""

    left: Array
    inside: Array


class Found(NamedTuple):
    """What a search found, without derivatives."""

    t: Array
    """Distance, inf for nothing."""
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


class Shading(NamedTuple):
    """Local illumination at a hit."""

    color: Array
    """(C,) radiance shown, before the local weight."""
    weights: Weights
    lit: Array
    """() uint32: bit j is set if light j is seen."""


def elsewhere(x: Array) -> Origin:
    """Origin of a ray that starts on no primitive, such as a camera ray; x is any number of the ray."""
    return Origin(jnp.full_like(x, -1, jnp.int32), jnp.zeros_like(x, bool))


def closest_hit(scene: Stage, ray: Ray, origin: Origin, remedy: Remedy) -> Found:
    """Nearest primitive; of equal distances the lower number wins."""
    ray, t_min = lax.stop_gradient((ray, jnp.asarray(remedy.t_min, ray.origin.x.dtype)))
    x = ray.origin.x
    best = Found(jnp.full_like(x, jnp.inf), jnp.full_like(x, -2, jnp.int32))
    for kind in scene.kinds:
        shapes, ids = lax.stop_gradient(kind.shape), jnp.asarray(kind.ids, jnp.int32)

        def nearer(i: Array, best: Found, shapes: Any = shapes, ids: Array = ids) -> Found:
            root = at(shapes, i).roots(ray, ids[i] == origin.left, origin.inside, t_min)
            code = 2 * ids[i] + root.far
            better = (root.t < best.t) | ((root.t == best.t) & (code < best.code))
            return Found(jnp.where(better, root.t, best.t), jnp.where(better, code, best.code))

        best = lax.fori_loop(0, len(kind.ids), nearer, best)
    return best


def is_blocked(scene: Stage, ray: Ray, origin: Origin, distance: Array, remedy: Remedy) -> Array:
    """Whether anything stands between the origin of a ray and a distance."""
    ray, distance, t_min = lax.stop_gradient((ray, distance, jnp.asarray(remedy.t_min, ray.origin.x.dtype)))
    blocked = jnp.zeros_like(ray.origin.x, bool)
    for kind in scene.kinds:
        shapes, ids = lax.stop_gradient(kind.shape), jnp.asarray(kind.ids, jnp.int32)

        def test(i: Array, blocked: Array, shapes: Any = shapes, ids: Array = ids) -> Array:
            root = at(shapes, i).roots(ray, ids[i] == origin.left, origin.inside, t_min)
            return blocked | (root.t < distance)

        blocked = lax.fori_loop(0, len(kind.ids), test, blocked)
    return blocked


def once(alive: Array, function: Callable[..., Any], *args: Any) -> Any:
    """``function(*args)``, computed once: what uses it does not compute it again; zeros if no ray of the batch is alive.

    A backend that fuses a value into each of its users computes it once per user, and once per channel (measured on
    the CPU: 5 to 8 times slower). The branch of a conditional whose predicate only the run knows is what it does not
    see through.
    """
    nothing = jax.eval_shape(function, *args)
    return lax.cond(alive, function, lambda *_: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), nothing), *args)


def at(models: Any, i: Array) -> Any:
    """Model i of a stack; what is shared stays as it is."""
    return jax.tree.map(lambda x: x if is_shared(x) else x[i], models, is_leaf=is_shared)


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


def hits_at(scene: Stage, ray: Ray, origin: Origin, found: Found, alive: Array) -> tuple[Hit, tuple[Hit, ...]]:
    """Differentiable hit that a search found, merged and per kind of shape; a legal one, without derivatives, of every
    kind that it is not of."""
    points = []
    for kind in scene.kinds:

        def fit(shapes: Any, ray: Ray, number: Array, kind: Kind = kind) -> tuple[Any, Ray]:
            shape = pick(shapes, kind.ids, number)
            legal = lax.stop_gradient(shape.legal_ray())
            here = is_among(kind.ids, number)
            return shape, Ray(where(here, ray.origin, legal.origin), where(here, ray.direction, legal.direction))

        shape, ray_here = once(alive, fit, kind.shape, ray, found.id)
        here = is_among(kind.ids, found.id)
        point: Point = shape.point(ray_here, (found.id == origin.left) & here, found.far & here)
        points.append((here, hit_of(ray_here, point, found.far & here)))

    def merge(points: Any) -> Any:
        merged = points[0][1]
        for here, hit in points[1:]:
            merged = jax.tree.map(lambda a, b, here=here: jnp.where(here, a, b), hit, merged)
        return merged

    core = [(here, (hit.p, hit.n, hit.wo, hit.t, hit.entering)) for here, hit in points]
    p, n, wo, t, entering = once(alive, merge, core)
    hits = tuple(Hit(p, n, hit.tangent, wo, t, hit.uv, entering) for _, hit in points)
    return hits[0], hits


def legal_hit(scene: Stage) -> Hit:
    """A hit of the first primitive."""
    kind = scene.kinds[0]
    shape = pick(kind.shape, kind.ids, jnp.zeros((), jnp.int32))
    ray = shape.legal_ray()
    near = jnp.zeros_like(ray.origin.x, bool)
    return hit_of(ray, shape.point(ray, near, near), near)


def shade(
    scene: Stage, hit: Hit, hits: tuple[Hit, ...], found: Found, remedy: Remedy, channels: int, alive: Array
) -> Shading:
    """Local illumination E_m + I_a k_a + sum_j f_j S_j (I_aj k_a + V_j (I_dj diffuse + I_sj specular)) and the weights.

    The ambient intensity of a light is attenuated and not shadowed. Source: JHU, "Local Illumination Equation", whose
    legend has I_aj and whose sum lacks it (S27).
    """
    groups = [(hits[g.kind], pick(g.surface, g.ids, found.id)) for g in scene.groups]
    chosen = [is_among(g.ids, found.id) for g in scene.groups]

    def merge(values: list[Any]) -> Any:
        merged = values[0]
        for here, value in zip(chosen[1:], values[1:], strict=True):
            merged = jax.tree.map(lambda a, b, here=here: jnp.where(here, a, b), value, merged)
        return merged

    weights = merge([wide(surface.weights(own), channels, hit.t.dtype) for own, surface in groups])
    color = weights.emitted + scene.ambient * weights.ambient
    lit, bit = jnp.zeros_like(hit.t, jnp.uint32), 0
    for lights in scene.lights:
        count = jax.tree.leaves(lights)[0].shape[0]

        def add(total: tuple[Array, Array], item: tuple[Any, Array]) -> tuple[tuple[Array, Array], None]:
            light, bit = item
            sent = once(alive, lambda light, p: light.at(p), light, hit.p)
            facing = dot(hit.n, sent.wi) > 0
            seen = facing
            if light.shadows:
                origin = Origin(jnp.where(remedy.skip, found.id, -1), ~hit.entering)
                shadow_ray = spawn(hit, sent.wi, remedy)
                seen = facing & ~is_blocked(scene, shadow_ray, origin, sent.distance, remedy)
            local = merge([wide(surface.local(own, sent.wi), channels, hit.t.dtype) for own, surface in groups])
            direct = light.diffuse * local.diffuse + light.specular * local.specular
            new = sent.factor * (light.ambient * weights.ambient + jnp.where(seen, direct, 0.0))
            return (total[0] + new, total[1] | jnp.where(seen, bit, 0).astype(jnp.uint32)), None

        bits = jnp.asarray([1 << ((bit + j) % 32) for j in range(count)], jnp.uint32)
        (color, lit), _ = lax.scan(add, (color, lit), (lights, bits))
        bit += count
    return Shading(color, weights, lit)


def wide(values: Any, channels: int, dtype: Any) -> Any:
    """Every member of a record as an array of one dtype, spectra (C,), scalars ()."""
    scalars = ("eta", "alpha")
    return type(values)(
        *(
            jnp.asarray(value, dtype) if name in scalars else jnp.broadcast_to(jnp.asarray(value, dtype), (channels,))
            for name, value in zip(values._fields, values, strict=True)
        )
    )


__all__ = ["Found", "Origin", "Shading", "Vec3", "closest_hit", "elsewhere", "hits_at", "is_blocked", "shade"]
