"""Pairs of directions that find mistakes: spread over both hemispheres, dense about the mirror direction, and edges."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..quadrature import spread_points

GRAZING = 1e-3
"""Smallest cosine of a direction: at 0 several models diverge."""
_MOST_VIEWS = 64


class Directions(NamedTuple):
    """Pairs of directions, a view and its lights one after the other."""

    wi: np.ndarray
    """(N, 3) unit vectors."""
    wo: np.ndarray
    view: np.ndarray
    """(N,) number of the view, 0 to V - 1."""
    cos_theta_o: np.ndarray
    """(V,)."""
    phi_o: np.ndarray
    """(V,)."""


def _unit(cos_theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    sine = np.sqrt((1 - cos_theta) * (1 + cos_theta))
    return np.stack([sine * np.cos(phi) + 0.0, sine * np.sin(phi) + 0.0, cos_theta], axis=-1)  # + 0: no -0


def _even(n: int, shift: np.ndarray) -> np.ndarray:
    """(n, 2) points that fill the unit square evenly."""
    return (shift + spread_points(n + 1).T[1:]) % 1.0


def _edges(mu: float, phi: float) -> np.ndarray:
    """Mirror and retro direction, normal, and grazing light from ahead, from behind and from the side."""
    pairs = dict.fromkeys([(mu, 1.0), (mu, 0.0), (1.0, 0.0), (GRAZING, 1.0), (GRAZING, 0.0), (GRAZING, 0.5)])
    if mu == 1.0:
        pairs.pop((1.0, 1.0))
    cosines, turns = np.array(list(pairs)).T
    return _unit(cosines, phi + np.pi * turns)


def _about(centre: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Directions at 0.001 to 0.5 radians from a centre; those that would be below the surface are mirrored in it."""
    angle, around = 0.001 * 500 ** points[:, 0], 2 * np.pi * points[:, 1]
    side = np.array([-centre[1], centre[0], 0.0]) if abs(centre[2]) < 1 - 1e-12 else np.array([0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    third = np.cross(centre, side)
    w = np.cos(angle)[:, None] * centre + np.sin(angle)[:, None] * (
        np.cos(around)[:, None] * side + np.sin(around)[:, None] * third
    )
    w[:, 2] = np.maximum(abs(w[:, 2]), GRAZING)
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def spread_directions(n: int, seed: int = 0) -> Directions:
    """Pairs of unit directions above the surface, the same for the same n and seed.

    Up to 64 views, the normal and grazing among them; for each its edges (mirror, retro, normal, grazing), then
    lights of which a third lie about the mirror direction, at all distances, and the rest anywhere.

    Raises:
        ValueError: n is not a positive integer, or seed a negative one.
    """
    if not isinstance(n, (int, np.integer)) or n < 1:
        raise ValueError(f"n = {n!r} must be an integer in [1, inf)")
    if not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"seed = {seed!r} must be an integer in [0, inf)")
    shifts = np.random.default_rng(seed).random((2, 2))
    views = min(_MOST_VIEWS, math.isqrt(n))
    cosines, turns = _even(views, shifts[0]).T
    cosines = (np.arange(views) + cosines) / views  # one in each of equal strips
    cosines[0], cosines[-1] = GRAZING, 1.0
    phi = 2 * np.pi * turns
    counts = np.diff(np.round(np.linspace(0, n, views + 1)).astype(int))
    points = _even(n, shifts[1])
    lights, first = [], 0
    for mu, angle, count in zip(cosines, phi, counts, strict=True):
        edges = _edges(float(mu), float(angle))[:count]
        free = points[first : first + count - len(edges)]
        near = len(free) // 3
        anywhere = _unit(np.maximum(free[near:, 0], GRAZING), 2 * np.pi * free[near:, 1])
        mirror = _unit(np.array([mu]), np.array([angle + np.pi]))[0]
        lights += [edges, _about(mirror, free[:near]), anywhere]
        first += count
    view = np.repeat(np.arange(views), counts)
    return Directions(np.concatenate(lights), _unit(cosines, phi)[view], view, cosines, phi)
