"""Two models beside each other: where they differ most."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..params import Interval, require
from .evaluate import values
from .report import Curve
from .search import describe, maximise, pair
from .subject import TINY, Subject


class Difference(NamedTuple):
    """Largest difference of two models."""

    value: float
    where: str
    a: float
    """Value of the first model there."""
    b: float


class Comparison(NamedTuple):
    """Two models beside each other; delta parts count in the albedos only."""

    absolute: Difference
    """Of f in 1/sr, among directions above the surface."""
    relative: Difference
    """Of f, relative to the larger of the two."""
    reflected: Difference
    """Of f cos theta_i, what is reflected of a beam: it stays finite where f diverges at grazing light."""
    albedo: Difference
    """Of the directional albedos with the view held, absolute."""


def compare(a: Any, b: Any, below_deg: float = 90.0) -> Comparison:
    """Largest absolute and relative difference of two models, and where; difference of their albedos.

    Args:
        a, b: models or functions f(wi, wo), of the same number of channels unless one of them has one.
        below_deg: largest angle of either direction from the normal, (0, 90]; several models diverge at 90.

    Raises:
        ValueError: another number of channels; an angle out of its range.
    """
    require("below_deg", below_deg, Interval.parse("(0, 90]"))
    first, second = Subject.of(a), Subject.of(b)
    dimension = max(first.dimension, second.dimension)
    reach = np.array([below_deg / 90, below_deg / 90, 1.0, 1.0])[:dimension]

    def both(x: np.ndarray, cosine: bool) -> tuple[np.ndarray, np.ndarray]:
        wi, wo = pair(x * reach)
        f, g = (values(s.model, wi, wo) for s in (first, second))
        if 1 not in (f.shape[-1], g.shape[-1]) and f.shape != g.shape:
            raise ValueError(f"b has {g.shape[-1]} channels, a has {f.shape[-1]}")
        mu = np.asarray(wi.z)[:, None] if cosine else 1.0
        one, two = np.broadcast_arrays(f * mu, g * mu)
        return one, two

    def largest(relative: bool = False, cosine: bool = False) -> Difference:
        def apart(f: np.ndarray, g: np.ndarray) -> np.ndarray:
            return abs(f - g) / (np.maximum(np.maximum(abs(f), abs(g)), TINY) if relative else 1.0)

        value, x = maximise(lambda x: apart(*both(x, cosine)).max(axis=-1), dimension)
        f, g = (each[0] for each in both(x[None], cosine))
        c = int(np.argmax(apart(f, g)))
        return Difference(value, describe(x * reach, c if f.size > 1 else None), float(f[c]), float(g[c]))

    of_f = largest(), largest(relative=True), largest(cosine=True)
    return Comparison(*of_f, _albedos(first.view, second.view))


def _albedos(one: Curve, two: Curve) -> Difference:
    """Difference of two curves; of an anisotropic model and an isotropic one at every azimuth."""
    p, q = np.broadcast_arrays(one.value, two.value)
    a, m, c = np.unravel_index(np.argmax(abs(p - q)), p.shape)
    where = f"theta_o = {np.rad2deg(np.arccos(one.cos_theta[m])):.6g}°"
    where += f", channel {c}" if p.shape[-1] > 1 else ""
    return Difference(float(abs(p - q)[a, m, c]), where, float(p[a, m, c]), float(q[a, m, c]))
