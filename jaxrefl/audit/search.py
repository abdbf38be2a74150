"""Pairs of directions as points of a cube, and the largest value of a function on it.

The search looks at a grid, which holds the normal, the horizon, the mirror and the retro direction, and then closes in
on the best places of it, halving the distance each time. It needs no derivative: kinks and jumps do not stop it.
"""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np

from ..vec import Vec3

PAIRS = 16384
"""Pairs that are evaluated at a time: one size, one compilation."""
_STARTS = 8
_ROUNDS = 26  # the last steps are 1e-9 of the first


def unit(elevation: np.ndarray, phi: np.ndarray) -> Vec3:
    """Unit vectors from the angle above the horizon, z exactly 0 at 0."""
    parts = np.cos(elevation) * np.cos(phi), np.cos(elevation) * np.sin(phi), np.sin(elevation)
    return Vec3(*(jnp.asarray(x, float) for x in np.broadcast_arrays(*parts)))


def pair(x: np.ndarray) -> tuple[Vec3, Vec3]:
    """Directions wi and wo of points (N, 3) or (N, 4): theta_i, theta_o, phi_i - phi_o and phi_o, all in [0, 1]."""
    phi = 2 * np.pi * x[:, 3] if x.shape[1] == 4 else np.zeros(len(x))
    up = 0.5 * np.pi * (1 - x[:, :2])
    return unit(up[:, 0], phi + 2 * np.pi * x[:, 2]), unit(up[:, 1], phi)


def describe(x: np.ndarray, channel: int | None = None) -> str:
    """A point of the cube in words."""
    parts = [f"theta_i = {90 * x[0]:.8g}°, theta_o = {90 * x[1]:.8g}°, dphi = {360 * x[2]:.6g}°"]
    parts += [f"phi_o = {360 * x[3]:.6g}°"] if len(x) == 4 else []
    return ", ".join(parts + ([] if channel is None else [f"channel {channel}"]))


def grid(dimension: int) -> np.ndarray:
    """Regular grid of the cube, its ends included; at most `PAIRS` points."""
    n = int(PAIRS ** (1 / dimension))
    n -= 1 - n % 2  # odd: 45 and 180 degrees are on it
    return np.stack([x.ravel() for x in np.indices((n,) * dimension)], axis=-1) / (n - 1)


def scattered() -> np.ndarray:
    """`PAIRS` points (N, 3) in general position: at none of them is a model likely to jump."""
    return np.random.default_rng(0).random((PAIRS, 3))


def _filled(score: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """Scores of at most `PAIRS` points; what is not a number is the worst of all."""
    full = np.concatenate([x, np.repeat(x[:1], PAIRS - len(x), axis=0)])
    found = np.asarray(score(full), float)[: len(x)]
    return np.where(np.isnan(found), -np.inf, found)


def maximise(score: Callable[[np.ndarray], np.ndarray], dimension: int) -> tuple[float, np.ndarray]:
    """Largest score on the cube and where.

    Args:
        score: maps `PAIRS` points (N, dimension) to (N,).
        dimension: 3, or 4 for a model that is not isotropic.
    """
    points = grid(dimension)
    step = 1 / (round(len(points) ** (1 / dimension)) - 1)
    left, starts = _filled(score, points), []
    for _ in range(_STARTS):
        starts.append(points[np.argmax(left)])
        left[np.max(abs(points - starts[-1]), axis=-1) < 2.5 * step] = -np.inf
    x = np.array(starts)
    n = int((PAIRS // _STARTS) ** (1 / dimension))
    n -= 1 - n % 2  # odd: the middle stays
    around = np.stack([a.ravel() for a in np.indices((n,) * dimension)], axis=-1) / (n // 2) - 1
    around = np.concatenate([np.zeros((1, dimension)), around])  # first: it wins a tie, and the search stays
    best = np.full(len(x), -np.inf)
    for _ in range(_ROUNDS):
        near = np.clip(x[:, None] + step * around, 0, 1)
        found = _filled(score, near.reshape(-1, dimension)).reshape(near.shape[:2])
        chosen = np.argmax(found, axis=1)
        x, best = near[np.arange(len(x)), chosen], found[np.arange(len(x)), chosen]
        step /= 2
    k = int(np.argmax(best))
    return float(best[k]), x[k]
