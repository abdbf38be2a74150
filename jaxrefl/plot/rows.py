"""A chart with one row per thing: its name, a bar from a reference to its value, and a text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .diagram import mark
from .style import GREY, labels


def rows(
    ax: Axes,
    names: Sequence[str],
    values: Any,
    *,
    base: float = 0.0,
    colors: Sequence[Any] | None = None,
    texts: Sequence[str] = (),
    xlabel: str | None = None,
    title: str | None = None,
    xlim: tuple[float, float] | None = None,
    log: bool = False,
) -> list[Any]:
    """Named values, the first at the top: a dot, joined to the reference ``base``, with a text to its right.

    Args:
        names: (n,) written to the left; empty strings leave the place free.
        values: (n,).
        colors: (n,) of the dots.
        texts: (n,) beside them.
        log: logarithmic abscissa.

    Returns:
        the artists of the dots.
    """
    x, y = np.asarray(values, float), np.arange(len(values))
    shades = colors or [GREY] * len(x)
    artists = []
    for i, shade in enumerate(shades):
        ax.plot([base, x[i]], [y[i], y[i]], color=shade, linewidth=2.2, solid_capstyle="butt")
        artists += ax.plot(x[i], y[i], "o", color=shade, markersize=6)
    for i, text in enumerate(texts):
        ax.annotate(text, (max(x[i], base), y[i]), (7, 0), textcoords="offset points", va="center", fontsize="small")
    if log:
        ax.set_xscale("log")
    mark(ax, x=base)
    ax.set_yticks(y, names)
    ax.set_ylim(len(x) - 0.5, -0.6)
    ax.tick_params(axis="y", length=0)
    ax.grid(False, axis="y")
    ax.spines["left"].set_visible(False)
    labels(ax, xlabel=xlabel, title=title, xlim=xlim)
    return artists
