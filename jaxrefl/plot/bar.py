"""One colour bar for several maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes


def shared_bar(artist: Any, axes: Sequence[Axes], label: str | None = None, *, shrink: float = 0.5) -> Any:
    """Colour bar below several maps of one scale, drawn with ``bar=False``.

    Args:
        artist: what one of them returned.
        axes: all of them.
        label: of the bar, with the unit.
        shrink: its length as a fraction of the width of the axes.

    Returns:
        the Colorbar.
    """
    figure = axes[0].get_figure(root=True)
    assert figure is not None
    return figure.colorbar(
        artist, ax=list(axes), label=label, location="bottom", shrink=shrink, aspect=40 * shrink / 0.5, pad=0.04
    )
