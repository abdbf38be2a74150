"""What an audit found: rows with a verdict each, printed as a table, as JSON or in a notebook."""

from __future__ import annotations

import dataclasses
import html
import json
import math
from typing import Any, NamedTuple

import numpy as np

SCHEMA = "jaxrefl.audit/1"
VERDICTS = ("ok", "fails", "undecided", "not offered", "skipped")


class Row(NamedTuple):
    """One property of a model."""

    name: str
    verdict: str
    """One of `VERDICTS`."""
    number: float | None
    """What the verdict is about: the largest albedo, the smallest value, ..."""
    where: str
    text: str
    """What it means, in a sentence."""
    error: float | None = None
    """Bound on the error of the number, where it is an integral."""

    @property
    def ok(self) -> bool:
        """Whether nothing was found: what is not offered, or skipped, counts as ok."""
        return self.verdict not in ("fails", "undecided")


class Curve(NamedTuple):
    """Directional albedos over the angle, reflected and transmitted and delta parts together."""

    cos_theta: np.ndarray
    """(M,), from grazing to normal."""
    phi: np.ndarray
    """(A,) azimuths; one if the model is isotropic."""
    value: np.ndarray
    """(A, M, C)."""
    error: np.ndarray

    @property
    def offset(self) -> np.ndarray:
        """Distance (M,) from the centre of a sphere of radius 1 at which it is seen under these angles."""
        return np.sqrt((1 - self.cos_theta) * (1 + self.cos_theta))


@dataclasses.dataclass(frozen=True)
class Report:
    """Rows of an audit; ``report["reciprocity"]`` is one of them."""

    model: str
    dtype: str
    rows: tuple[Row, ...]
    view: Curve | None = None
    """What is seen in a uniform environment of radiance 1: the white-furnace sphere. None if it was not asked for."""
    light: Curve | None = None
    """What becomes of a beam."""

    @property
    def ok(self) -> bool:
        """Whether no property fails or is undecided."""
        return all(row.ok for row in self.rows)

    def __getitem__(self, name: str) -> Row:
        for row in self.rows:
            if row.name == name:
                return row
        raise KeyError(f"{name!r} is not one of {', '.join(row.name for row in self.rows)}")

    def _cells(self) -> list[tuple[str, ...]]:
        head = ("property", "verdict", "number", "where", "meaning")
        return [head, *((r.name, r.verdict, _short(r.number), r.where, r.text) for r in self.rows)]

    @property
    def title(self) -> str:
        """The whole in a line."""
        bad = [row.name for row in self.rows if not row.ok]
        return f"{self.model} in {self.dtype}: {'FAILS ' + ', '.join(bad) if bad else 'ok'}"

    def __str__(self) -> str:
        cells = self._cells()
        widths = [max(len(row[i]) for row in cells) for i in range(4)]
        lines = ["  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[4]]) for row in cells]
        return "\n".join([self.title, *(line.rstrip() for line in lines)])

    def to_json(self, indent: int | None = 1) -> str:
        """JSON with the rows and the curves; a number that is not finite is null, the row's text says what it is."""
        facts: dict[str, Any] = {"schema": SCHEMA, "model": self.model, "dtype": self.dtype, "ok": self.ok}
        facts["rows"] = [row._asdict() for row in self.rows]
        for name in ("view", "light"):
            curve = getattr(self, name)
            facts[name] = None if curve is None else {k: x.tolist() for k, x in curve._asdict().items()}
        return json.dumps(_finite(facts), indent=indent, allow_nan=False)

    def _repr_html_(self) -> str:
        head, *rows = self._cells()
        marks = {"ok": "#2e7d32", "fails": "#c62828", "undecided": "#ef6c00"}
        lines = ["<tr>" + "".join(f"<th style='text-align:left'>{cell}</th>" for cell in head) + "</tr>"]
        for row in rows:
            colours = ["inherit", marks.get(row[1], "#757575"), *["inherit"] * 3]
            cells = zip(colours, row, strict=True)
            lines += [
                "<tr>"
                + "".join(f"<td style='text-align:left;color:{c}'>{html.escape(text)}</td>" for c, text in cells)
                + "</tr>"
            ]
        return f"<table><caption>{html.escape(self.title)}</caption>{''.join(lines)}</table>"


def _short(number: float | None) -> str:
    return "" if number is None else f"{number:.6g}"


def _finite(x: Any) -> Any:
    """The same with None for what JSON has no number for."""
    if isinstance(x, dict):
        return {key: _finite(value) for key, value in x.items()}
    if isinstance(x, (list, tuple)):
        return [_finite(value) for value in x]
    return None if isinstance(x, float) and not math.isfinite(x) else x
