"""A reflection model seen four ways: albedo over angle, lobe, slice through its half angles, sphere in a white furnace.

Every function takes a model, or the values that `albedos`, `lobe_values` and `slice_values` have computed of it: a
figure computes first and draws later. Delta parts count in the albedo, and are in no lobe and no slice.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colors
from matplotlib.axes import Axes

from .curves import angles, cartesian
from .diagram import mark
from .picture import _empty
from .style import BLUE, GREY, RED, axes, labels
from .values import albedos, lobe_values, slice_values


def _gray(values: np.ndarray, ndim: int) -> np.ndarray:
    """Mean over the channels, if there are any."""
    return values.mean(axis=-1) if values.ndim > ndim else values


def albedo(
    model: Any | Mapping[str, Any],
    theta_deg: Any = None,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    title: str | None = None,
    part: str = "reflected",
    fixed: str = "view",
    ylim: tuple[float | None, float | None] | None = (0.0, None),
    legend: bool | str = False,
    **line: Any,
) -> list[Any]:
    """Directional albedo over angle, with a line at 1, above which light is created.

    Args:
        model: model, or values (M,) or (M, C) over ``theta_deg``, or a dict label -> either.
        theta_deg: angles in degrees; 0, 1, ... 90 for a model if None, evenly from 0 to 90 for values.
        ax: axes to draw into; new ones if None.
        part, fixed: as in `jaxrefl.albedo.directional_albedo`.
        line: passed to `matplotlib.axes.Axes.plot`.

    Returns:
        the Line2D artists, one per model and channel.
    """
    ax = ax or axes()
    given = dict(model) if isinstance(model, Mapping) else {label: model}
    models = {name: one for name, one in given.items() if callable(one)}
    given |= {name: one.value for name, one in albedos(models, theta_deg, part=part, fixed=fixed).items()}
    artists: list[Any] = []
    for name, one in given.items():
        values = np.asarray(one)
        theta = np.linspace(0, 90, len(values)) if theta_deg is None else theta_deg
        for i, channel in enumerate(values.reshape(len(values), -1).T):
            artists += cartesian(theta, channel, ax=ax, label=name if i == 0 else None, **line)
    mark(ax, y=1.0)
    text = {"xlabel": f"angle of {fixed} θ (degrees)", "ylabel": "directional albedo", "title": title}
    labels(ax, **text, xlim=(0, 90), ylim=ylim, legend=legend)
    return artists


def image_slice(
    model: Any,
    *,
    ax: Axes | None = None,
    title: str | None = None,
    range: tuple[float, float] = (0.01, 100.0),
    phi_d_deg: float = 90.0,
    xlabel: str | None = r"$\theta_h$ (degrees)",
    ylabel: str | None = r"$\theta_d$ (degrees)",
    bar: bool = True,
) -> Any:
    """Slice of a model as a map of π f, which is 1 for white Lambert, over θ_h and θ_d.

    The highlight is at the left edge, the Fresnel rise at the upper left, grazing light at the upper edge and to the
    right, retroreflection at the lower edge.

    Args:
        model: model, or values of `slice_values`; of several channels the mean is drawn.
        ax: axes to draw into; new ones if None.
        range: ends of the logarithmic colour scale; what is outside is drawn in the end colour.
        phi_d_deg: azimuth of the light about the half vector.
        bar: draw a colour bar.

    Returns:
        the QuadMesh artist.
    """
    ax = ax or axes()
    values = np.pi * _gray(slice_values(model, phi_d_deg=phi_d_deg) if callable(model) else np.asarray(model), 2)
    edges = [np.linspace(0, 90, n + 1) for n in values.shape]
    norm = colors.LogNorm(*range)
    mesh = ax.pcolormesh(edges[1], edges[0], np.clip(values, *range), norm=norm, rasterized=True)
    ax.set(aspect="equal", xticks=(0, 30, 60, 90), yticks=(0, 30, 60, 90))
    ax.grid(False)
    if bar:
        ax.figure.colorbar(mesh, ax=ax, label="π f", extend="both")
    labels(ax, xlabel=xlabel, ylabel=ylabel, title=title)
    return mesh


def lobe3d(
    model: Any,
    incident_deg: float = 40.0,
    *,
    ax: Axes | None = None,
    title: str | None = None,
    reach: float | None = None,
    color: Any = BLUE,
    view_deg: tuple[float, float] = (26.0, -62.0),
) -> Any:
    """Lobe of a model in space: the distance from the centre is f(wi, wo), the normal points up, the light is an arrow.

    Args:
        model: model, or values of `lobe_values`; of several channels the mean is drawn.
        incident_deg: angle of the light from the normal.
        ax: axes, put aside for three-dimensional ones in their place; new ones if None.
        reach: f in 1/sr at the edge of the box; the largest one if None.
        view_deg: elevation and azimuth of the eye.

    Returns:
        the Poly3DCollection artist.
    """
    values = _gray(lobe_values(model, incident_deg) if callable(model) else np.asarray(model), 2)
    space = _in_space(ax)
    theta = np.linspace(0, 0.5 * np.pi, values.shape[0])[:, None]
    phi = np.linspace(0, 2 * np.pi, values.shape[1])
    reach = float(values.max()) or 1.0 if reach is None else reach
    r = values / reach
    x, y, z = r * np.sin(theta) * np.cos(phi), r * np.sin(theta) * np.sin(phi), r * np.cos(theta)
    space.computed_zorder = False  # the arrow stays in sight
    space.plot(np.cos(phi), np.sin(phi), 0 * phi, color=GREY, linewidth=0.8, zorder=1)
    space.plot([0, 0], [0, 0], [0, 1.1], color=GREY, linewidth=0.8, zorder=1)
    shown = {"rcount": values.shape[0], "ccount": values.shape[1], "lightsource": colors.LightSource(185, 50)}
    x, y, z = (part[:, ::-1] for part in (x, y, z))  # the order that makes a facet face outward, for its shading
    with np.errstate(divide="ignore", invalid="ignore"):  # a facet of no size has no normal
        artist = space.plot_surface(x, y, z, color=color, linewidth=0, antialiased=False, zorder=2, **shown)
    angle = np.deg2rad(incident_deg)
    tip = 1.1 * np.array([-np.sin(angle), 0.0, np.cos(angle)])
    space.quiver(*tip, *(-0.94 * tip), color=RED, linewidth=1.4, arrow_length_ratio=0.14, zorder=3)
    space.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(0, 1.1))
    space.set_box_aspect((2, 2, 1.1), zoom=1.35)
    space.view_init(*view_deg)
    space.set_axis_off()
    labels(space, title=title)
    return artist


def _in_space(ax: Axes | None) -> Any:
    """Three-dimensional axes in the place of plain ones."""
    if ax is None:
        return plt.figure().add_subplot(projection="3d")
    if ax.name == "3d":
        return ax
    figure, place = ax.get_figure(), ax.get_subplotspec()
    assert figure is not None
    ax.remove()
    return figure.add_subplot(place, projection="3d") if place is not None else figure.add_subplot(projection="3d")


def furnace(
    model: Any,
    *,
    ax: Axes | None = None,
    title: str | None = None,
    part: str = "reflected",
    pixels: int = 240,
    label: str = "light gained or lost (%)",
    bar: bool = True,
) -> Any:
    """Sphere of a model in a white furnace: how much brighter than the furnace it is; a perfect model vanishes.

    A pixel at the distance s from the middle has cos theta = sqrt(1 - s^2): no ray is traced. The scale is logarithmic
    beyond 1 % on both sides, red where light is created and blue where it is lost.

    Args:
        model: model, or albedos (M,) or (M, C) evenly over the angles 0 to 90 degrees; the mean of channels is drawn.
        ax: axes to draw into; new ones if None.
        part: "both" shows what a plate lets through as well.
        bar: draw a colour bar.

    Returns:
        the AxesImage artist.
    """
    values = _gray(np.asarray(albedos(model, part=part).value if callable(model) else model), 1)
    x = (np.arange(pixels) + 0.5) * (2.2 / pixels) - 1.1
    s = np.hypot(x, x[:, None])
    seen = np.interp(np.rad2deg(np.arcsin(np.minimum(s, 1))), angles(len(values))[0], values)
    excess = np.where(s < 1, 100 * (seen - 1), 0.0)
    norm = colors.SymLogNorm(1.0, linscale=0.6, vmin=-100, vmax=100)
    artist = _empty(ax or axes(), title).imshow(excess, cmap="RdBu_r", norm=norm, interpolation="nearest")
    if bar:
        artist.axes.figure.colorbar(artist, ax=artist.axes, label=label, extend="max", fraction=0.046, pad=0.03)
    return artist
