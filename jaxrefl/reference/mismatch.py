"""Differences of convention, recognised by trying them.

Another renderer's table was made with some convention for its directions (a frame), for its factors (cosine, pi) and
for its parameters (alpha or roughness). Every combination is tried; the simplest one of those that make the table
agree with the model is the explanation.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..params import parameters, validate
from .agreement import digits_of, matched
from .read import Given, from_angles
from .vectors import evaluate

CONSTANT = "constant factor"
WIDTHS = ("alpha", "alpha_x", "alpha_y", "roughness", "width")
_ROWS = 2000  # of a longer file, evenly spaced
SHARE = 10.0
"""Percent of the rows that an explanation may leave unexplained."""
_GAIN, _LEAST = 1.5, 3.0  # digits that it has to gain, and to reach


class Explanation(NamedTuple):
    """Differences of convention that make a table agree with a model."""

    quantity: str
    names: tuple[str, ...]
    factor: float | None
    """Constant factor, theirs over ours, if that is one of them."""
    median: float
    """Digits with them; likewise"""
    worst: float


class _Frame(NamedTuple):
    names: tuple[str, ...]
    wi: np.ndarray
    wo: np.ndarray


def _frames(given: Given, rows: np.ndarray) -> Iterator[_Frame]:
    """Directions of the file, read in every way."""
    readings: list[tuple[tuple[str, ...], Any, Any]] = [((), given.wi[rows], given.wo[rows])]
    if given.angles is not None:
        readings.append((("angles are in degrees",), *from_angles(np.deg2rad(given.angles[rows]))))
    for (read, wi, wo), up, sign, swap in itertools.product(readings, "zy", ("", "i", "o", "io"), (False, True)):
        names = [*read]
        if up == "y":
            names.append("the normal is y, not z")
            wi, wo = (np.stack([w[:, 0], -w[:, 2], w[:, 1]], axis=-1) for w in (wi, wo))
        if swap:
            names.append("wi and wo are swapped")
            wi, wo = wo, wi
        if sign:
            names.append({"i": "wi points", "o": "wo points", "io": "wi and wo point"}[sign] + " toward the surface")
            wi, wo = -wi if "i" in sign else wi, -wo if "o" in sign else wo
        yield _Frame(tuple(names), wi, wo)


def _models(brdf: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The model, and with the parameters that another convention would make of its own."""
    yield (), brdf
    if not dataclasses.is_dataclass(brdf) or isinstance(brdf, type):
        return
    for p in parameters(brdf):
        value = getattr(brdf, p.name)
        others = {}
        if p.name in WIDTHS:
            others = {"square": np.square(value), "square root": np.sqrt(value)}
        elif p.unit == "rad":
            others = {"value as degrees": np.deg2rad(value)}
        for name, other in others.items():
            changed = dataclasses.replace(brdf, **{p.name: other})
            try:
                validate(changed)
            except ValueError:
                continue
            against = "" if p.unit else " (alpha against roughness: alpha = roughness^2)"
            yield (f"theirs has {p.name} = {_short(other)}, the {name} of {_short(value)}{against}",), changed


def _short(value: Any) -> str:
    return ",".join(format(x, ".6g") for x in np.ravel(value))


def _factors(frame: _Frame, quantity: str) -> Iterator[tuple[tuple[str, ...], np.ndarray]]:
    """Factors between the conventions, (N, 1)."""
    cosine = frame.wi[:, 2:]
    one = np.ones_like(cosine)
    shapes = {"": one, "the cosine of wi is included": cosine, "it is divided by the cosine of wi": _over(cosine)}
    if quantity == "pdf":
        half = frame.wi + frame.wo
        along = np.sum(frame.wo * half, axis=1, keepdims=True) / np.maximum(
            np.linalg.norm(half, axis=1, keepdims=True), 1e-300
        )
        shapes["it is the density of the half vector (the Jacobian 1 / (4 wo.h) is missing)"] = 4 * along
    constants = {"": 1.0, "a factor 1/pi is missing": np.pi, "a factor 1/pi is there once too often": 1 / np.pi}
    for (shape, values), (name, constant) in itertools.product(shapes.items(), constants.items()):
        yield tuple(filter(None, (shape, name))), values * constant


def _over(x: np.ndarray) -> np.ndarray:
    return np.where(x == 0, 0.0, 1 / np.where(x == 0, 1.0, x))


def _ratio(theirs: np.ndarray, ours: np.ndarray) -> float:
    """Median of theirs / ours over the larger half of the values, 0 if there is none."""
    usable = np.isfinite(theirs) & (ours > 0)
    usable &= ours >= (np.median(ours[usable]) if usable.any() else 0.0)
    return float(np.median(theirs[usable] / ours[usable])) if usable.any() else 0.0


def _score(theirs: np.ndarray, ours: np.ndarray) -> tuple[float, float, float]:
    """Digits that all but a tenth of the rows have, their median, and the worst."""
    digits, says = digits_of(theirs, ours)
    if not says.any() or not (abs(ours) > 0).any():
        return 0.0, 0.0, 0.0
    said = digits[says]
    return float(np.percentile(said, SHARE)), float(np.median(said)), float(digits.min())


def explain(brdf: Any, given: Given, quantity: str = "f") -> Explanation | None:
    """Differences of convention between a table and a model, None if none of those known makes them agree.

    Recognised: the cosine of wi included or divided by, pi missing or too often, any constant factor, wi and wo
    swapped, directions toward the surface, y as normal, degrees, alpha against roughness, the order of the channels,
    and for a pdf the density of the half vector; and all combinations of one of each kind.
    An explanation has to hold for nine rows of ten to 3 digits, and to gain 1.5 over the table as it is.
    """
    every = -(-len(given.wi) // _ROWS)
    rows = np.arange(0, len(given.wi), every)
    theirs = given.values[quantity][rows]
    orders = {"": theirs} | (
        {"the channels are in reverse order": theirs[:, ::-1]} if quantity == "f" and theirs.shape[1] > 1 else {}
    )
    plain, found = 0.0, []
    for (renamed, model), frame in itertools.product(_models(brdf), list(_frames(given, rows))):
        mine = evaluate(model, frame.wi, frame.wo)
        if quantity not in mine:
            return None
        base = matched(theirs, mine[quantity], quantity)
        for (factors, factor), (order, table) in itertools.product(_factors(frame, quantity), orders.items()):
            ours = factor * base
            names = (*frame.names, *renamed, *factors, *filter(None, (order,)))
            score, median, worst = _score(table, ours)
            plain = max(plain, score) if not names else plain
            found.append((score, len(names) + 0.0, Explanation(quantity, names, None, median, worst)))
            constant = _ratio(table, ours)
            if constant > 0 and not any("1/pi" in name for name in factors):
                score, median, worst = _score(table, constant * ours)
                with_factor = Explanation(quantity, (*names, CONSTANT), constant, median, worst)
                found.append((score, len(names) + 1.5, with_factor))
    best = max(score for score, _, _ in found)
    if best < max(_LEAST, plain + _GAIN):
        return None
    # the simplest of those that do about as well as the best; of equally simple ones the better
    enough = max(best - 1.0, _LEAST, plain + _GAIN)
    good = [entry for entry in found if entry[0] >= enough]
    return min(good, key=lambda entry: (entry[1], -entry[0]))[2]
