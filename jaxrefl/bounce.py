r"""One step of one ray: shade the hit, spawn the rays that go on, choose which is next.

The same step, whichever the model. With T = exp(-sigma t) of the way that the ray came,

    radiance += beta T w.local (w.emitted + I_a w.ambient + sum_j ...)      then     beta *= T w.reflected

which is `series.bounce_step`, and beta *= T w.transmitted for the refracted branch. The radiance carried is basic
radiance L / n^2: what is shaded inside a medium of index n is divided by n^2. Where nothing transmits the rays form a
chain; else the branches that wait stand in a short list sorted by weight. A branch of weight 0 is followed as any
other, so that the derivative in a reflectivity of 0 is the true one; a weight that a surface left absent is not.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from .beam import reached
from .geometry import Hit, refract, spawn
from .path import Account, Branch, Budget, Features, Medium, Options, Walk
from .search import Found, closest_hit, is_among, leaving
from .series import Layers, State, bounce_step
from .shade import Shading, any_of, batch, once, shade
from .stage import Stage
from .surface.protocol import Weights
from .vec import Vec3, reflect
from .waiting import DEAD, Waiting, pack, put, take, unpack


def search(scene: Stage, options: Options, branch: Branch) -> Found:
    """Nearest hits of the branches of a BATCH of rays."""
    near = reached(scene, branch.ray, branch.strength >= 0)
    return batch(lambda ray, origin: closest_hit(near, ray, origin, options.remedy))(branch.ray, branch.origin)


Shown = tuple[Array, Array, Array, Array]
"""Color, local, reflected and weight of a step, each (C, N)."""


class Gathered(NamedTuple):
    """What a step adds, and what it leaves to be traced; the rest of a walk is not copied in and out of its stage."""

    radiance: Array
    account: Account | None
    shown: Shown
    children: list[Branch]


def visit(scene: Stage, known: Features, options: Options, walk: Walk, step: Array, any_hit: Array) -> Gathered:
    """What the hits of a BATCH of rays show, and what goes on from them; zero weights for a dead ray."""
    branch = walk.branch
    hit, shading = shade(scene, branch.ray, branch.origin, walk.found, options.remedy, known.channels, any_hit)

    def gather(walk: Walk, hit: Hit, shading: Shading) -> Gathered:
        return _gather(scene, known, options, step, walk, hit, shading)

    return once(any_hit, batch(gather), walk._replace(waiting=None), hit, shading)


def escape(scene: Stage, walk: Walk) -> Gathered:
    """The same of a BATCH of rays none of which hits anything, without what only hits need."""

    def gather(walk: Walk) -> Gathered:
        zero, nothing = jnp.zeros_like(walk.branch.beta), walk.branch._replace(strength=0 * walk.branch.strength + DEAD)
        children = [nothing] * (1 if nothing.depth is None else 2)
        return _add(walk, _behind(scene, walk.branch), (zero, zero), walk.found.code < 0, jnp.uint32(0), children)

    return batch(gather)(walk._replace(waiting=None))


def _behind(scene: Stage, branch: Branch) -> Layers:
    """What a ray shows that meets nothing: the background, or nothing in a medium that absorbs."""
    medium, one = branch.medium, jnp.ones_like(branch.beta)
    through = one if medium.sigma is None else jnp.where(medium.sigma > 0, 0.0, one)
    return Layers(scene.radiance_behind(branch.ray.direction) * _per_index(medium) * one, through, 0.0 * one)


def _per_index(medium: Medium) -> Any:
    """1 / n^2: from radiance to basic radiance."""
    return 1.0 if medium.index is None else 1 / medium.index**2


def _gather(
    scene: Stage, known: Features, options: Options, step: Array, walk: Walk, hit: Hit, shading: Shading
) -> Gathered:
    """What one hit adds, and the branches that leave it."""
    branch, found = walk.branch, walk.found
    alive, missed = branch.strength >= 0, found.code < 0
    through = _transmittance(branch.medium, hit.t, missed)
    color, weights = shading.color * _per_index(branch.medium), shading.weights
    there = Layers(color, weights.local * through, weights.reflected * through)
    layer = _choose(missed, _behind(scene, branch), there)
    here = State(walk.radiance, jnp.where(alive, branch.beta, 0.0))
    reaching = Reaching(hit, found, weights, branch, here.beta * through)
    last = (step if branch.depth is None else branch.depth) >= options.n_bounces
    zero = jnp.zeros_like(here.beta)
    kept, cut, truncated = [], zero, zero
    for child in spawned(scene, known, options, reaching, bounce_step(here, layer).beta):
        exists, weak = alive & (child.strength >= 0), child.strength < options.min_weight
        kept.append(child._replace(strength=jnp.where(exists & ~last & ~weak, child.strength, DEAD)))
        cut += jnp.where(exists & ~last & weak, child.beta, 0.0)
        truncated += jnp.where(exists & last, child.beta, 0.0)
    event = (2 * (found.code + 4) + hit.entering).astype(jnp.uint32) * 31 + shading.lit
    return _add(walk, layer, (cut, truncated), missed, jnp.where(missed, jnp.uint32(0), event), kept)


def _add(
    walk: Walk, layer: Layers, ended: tuple[Array, Array], missed: Array, event: Array, children: list[Branch]
) -> Gathered:
    """A layer added to radiance and account; ended is the weight that was cut and truncated."""
    alive = walk.branch.strength >= 0
    beta = jnp.where(alive, walk.branch.beta, 0.0)
    radiance = bounce_step(State(walk.radiance, beta), layer).radiance
    account = walk.account
    if account is not None:
        account = _book(account, beta * layer.local, ended, alive, missed, event)
    local, reflected = (jnp.where(alive, x, 0.0) for x in (layer.local, layer.reflected))
    return Gathered(radiance, account, (layer.color, local, reflected, beta), children)


def go_on(walk: Walk, new: Gathered) -> Walk:
    """What is next: the branch of a chain; in a tree one of two branches or of those that wait. For a BATCH."""
    waiting, walk = walk.waiting, walk._replace(radiance=new.radiance, account=new.account, waiting=None)
    if waiting is None:
        return _follow(walk, new.children[0])
    branching = any_of(new.children[1].strength >= 0) | any_of((waiting.strength >= 0).reshape(-1))
    return lax.cond(branching, _line_up, _line_of_one, walk, waiting, *new.children)


def _follow(walk: Walk, following: Branch) -> Walk:
    """The next branch; a ray that is dead keeps its state, of which nothing can overflow, in value or derivative."""
    dead = walk.branch._replace(strength=0 * walk.branch.strength + DEAD)
    return walk._replace(branch=_choose(following.strength >= 0, following, dead))


def _transmittance(medium: Medium, t: Array, missed: Array) -> Any:
    """exp(-sigma t) of the way to a hit."""
    if medium.sigma is None:
        return 1.0
    return jnp.exp(-medium.sigma * jnp.where(missed, 0.0, t))  # of a hit that is none t may be < 0, and exp overflow


def _leaves(scene: Stage, present: tuple[bool, ...], found: Found) -> Array:
    """Whether a branch leaves the hit: there is one, on a surface that has the weight."""
    if all(present):
        return found.code >= 0
    mine = [is_among(group.ids, found.id) for group, has in zip(scene.groups, present, strict=True) if has]
    return jnp.any(jnp.stack(mine), axis=0) if mine else jnp.zeros_like(found.code, bool)


class Reaching(NamedTuple):
    """A branch that has reached a hit."""

    hit: Hit
    found: Found
    weights: Weights
    branch: Branch
    beta: Array
    """(C,) throughput that arrives, extinction of the way included."""


def spawned(scene: Stage, known: Features, options: Options, reaching: Reaching, reflected: Array) -> list[Branch]:
    """Reflected branch with a throughput and, in a tree, the refracted one.

    Under total reflection the transmitted weight joins the reflected one. The reflected branch stays in its medium; the
    refracted one is inside the primitive or outside of everything.
    """
    hit, found, weights, branch, beta = reaching
    mirrors, medium = _leaves(scene, known.reflecting, found), branch.medium
    if known.absorbs:
        medium = medium._replace(sigma=weights.sigma_reflected + (0.0 if medium.inside is None else medium.inside))
    depth = None if branch.depth is None else branch.depth + 1

    def child(direction: Vec3, inside: Array, beta: Array, medium: Medium, exists: Array) -> Branch:
        strength = jnp.where(exists, lax.stop_gradient(_largest(beta)), DEAD)
        origin = leaving(hit, found, direction, inside, options.remedy)
        return Branch(spawn(hit, direction, options.remedy), origin, beta, depth, medium, strength)

    mirror_direction = reflect(hit.wo, hit.n)
    if not known.is_tree:
        return [child(mirror_direction, ~hit.entering, reflected, medium, mirrors)]
    refracts = _leaves(scene, known.transmitting, found)
    direction, total = refract(hit.wo, hit.n, jnp.where(hit.entering, weights.eta, 1 / weights.eta))
    onwards = jnp.where(found.code < 0, 0.0, weights.transmitted) * beta
    inside = jnp.where(hit.entering, weights.sigma, 0.0) if known.absorbs else None
    refracted = Medium(jnp.where(hit.entering, weights.eta, 1.0), inside, inside)
    joined = reflected + jnp.where(total, onwards, 0.0)
    return [
        child(mirror_direction, ~hit.entering, joined, medium, mirrors | (refracts & total)),
        child(direction, hit.entering, jnp.where(total, 0.0, onwards), refracted, refracts & ~total),
    ]


def _largest(color: Array) -> Array:
    """Largest channel; of a few written out, because a reduction is a kernel of its own."""
    return functools.reduce(jnp.maximum, list(color)) if color.shape[0] <= 8 else jnp.max(color)


def _choose(condition: Array, a: Any, b: Any) -> Any:
    return jax.tree.map(lambda x, y: jnp.where(condition, x, y), a, b)


def _line_up(walk: Walk, waiting: Waiting, a: Branch, b: Branch) -> Walk:
    """The stronger of two branches follows, the other waits; if neither exists, the strongest that waits follows.

    The weight of a branch for which there is no room is truncated. For a BATCH.
    """
    first = a.strength >= b.strength
    following, other = _choose(first, a, b), _choose(first, b, a)
    done = following.strength < 0  # and then the other one is dead, too: of taking and putting one happens
    strongest, record, waiting = take(waiting, done)
    head = unpack(other, record)._replace(strength=strongest)
    waiting, strength, dropped = put(waiting, other.strength, pack(other))
    account = walk.account
    if account is not None:
        no_room = jnp.where(strength >= 0, unpack(other, dropped).beta, 0.0)
        budget = account.budget
        account = account._replace(budget=budget._replace(truncated=budget.truncated + no_room))
    return _follow(walk._replace(waiting=waiting, account=account), _choose(done, head, following))


def _line_of_one(walk: Walk, waiting: Waiting, a: Branch, _: Branch) -> Walk:
    """Nothing is refracted and nothing waits."""
    return _follow(walk._replace(waiting=waiting), a)


def _book(account: Account, shown: Array, ended: tuple[Any, Any], alive: Array, missed: Array, event: Array) -> Account:
    """The account after a step."""
    budget, (cut, truncated) = account.budget, ended
    return Account(
        Budget(
            budget.shaded + jnp.where(missed, 0.0, shown),
            budget.escaped + jnp.where(missed, shown, 0.0),
            budget.cut + cut,
            budget.truncated + truncated,
        ),
        account.rays + alive.astype(jnp.int32),
        account.hits + (alive & ~missed).astype(jnp.int32),
        jnp.where(alive, account.path_id * 961 + event, account.path_id),
    )
