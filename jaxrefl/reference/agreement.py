"""To how many digits two tables of a model agree."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .read import Given
from .vectors import evaluate

FLOOR = 1e-6
"""Of the largest value: an error is relative to at least this much, and two values below it agree."""
MOST = 16.0
"""Digits of equal numbers."""


class Comparison(NamedTuple):
    """Agreement of one quantity."""

    quantity: str
    points: int
    """How many rows were compared, those left out where both are 0 (or below `FLOOR`)."""
    failing: int
    """How many of them agree to fewer digits than were asked for."""
    median: float
    """Digits: -log10 of the relative error, the worst channel of a row, 0 to 16."""
    worst: float
    worst_at: str
    """Where in the file."""
    wi: list[float]
    wo: list[float]
    theirs: list[float]
    ours: list[float]


class Agreement(NamedTuple):
    """Agreement of a file with a model."""

    path: str
    digits: float
    """Digits that were asked for."""
    comparisons: list[Comparison]
    left_out: list[str]
    """Quantities of the file that the model does not offer."""

    @property
    def ok(self) -> bool:
        """Whether every row of every quantity has the digits."""
        return not any(c.failing for c in self.comparisons)


def matched(theirs: np.ndarray, ours: np.ndarray, quantity: str) -> np.ndarray:
    """Ours (N, C) with the channels of theirs; a single one of ours stands for all of theirs.

    Raises:
        ValueError: different numbers of channels.
    """
    if ours.shape[1] not in (1, theirs.shape[1]):
        raise ValueError(
            f"{quantity} has {theirs.shape[1]} channel{'s' * (theirs.shape[1] > 1)} in the file and {ours.shape[1]} "
            "in the model; give the model parameters of as many values"
        )
    return np.broadcast_to(ours, theirs.shape)


def digits_of(theirs: np.ndarray, ours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Digits (N,) of the worst channel of each row, and (N,) whether the row says anything: is not 0 in both."""
    scale = np.max(abs(ours), initial=0.0)
    floor = FLOOR * scale
    wrong = ~np.isfinite(theirs)
    theirs = np.where(wrong, 0.0, theirs)
    says = ((abs(theirs) > floor) | (abs(ours) > floor) | wrong).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        error = abs(theirs - ours) / np.maximum(abs(ours), floor)
        error = np.where((theirs == ours) & ~wrong, 0.0, np.where(wrong | np.isnan(error), np.inf, error))
        digits = np.clip(-np.log10(error.max(axis=1)), 0.0, MOST)
    return np.where(says, digits, MOST), says


def compare(brdf: Any, given: Given, digits: float = 5.0) -> Agreement:
    """Agreement of a table with a model, quantity by quantity: f, and pdf, mirror, through where both have them.

    Args:
        brdf: model, or function f(wi, wo).
        given: from `jaxrefl.reference.read`.
        digits: how many every row has to agree to, [0, 16].

    Raises:
        ValueError: digits out of its range; different numbers of channels.
    """
    if not 0 <= digits <= MOST:
        raise ValueError(f"digits = {digits} is outside [0, {MOST:g}]")
    mine = evaluate(brdf, given.wi, given.wo)
    comparisons = []
    for quantity, theirs in given.values.items():
        if quantity not in mine:
            continue
        ours = matched(theirs, mine[quantity], quantity)
        found, says = digits_of(theirs, ours)
        i = int(np.argmin(found))
        comparisons.append(
            Comparison(
                quantity,
                int(says.sum()),
                int((found < digits).sum()),
                float(np.median(found[says])) if says.any() else MOST,
                float(found[i]),
                given.where[i],
                *(x[i].tolist() for x in (given.wi, given.wo, theirs, ours)),
            )
        )
    return Agreement(given.path, digits, comparisons, [name for name in given.values if name not in mine])
