"""Layers of a rendered picture: normals, primitives, strips over an abscissa, and bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colors, patheffects
from matplotlib.axes import Axes

from ..image import decode_srgb
from .picture import _empty, picture
from .style import axes


def normals(normal: Any, *, ax: Axes | None = None, title: str | None = None) -> Any:
    """Unit normals as colours: (1 + x) / 2, (1 + y) / 2 and (1 + z) / 2 are red, green and blue; no normal is black.

    Args:
        normal: (H, W, 3); 0 for a miss.
        ax: axes to draw into; new ones if None.

    Returns:
        the AxesImage artist.
    """
    n = np.asarray(normal, dtype=float)
    codes = np.where((n == 0).all(-1, keepdims=True), 0.0, 0.5 + 0.5 * n)
    return picture(decode_srgb(codes), ax=ax, title=title)


def categories(numbers: Any, *, ax: Axes | None = None, title: str | None = None, missing: Any = "0.5") -> Any:
    """Numbers of things, one flat colour each, the number written at the middle of each; negative ones are ``missing``.

    Args:
        numbers: (H, W) integers.
        ax: axes to draw into; new ones if None.

    Returns:
        the AxesImage artist.
    """
    z = np.asarray(numbers)
    cycle = colors.to_rgba_array(plt.rcParams["axes.prop_cycle"].by_key()["color"][:6])
    shades = [cycle[i % 6] ** (2.2 ** (i // 6)) for i in range(int(z.max()) + 1)]  # darker at each turn of the cycle
    colormap = colors.ListedColormap([missing, *shades])
    norm = colors.BoundaryNorm(np.arange(-1, z.max() + 2) - 0.5, colormap.N)
    ax = _empty(ax or axes(), title)
    artist = ax.imshow(z, cmap=colormap, norm=norm, interpolation="nearest")
    text = {
        "color": "white",
        "fontweight": "bold",
        "path_effects": [patheffects.withStroke(linewidth=2, foreground="black")],
    }
    for number in range(int(z.max()) + 1):
        rows, columns = np.nonzero(z == number)
        if rows.size:
            # the pixel of this number that is nearest to the mean of them all: never outside of it
            i = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
            ax.text(columns[i], rows[i], str(number), **text)
    return artist


def strip(
    radiance: Any, x: tuple[float, float], *, ax: Axes | None = None, title: str | None = None, **text: Any
) -> Any:
    """Picture whose columns lie over an abscissa, stretched to the width of its axes.

    Args:
        radiance: (H, W) or (H, W, 3), linear; what is above 1 is shown as 1.
        x: abscissa of the left and the right edge.
        ax: axes to draw into; new ones if None.
        text: ``xlabel`` and ``ylabel``.

    Returns:
        the AxesImage artist.
    """
    ax = ax or axes()
    artist = picture(radiance, ax=ax, title=title)
    artist.set_extent((*x, 0.0, 1.0))
    ax.set(aspect="auto", **text)
    return artist


def bars(ax: Axes, x: Any, height: Any, width: Any = 0.8, color: Any = None, labels: Sequence[str] = ()) -> Any:
    """Bars that stand on 0, with a text above each.

    Returns:
        the BarContainer.
    """
    artist = ax.bar(np.asarray(x), np.asarray(height), width, color=color)
    if labels:
        ax.bar_label(artist, labels, fontsize="small", padding=2)
    return artist
