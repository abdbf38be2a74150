"""The state of one path: its branches, what they run through, and the account that is kept of them."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from .geometry import Ray, Remedy
from .search import Found, Origin, elsewhere, pick
from .shade import legal_hit
from .stage import Stage
from .surface.protocol import Weights, is_absent
from .texture import resolve
from .waiting import Waiting


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
    """() uint32: equal for equal sequences of primitives, branches and lights seen; textures are not looked at."""


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
    waiting: Waiting | None
    """Branches that wait; None in a chain."""
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

    def probe() -> Array:
        hit = legal_hit(scene)
        for group in scene.groups:
            surface = resolve(pick(group.surface, group.ids, jnp.zeros((), jnp.int32)), hit.uv)
            seen.append(surface.weights(hit))
            if jnp.ndim(seen[-1].eta):
                name, shape = type(surface).__name__, jnp.shape(seen[-1].eta)
                raise ValueError(f"{name}.weights: eta has shape {shape}; a ray is bent by one index, shape ()")
            shapes.extend(jnp.shape(x) for x in (*seen[-1], *surface.local(hit, hit.n)))
        shapes.append(jnp.shape(scene.radiance_behind(hit.n)))
        shapes.extend(
            jnp.shape(x)[1:] for light in scene.lights for x in (light.diffuse, light.specular, light.ambient)
        )
        return hit.t

    jax.eval_shape(probe)
    absorbs = any(not is_absent(w.sigma) or not is_absent(w.sigma_reflected) for w in seen)
    present = [tuple(not is_absent(getattr(w, name)) for w in seen) for name in ("reflected", "transmitted")]
    lengths = sorted({shape[-1] for shape in shapes if shape} - {1})
    if len(lengths) > 1:
        raise ValueError(f"the spectra of the scene have {' and '.join(map(str, lengths))} channels; they must agree")
    return Features(jnp.broadcast_shapes(*shapes)[0], absorbs, *present)


def start(ray: Ray, known: Features, account: bool) -> Walk:
    """Nothing gathered, weight 1; made from the ray, so that it is mapped and sharded as the ray is."""
    zero = 0.0 * ray.direction.x
    none, count = jnp.zeros((known.channels,), zero.dtype) + zero, jnp.zeros_like(zero, jnp.int32)
    tree, absorbs = known.is_tree, known.absorbs
    medium = Medium(zero + 1 if tree else None, none if tree and absorbs else None, none if absorbs else None)
    branch = Branch(ray, elsewhere(zero), none + 1, count if tree else None, medium, zero + 1)
    kept = Account(Budget(none, none, none, none), count, count, count.astype(jnp.uint32)) if account else None
    return Walk(none, branch, Found(count), None, kept)
