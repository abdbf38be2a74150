"""The one style of every plot, its colours, and how a figure is opened and saved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..files import write_atomically

STYLES = ("paper", "slide", "dark")
ANGLE = "angle of incidence θ (degrees)"
BLUE, RED, GREEN, PINK, ORANGE, SKY, GREY = (f"C{i}" for i in range(7))
"""Names of the style's colours, in the order of the colour cycle; safe for colour-blind readers."""


@contextmanager
def style(name: str = "paper") -> Iterator[None]:
    """Context in which plots have the project's style: "paper", "slide" (larger) or "dark".

    Raises:
        ValueError: another name.
    """
    if name not in STYLES:
        raise ValueError(f"name = {name!r} must be one of {', '.join(STYLES)}")
    sheets = ["jaxrefl"] if name == "paper" else ["jaxrefl", name]
    data = resources.files("jaxrefl") / "data"
    with resources.as_file(data) as folder, plt.style.context([str(Path(folder) / f"{s}.mplstyle") for s in sheets]):
        yield


def figure(size: tuple[float, float]) -> Figure:
    """Empty figure of a size in inches, grown by the root of the style's type size, that belongs to no window."""
    growth = (plt.rcParams["font.size"] / 9) ** 0.5
    return Figure(figsize=(growth * size[0], growth * size[1]))


def axes(figure: Figure | None = None, polar: bool = False) -> Axes:
    """New axes, in a new figure unless one is given."""
    figure = figure or plt.figure()
    return figure.add_subplot(projection="polar" if polar else None)


def save(target: Axes | Figure, path: str | Path) -> Path:
    """Write a figure under a temporary name and rename it, so that no half-written file is ever left behind.

    The format is that of the suffix: .png, .pdf or .svg. No date is written, so equal figures are equal files.
    """
    figure, path = (target if isinstance(target, Figure) else target.get_figure(root=True)), Path(path)
    kind = path.suffix.lstrip(".").lower()
    metadata = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
    assert figure is not None
    write_atomically(path, lambda temporary: figure.savefig(temporary, format=kind, metadata=metadata))
    return path


def labels(
    ax: Axes,
    *,
    xlabel: str | None = None,
    ylabel: str | None = None,
    title: str | None = None,
    xlim: tuple[float, float] | None = None,
    ylim: tuple[float | None, float | None] | None = None,
    xscale: str | None = None,
    yscale: str | None = None,
    xticks: Any = None,
    yticks: Any = None,
    aspect: str | float | None = None,
    legend: bool | str = False,
) -> Axes:
    """Set what is given of the axes' texts, limits, scales, ticks and aspect; ``legend`` is True or a location.

    Ticks are places, or a dict place -> text.
    """
    given: dict[str, Any] = {"xlabel": xlabel, "ylabel": ylabel, "title": title, "xlim": xlim, "ylim": ylim}
    given |= {"xscale": xscale, "yscale": yscale, "aspect": aspect}
    ax.set(**{name: value for name, value in given.items() if value is not None})
    for put, ticks in ((ax.set_xticks, xticks), (ax.set_yticks, yticks)):
        if ticks is not None:
            put(list(ticks), list(ticks.values()) if isinstance(ticks, Mapping) else None)
    if legend:
        ax.legend(loc=legend if isinstance(legend, str) else "best")
    return ax


def legend(ax: Axes, keys: Mapping[str, Mapping[str, Any]] | None = None, **place: Any) -> Any:
    """Legend of the labelled curves, or of ``keys`` alone (label -> line style); ``place`` goes to matplotlib."""
    handles = None if keys is None else [Line2D([], [], label=label, **line) for label, line in keys.items()]
    return ax.legend(handles=handles, **place) if handles else ax.legend(**place)
