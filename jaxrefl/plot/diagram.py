"""Marks on a plot, and the parts of a drawn diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes

from .style import BLUE, GREY, RED, labels


def mark(
    ax: Axes,
    *,
    x: float | None = None,
    y: float | None = None,
    text: str = "",
    side: str = "right",
    at: float = 0.97,
    color: Any = GREY,
) -> list[Any]:
    """Thin reference line at an abscissa or an ordinate, with a text in which ``{}`` becomes the number.

    Args:
        side: of the line on which the text stands: "left" or "right" for x, "above" or "below" for y.
        at: where along the line, in axes fractions.
    """
    value, line = (x, ax.axvline) if x is not None else (y, ax.axhline)
    if value is None:
        raise ValueError("x = None, y = None: one of them is needed")
    artist = line(value, color=color, linestyle=":", linewidth=1)
    if not text:
        return [artist]
    box = {"fontsize": "small", "color": color}
    if x is not None:
        sign, ha = (-1, "right") if side == "left" else (1, "left")
        where, shift, align = (x, at), (3 * sign, 0), {"ha": ha, "va": "top", "rotation": 90}
        note = ax.annotate(text.format(value), where, shift, ax.get_xaxis_transform(), "offset points", **align, **box)
    else:
        sign, va = (-1, "top") if side == "below" else (1, "bottom")
        where, shift, align = (at, value), (0, 2 * sign), {"ha": "right", "va": va}
        note = ax.annotate(text.format(value), where, shift, ax.get_yaxis_transform(), "offset points", **align, **box)
    return [artist, note]


def points(
    ax: Axes, x: Any, y: Any, labels: Sequence[str] = (), dy: Sequence[float] | float = 4, **scatter: Any
) -> Any:
    """Labelled points, readable on any background; ``dy`` shifts each label in printer's points."""
    x, y = np.atleast_1d(np.asarray(x)), np.atleast_1d(np.asarray(y))
    artist = ax.scatter(x, y, zorder=5, **({"s": 18, "color": RED, "edgecolors": "white", "linewidths": 0.7} | scatter))
    for xi, yi, text, shift in zip(x, y, labels, np.broadcast_to(dy, x.shape), strict=False):
        outline = [patheffects.withStroke(linewidth=2, foreground=plt.rcParams["axes.facecolor"])]
        place = {"ha": "center", "va": "bottom" if shift > 0 else "top", "fontsize": "small"}
        ax.annotate(text, (xi, yi), (0, shift), textcoords="offset points", path_effects=outline, **place)
    return artist


def canvas(ax: Axes, xlim: tuple[float, float], ylim: tuple[float, float], title: str | None = None) -> Axes:
    """Axes turned into an empty drawing plane with equal units, for `arrow`, `note` and `dot`."""
    ax.set(xlim=xlim, ylim=ylim, aspect="equal")
    ax.axis("off")
    return labels(ax, title=title)


def arrow(
    ax: Axes, start: Any, end: Any, text: str = "", *, color: Any = None, width: float = 1.6, **place: Any
) -> Any:
    """Arrow between two points of a diagram with a text at its middle; ``place`` goes to the text."""
    color = color or plt.rcParams["text.color"]
    artist = ax.annotate(
        "", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0}
    )
    if text:
        middle = 0.5 * (np.asarray(start) + np.asarray(end))
        note(ax, middle + np.asarray(place.pop("shift", (0, 0))), text, **({"color": color} | place))
    return artist


def note(ax: Axes, at: Any, text: str, **place: Any) -> Any:
    """Text of a diagram, centred at a point, on a patch of the background."""
    box = {
        "boxstyle": "round,pad=0.15",
        "facecolor": plt.rcParams["axes.facecolor"],
        "edgecolor": "none",
        "alpha": 0.85,
    }
    return ax.text(*at, text, **({"ha": "center", "va": "center", "bbox": box} | place))


def dot(ax: Axes, at: Any, radius: float, text: str = "", color: Any = BLUE) -> Any:
    """Filled node of a diagram with a text in it, in the colour of the background."""
    artist = ax.add_patch(plt.Circle(at, radius, color=color, zorder=3))
    ax.text(*at, text, ha="center", va="center", color=plt.rcParams["axes.facecolor"], zorder=4, fontsize="small")
    return artist


def band(ax: Axes, low: float, high: float, color: Any = BLUE, alpha: float = 0.25) -> Any:
    """Horizontal band of a diagram between two ordinates."""
    return ax.axhspan(low, high, color=color, alpha=alpha)


def segment(ax: Axes, start: Any, end: Any, color: Any = GREY) -> Any:
    """Straight line of a diagram, behind its nodes."""
    return ax.plot(*zip(start, end, strict=True), color=color, zorder=1)[0]
