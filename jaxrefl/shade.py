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
import numpy as np
from jax import Array, lax
from jax.experimental.layout import Layout, with_layout_constraint

from .beam import reached
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
    """() uint32: a number of the set of lights seen."""


def once(needed: Array, function: Callable[..., Any], *args: Any) -> Any:
    """``function(*args)``, computed once: what uses it does not compute it again; zeros if it is not needed.

    A backend that fuses a value into each of its users computes it once per user, and once per channel (measured on
    the CPU: 5 to 8 times slower). The branch of a conditional whose predicate only the run knows is what it does not
    see through. Arguments that are not arrays are passed on as they are.
    """
    leaves, structure = jax.tree.flatten(args)
    arrays = [x for x in leaves if isinstance(x, Array)]

    @functools.partial(jax.jit, inline=True)  # so that JAX traces it once, for its shapes and for the branch
    def apply(arrays: list[Any]) -> Any:
        rest = iter(arrays)
        return function(*jax.tree.unflatten(structure, [next(rest) if isinstance(x, Array) else x for x in leaves]))

    nothing = jax.eval_shape(apply, arrays)
    return lax.cond(needed, apply, lambda _: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), nothing), arrays)


@jax.custom_batching.custom_vmap
def any_of(flags: Array) -> Array:
    """Whether any of the flags is set; mapped over many scenes, whether any is in any of them.

    So the predicate of a conditional stays one number under `vmap`: else both of its branches would be computed, and
    the second one, "nothing to do", would be no help.
    """
    return jnp.any(flags, axis=-1)


@any_of.def_vmap
def _any_of_many(axis_size: int, in_batched: Any, flags: Array) -> tuple[Array, bool]:
    return any_of(jnp.any(flags, axis=0)), False


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
    p, n, t, entering = merge(here, [(point.p, point.n, point.t, point.entering) for point in points])
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


class Model(NamedTuple):
    """One model of surface at a hit, textures resolved."""

    here: Array
    """() bool: it is the one that was hit."""
    surface: Any


def models_at(scene: Stage, hits: Sequence[Hit], found: Found) -> tuple[list[Model], list[tuple[int, ...]]]:
    """Models of surface at a hit, and the kinds of shape that have each of them.

    Primitives whose surfaces differ in numbers or textures alone are one model, evaluated once.
    """
    same: dict[Any, list[tuple[int, Model]]] = {}
    for group in scene.groups:
        surface = resolve(pick(group.surface, group.ids, found.id), hits[group.kind].uv)
        key = jax.tree.structure(surface), tuple(jnp.shape(x) for x in jax.tree.leaves(surface))
        same.setdefault(key, []).append((group.kind, Model(is_among(group.ids, found.id), surface)))
    models = []
    for members in same.values():
        chosen = [model.here for _, model in members]
        surface = merge(chosen, [model.surface for _, model in members])
        models.append(Model(functools.reduce(operator.or_, chosen), surface))
    return models, [tuple(sorted({kind for kind, _ in members})) for members in same.values()]


def hit_on(scene: Stage, hits: Sequence[Hit], kinds: tuple[int, ...], found: Found) -> Hit:
    """The hit with tangent and uv of the one of some kinds of shape that was hit."""
    return merge([is_among(scene.kinds[kind].ids, found.id) for kind in kinds], [hits[kind] for kind in kinds])


def legal_hit(scene: Stage) -> Hit:
    """A hit of the first primitive."""
    kind = scene.kinds[0]
    shape = pick(kind.shape, kind.ids, jnp.zeros((), jnp.int32))
    one = jnp.ones_like(jax.tree.leaves(shape)[0])
    ray, no = Ray(Vec3(one, one, one), Vec3(one, 0 * one, 0 * one)), one < 0
    point: Point = shape.point(ray, no, no, no)
    return Hit(point.p, point.n, point.tangent, point.n, one, point.uv, ~no, one)


def batch(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of one ray, mapped over a batch, whose rays are the last axis.

    In memory, too: where scalars meet spectra JAX puts the mapped axis first, and a backend left alone would then store
    and compute channel by channel within a ray, which no vector unit likes (measured: the response to a light takes
    1.4 times as long).
    """
    mapped = jax.vmap(function, in_axes=-1, out_axes=0)
    return lambda *args: jax.tree.map(_rays_last, mapped(*args))


def _rays_last(x: Array) -> Array:
    """First axis moved to the end; in memory it was there."""
    if x.ndim < 2:
        return x
    axes = tuple(range(x.ndim))
    stored = with_layout_constraint(x, Layout(major_to_minor=(*axes[1:], 0)))
    return with_layout_constraint(jnp.moveaxis(stored, 0, -1), Layout(major_to_minor=axes))


def shade(
    scene: Stage, ray: Ray, origin: Origin, found: Found, remedy: Remedy, channels: int, any_hit: Array
) -> tuple[Hit, Shading]:
    """Hits of a BATCH of rays and their local illumination and weights.

    E_m + I_a k_a + sum_j f_j S_j (I_aj k_a + V_j (I_dj diffuse + I_sj specular)): the ambient intensity of a light is
    attenuated and not shadowed. Source: JHU, "Local Illumination Equation", whose legend has I_aj and whose sum lacks
    it (S27).
    """
    shapes = once(any_hit, batch(functools.partial(shapes_at, scene)), found)
    hit = once(any_hit, batch(functools.partial(hit_at, scene)), shapes, ray, origin, found)
    place = (shapes, ray, origin, found, hit)
    dtype = hit.t.dtype
    shared_by: list[tuple[int, ...]] = []

    def models_of(*place: Any) -> list[Model]:
        models, shared_by[:] = models_at(scene, chart_at(scene, *place), place[3])
        return models

    def hits_of(place: Any) -> list[Hit]:
        hits = chart_at(scene, *place)
        return [hit_on(scene, hits, kinds, place[3]) for kinds in shared_by]

    models = once(any_hit, batch(models_of), *place)

    def weigh(models: list[Model], *place: Any) -> tuple[Weights, Array]:
        own = zip(hits_of(place), models, strict=True)
        values = [wide(model.surface.weights(hit), channels, dtype) for hit, model in own]
        weights: Weights = merge([model.here for model in models], values)
        return weights, weights.emitted + scene.ambient * weights.ambient

    weights, color = once(any_hit, batch(weigh), models, *place)
    if not scene.lights:
        return hit, Shading(color, weights, jnp.zeros(hit.t.shape, jnp.uint32))

    def illuminate(p: Vec3) -> Illumination:
        """Of every light what it sends to a point, (L,)."""
        sent = [jax.vmap(lambda light: light.at(p))(lights) for lights in scene.lights]
        return jax.tree.map(lambda *x: jnp.concatenate(x), *sent)

    sent = once(any_hit, batch(illuminate), hit.p)
    power, shadows = intensities(scene, channels, dtype)

    def is_seen(hit: Hit, found: Found, sent: Illumination, shadow: Array) -> Array:
        """Of each ray of the batch whether a light shines on its hit."""
        facing = dot(hit.n, sent.wi) > 0
        if not np.any(shadows):
            return facing
        ray, start = spawn(hit, sent.wi, remedy), leaving(hit, found, sent.wi, ~hit.entering, remedy)
        near = reached(scene, ray, facing & (found.code >= 0))
        blocked = batch(lambda ray, start, distance: is_blocked(near, ray, start, distance, remedy))
        return facing & ~(shadow & blocked(ray, start, sent.distance))

    def add(total: tuple[Array, Array], item: Any) -> tuple[tuple[Array, Array], None]:
        sent, (diffuse, specular, ambient), shadow, bit = item
        seen = once(any_hit, functools.partial(is_seen, shadow=shadow), hit, found, sent)

        def respond(
            color: Array, sent: Illumination, seen: Array, weights: Weights, models: list[Model], *place: Any
        ) -> Array:
            own = zip(hits_of(place), models, strict=True)
            values = [wide(model.surface.local(hit, sent.wi), channels, dtype) for hit, model in own]
            local = merge([model.here for model in models], values)
            direct = diffuse * local.diffuse + specular * local.specular
            return color + sent.factor * (ambient * weights.ambient + jnp.where(seen, direct, 0.0))

        color = batch(respond)(total[0], sent, seen, weights, models, *place)
        return (color, total[1] + jnp.where(seen & (sent.factor > 0), bit, jnp.uint32(0))), None

    bits = ((2 * np.arange(len(shadows), dtype=np.uint64) + 1) * 2654435761 % 2**32).astype(np.uint32)
    begin = (color, jnp.zeros(hit.t.shape, jnp.uint32))
    (color, lit), _ = lax.scan(add, begin, (sent, power, jnp.asarray(shadows), jnp.asarray(bits)))
    return hit, Shading(color, weights, lit)


def intensities(scene: Stage, channels: int, dtype: Any) -> tuple[tuple[Array, Array, Array], np.ndarray]:
    """Diffuse, specular and ambient intensity of every light, each (L, C), and whether it casts shadows, (L,)."""

    def column(name: str) -> Array:
        columns = [jnp.asarray(getattr(lights, name), dtype) for lights in scene.lights]
        wide = [x[:, None] if x.ndim == 1 else x for x in columns]
        return jnp.concatenate([jnp.broadcast_to(x, (x.shape[0], channels)) for x in wide])

    counts = [jax.tree.leaves(lights)[0].shape[0] for lights in scene.lights]
    shadows = np.concatenate([np.full(n, lights.shadows) for n, lights in zip(counts, scene.lights, strict=True)])
    return (column("diffuse"), column("specular"), column("ambient")), shadows


def wide(values: Any, channels: int, dtype: Any) -> Any:
    """Every member of a record as an array of one dtype, spectra (C,), scalars ()."""
    scalars = ("eta", "alpha")
    return type(values)(
        *(
            jnp.asarray(value, dtype) if name in scalars else jnp.broadcast_to(jnp.asarray(value, dtype), (channels,))
            for name, value in zip(values._fields, values, strict=True)
        )
    )
