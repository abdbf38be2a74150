"""Reciprocity and sign: the worst pair of directions, found by a search."""

from __future__ import annotations

import numpy as np

from ..vec import Vec3
from .evaluate import deltas, epsilon, values
from .report import Row
from .search import describe, maximise, pair
from .subject import Subject


def _channel(x: np.ndarray) -> int | None:
    return int(np.argmax(x)) if x.size > 1 else None


def _both_ways(subject: Subject, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """f(wi, wo), f(wo, wi) and the larger of the two, each (N, C)."""
    wi, wo = pair(x)
    there, back = values(subject.model, wi, wo), values(subject.model, wo, wi)
    return there, back, np.maximum(abs(there), abs(back))


def reciprocity(subject: Subject) -> Row:
    """Row of the largest |f(wi, wo) - f(wo, wi)| relative to the larger of the two, above the surface."""

    def score(x: np.ndarray) -> np.ndarray:
        there, back, larger = _both_ways(subject, x)
        return (abs(there - back) / (larger + 1e3 * subject.negligible)).max(
            axis=-1
        )  # of equal defects, where f is large

    best, x = maximise(score, subject.dimension)
    if not np.isfinite(best):
        return Row("reciprocity", "fails", None, "", "f is a number nowhere")
    there, back, larger = (a[0] for a in _both_ways(subject, x[None]))
    apart = abs(there - back) / np.maximum(larger, subject.negligible)
    c = int(np.argmax(apart))
    defect = float(apart[c])
    if defect == 0:
        return Row("reciprocity", "ok", 0.0, "", "f(wi, wo) = f(wo, wi) exactly")
    if defect <= epsilon() ** 0.5:
        return Row("reciprocity", "ok", defect, describe(x, _channel(apart)), f"f(wi, wo) = f(wo, wi) to {defect:.1g}")
    ratio = abs(there[c] / back[c]) if back[c] else np.inf
    text = f"f(wi, wo) = {there[c]:.6g}, f(wo, wi) = {back[c]:.6g}, ratio {ratio:.6g}"
    return Row("reciprocity", "fails", defect, describe(x, _channel(apart)), text)


def negativity(subject: Subject) -> Row:
    """Row of the smallest value on either side of the surface, and of the delta parts."""

    def sides(x: np.ndarray) -> np.ndarray:
        wi, wo = pair(x)
        below = [values(subject.model, Vec3(wi.x, wi.y, -wi.z), wo)] if subject.part == "both" else []
        return np.concatenate([values(subject.model, wi, wo), *below], axis=-1)

    below_all, x = maximise(lambda x: -sides(x).min(axis=-1), subject.dimension)
    if below_all == -np.inf:
        return Row("negativity", "fails", None, "", "f is a number nowhere")
    found = sides(x[None])[0]
    k, channels = int(np.argmin(found)), found.size // (2 if subject.part == "both" else 1)
    side = "wi below the surface, " if k >= channels else ""
    smallest, where = float(found[k]), side + describe(x, k % channels if channels > 1 else None)
    mu = np.sin(np.linspace(0, 0.5 * np.pi, 181))
    delta = deltas(subject.model, mu)
    if np.nanmin(delta) < min(smallest, -64 * epsilon()):
        i = int(np.nanargmin(delta.min(axis=-1)))
        smallest, where = float(np.nanmin(delta)), f"delta part, theta = {90 - np.rad2deg(np.arcsin(mu[i])):.6g}°"
        return Row("negativity", "fails", smallest, where, "a mirror or transmitted part is negative")
    if smallest < -1e8 * epsilon() * subject.negligible:  # 100 roundings of the average value
        return Row("negativity", "fails", smallest, where, "f is negative")
    return Row("negativity", "ok", smallest, where, "the smallest value of f")
