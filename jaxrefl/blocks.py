"""A batch in blocks, whose rays change places so that those which have something to do lie together.

A block without such rays is skipped; in a batch as it comes nearly every block has some. What moves is the state of a
ray, once it pays; its number moves with it, by which all are put back in the end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

LINE = 64  # flags that are summed at once


def divided(tree: Any, blocks: int) -> Any:
    """Leaves (..., N) as (blocks, ..., N / blocks); as they are, if there is to be one block."""
    if blocks == 1:  # an axis more is one more way to be laid out, and so a copy in each step of a mapped tracer
        return tree
    return jax.tree.map(lambda x: jnp.moveaxis(x.reshape(*x.shape[:-1], blocks, -1), -2, 0), tree)


def joined(tree: Any, blocks: int) -> Any:
    """What was divided in one piece again."""
    if blocks == 1:
        return tree
    return jax.tree.map(lambda x: jnp.moveaxis(x, 0, -2).reshape(*x.shape[1:-1], -1), tree)


def each(function: Callable[[Any], Any], tree: Any, blocks: int) -> Any:
    """A function of one block, of all of them one after the other."""
    return function(tree) if blocks == 1 else lax.map(function, tree)


def pays(flags: Array) -> Array:
    """Whether fewer blocks would have a flag if those with flags lay together."""
    count = jnp.sum(flags, axis=1, dtype=jnp.int32)
    return jnp.sum(count > 0, dtype=jnp.int32) * flags.shape[1] - jnp.sum(count) >= flags.shape[1]


def first(flags: Array) -> Array:
    """Order in which those with a flag come first, each in the order in which they were; (blocks, B)."""
    flag = flags.reshape(-1)
    before = _sums(flag) - flag
    with_flag = before[-1] + flag[-1]
    number = jnp.arange(flag.size, dtype=jnp.int32)
    return inverse(jnp.where(flag, before, with_flag + number - before).reshape(flags.shape))


def inverse(order: Array) -> Array:
    """Order that undoes another."""
    number = jnp.arange(order.size, dtype=jnp.int32)
    back = jnp.zeros_like(number).at[order.reshape(-1)]
    return back.set(number, unique_indices=True, mode="promise_in_bounds").reshape(order.shape)


@jax.checkpoint
def taken(tree: Any, order: Array) -> Any:
    """Leaves (blocks, ..., B) in another order."""
    block, place = jnp.divmod(order, order.shape[1])

    def take(x: Array) -> Array:
        rows = x[0, ..., 0].size
        row = jnp.arange(rows, dtype=jnp.int32)[:, None]
        index = (block[:, None] * rows + row) * order.shape[1] + place[:, None]
        return x.reshape(-1).at[index].get(mode="promise_in_bounds", unique_indices=True).reshape(x.shape)

    return jax.tree.map(take, tree)


def _sums(flag: Array) -> Array:
    """Running sum, in lines by a product with a triangle of ones (a third of the time of `cumsum` on a CPU)."""
    lines = jnp.pad(flag, (0, -flag.size % LINE)).reshape(-1, LINE).astype(jnp.float32)
    within = (lines @ jnp.triu(jnp.ones((LINE, LINE), jnp.float32))).astype(jnp.int32)
    before = jnp.cumsum(within[:, -1]) - within[:, -1]
    return (within + before[:, None]).reshape(-1)[: flag.size]
