"""The arguments of the functions of films, checked and taken relative to the medium of incidence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import Interval, Real, floats, require
from .layers import Medium, medium, to_complex

Layers: TypeAlias = Float[ArrayLike, "..."] | Sequence[Any]
"""Quantity of the layers, the first axis theirs, from the top down; a number if they have it in common."""
Half: TypeAlias = Any
"""Index of a half-space: a real number n, or a pair (n, k) such as the ``Index`` that a dispersion model returns."""

_RANGES = {
    name: Interval.parse(text)
    for name, text in (
        *(("cos_theta", "[0, 1]"), ("wavelength_nm", "(0, inf)"), ("n", "(0, inf)"), ("k", "[0, inf)")),
        *(("thickness_nm", "[0, inf)"), ("outside", "(0, inf)"), ("inside n", "(0, inf)"), ("inside k", "[0, inf)")),
    )
}


class Given(NamedTuple):
    """Arguments relative to the medium of incidence: layers are eta, kappa and x = 2 pi n_outside d / lambda."""

    c: Array
    layers: tuple[Array, Array, Array]
    outside: Medium
    inside: Medium
    index_inside: Array


def given(
    cos_theta: Real, wavelength_nm: Real, n: Layers, k: Layers, thickness_nm: Layers, outside: Real, inside: Half
) -> Given:
    """Arguments of `jaxrefl.films.film`, checked where they are concrete."""
    pair = tuple(inside) if isinstance(inside, (tuple, list)) else (inside, 0.0)
    if len(pair) != 2:
        raise ValueError(f"inside has {len(pair)} entries; it is an index n, or a pair (n, k)")
    given = (cos_theta, wavelength_nm, n, k, thickness_nm, outside, *pair)
    arguments = tuple(_array(name, value) for name, value in zip(_RANGES, given, strict=True))
    for (name, interval), value in zip(_RANGES.items(), arguments, strict=True):
        require(name, value, interval)
    c, wavelength, n, k, d, outer, n_in, k_in = floats(*arguments)
    counts = {name: v.shape[0] for name, v in (("n", n), ("k", k), ("thickness_nm", d)) if v.ndim}
    if len(set(counts.values())) != 1:
        raise ValueError(f"layers = {counts}: the first axis of n, k and thickness_nm is that of the layers, and equal")
    (count,) = set(counts.values())
    n, k, d = (v if v.ndim else jnp.broadcast_to(v, (count,)) for v in (n, k, d))
    shape = _shape(
        {"cos_theta": c, "wavelength_nm": wavelength, "outside": outer, "inside n": n_in, "inside k": k_in},
        {"n": n, "k": k, "thickness_nm": d},
    )
    eta, kappa = (jax.vmap(lambda v: v / outer)(v) for v in (n, k))
    x = jax.vmap(lambda d: 2 * jnp.pi * outer * d / wavelength)(d)
    c, n_in, k_in = jnp.broadcast_to(c, shape), n_in / outer, k_in / outer
    q = to_complex(c, jnp.zeros_like(c))
    return Given(c, (eta, kappa, x), Medium(q, jnp.stack([q, q])), medium(c, n_in, k_in), to_complex(n_in, k_in))


def _array(name: str, value: Any) -> Any:
    """A list as an array; its entries have one shape."""
    if not isinstance(value, (list, tuple)):
        return value
    try:
        return jnp.asarray(value)
    except (TypeError, ValueError) as error:
        shapes = [np.shape(entry) for entry in jax.tree.leaves(value)]
        if len(set(shapes)) < 2:
            raise
        hint = "; films.stack makes n and k of one pair per layer" if name in ("n", "k") else ""
        raise ValueError(f"{name} has entries of shapes {shapes}; they must be equal{hint}") from error


def _shape(single: dict[str, Array], layered: dict[str, Array]) -> tuple[int, ...]:
    """Shape of the result: of the arguments, and of those of the layers without their first axis."""
    shapes = {name: v.shape for name, v in single.items()} | {name: v.shape[1:] for name, v in layered.items()}
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        text = ", ".join(f"{name} {v.shape}" for name, v in (layered | single).items() if v.shape)
        raise ValueError(
            f"shapes {text} do not broadcast, the first axis of n, k and thickness_nm left aside; "
            "films.stack makes n and k of one pair per layer"
        ) from None


def stack(*indices: tuple[Real, Real]) -> tuple[Float[Array, "layers ..."], Float[Array, "layers ..."]]:
    """Indices of several layers, from the top down, as the arrays (n, k) that `film` takes.

    Args:
        indices: one pair (n, k) per layer, numbers or arrays that broadcast, such as what dispersion models return.

    Returns:
        (n, k), each (layers, ...).

    Raises:
        ValueError: no layer is given, or an entry is not a pair.
    """
    if not indices or any(not isinstance(index, (tuple, list)) or len(index) != 2 for index in indices):
        raise ValueError(f"indices = {indices!r}: at least one layer is needed, each a pair (n, k)")
    values = jnp.broadcast_arrays(*floats(*(value for index in indices for value in index)))
    return jnp.stack(values[0::2]), jnp.stack(values[1::2])
