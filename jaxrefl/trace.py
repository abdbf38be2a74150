"""Rays through a scene: what each brings back, and where a prescribed path leads.

The loop is in `loop`; here are the functions of a user: arguments checked, compiled at the entry.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from .geometry import SKIP, Ray, Remedy, refract, spawn
from .loop import Terms, Trace, surfaces_at, trace_batch
from .params import Interval, foreign_classes, require
from .path import Options
from .scene import Scene, canonical_model, check
from .search import Origin, closest_hit, elsewhere, leaving
from .stage import Stage, stage
from .vec import reflect, where


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
    hit, models = surfaces_at(scene, ray, origin, found)
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


__all__ = ["Terms", "Trace", "check_loop", "follow", "radiance", "trace"]
