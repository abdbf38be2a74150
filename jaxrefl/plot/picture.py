"""Rendered pictures and maps of one number per pixel."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colors
from matplotlib.axes import Axes

from ..image import encode_srgb
from .style import axes, labels


def picture(radiance: Any, *, ax: Axes | None = None, exposure: float = 0.0, title: str | None = None) -> Any:
    """Radiance as a picture, through the sRGB curve.

    Args:
        radiance: (H, W), (H, W, 1) or (H, W, 3), linear; what is above 1 after exposure is shown as 1.
        exposure: in stops; the radiance is multiplied by 2^exposure.
        ax: axes to draw into; new ones if None.

    Returns:
        the AxesImage artist.
    """
    values = encode_srgb(np.asarray(radiance) * 2.0**exposure)
    values = np.repeat(values[..., None], 3, -1) if values.ndim == 2 else values
    values = np.repeat(values, 3, -1) if values.shape[-1] == 1 else values
    ax = _empty(ax or axes(), title)
    return ax.imshow(values, interpolation="nearest")


def field(
    values: Any,
    *,
    ax: Axes | None = None,
    title: str | None = None,
    label: str | None = None,
    range: tuple[float, float] | None = None,
    diverging: bool = False,
    missing: Any = "0.5",
    bar: bool = True,
) -> Any:
    """One number per pixel as a map of colours, with a bar.

    Args:
        values: (H, W); NaN and infinity are drawn in the colour ``missing``.
        label: of the bar, with the unit.
        range: ends of the scale; the extremes of the values if None.
        diverging: a scale with white at 0, red above and blue below, symmetric unless ``range`` says otherwise.

    Returns:
        the AxesImage artist.
    """
    z = np.ma.masked_invalid(np.asarray(values, dtype=float))
    low, high = range or (float(z.min()), float(z.max()))
    if diverging and range is None:
        high = max(abs(low), abs(high)) or 1.0
        low = -high
    colormap = plt.get_cmap("RdBu_r" if diverging else "viridis").with_extremes(bad=missing)
    ax = _empty(ax or axes(), title)
    norm = colors.TwoSlopeNorm(0.0, low, high) if diverging and low < 0 < high else colors.Normalize(low, high)
    artist = ax.imshow(z, cmap=colormap, norm=norm, interpolation="nearest")
    if bar:
        ax.figure.colorbar(artist, ax=ax, label=label, fraction=0.046, pad=0.03)
    return artist


def _empty(ax: Axes, title: str | None) -> Axes:
    ax.grid(False)
    ax.set_xticks([])
    ax.set_yticks([])
    for spine in ax.spines.values():
        spine.set_visible(False)
    return labels(ax, title=title)
