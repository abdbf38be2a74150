"""Curves, lobes, error maps and convergence plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colors, patheffects
from matplotlib.axes import Axes

from .. import fresnel as _fresnel
from .diagram import mark
from .style import ANGLE, BLUE, GREEN, GREY, RED, axes, labels

Curve = Any
"""An array over the abscissa, or a callable of the abscissa."""


def angles(samples: int = 1801, first: float = 0.0, last: float = 90.0) -> tuple[np.ndarray, np.ndarray]:
    """Angles in degrees and their cosines, 0 and not 6e-17 at 90 degrees."""
    theta = np.linspace(first, last, samples)
    return theta, np.sin(np.deg2rad(90.0 - theta))


def _evaluate(curve: Curve, *abscissae: np.ndarray) -> np.ndarray:
    """Values of an array or a callable, as NumPy."""
    return np.asarray(curve(*abscissae) if callable(curve) else curve)


def cartesian(
    x: Any,
    y: Curve | Mapping[str, Curve],
    *,
    ax: Axes | None = None,
    label: str | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    title: str | None = None,
    xlim: tuple[float, float] | None = None,
    ylim: tuple[float | None, float | None] | None = None,
    yscale: str | None = None,
    legend: bool | str = False,
    **line: Any,
) -> list[Any]:
    """Curves over an abscissa.

    Args:
        x: abscissa (n,).
        y: one curve (array or callable of x), or a dict label -> curve.
        ax: axes to draw into; new ones if None.
        label, xlabel, ylabel, title: text; write the unit into the axis label.
        xlim, ylim, yscale: passed to the axes.
        legend: True, or a location such as "upper left".
        line: passed to `matplotlib.axes.Axes.plot` (color, linestyle, marker, ...).

    Returns:
        the Line2D artists.
    """
    ax = ax or axes()
    x = np.asarray(x)
    curves = y if isinstance(y, Mapping) else {label: y}
    artists = [ax.plot(x, _evaluate(curve, x), label=name, **line)[0] for name, curve in curves.items()]
    labels(ax, xlabel=xlabel, ylabel=ylabel, title=title, xlim=xlim, ylim=ylim, yscale=yscale, legend=legend)
    return artists


def fresnel(
    eta: float,
    k: float | None = None,
    *,
    ax: Axes | None = None,
    curves: Sequence[str] = ("s", "p", "mean"),
    mark_angles: bool = True,
    title: str | None = None,
    legend: bool | str = "upper left",
    samples: int = 1801,
) -> list[Any]:
    """Exact Fresnel reflectance over the angle of incidence.

    Args:
        eta, k: relative index; k = None draws a dielectric.
        curves: which of "s", "p" and "mean" (unpolarised) to draw.
        mark_angles: mark Brewster's and the critical angle of a dielectric.
        samples: number of angles.

    Returns:
        the Line2D artists, in the order of ``curves``.
    """
    ax = ax or axes()
    theta, mu = angles(samples)
    r_s, r_p = _fresnel.dielectric_sp(mu, eta) if k is None else _fresnel.conductor_sp(mu, eta, k)
    known: dict[str, tuple[Any, str, dict[str, Any]]] = {
        "s": (r_s, "$R_s$", {"color": BLUE, "linestyle": "--"}),
        "p": (r_p, "$R_p$", {"color": RED, "linestyle": "-."}),
        "mean": (0.5 * (r_s + r_p), "unpolarised", {"color": GREEN}),
    }
    unknown = [c for c in curves if c not in known]
    if unknown:
        raise ValueError(f"curves = {unknown} must be among {', '.join(known)}")
    artists = [a for c in curves for a in cartesian(theta, known[c][0], ax=ax, label=known[c][1], **known[c][2])]
    if mark_angles and k is None:
        mark(ax, x=float(np.rad2deg(_fresnel.brewster_angle(eta))), text="Brewster {:.1f}°", side="left")
        if eta < 1:
            mark(ax, x=float(np.rad2deg(_fresnel.critical_angle(eta))), text="critical {:.1f}°", side="right")
    labels(ax, xlabel=ANGLE, ylabel="reflectance R", title=title, xlim=(0, 90), ylim=(0, 1.02), legend=legend)
    return artists


def polar(
    r: Curve | Mapping[str, Curve],
    theta: Any = None,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    incident: float | None = None,
    title: str | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Any]:
    """Lobe in the plane of incidence: distance from the centre is the value, the normal points up.

    Args:
        r: array over theta, callable of theta in radians, or a dict label -> either.
        theta: angles from the normal in radians, [-pi/2, pi/2]; 721 of them if None.
        ax: polar axes; new ones if None.
        incident: angle in radians of an arrow for the incoming light, drawn on the negative side.

    Returns:
        the Line2D artists.
    """
    ax = ax or axes(polar=True)
    if ax.name != "polar":
        raise ValueError(f"ax is {ax.name}; it must be polar, as plot.axes(polar=True) makes")
    theta = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721) if theta is None else np.asarray(theta)
    polar_ax: Any = ax
    polar_ax.set_theta_zero_location("N")
    polar_ax.set_theta_direction(-1)
    polar_ax.set_thetamin(-90)
    polar_ax.set_thetamax(90)
    curves = r if isinstance(r, Mapping) else {label: r}
    artists = [ax.plot(theta, _evaluate(curve, theta), label=name, **line)[0] for name, curve in curves.items()]
    if incident is not None:
        top = ax.get_ylim()[1]
        ax.annotate("", (0, 0), (-incident, top), arrowprops={"arrowstyle": "->", "color": GREY, "lw": 1.2})
    labels(ax, title=title)
    if legend and isinstance(r, Mapping):
        ax.legend(loc="lower center", ncols=3, bbox_to_anchor=(0.5, 0.02))
    return artists


def error_map(
    x: Any,
    y: Any,
    error: Curve,
    *,
    ax: Axes | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    zlabel: str = "absolute error",
    title: str | None = None,
    levels: Sequence[float] = (0.01,),
    range: tuple[float, float] = (1e-4, 1.0),
    bar: bool = True,
    label_contours: bool | Sequence[tuple[float, float]] = True,
) -> list[Any]:
    """Magnitude of an error over two variables, on a logarithmic colour scale, with labelled contours.

    Args:
        x, y: abscissa (n,) and ordinate (m,).
        error: array (m, n), or a callable of the broadcast grids; its absolute value is drawn.
        levels: contours to draw.
        range: ends of the colour scale; what is outside is drawn in the end colour, NaN not at all.
        bar: draw a colour bar.
        label_contours: write the level on each contour, or only where a contour comes nearest to the given points.

    Returns:
        [mesh, contours].
    """
    ax = ax or axes()
    x, y = np.asarray(x), np.asarray(y)
    z = np.abs(_evaluate(error, *np.meshgrid(x, y)))
    norm = colors.LogNorm(*range)
    mesh = ax.pcolormesh(x, y, np.clip(z, *range), norm=norm, shading="nearest", rasterized=True)
    lines = ax.contour(x, y, z, levels=list(levels), colors="white", linewidths=1.2)
    lines.set_path_effects([patheffects.withStroke(linewidth=2.4, foreground="black")])
    if label_contours:
        manual = False if label_contours is True else label_contours
        ax.clabel(lines, fmt=lambda v: f"{v:.3g}", fontsize="small", manual=manual)
    if bar:
        ax.figure.colorbar(mesh, ax=ax, label=zlabel, extend="both")
    ax.grid(False)
    labels(ax, xlabel=xlabel, ylabel=ylabel, title=title)
    return [mesh, lines]


def convergence(
    n: Any,
    error: Any | Mapping[str, Any],
    *,
    ax: Axes | None = None,
    xlabel: str = "number of nodes",
    ylabel: str = "relative error",
    title: str | None = None,
    slopes: Sequence[float] = (),
    floor: float = 1e-17,
    legend: bool | str = True,
    **line: Any,
) -> list[Any]:
    """Error against the number of nodes, both logarithmic; an error of exactly 0 is drawn at ``floor``.

    Args:
        n: counts (n,), or a dict label -> counts when each curve has its own.
        error: errors (n,), a callable of the counts, or a dict label -> either; absolute values are drawn.
        slopes: exponents of reference lines n^slope.
        floor: ordinate at which zeros are drawn.

    Returns:
        the Line2D artists of the errors.
    """
    ax = ax or axes()
    curves = error if isinstance(error, Mapping) else {None: error}
    markers = "osD^vPX*"
    artists = []
    for i, (name, values) in enumerate(curves.items()):
        counts = np.asarray(n[name] if isinstance(n, Mapping) else n, dtype=float)
        style_ = {"marker": markers[i % len(markers)], "markersize": 4, "linewidth": 1.1} | line
        artists += ax.loglog(counts, np.maximum(np.abs(_evaluate(values, counts)), floor), label=name, **style_)
    low, high = ax.get_xlim()
    for slope in slopes:
        reach = np.array([low * 1.2, high / 1.2])
        ax.loglog(reach, 0.3 * (reach / reach[0]) ** slope, color=GREY, linestyle=":", linewidth=1)
        ax.annotate(
            f"$n^{{{slope:g}}}$", (reach[1], 0.3 * (reach[1] / reach[0]) ** slope), fontsize="small", color=GREY
        )
    labels(ax, xlabel=xlabel, ylabel=ylabel, title=title, legend=legend if isinstance(error, Mapping) else False)
    return artists
