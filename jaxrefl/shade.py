"""Local illumination: everything that happens at one hit.

The functions of one ray come first. `shade`, which is for a batch of rays, goes in stages, each computed `once`; in a
batch the rays are the last axis, so that a colour is C rows of N.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from .geometry import Hit, Point, Ray, Remedy, spawn
from .light import Illumination
from .search import Found, Origin, is_among, is_blocked, leaving, pick
from .stage import Stage
from .surface import Weights
from .texture import resolve
from .vec import Vec3, dot, where


class Shading(NamedTuple):
    """Local illumination at a hit."""

    color: Array
    """(C,) radiance shown, before the local weight."""
    weights: Weights
    lit: Array
    """() uint32: bit j is set if light j is seen."""


def once(alive: Array, function: Callable[..., Any], *args: Any) -> Any:
    """``function(*args)``, computed once: what uses it does not compute it again; zeros if no ray is alive.

    A backend that fuses a value into each of its users computes it once per user, and once per channel (measured on
    the CPU: 5 to 8 times slower). The branch of a conditional whose predicate only the run knows is what it does not
    see through. Arguments that are not arrays are passed on as they are.
    """
    leaves, structure = jax.tree.flatten(args)
    arrays = [x for x in leaves if isinstance(x, Array)]

    def apply(arrays: list[Any]) -> Any:
        rest = iter(arrays)
        return function(*jax.tree.unflatten(structure, [next(rest) if isinstance(x, Array) else x for x in leaves]))

    nothing = jax.eval_shape(apply, arrays)
    return lax.cond(alive, apply, lambda _: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), nothing), arrays)


def shapes_at(scene: Stage, found: Found) -> tuple[Any, ...]:
    """Of each kind of shape the primitive found."""
    return tuple(pick(kind.shape, kind.ids, found.id) for kind in scene.kinds)


def points_at(scene: Stage, shapes: Any, ray: Ray, origin: Origin, found: Found) -> tuple[list[Array], list[Point]]:
    """Of each kind of shape whether it was hit, and a point; a legal one where it was not."""
    here = [is_among(kind.ids, found.id) for kind in scene.kinds]
    own = found.id == origin.left
    return here, [shape.point(ray, own & at, found.far, at) for shape, at in zip(shapes, here, strict=True)]


def hit_at(scene: Stage, shapes: Any, ray: Ray, origin: Origin, found: Found) -> Hit:
    """Differentiable hit that a search found, a legal one where it found nothing; tangent and uv are `chart_at`'s."""
    here, points = points_at(scene, shapes, ray, origin, found)
    p, n, t = merge(here, [(point.p, point.n, point.t) for point in points])
    entering = (dot(ray.direction, n) < 0) & ~found.far
    diameter = merge(here, [shape.chord(n, n) for shape in shapes])
    return Hit(p, where(entering, n, -n), n, -ray.direction, t, (t, t), entering, diameter)


def chart_at(scene: Stage, shapes: Any, ray: Ray, origin: Origin, found: Found, hit: Hit) -> list[Hit]:
    """The hit with tangent and uv, of each kind of shape."""
    points = points_at(scene, shapes, ray, origin, found)[1]
    return [hit._replace(tangent=point.tangent, uv=point.uv) for point in points]


def merge(chosen: Sequence[Array], values: Sequence[Any]) -> Any:
    """The value of the one that is chosen, the first if none is."""
    merged = values[0]
    for here, value in zip(chosen[1:], values[1:], strict=True):
        merged = jax.tree.map(lambda a, b, here=here: jnp.where(here, a, b), value, merged)
    return merged


def models_at(scene: Stage, hits: Sequence[Hit], found: Found) -> list[tuple[Array, Hit, Any]]:
    """Surfaces at a hit, textures resolved: one per model, with where it is the one, and its hit.

    Primitives whose surfaces differ in numbers or textures alone are one model, evaluated once.
    """
    models: dict[Any, list[tuple[Array, Hit, Any]]] = {}
    for group in scene.groups:
        own = hits[group.kind]
        surface = resolve(pick(group.surface, group.ids, found.id), own.uv)
        shapes = tuple(jnp.shape(x) for x in jax.tree.leaves(surface))
        models.setdefault((jax.tree.structure(surface), shapes), []).append(
            (is_among(group.ids, found.id), own, surface)
        )
    merged = []
    for members in models.values():
        chosen = [here for here, _, _ in members]
        own, surface = merge(chosen, [(own, surface) for _, own, surface in members])
        merged.append((functools.reduce(operator.or_, chosen), own, surface))
    return merged


def legal_hit(scene: Stage) -> Hit:
    """A hit of the first primitive."""
    kind = scene.kinds[0]
    shape = pick(kind.shape, kind.ids, jnp.zeros((), jnp.int32))
    one = jnp.ones_like(jax.tree.leaves(shape)[0])
    ray, no = Ray(Vec3(one, one, one), Vec3(one, 0 * one, 0 * one)), one < 0
    point: Point = shape.point(ray, no, no, no)
    return Hit(point.p, point.n, point.tangent, point.n, one, point.uv, ~no, one)


def batch(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of one ray, mapped over a batch, whose rays are the last axis."""
    return jax.vmap(function, in_axes=-1, out_axes=-1)


def shade(
    scene: Stage, ray: Ray, origin: Origin, found: Found, remedy: Remedy, channels: int, alive: Array
) -> tuple[Hit, Shading]:
    """Hits of a BATCH of rays and their local illumination and weights.

    E_m + I_a k_a + sum_j f_j S_j (I_aj k_a + V_j (I_dj diffuse + I_sj specular)): the ambient intensity of a light is
    attenuated and not shadowed. Source: JHU, "Local Illumination Equation", whose legend has I_aj and whose sum lacks
    it (S27).
    """
    shapes = once(alive, batch(functools.partial(shapes_at, scene)), found)
    hit = once(alive, batch(functools.partial(hit_at, scene)), shapes, ray, origin, found)
    dtype = hit.t.dtype

    def models_of(shapes: Any, ray: Ray, origin: Origin, found: Found, hit: Hit) -> Any:
        return models_at(scene, chart_at(scene, shapes, ray, origin, found, hit), found)

    def surfaces_of(*args: Any) -> Any:
        return [(here, surface) for here, _, surface in models_of(*args)]

    place = (shapes, ray, origin, found, hit)
    surfaces = once(alive, batch(surfaces_of), *place)

    def weigh(surfaces: Any, *place: Any) -> Weights:
        own = [hit for _, hit, _ in models_of(*place)]
        values = [wide(s.weights(hit), channels, dtype) for hit, (_, s) in zip(own, surfaces, strict=True)]
        return merge([here for here, _ in surfaces], values)

    weights = once(alive, batch(weigh), surfaces, *place)
    color = batch(lambda w: w.emitted + scene.ambient * w.ambient)(weights)
    lit, bit = jnp.zeros(hit.t.shape, jnp.uint32), 0
    for lights in scene.lights:
        count = jax.tree.leaves(lights)[0].shape[0]

        def add(total: tuple[Array, Array], item: tuple[Any, Array]) -> tuple[tuple[Array, Array], None]:
            light, bit = item

            def illuminate(hit: Hit, found: Found) -> tuple[Illumination, Array]:
                sent = light.at(hit.p)
                seen = dot(hit.n, sent.wi) > 0
                if light.shadows:
                    start = leaving(hit, found, sent.wi, ~hit.entering, remedy)
                    seen &= ~is_blocked(scene, spawn(hit, sent.wi, remedy), start, sent.distance, remedy)
                return sent, seen

            sent, seen = once(alive, batch(illuminate), hit, found)

            def respond(color: Array, sent: Illumination, seen: Array, w: Weights, surfaces: Any, *place: Any) -> Array:
                own = [hit for _, hit, _ in models_of(*place)]
                values = [wide(s.local(h, sent.wi), channels, dtype) for h, (_, s) in zip(own, surfaces, strict=True)]
                local = merge([here for here, _ in surfaces], values)
                direct = light.diffuse * local.diffuse + light.specular * local.specular
                return color + sent.factor * (light.ambient * w.ambient + jnp.where(seen, direct, 0.0))

            color = batch(respond)(total[0], sent, seen, weights, surfaces, *place)
            return (color, total[1] | jnp.where(seen, bit, 0).astype(jnp.uint32)), None

        bits = jnp.asarray([1 << ((bit + j) % 32) for j in range(count)], jnp.uint32)
        (color, lit), _ = lax.scan(add, (color, lit), (lights, bits))
        bit += count
    return hit, Shading(color, weights, lit)


def wide(values: Any, channels: int, dtype: Any) -> Any:
    """Every member of a record as an array of one dtype, spectra (C,), scalars ()."""
    scalars = ("eta", "alpha")
    return type(values)(
        *(
            jnp.asarray(value, dtype) if name in scalars else jnp.broadcast_to(jnp.asarray(value, dtype), (channels,))
            for name, value in zip(values._fields, values, strict=True)
        )
    )
