"""The bounce loop: what a batch of rays brings back.

Everything is a function of one ray, mapped; the loop over bounces belongs to the batch, which is worked on in blocks. A
block whose rays are all dead is left alone, and rays change places so that there are such blocks. It is one `lax.scan`,
the same in value, forward and reverse mode, whose step is recomputed on the way back: the memory of a gradient grows by
the state of a ray per bounce, not by everything that a bounce computes.

PERRIN: "find the next reflection point and start over". JHU: I(P) = I_local(P) + k_rg I(P_r) + k_tg I(P_t).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from . import d3d9
from .blocks import divided, each, first, inverse, joined, pays, taken
from .bounce import Gathered, Shown, escape, go_on, search, visit
from .geometry import Hit, Ray
from .path import Account, Branch, Budget, Features, Options, Walk, features, start
from .search import Found, Origin, elsewhere
from .shade import any_of, batch, chart_at, hit_at, hit_on, models_at, shapes_at
from .stage import Stage
from .surface import Weights
from .vec import Vec3, where
from .waiting import nobody, unpack


class Terms(NamedTuple):
    """Terms of the series, one entry per step: radiance = sum weight local color.

    For scenes in which nothing transmits, ``series.iterative(Layers(color, local, reflected))`` is the radiance.
    """

    color: Array
    """(N + 1, C), in a tree (max_nodes, C): c_i; the background at a miss."""
    local: Array
    """(N + 1, C): weight of the colour; 1 at a miss, 0 after it."""
    reflected: Array
    """(N + 1, C): reflectivity_i; 0 at and after a miss."""
    weight: Array
    """(N + 1, C): beta_i, the product of what came before."""


class Trace(NamedTuple):
    """What a ray brought back."""

    radiance: Array
    """(C,)."""
    alpha: Array
    """() opacity of the first hit, 1 - (1 - d_a) (1 - |rho|), for the premultiplied blend of D3D9 (7); 0 for a miss."""
    coverage: Array
    """() d_a of the first hit, 0 for a miss."""
    depth: Array
    """() distance to the first hit, inf for a miss."""
    normal: Vec3
    """Normal of the first hit, to the viewer; 0 for a miss."""
    primitive: Array
    """() int32: number of the primitive first hit, -1 for a miss."""
    account: Account | None
    """Budget, counts and identity of the path."""
    terms: Terms | None
    """What each step added, if asked for."""


def trace_batch(
    scene: Stage,
    rays: Ray,
    options: Options,
    *,
    n_bounces: int,
    max_nodes: int | None = None,
    max_waiting: int = 6,
    account: bool = True,
    terms: bool = False,
    blocks: int = 1,
) -> Trace:
    """`trace` of a staged scene; call it inside jit.

    The batch is worked on in blocks of equal size; in one, where surfaces transmit or terms are asked for.
    """
    known = features(scene)
    assert blocks == 1 or not (known.is_tree or terms)
    steps = (max_nodes or 4 * (n_bounces + 1)) if known.is_tree else n_bounces + 1
    waiting = max(1, min(max_waiting, 2 ** min(n_bounces, 10)))
    # the batch is the last axis, so that a colour is C rows of N: everything runs along N
    begin = batch(functools.partial(start, known=known, account=account))
    look = functools.partial(search, scene, options)
    step = functools.partial(_step, scene, known, options, look, terms)
    walk = divided(begin(rays), blocks)
    walk = walk._replace(found=each(look, walk.branch, blocks))
    if known.is_tree:
        walk = walk._replace(waiting=nobody(walk.branch, waiting))
    found = joined(walk.found, blocks)

    def body(state: tuple[Walk, Array], i: Array) -> tuple[tuple[Walk, Array], Any]:
        if blocks > 1:
            hits = _hits(state[0])
            worth = any_of(pays(hits)[None])
            state = lax.cond(worth, lambda state: taken(state, first(hits)), lambda state: state, state)
        walk, number = state
        some = any_of(_alive(walk)), any_of(_hits(walk))
        walk, shown = each(lambda block: step(i, *block), (walk, *some), blocks)
        return (walk, number), shown

    number = divided(jnp.arange(found.code.size, dtype=jnp.int32), blocks)
    (walk, number), shown = lax.scan(body, (walk, number), jnp.arange(steps, dtype=jnp.int32))
    walk = joined(taken(walk, inverse(number)) if blocks > 1 else walk, blocks)
    hit, coverage, alpha = batch(functools.partial(_first_hit, scene, known.channels))(rays, found)
    missed = found.code < 0
    return Trace(
        walk.radiance.T,
        alpha,
        coverage,
        jnp.where(missed, jnp.inf, hit.t),
        where(missed, hit.n * 0.0, hit.n),
        found.id,
        _settle(walk),
        Terms(*(jnp.moveaxis(x, -1, 0) for x in shown)) if terms else None,
    )


def _alive(walk: Walk) -> Array:
    return lax.stop_gradient(walk.branch.strength) >= 0


def _hits(walk: Walk) -> Array:
    return _alive(walk) & (walk.found.code >= 0)


def _step(
    scene: Stage,
    known: Features,
    options: Options,
    look: Callable[[Branch], Found],
    terms: bool,
    i: Array,
    walk: Walk,
    any_alive: Array,
    any_hit: Array,
) -> tuple[Walk, Shown | None]:
    """One step of a block, recomputed on the way back; nothing for a dead one."""

    @jax.checkpoint
    def move(walk: Walk, any_hit: Array, i: Array) -> tuple[Walk, Shown]:
        def meet(walk: Walk) -> Gathered:
            return visit(scene, known, options, walk, i, any_hit)

        new = lax.cond(any_hit, meet, functools.partial(escape, scene), walk)
        return go_on(walk, new), new.shown

    dark = (jnp.zeros_like(walk.radiance),) * 4
    walk, shown = lax.cond(any_alive, move, lambda walk, *_: (walk, dark), walk, any_hit, i)
    found = lax.cond(any_of(_alive(walk)), look, lambda branch: walk.found, walk.branch)
    return walk._replace(found=found), shown if terms else None


def _settle(walk: Walk) -> Account | None:
    """Account of a batch at the end: what still waits is truncated."""
    if walk.account is None:
        return None
    pending = jnp.where(walk.branch.strength >= 0, walk.branch.beta, 0.0)
    if walk.waiting is not None:
        for strength, record in zip(*walk.waiting, strict=True):
            pending += jnp.where(strength >= 0, unpack(walk.branch, record).beta, 0.0)
    budget = walk.account.budget
    return walk.account._replace(budget=Budget(*(x.T for x in budget._replace(truncated=budget.truncated + pending))))


def _first_hit(scene: Stage, channels: int, ray: Ray, found: Found) -> tuple[Hit, Array, Array]:
    """First hit of a ray, its coverage and its opacity."""
    hit, models = surfaces_at(scene, ray, elsewhere(ray.direction.x), found)
    coverage = alpha = jnp.zeros_like(hit.t)
    for here, weights in models:
        reflected = jnp.broadcast_to(jnp.asarray(weights.reflected, hit.t.dtype), (channels,))
        own = jnp.asarray(weights.alpha, hit.t.dtype)
        coverage = jnp.where(here, own, coverage)
        alpha = jnp.where(here, d3d9.alpha_premultiplied(own, reflected), alpha)
    return hit, coverage, alpha


def surfaces_at(scene: Stage, ray: Ray, origin: Origin, found: Found) -> tuple[Hit, list[tuple[Array, Weights]]]:
    """Hit of one ray, and the weights of each model, with where it is the one."""
    shapes = shapes_at(scene, found)
    hit = hit_at(scene, shapes, ray, origin, found)
    hits = chart_at(scene, shapes, ray, origin, found, hit)
    models, shared_by = models_at(scene, hits, found)
    own = [hit_on(scene, hits, kinds, found) for kinds in shared_by]
    return hit, [(m.here, m.surface.weights(hit)) for hit, m in zip(own, models, strict=True)]
