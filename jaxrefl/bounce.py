r"""One step of one ray: shade the hit, spawn the rays that go on, choose which is next.

The same step, whichever the model. With T = exp(-sigma t) of the way that the ray came,

    radiance += beta T w.local (w.emitted + I_a w.ambient + sum_j ...)      then     beta *= T w.reflected

which is `series.bounce_step`, and beta *= T w.transmitted for the refracted branch. The radiance carried is basic
radiance L / n^2: what is shaded inside a medium of index n is divided by n^2. Where nothing transmits the rays form a
chain; else the branches that wait stand in a short list sorted by weight. A branch of weight 0 is followed as any
other, so that the derivative in a reflectivity of 0 is the true one; a weight that a surface left absent is not.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from .geometry import Hit, Ray, Remedy, refract, spawn
from .scene import Stage
from .series import Layers, State, bounce_step
from .shade import Found, Origin, Shading, closest_hit, elsewhere, hits_at, is_among, legal_hit, pick, shade
from .surface.protocol import Weights, is_absent
from .vec import Vec3, reflect

DEAD = -1.0  # strength of a branch that does not exist


class Budget(NamedTuple):
    """Where the weight of a ray went, each (C,) and added up on its own.

    The sum is 1 where every hit passes on what it does not show: PERRIN's blend, lossless glass. What is missing was
    absorbed; what is above 1 was made by coefficients that nothing bounds.
    """

    shaded: Array
    """Sum of beta w.local over the hits."""
    escaped: Array
    """Weight of the rays that left the scene."""
    cut: Array
    """Weight of the branches not followed for being weaker than ``min_weight``."""
    truncated: Array
    """Weight of what lies behind the last bounce, or found no room."""

    @property
    def total(self) -> Array:
        """Sum of the four."""
        return self.shaded + self.escaped + self.cut + self.truncated


class Account(NamedTuple):
    """What is kept of a path besides its radiance."""

    budget: Budget
    """Where its weight went."""
    rays: Array
    """() int32: rays traced, the first one included."""
    hits: Array
    """() int32: how many of them hit something."""
    path_id: Array
    """() uint32: equal for equal sequences of primitives, branches and lights seen: no edge lies between."""


class Features(NamedTuple):
    """What is known of a scene without its numbers."""

    channels: int
    absorbs: bool
    reflecting: tuple[bool, ...]
    """Per group of surfaces, whether its reflected weight exists."""
    transmitting: tuple[bool, ...]
    """Likewise the transmitted one."""

    @property
    def is_tree(self) -> bool:
        """Whether a ray can branch."""
        return any(self.transmitting)


class Medium(NamedTuple):
    """What a ray runs through; None where no surface needs it."""

    index: Any
    """() index of the solid it is inside of, 1 outside."""
    inside: Any
    """(C,) extinction of that solid."""
    sigma: Any
    """(C,) extinction of this way."""


class Branch(NamedTuple):
    """A ray to be traced."""

    ray: Ray
    origin: Origin
    beta: Array
    """(C,) throughput."""
    depth: Any
    """() int32: bounces behind it; None in a chain, where every ray has as many."""
    medium: Medium
    strength: Array
    """() largest channel of beta, without derivatives; negative: the branch does not exist."""


class Walk(NamedTuple):
    """State of one path."""

    radiance: Array
    branch: Branch
    found: Found
    waiting: tuple[Branch, ...]
    account: Account | None


class Options(NamedTuple):
    """Numbers of the loop."""

    remedy: Remedy
    min_weight: Any
    n_bounces: Any


def features(scene: Stage) -> Features:
    """Channels of a scene, and which of its surfaces reflect, transmit and absorb; nothing is computed."""
    seen: list[Weights] = []
    shapes: list[tuple[int, ...]] = [(1,), jnp.shape(scene.ambient)]

    def probe(scene: Stage) -> Array:
        hit = legal_hit(scene)
        for group in scene.groups:
            surface = pick(group.surface, group.ids, jnp.zeros((), jnp.int32))
            seen.append(surface.weights(hit))
            shapes.extend(jnp.shape(x) for x in (*seen[-1], *surface.local(hit, hit.n)))
        shapes.append(jnp.shape(scene.radiance_behind(hit.n)))
        shapes.extend(
            jnp.shape(x)[1:] for light in scene.lights for x in (light.diffuse, light.specular, light.ambient)
        )
        return hit.t

    jax.eval_shape(probe, scene)
    absorbs = any(not is_absent(w.sigma) or not is_absent(w.sigma_reflected) for w in seen)
    present = [tuple(not is_absent(getattr(w, name)) for w in seen) for name in ("reflected", "transmitted")]
    return Features(jnp.broadcast_shapes(*shapes)[0], absorbs, *present)


def start(ray: Ray, known: Features, waiting: int, account: bool) -> Walk:
    """Nothing gathered, weight 1; made from the ray, so that it is mapped and sharded as the ray is."""
    zero = 0.0 * ray.direction.x
    none, count = jnp.zeros((known.channels,), zero.dtype) + zero, jnp.zeros_like(zero, jnp.int32)
    tree, absorbs = known.is_tree, known.absorbs
    medium = Medium(zero + 1 if tree else None, none if tree and absorbs else None, none if absorbs else None)
    branch = Branch(ray, elsewhere(zero), none + 1, count if tree else None, medium, zero + 1)
    kept = Account(Budget(none, none, none, none), count, count, count.astype(jnp.uint32)) if account else None
    return Walk(none, branch, Found(zero, count), (branch._replace(strength=zero + DEAD),) * waiting, kept)


def search(scene: Stage, options: Options, walk: Walk) -> Walk:
    """Nearest hit of the current branch."""
    return walk._replace(found=closest_hit(scene, walk.branch.ray, walk.branch.origin, options.remedy))


def visit(
    scene: Stage, known: Features, options: Options, walk: Walk, step: Array, any_alive: Array
) -> tuple[Walk, tuple[Array, Array, Array, Array]]:
    """One step: what the hit of the current branch shows, what goes on from it, and what is next.

    Returns:
        the new state; (color, local, reflected, weight) of this step, each (C,), zero weights for a dead ray.
    """
    branch, found = walk.branch, walk.found
    alive, missed = branch.strength >= 0, found.code < 0
    hit, hits = hits_at(scene, branch.ray, branch.origin, found, any_alive)
    shading = shade(scene, hit, hits, found, options.remedy, known.channels, any_alive)
    through = _transmittance(branch.medium, hit.t, missed)
    per_index = 1.0 if branch.medium.index is None else 1 / branch.medium.index**2
    layer = Layers(
        jnp.where(missed, scene.radiance_behind(branch.ray.direction), shading.color) * per_index,
        jnp.where(missed, 1.0, shading.weights.local) * through,
        jnp.where(missed, 0.0, shading.weights.reflected) * through,
    )
    here = State(walk.radiance, jnp.where(alive, branch.beta, 0.0))
    after = bounce_step(here, layer)
    reaching = Reaching(hit, found, shading.weights, branch, here.beta * through)
    children = spawned(scene, known, options, reaching, after.beta)
    last = (step if branch.depth is None else branch.depth) >= options.n_bounces
    kept, cut, truncated = [], 0.0, 0.0
    for child in children:
        exists, weak = alive & (child.strength >= 0), child.strength < options.min_weight
        kept.append(child._replace(strength=jnp.where(exists & ~last & ~weak, child.strength, DEAD)))
        cut += jnp.where(exists & ~last & weak, child.beta, 0.0)
        truncated += jnp.where(exists & last, child.beta, 0.0)
    following, waiting, no_room = kept[0], walk.waiting, 0.0
    if known.is_tree:
        following, waiting, no_room = _line_up(kept[0], kept[1], waiting)
    # a ray that is dead keeps its state: nothing it is made of can overflow, in value or derivative
    following = _choose(following.strength >= 0, following, branch._replace(strength=0 * branch.strength + DEAD))
    account = walk.account
    if account is not None:
        shown = here.beta * layer.local
        account = _book(account, shown, (cut, truncated + no_room), alive, missed, _event(found, hit, shading))
    layer = layer._replace(local=jnp.where(alive, layer.local, 0.0), reflected=jnp.where(alive, layer.reflected, 0.0))
    return Walk(after.radiance, following, found, waiting, account), (*layer, here.beta)


def _transmittance(medium: Medium, t: Array, missed: Array) -> Any:
    """exp(-sigma t) of the way that the ray came; of an infinite one 0 where sigma > 0."""
    if medium.sigma is None:
        return 1.0
    return jnp.where(missed, jnp.where(medium.sigma > 0, 0.0, 1.0), jnp.exp(-medium.sigma * t))


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
    left = jnp.where(options.remedy.skip, found.id, -1)
    depth = None if branch.depth is None else branch.depth + 1

    def child(direction: Vec3, inside: Array, beta: Array, medium: Medium, exists: Array) -> Branch:
        strength = jnp.where(exists, lax.stop_gradient(jnp.max(beta)), DEAD)
        return Branch(spawn(hit, direction, options.remedy), Origin(left, inside), beta, depth, medium, strength)

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


def _choose(condition: Array, a: Any, b: Any) -> Any:
    return jax.tree.map(lambda x, y: jnp.where(condition, x, y), a, b)


def _line_up(a: Branch, b: Branch, waiting: tuple[Branch, ...]) -> tuple[Branch, tuple[Branch, ...], Array | float]:
    """The branch to follow, those that wait, strongest first, and the weight of one for which there is no room."""
    first = a.strength >= b.strength
    following, other = _choose(first, a, b), _choose(first, b, a)
    slots = []
    for slot in waiting:
        before = other.strength > slot.strength
        slots.append(_choose(before, other, slot))
        other = _choose(before, slot, other)
    no_room = jnp.where(other.strength >= 0, other.beta, 0.0)
    if not slots:
        return following, (), no_room
    done = following.strength < 0
    moved = (*slots[1:], slots[-1]._replace(strength=jnp.full_like(other.strength, DEAD)))
    return _choose(done, slots[0], following), tuple(map(lambda x, y: _choose(done, x, y), moved, slots)), no_room


def _event(found: Found, hit: Hit, shading: Shading) -> Array:
    """Number of what happened at a hit: the primitive, the root, the side and the lights seen."""
    what = (2 * (found.code + 4) + hit.entering).astype(jnp.uint32)
    return what * 31 + jnp.where(found.code < 0, 0, shading.lit).astype(jnp.uint32)


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
