"""Slopes and minima of elementwise functions, by automatic differentiation, and the ends of predicates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from numpy.typing import ArrayLike

NODES = 200
"""Of the Gauss-Legendre rule for averages and fits: twice as many as change the last digit."""


def slopes(f: Callable[..., Array], *args: Array) -> tuple[Array, ...]:
    """Partial derivatives of an elementwise f in each of its arguments, at every element."""
    derivatives: tuple[Array, ...] = jax.grad(lambda *xs: jnp.sum(f(*xs)), argnums=tuple(range(len(args))))(*args)
    return derivatives


def minimum(f: Callable[[Any], Array], grid: Array) -> Array:
    """Place of the smallest value of an elementwise f that holds parameters: an array of their shape.

    The smallest on the grid but its last point, then the root of f' between the neighbours, by bisection: near a
    minimum the values are the same to half their digits, the slope is not. The first point of the grid, if it is the
    smallest, stays as it is, the end of the range.
    """
    start = jnp.argmin(jax.vmap(f)(grid[:-1]), axis=0)

    def halve(_: int, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        falling = slopes(f, middle)[0] < 0
        return jnp.where(falling, middle, low), jnp.where(falling, high, middle)

    low, high = lax.fori_loop(0, 52, halve, (grid[jnp.maximum(start - 1, 0)], grid[start + 1]))
    return jnp.where(start == 0, grid[0], 0.5 * (low + high))


def extrema(f: Callable[[Any], Array]) -> tuple[Array, Array]:
    """Angles in degrees of the largest and the smallest value of f(cos theta) between 0 and 90 degrees."""
    sign = jnp.array([[-1.0], [1.0]])
    high, low = jnp.rad2deg(minimum(lambda theta: sign * f(jnp.cos(theta)), jnp.linspace(0.0, jnp.pi / 2, 181)))
    return high, low


def boundary(holds: Callable[[np.ndarray], ArrayLike], low: ArrayLike, high: ArrayLike) -> np.ndarray:
    """Place between ``low`` and ``high`` where an elementwise predicate ceases to hold, by bisection on the host."""
    low, high = np.array(low, float), np.array(high, float)
    for _ in range(52):
        middle = 0.5 * (low + high)
        still = np.asarray(holds(middle))
        low, high = np.where(still, middle, low), np.where(still, high, middle)
    return 0.5 * (low + high)
