"""The bounce loop: what a batch of rays brings back.

Everything is a function of one ray, mapped; the loop over bounces belongs to the batch and stops computing when its
last ray is dead. It is one `lax.scan`, the same in value, forward and reverse mode, whose step is recomputed on the way
back: the memory of a gradient grows by the state of a ray per bounce, not by everything that a bounce computes.

PERRIN: "find the next reflection point and start over". JHU: I(P) = I_local(P) + k_rg I(P_r) + k_tg I(P_t).
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from . import d3d9
from .blocks import divided, first, inverse, joined, numbers, pays, taken
from .bounce import Shown, escape, search, visit
from .geometry import SKIP, Hit, Ray, Remedy, refract, spawn
from .params import Interval, foreign_classes, require
from .path import Account, Budget, Features, Options, Walk, features, start
from .scene import Scene, canonical_model, check
from .search import Found, Origin, closest_hit, elsewhere, leaving
from .shade import any_of, batch, chart_at, hit_at, hit_on, models_at, shapes_at
from .stage import Stage, stage
from .surface import Weights
from .vec import Vec3, reflect, where
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
    """`trace` of a staged scene; call it inside jit. The batch is worked on in blocks of equal size."""
    known = features(scene)
    steps = (max_nodes or 4 * (n_bounces + 1)) if known.is_tree else n_bounces + 1
    waiting = max(1, min(max_waiting, 2 ** min(n_bounces, 10)))
    # the batch is the last axis, so that a colour is C rows of N: everything runs along N
    begin = batch(functools.partial(start, known=known, account=account))
    look = batch(functools.partial(search, scene, options))
    step = functools.partial(_step, scene, known, options, look)
    walk = divided(begin(rays), blocks)
    walk = walk._replace(found=lax.map(look, walk.branch))
    if known.is_tree:
        walk = walk._replace(waiting=jax.vmap(lambda branch: nobody(branch, waiting))(walk.branch))
    found = joined(walk.found)

    def body(state: tuple[Walk, Array], i: Array) -> tuple[tuple[Walk, Array], Any]:
        hits = _hits(state[0])
        if blocks > 1:
            state = lax.cond(
                any_of(pays(hits)[None]), lambda state: taken(state, first(hits)), lambda state: state, state
            )
            hits = _hits(state[0])
        walk, number = state
        some = any_of(_alive(walk)), any_of(hits)
        walk, shown = lax.map(lambda block: step(i, *block), (walk, *some))
        return (walk, number), shown if terms else None

    begin_with = walk, numbers(blocks, found.code.size // blocks)
    (walk, number), shown = lax.scan(body, begin_with, jnp.arange(steps, dtype=jnp.int32))
    walk = joined(taken(walk, inverse(number)) if blocks > 1 else walk)
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
        Terms(*(jnp.moveaxis(x[:, 0], -1, 0) for x in shown)) if terms else None,
    )


def _alive(walk: Walk) -> Array:
    return lax.stop_gradient(walk.branch.strength) >= 0


def _hits(walk: Walk) -> Array:
    return _alive(walk) & (walk.found.code >= 0)


def _step(
    scene: Stage,
    known: Features,
    options: Options,
    look: Any,
    i: Array,
    walk: Walk,
    any_alive: Array,
    any_hit: Array,
) -> tuple[Walk, Shown]:
    """One step of a block, recomputed on the way back; nothing for a dead one."""

    @jax.checkpoint
    def move(walk: Walk, i: Array, any_hit: Array) -> tuple[Walk, Shown]:
        step = functools.partial(visit, scene, known, options)
        return lax.cond(any_hit, step, lambda walk, *_: escape(scene, walk), walk, i, any_hit)

    dark = (jnp.zeros_like(walk.radiance),) * 4
    walk, shown = lax.cond(any_alive, move, lambda walk, *_: (walk, dark), walk, i, any_hit)
    found = lax.cond(any_of(_alive(walk)), look, lambda branch: walk.found, walk.branch)
    return walk._replace(found=found), shown


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
    hit, models = _surfaces(scene, ray, elsewhere(ray.direction.x), found)
    coverage = alpha = jnp.zeros_like(hit.t)
    for here, weights in models:
        reflected = jnp.broadcast_to(jnp.asarray(weights.reflected, hit.t.dtype), (channels,))
        own = jnp.asarray(weights.alpha, hit.t.dtype)
        coverage = jnp.where(here, own, coverage)
        alpha = jnp.where(here, d3d9.alpha_premultiplied(own, reflected), alpha)
    return hit, coverage, alpha


def _surfaces(scene: Stage, ray: Ray, origin: Origin, found: Found) -> tuple[Hit, list[tuple[Array, Weights]]]:
    """Hit of one ray, and the weights of each model, with where it is the one."""
    shapes = shapes_at(scene, found)
    hit = hit_at(scene, shapes, ray, origin, found)
    hits = chart_at(scene, shapes, ray, origin, found, hit)
    models, shared_by = models_at(scene, hits, found)
    own = [hit_on(scene, hits, kinds, found) for kinds in shared_by]
    return hit, [(m.here, m.surface.weights(hit)) for hit, m in zip(own, models, strict=True)]


@functools.partial(jax.jit, static_argnames=("n_bounces", "max_nodes", "max_waiting", "account", "terms", "classes"))
def _traced(
    scene: Scene, rays: Ray, remedy: Remedy, min_weight: Any, n_bounces: int, classes: Any, **static: Any
) -> Trace:
    staged = stage(scene)
    return trace_batch(
        staged,
        canonical_model(rays, staged.dtype),
        Options(remedy, min_weight, n_bounces),
        n_bounces=n_bounces,
        **static,
    )


def trace(
    scene: Scene,
    rays: Ray,
    n_bounces: int,
    *,
    max_nodes: int | None = None,
    max_waiting: int = 6,
    min_weight: Any = 0.0,
    remedy: Remedy = SKIP,
    account: bool = True,
    terms: bool = False,
) -> Trace:
    """What each of a batch of rays brings back.

    Args:
        scene: the scene; its dtype rules.
        rays: components (N,), unit directions (not checked); they start outside of every medium.
        n_bounces: 0 = the first hit only; static.
        max_nodes: largest number of rays per path where a surface transmits, 4 (n_bounces + 1) by default; static.
        max_waiting: branches of a path that can wait, [1, inf); the weakest one is dropped; static.
        min_weight: branches weaker than this are cut, [0, inf); 0 cuts nothing.
        remedy: against self-shadowing.
        account: keep budget, counts and path identity; static.
        terms: keep what each step added; static.

    Raises:
        ValueError: a value of the scene out of its range, a scene without objects, n_bounces below 0.

    Pure; differentiable in every leaf of scene and rays, except for the motion of edges (silhouettes, shadows).
    """
    check_loop(n_bounces, max_nodes, max_waiting, min_weight)
    check(scene)
    static = {"max_nodes": max_nodes, "max_waiting": max_waiting, "account": account, "terms": terms}
    return _traced(scene, rays, remedy, min_weight, n_bounces=n_bounces, classes=foreign_classes(scene), **static)


def check_loop(n_bounces: int, max_nodes: int | None, max_waiting: int, min_weight: Any) -> None:
    """Raise `ValueError` if a setting of the loop is out of its range, or no whole number where it has to be one."""
    for name, value in (("n_bounces", n_bounces), ("max_nodes", max_nodes), ("max_waiting", max_waiting)):
        if value is not None and not isinstance(value, (int, np.integer)):
            raise ValueError(f"{name} = {value!r} is not a whole number")
    require("n_bounces", n_bounces, Interval.parse("[0, inf)"))
    require("max_nodes", 1 if max_nodes is None else max_nodes, Interval.parse("[1, inf)"))
    require("max_waiting", max_waiting, Interval.parse("[1, inf)"))
    require("min_weight", min_weight, Interval.parse("[0, inf)"))


def radiance(scene: Scene, ray: Ray, n_bounces: int, **options: Any) -> Array:
    """Radiance (C,) that one ray brings back; options as in `trace`."""
    batch = jax.tree.map(lambda x: jnp.asarray(x)[None], ray)
    return trace(scene, batch, n_bounces, account=False, **options).radiance[0]


@functools.partial(jax.jit, static_argnames="classes")
def _followed(scene: Scene, ray: Ray, remedy: Remedy, transmits: Array, classes: Any) -> Ray:
    staged = stage(scene)
    ray = canonical_model(ray, staged.dtype)
    begin = ray, elsewhere(ray.direction.x), jnp.isfinite(ray.direction.x)
    (ray, _, alive), _ = lax.scan(functools.partial(_one_branch, staged, remedy), begin, transmits)
    return Ray(ray.origin, where(alive, ray.direction, ray.direction * 0.0))


def _one_branch(
    scene: Stage, remedy: Remedy, state: tuple[Ray, Origin, Array], transmits: Array
) -> tuple[tuple[Ray, Origin, Array], None]:
    """The next hit, and the prescribed branch there; a ray that has none stays as it is and is dead."""
    ray, origin, alive = state
    found = closest_hit(scene, ray, origin, remedy)
    hit, models = _surfaces(scene, ray, origin, found)
    eta = jnp.ones_like(hit.t)
    for here, weights in models:
        eta = jnp.where(here, weights.eta, eta)
    refracted, total = refract(hit.wo, hit.n, jnp.where(hit.entering, eta, 1 / eta))
    direction = where(transmits, refracted, reflect(hit.wo, hit.n))
    exists = alive & (found.code >= 0) & ~(transmits & total)
    new = spawn(hit, direction, remedy), leaving(hit, found, direction, hit.entering == transmits, remedy)
    ray, origin = jax.tree.map(lambda a, b: jnp.where(exists, a, b), new, (ray, origin))
    return (ray, origin, exists), None


def follow(scene: Scene, ray: Ray, branches: str, remedy: Remedy = SKIP) -> Ray:
    """Ray after a prescribed sequence of branches, such as ``"TRT"`` for the primary rainbow.

    Args:
        scene: the scene.
        ray: one ray.
        branches: one letter per hit, R for the reflected and T for the transmitted branch.
        remedy: against self-shadowing.

    Returns:
        the ray that leaves the last hit; with direction 0 if a hit is missed or a T meets total reflection.

    Raises:
        ValueError: another letter.

    The step is that of `trace` with the branch prescribed, whatever its weight. Differentiable in scene and ray.
    """
    if set(branches) - set("RT"):
        raise ValueError(f"branches = {branches!r} must be a sequence of the letters R and T")
    check(scene)
    transmits = jnp.array([letter == "T" for letter in branches], bool)
    return _followed(scene, ray, remedy, transmits, classes=foreign_classes(scene))
