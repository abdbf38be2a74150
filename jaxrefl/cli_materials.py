"""The command of materials: `jaxrefl materials`, what there is, where it comes from, how far its sources are apart."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import jax
import numpy as np
import typer
from rich.table import Table

from .cli_model import show

app = typer.Typer()

LINES_NM = (450.0, 550.0, 650.0)


@app.command()
def materials(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Au, gold, N-BK7, ...; all if none.")] = None,
    source: Annotated[str | None, typer.Option(help="First author: one of its sources instead of all.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw n, k and R; .png, .pdf or .svg.")] = None,
) -> None:
    """Measured complex indices: sources, ranges, citations, licence, and the spread between the sources."""
    from .materials import materials as names
    from .materials import provenance

    jax.config.update("jax_enable_x64", True)
    if name is None:
        if source is not None or plot is not None:
            raise ValueError("--source and --plot need the NAME of a material")
        _list(names())
        return
    key = provenance(name, source).material
    sources = names()[key] if source is None else (provenance(name, source).source,)
    _describe(key, sources)
    if plot is not None:
        _draw(key, sources, plot)
        print(plot)


def _spread_cells(name: str) -> tuple[str, ...]:
    from .materials import spread

    found = spread(name)
    if found is None:
        return "", "", ""
    return f"{found.n:.2g}", "" if found.k is None else f"{found.k:.2g}", f"{found.reflectance:.2g}"


def _list(names: dict[str, tuple[str, ...]]) -> None:
    from .materials import provenance

    table = Table("material", "sources", "nm", "spread of n", "of k", "of R")
    for name, sources in names.items():
        low, high = provenance(name).range_nm
        table.add_row(name, ", ".join(sources), f"{low:g}-{high:g}", *_spread_cells(name))
    show(table)
    print("nm is the range of the first source, the default. Spread: the largest difference between two sources,")
    print("380 to 780 nm, R at normal incidence. `jaxrefl materials NAME` prints citations and licence.")


def _describe(name: str, sources: tuple[str, ...]) -> None:
    from .dispersion import normal_reflectance
    from .materials import material

    table = Table("source", "kind", "nm", *(f"n, k at {at:g} nm" for at in LINES_NM), "R at 550 nm", "V_d")
    shown = [material(name, source) for source in sources]
    for found in shown:
        about = found.provenance
        low, high = about.range_nm
        cells = [_index(found, at) if low <= at <= high else "" for at in LINES_NM]
        reflectance = f"{float(normal_reflectance(found, 550.0)):.4f}" if low <= 550 <= high else ""
        table.add_row(about.source, about.kind, f"{low:g}-{high:g}", *cells, reflectance, _abbe(found))
    show(table)
    n, k, reflectance = _spread_cells(name)
    if n:
        print(f"spread of all its sources over the visible: n {n}, {f'k {k}, ' if k else ''}R {reflectance}")
    for found in shown:
        about = found.provenance
        print(f"{about.source}: {about.citation}")
        print(f"    {about.page}; {f'{about.note}; ' if about.note else ''}{about.licence}")


def _index(found: Any, at: float) -> str:
    n, k = found(at)
    return f"{float(n):.4f}, {float(k):.4g}" if found.provenance.has_k else f"{float(n):.5f}, not given"


def _abbe(found: Any) -> str:
    """Abbe number of what is transparent."""
    from .dispersion import abbe_number

    low, high = found.provenance.range_nm
    if not (low <= 486 and high >= 657) or float(found(550.0).k) > 1e-3:
        return ""
    return f"{float(abbe_number(found)):.2f}"


def _draw(name: str, sources: tuple[str, ...], path: Path) -> None:
    from . import plot
    from .dispersion import normal_reflectance
    from .materials import material

    if path.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise ValueError(f"--plot {path} must end in .png, .pdf or .svg")
    with plot.style():
        figure = plot.figure((9.4, 3.4))
        axes = figure.subplots(1, 3)
        colors = (plot.BLUE, plot.ORANGE, plot.GREEN, plot.PINK, plot.SKY, plot.RED)
        for source, color in zip(sources, colors, strict=False):
            found = material(name, source)
            low, high = found.provenance.range_nm
            x = np.linspace(max(low, 350.0), min(high, 850.0), 501)
            n, k = found(x)
            curves = (n, k if found.provenance.has_k else np.full_like(x, np.nan), normal_reflectance(found, x))
            for ax, curve in zip(axes, curves, strict=True):
                plot.cartesian(x, curve, ax=ax, label=source, color=color)
        for ax, what in zip(axes, ("n", "k", "R at normal incidence"), strict=True):
            plot.labels(ax, xlabel="wavelength (nm)", ylabel=what)
        plot.labels(axes[0], title=name)
        plot.legend(axes[0])
        plot.save(figure, path)
