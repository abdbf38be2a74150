"""The commands of reflection models: `jaxrefl albedo`, `jaxrefl audit`, `jaxrefl plot`, `jaxrefl compare`.

A model is a name of the catalog or ``path/to/file.py:Name``, with its parameters as name=value behind it; where a
command takes several models, each is one argument in quotes: "eon rho=0.8 roughness=1". They compute in float64.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import jax
import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .cli_scene import INTERRUPTED

app = typer.Typer()

Model = Annotated[str, typer.Argument(metavar="MODEL", help="A name of the catalog, or path/to/file.py:Name.")]
Settings = Annotated[
    list[str] | None,
    typer.Argument(metavar="[NAME=VALUE]...", help="Parameters of the model, such as rho=0.9,0.5,0.1."),
]
_DIGITS = ".15g"


def _build(text: str, settings: list[str] | None = None) -> tuple[str, Any]:
    """Label and model of "name parameter=value ...", quotes around a path with spaces, and further settings."""
    from . import catalog

    words = shlex.shlex(text, posix=True)
    words.whitespace_split, words.escape, words.commenters = True, "", ""  # a backslash belongs to a Windows path
    parts = [*words, *(settings or [])]
    if not parts:
        raise ValueError(f"model = {text!r} is empty")
    return " ".join(parts), catalog.build(parts[0], parts[1:])


def _numbers(name: str, text: str) -> np.ndarray:
    """Numbers written 0,30,60 or, evenly spaced with both ends, low:high:count."""
    try:
        if text.count(":") == 2:
            low, high, count = text.split(":")
            return np.linspace(float(low), float(high), int(count))
        return np.array([float(part) for part in text.split(",")])
    except ValueError:
        raise ValueError(f"{name} = {text!r} must be numbers with commas between them, or low:high:count") from None


def _cosines(text: str) -> tuple[np.ndarray, np.ndarray]:
    theta = _numbers("theta", text)
    if not theta.size or not np.all((theta >= 0) & (theta <= 90)):
        raise ValueError(f"theta = {text!r} must be angles in degrees in [0, 90]")
    return theta, np.sin(np.deg2rad(90.0 - theta))  # exactly 0 at 90 degrees


def show(table: Table) -> None:
    """Table at its natural width when the output is a pipe, so that no number is cut."""
    Console(width=None if sys.stdout.isatty() else 200).print(table)


@contextmanager
def _interruptible() -> Iterator[None]:
    """A Ctrl-C in the block ends the command with its own exit code."""
    try:
        yield
    except KeyboardInterrupt:
        Console(stderr=True).print("interrupted; nothing was written")
        raise typer.Exit(INTERRUPTED) from None


def _cell(values: Any, form: str) -> str:
    return ", ".join(format(float(x), form) for x in np.ravel(values))


@app.command()
def albedo(
    model: Model,
    settings: Settings = None,
    theta: Annotated[str, typer.Option(help="Degrees, 0,30,60 or 0:90:91.")] = "0,30,60,80,90",
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-10,
    part: Annotated[str, typer.Option(help="reflected, transmitted or both.")] = "reflected",
    fixed: Annotated[str, typer.Option(help="Which direction has the angle theta: the view or the light.")] = "view",
    out: Annotated[Path | None, typer.Option("-o", "--out", help="With --over: a .csv, .npz or .exr.")] = None,
    over: Annotated[str | None, typer.Option(metavar="NAME=LOW:HIGH:N", help="With -o: a parameter to vary.")] = None,
) -> None:
    """Directional albedos with their errors, and the bihemispherical one; or a table of them over a parameter."""
    from .albedo import bihemispherical_albedo, check_arguments, rule_for
    from .brdf.function import as_model
    from .certified import albedo_to

    jax.config.update("jax_enable_x64", True)
    angles, cosines = _cosines(theta)
    check_arguments(part, fixed, cosines, many=True)
    if (out is None) != (over is None):
        raise ValueError("-o FILE and --over NAME=LOW:HIGH:N go together: a table is over a parameter and the angle")
    brdf = as_model(_build(model, settings)[1])
    if out is not None and over is not None:
        _save_table(model, settings or [], over, cosines, out, part, fixed)
        return
    table, code = Table("theta", "albedo", "error", "rule", "evaluations", "confirmed by"), 0
    try:
        for angle, mu in zip(angles, cosines, strict=True):
            found = albedo_to(brdf, float(mu), rtol, part=part, fixed=fixed)
            confirmed = (found.confirmed_by or "nothing") + ("" if found.converged else ", rtol not met")
            numbers = f"{angle:g}°", _cell(found.value, _DIGITS), _cell(found.error, ".1e")
            table.add_row(*numbers, f"{found.chart} {found.level}", str(found.evaluations), confirmed)
        rule = rule_for(brdf, 4)
        both = jax.jit(lambda: bihemispherical_albedo(brdf, rule, part=part))()
        numbers = "bihemispherical", _cell(both.value, _DIGITS), _cell(both.error, ".1e")
        table.add_row(*numbers, f"{rule.chart} {rule.level}", "", "")
    except KeyboardInterrupt:
        Console(stderr=True).print("interrupted: the lines of the table are complete")
        code = INTERRUPTED
    show(table)
    raise typer.Exit(code)


def _save_table(
    model: str, settings: list[str], over: str, cosines: np.ndarray, out: Path, part: str, fixed: str
) -> None:
    """Albedos over a parameter whose range is checked as the model's declaration says."""
    from .tabulate import ENDINGS, albedo_table

    name, equals, span = over.partition("=")
    if not equals or span.count(":") != 2:
        raise ValueError(f"over = {over!r} must be written NAME=LOW:HIGH:N")
    if out.suffix not in ENDINGS:
        raise ValueError(f"out = {str(out)!r} must end in {', '.join(ENDINGS)}")
    values = _numbers("over", span)
    lowest, *_ = [_build(model, [*settings, f"{name}={end}"])[1] for end in (values.min(), values.max())]
    with _interruptible():
        table = albedo_table(lowest, name, list(values), list(cosines), part=part, fixed=fixed)
        table.save(out)
    error = f"error at most {np.max(table.error):.1e}"
    print(f"{out}: {values.size} values of {name}, {cosines.size} angles, {error}")


@app.command()
def audit(
    model: Model,
    settings: Settings = None,
    as_json: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Write JSON; - prints it.")] = None,
    html: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the table as a page.")] = None,
    part: Annotated[str, typer.Option(help="both, or reflected: f is not asked below the surface.")] = "both",
) -> None:
    """Energy, reciprocity, sign, edges and sampling of a model; exit code 1 if any of it fails or is undecided."""
    from .audit import audit as look
    from .files import write_atomically

    jax.config.update("jax_enable_x64", True)
    _, brdf = _build(model, settings)
    with _interruptible():
        report = look(brdf, part=part)
    if as_json == "-":
        print(report.to_json())
    else:
        table = Table("property", "verdict", "number", "where", "meaning", title=escape(report.title))
        for row in report.rows:
            number = "" if row.number is None else f"{row.number:.6g}"
            table.add_row(row.name, row.verdict, number, escape(row.where), escape(row.text))
        show(table)
    if as_json not in (None, "-"):
        write_atomically(Path(str(as_json)), lambda part: part.write_text(report.to_json() + "\n", encoding="utf-8"))
    if html is not None:
        page = f"<!doctype html><meta charset='utf-8'><title>jaxrefl audit</title>{report._repr_html_()}\n"
        write_atomically(html, lambda part: part.write_text(page, encoding="utf-8"))
    raise typer.Exit(0 if report.ok else 1)


@app.command("plot")
def draw(
    model: Model,
    out: Annotated[Path, typer.Option("-o", "--out", help="A .png, .pdf or .svg.")],
    settings: Settings = None,
    overlay: Annotated[
        list[str] | None, typer.Option(metavar='"MODEL NAME=VALUE ..."', help="Another model; several times.")
    ] = None,
    theta: Annotated[float, typer.Option(help="Angle of the light of the lobe, degrees.")] = 30.0,
) -> None:
    """Draw the lobe in the plane of incidence (mean of the channels, no delta part) and the albedo over the angle."""
    from .audit import profile
    from .gallery import FORMATS

    jax.config.update("jax_enable_x64", True)
    if out.suffix.lstrip(".").lower() not in FORMATS:
        raise ValueError(f"out = {str(out)!r} must end in {', '.join('.' + kind for kind in FORMATS)}")
    _cosines(str(theta))
    models = dict([_build(model, settings), *(_build(text) for text in overlay or [])])
    with _interruptible():
        _draw({label: profile(brdf, np.deg2rad(theta)) for label, brdf in models.items()}, theta, out)
    print(f"{out}: {', '.join(models)}")


def _draw(profiles: dict[str, Any], theta: float, out: Path) -> None:
    from . import plot

    with plot.style():
        figure = plot.figure((8.5, 3.8))
        lobes, albedos = figure.add_subplot(1, 2, 1, projection="polar"), figure.add_subplot(1, 2, 2)
        angles = next(iter(profiles.values())).angle
        plot.polar({n: p.lobe for n, p in profiles.items()}, angles, ax=lobes, incident=np.deg2rad(theta), legend=False)
        plot.labels(lobes, title=f"f in 1/sr, light at {theta:g}°")
        lobes.set_yticks(lobes.get_yticks()[::2])
        for label, p in profiles.items():
            plot.cartesian(np.rad2deg(p.theta), p.albedo, ax=albedos, label=label)
        texts = {"xlabel": "angle of view θ (degrees)", "ylabel": "directional albedo"}
        plot.labels(albedos, **texts, xlim=(0, 90), ylim=(0, None), legend=True)
        plot.save(figure, out)


@app.command()
def compare(
    a: Annotated[str, typer.Argument(metavar='"A NAME=VALUE ..."', help="A model with its parameters, in quotes.")],
    b: Annotated[str, typer.Argument(metavar='"B NAME=VALUE ..."', help="Another one.")],
    below: Annotated[float, typer.Option(help="Largest angle of both directions, degrees; f may diverge at 90.")] = 90,
) -> None:
    """Print where two models differ most, such as: jaxrefl compare "lambert rho=0.5" "eon rho=0.5"."""
    from .audit import compare as look

    jax.config.update("jax_enable_x64", True)
    (first, one), (second, two) = _build(a), _build(b)
    with _interruptible():
        found = look(one, two, below)
    table = Table("largest difference", "value", "where", escape(first), escape(second))
    rows = {"of f, 1/sr": found.absolute, "of f, relative": found.relative, "of f cos theta_i": found.reflected}
    for name, d in (rows | {"of the albedo": found.albedo}).items():
        table.add_row(name, f"{d.value:.6g}", escape(d.where), f"{d.a:.9g}", f"{d.b:.9g}")
    show(table)
