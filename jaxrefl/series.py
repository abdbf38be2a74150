r"""The bounce series: what a chain of reflections adds up to, by PERRIN (1)-(6) and by the additive rule of JHU.

One layer per hit. Layer i shows a colour c_i with a local weight and passes on what comes behind it with a reflected
weight; the two source documents differ in those weights alone:

    PERRIN (1), convex:   c^i = (1 - alpha_i) c_i + alpha_i c^(i+1)      local = 1 - alpha, reflected = alpha
    JHU, additive:        I^i = I_local,i + k_rg,i I^(i+1)               local = 1,         reflected = k_rg

Everything here is `bounce_step`, one affine map, under `lax.scan`: forwards it is the iterative form (5), backwards
the recursive form (1), and it is the step the tracer takes at each hit. Everything is elementwise, so a reflectivity
may be a scalar or a spectrum (C,) per layer. Superscript c^i is the colour from hit i on, printed like a power (S11).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from .params import Interval, checked, floats, require


class Layers(NamedTuple):
    """Hits of a path in order, each array (N + 1, ...): colour shown, its weight, and the weight of what lies
    behind."""

    color: Array
    local: Array
    reflected: Array


class State(NamedTuple):
    """What a path has gathered (radiance) and how much the next hit counts (beta)."""

    radiance: Array
    beta: Array


class Series(NamedTuple):
    """Sum of a bounce series and its parts."""

    radiance: Array
    """(...): the sum, tail included."""
    weights: Array
    """(N + 1, ...): beta_i local_i, which multiplies color_i."""
    partial: Array
    """(N + 1, ...): the sum after hit i, without tail."""
    remainder: Array
    """(...): beta_(N+1), the product of all reflected weights: what a tail colour is multiplied by."""


def bounce_step(state: State, layer: Layers) -> State:
    """One hit: radiance += beta * local * color, then beta *= reflected."""
    return State(state.radiance + state.beta * layer.local * layer.color, state.beta * layer.reflected)


@checked(reflectivity="[0, 1]")
def convex(color: Float[ArrayLike, "..."], reflectivity: Float[ArrayLike, "..."], fold: bool = False) -> Layers:
    """Layers of PERRIN's convex rule: local weight 1 - alpha, reflected weight alpha.

    Args:
        color: c_i, shape (N + 1,) or (N + 1, C); c_i is the colour at hit i without reflections.
        reflectivity: alpha_i in [0, 1], shape (N + 1,) or (N + 1, C) (the document's alpha).
        fold: set alpha_N := 0, so that the weights sum to 1; without it the truncated sum darkens by the
            remainder (S19).

    Source: PERRIN (1). N "reflections" make N + 1 terms, i = 0 is the primary hit (S15); the first term carries its
    1 - alpha_0 too, which the document's last paragraph forgets (S17).
    """
    color, reflectivity = _columns(color, reflectivity)
    if fold:
        reflectivity = reflectivity.at[-1].set(0)
    return Layers(color, 1 - reflectivity, reflectivity)


@checked(reflected="[0, inf)")
def additive(local_color: Float[ArrayLike, "..."], reflected: Float[ArrayLike, "..."]) -> Layers:
    """Layers of the additive Whitted rule I = I_local + k_rg I_reflected: local weight 1.

    Args:
        local_color: I_local at each hit, shape (N + 1,) or (N + 1, C).
        reflected: k_rg at each hit, [0, inf) as printed; nothing there bounds it by 1 (S32).

    Source: JHU, "Global Light Terms" (I_reflected there is I_r on the next slide, S29) and "Attenuation".
    """
    color, reflected = _columns(local_color, reflected)
    return Layers(color, jnp.ones_like(reflected), reflected)


def _columns(color: ArrayLike, weight: ArrayLike) -> tuple[Array, Array]:
    """Both with one leading axis of hits; a spectrum on one side broadcasts against a scalar per hit on the other."""
    color, weight = floats(color, weight)
    if color.ndim == 0 or weight.ndim == 0 or color.shape[0] != weight.shape[0] or color.shape[0] == 0:
        raise ValueError(
            f"color has shape {color.shape}, its weights {weight.shape}; both start with the number of hits >= 1"
        )
    ndim = max(color.ndim, weight.ndim)
    return tuple(x.reshape(x.shape + (1,) * (ndim - x.ndim)) for x in (color, weight))  # type: ignore[return-value]


def after_last_hit(layers: Layers, n_hits: ArrayLike, background: ArrayLike = 0.0) -> Layers:
    """Layers of a path that left the scene after ``n_hits`` hits: the miss shows the background, nothing follows.

    c_i = 0 for every intersection that does not occur (4); alpha of a miss is undefined there (S16) and is 0 here, so
    that entry n_hits is the background colour in full. ``n_hits`` may be traced; n_hits > N leaves the layers as they
    are.
    """
    i = jnp.arange(layers.color.shape[0]).reshape((-1,) + (1,) * (layers.color.ndim - 1))
    miss = i >= n_hits
    return Layers(
        jnp.where(i == n_hits, background, jnp.where(miss, 0.0, layers.color)),
        jnp.where(miss, 1.0, layers.local),
        jnp.where(miss, 0.0, layers.reflected),
    )


def _start(layers: Layers) -> State:
    """Nothing gathered, weight 1; made from the layers, so that it is mapped and sharded as they are."""
    zero = jnp.zeros_like(layers.color[0] * layers.local[0] * layers.reflected[0])
    return State(zero, zero + 1)


def _forwards(state: State, layer: Layers) -> tuple[State, tuple[Array, Array]]:
    new = bounce_step(state, layer)
    return new, (state.beta * layer.local, new.radiance)


def _backwards(behind: Array, layer: Layers) -> tuple[Array, Array]:
    here = bounce_step(State(jnp.zeros_like(behind), jnp.ones_like(behind)), layer)
    value = here.radiance + here.beta * behind
    return value, value


def iterative(layers: Layers, tail: ArrayLike = 0.0) -> Series:
    """Sum of the series front to back: sum_i local_i c_i prod_(k<i) reflected_k, plus remainder * tail.

    Args:
        layers: from `convex` or `additive`, N + 1 hits.
        tail: c^(N+1), the colour behind the last layer; 0 truncates. For the other convention, alpha_N := 0, use
            ``convex(..., fold=True)``. In (2) the tail stands outside the product, whose index i is reused (S12).

    Returns:
        Series(radiance, weights, partial, remainder).

    Multilinear, so differentiable to any order, at alpha = 0 as well (products, no division).
    Source: PERRIN (2), (5); with more layers (6). (3) restates (1) at N + 1 (S13).
    """
    end, (weights, partial) = lax.scan(_forwards, _start(layers), layers)
    return Series(end.radiance + end.beta * tail, weights, partial, end.beta)


def recursive(layers: Layers, tail: ArrayLike = 0.0) -> Float[Array, "hits ..."]:
    """Colours c^0 ... c^N of the recursion c^i = local_i c_i + reflected_i c^(i+1), with c^(N+1) = tail.

    c^0 is the pixel; equal to `iterative` by induction. With tail = 0 this is (4), which needs c^(N+1) = 0 as an
    assumption: if alpha_i = 1 for all i > N, c_i = 0 alone leaves it undetermined (S14).
    Source: PERRIN (1), (4).
    """
    behind = _start(layers).radiance + jnp.asarray(tail, layers.color.dtype)
    return lax.scan(_backwards, behind, layers, reverse=True)[1]


def periodic_limit(layers: Layers) -> Float[Array, "..."]:
    """Sum of the infinite series in which the given layers repeat for ever: L / (1 - beta) after one period.

    One layer is the constant series, c for the convex rule and I / (1 - k) for the additive one; two layers are the
    corridor between two facing mirrors.

    Raises:
        ValueError: if the product of the reflected weights of one period is not below 1 (outside jit only): the sum
            then diverges, or, for convex mirrors, does not determine c^0 (S18).

    Source: PERRIN (6).
    """
    period = iterative(layers)
    require("product of the reflected weights", period.remainder, Interval.parse("[0, 1)"))
    return period.radiance / (1 - period.remainder)


@checked(reflected="[0, inf)", transmitted="[0, inf)")
def tree(local_color: ArrayLike, reflected: ArrayLike, transmitted: ArrayLike, depth: int) -> Series:
    """Homogeneous reflect + transmit tree I = I_local + k_rg I_r + k_tg I_t of a given depth.

    Level d has 2^d nodes whose weights sum to (k_rg + k_tg)^d, so that the tree is an additive series in
    k_rg + k_tg; it diverges with depth if that is >= 1 (S32).

    Source: JHU, "Global Light Terms".
    """
    if depth < 0:
        raise ValueError(f"depth = {depth} is outside [0, inf)")
    local_color, k = floats(local_color, jnp.asarray(reflected) + jnp.asarray(transmitted))
    local_color, k = jnp.broadcast_arrays(local_color, k)
    return iterative(additive(*(jnp.broadcast_to(x, (depth + 1, *x.shape)) for x in (local_color, k))))


@checked(n_bounces="[0, inf)", reflectivity_max="[0, 1]", color_max="[0, inf)")
def truncation_bound(n_bounces: int, reflectivity_max: ArrayLike, color_max: ArrayLike = 1.0) -> Float[Array, "..."]:
    """Bound on what PERRIN's sum (5) leaves out after N bounces: alpha_max^(N+1) c_max, for colours in [0, c_max].

    The exact bound for given layers is ``iterative(layers).remainder * color_max``. Source: PERRIN (2), (6).
    """
    reflectivity_max, color_max = floats(reflectivity_max, color_max)
    return color_max * reflectivity_max ** (n_bounces + 1)


def bounces_needed(epsilon: float, reflectivity_max: float, color_max: float = 1.0) -> int:
    """Smallest N whose `truncation_bound` is <= epsilon: N >= ln(epsilon / c_max) / ln(alpha_max) - 1.

    Args:
        epsilon: allowed error, (0, inf), in the unit of the colours.
        reflectivity_max: largest reflectivity, [0, 1).
        color_max: largest colour, (0, inf).

    Raises:
        ValueError: an argument outside its range; at reflectivity 1 no N is enough.

    A host function: takes and returns Python numbers. Source: PERRIN (5).
    """
    for name, value, interval in (
        ("epsilon", epsilon, "(0, inf)"),
        ("reflectivity_max", reflectivity_max, "[0, 1)"),
        ("color_max", color_max, "(0, inf)"),
    ):
        require(name, float(value), Interval.parse(interval))
    ratio = epsilon / color_max
    if reflectivity_max <= ratio:
        return 0
    log_ratio = math.log(epsilon) - math.log(color_max)  # finite also where the quotient underflows
    n = max(0, math.ceil(log_ratio / math.log(reflectivity_max) - 1))
    while n > 0 and 0 < reflectivity_max**n <= ratio:  # the logarithms may round to the wrong side
        n -= 1
    while reflectivity_max ** (n + 1) > ratio > 0:
        n += 1
    return n
