"""The branches of a tree that wait: a short list of places per ray, from which the strongest is taken.

Everything here is for a BATCH, whose rays are the last axis. A branch waits as F numbers in a column, integers among
them (below 2^24, which a float32 holds exactly): one array is written and read instead of one per field.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

DEAD = -1.0  # strength of a branch that does not exist


class Waiting(NamedTuple):
    """K places per ray."""

    strength: Array
    """(K, N): largest channel of the weight; negative: the place is free."""
    records: Array
    """(K, F, N): what waits, by `pack`."""


def pack(branch: Any) -> Array:
    """Branches as columns (F, N)."""
    leaves = jax.tree.leaves(branch)
    dtype = jnp.result_type(*(x.dtype for x in leaves if jnp.issubdtype(x.dtype, jnp.floating)))
    return jnp.concatenate([x.astype(dtype).reshape(-1, x.shape[-1]) for x in leaves])


def unpack(like: Any, records: Array) -> Any:
    """Branches of columns (F, N), in the form of others."""
    leaves, structure = jax.tree.flatten(like)
    rows, first = [], 0
    for x in leaves:
        count = math.prod(x.shape[:-1])
        rows.append(records[first : first + count].reshape(x.shape).astype(x.dtype))
        first += count
    return jax.tree.unflatten(structure, rows)


def nobody(branch: Any, places: int) -> Waiting:
    """So many free places for such branches."""
    record = pack(branch)
    free = 0 * branch.strength + DEAD
    return Waiting(jnp.broadcast_to(free, (places, *free.shape)), jnp.broadcast_to(record, (places, *record.shape)))


def _first(flags: list[Array]) -> list[Array]:
    """Of several flags the first that is set, alone."""
    taken, alone = jnp.zeros_like(flags[0]), []
    for flag in flags:
        alone.append(flag & ~taken)
        taken = taken | flag
    return alone


def _chosen(waiting: Waiting, best: Callable[[Array, Array], Array]) -> tuple[Array, list[Array]]:
    """Extreme strength, and which place has it."""
    strengths = list(waiting.strength)
    value = functools.reduce(best, strengths)
    return value, _first([s == value for s in strengths])


def _read(waiting: Waiting, place: list[Array]) -> Array:
    """Record (F, N) of a place."""
    record = waiting.records[0]
    for here, other in zip(place[1:], waiting.records[1:], strict=True):
        record = jnp.where(here, other, record)
    return record


def take(waiting: Waiting, wanted: Array) -> tuple[Array, Array, Waiting]:
    """Strongest record that waits, where wanted: strength (N,) and record (F, N), and what is left."""
    strength, place = _chosen(waiting, jnp.maximum)
    left = [jnp.where(wanted & here, DEAD, s) for here, s in zip(place, waiting.strength, strict=True)]
    return strength, _read(waiting, place), waiting._replace(strength=jnp.stack(left))


def put(waiting: Waiting, strength: Array, record: Array) -> tuple[Waiting, Array, Array]:
    """A record into the place of the weakest, if that is weaker; and the strength and record that found no room."""
    weakest, place = _chosen(waiting, jnp.minimum)
    enters = strength > weakest
    here = jnp.stack([flag & enters for flag in place])
    dropped = jnp.where(enters, weakest, strength), jnp.where(enters, _read(waiting, place), record)
    return Waiting(
        jnp.where(here, strength, waiting.strength), jnp.where(here[:, None], record, waiting.records)
    ), *dropped
