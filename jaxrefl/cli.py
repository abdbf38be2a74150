"""The command line: `jaxrefl figures`, `jaxrefl check`, `jaxrefl info`, and those of `cli_scene`.

The commands here compute in float64: the command line is the program, so it may switch it on; the library never does.
"""

from __future__ import annotations

import io
import json
import os
import platform
import sys
import time
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

import jax
import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from . import __version__, cli_materials, cli_model, cli_reference, cli_scene, gallery
from .cli_model import show
from .cli_scene import INTERRUPTED

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Reflection models that can be plotted, trusted and differentiated.",
)
app.add_typer(cli_scene.app)
app.add_typer(cli_model.app)
app.add_typer(cli_reference.app)
app.add_typer(cli_materials.app)


def main() -> None:
    """Entry point of the command `jaxrefl`; a `ValueError` becomes one plain line and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console without Greek letters still shows the rest
    try:
        app()
    except SystemExit as end:
        if end.code != INTERRUPTED:
            raise
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED)  # an interrupted XLA compilation may crash while the interpreter shuts down
    except ValueError as error:
        print(f"jaxrefl: {error}", file=sys.stderr)
        raise SystemExit(2) from None


def _progress(console: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, transient=True)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"jaxrefl {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print it.")] = False,
) -> None:
    """Reflection models that can be plotted, trusted and differentiated."""


@app.command()
def figures(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Which ones; all if none.")] = None,
    out: Annotated[Path, typer.Option(help="Folder to write into.")] = Path("jaxrefl-figures"),
    formats: Annotated[str, typer.Option("--format", help="Any of png, pdf, svg, with commas.")] = "png",
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A parameter.")] = None,
    style: Annotated[str, typer.Option(help="paper, slide or dark.")] = "paper",
    data: Annotated[bool, typer.Option("--data", help="Write the computed numbers too, as NPZ and CSV.")] = False,
    listing: Annotated[bool, typer.Option("--list", help="List names, parameters and captions, and stop.")] = False,
) -> None:
    """Draw the figures of the gallery."""
    from . import plot

    entries = gallery.load_all(names or gallery.names())
    if listing:
        for entry in entries:
            values = ", ".join(f"{key}={_text(value)}" for key, value in entry.parameters.items())
            print(f"{entry.name}{f' ({values})' if values else ''}\n    {entry.caption}")
        return
    kinds = list(dict.fromkeys(kind.strip() for kind in formats.split(",")))
    if wrong := [kind for kind in kinds if kind not in gallery.FORMATS]:
        raise ValueError(f"format = {','.join(wrong)!r} must be among {', '.join(gallery.FORMATS)}")
    if style not in plot.STYLES:
        raise ValueError(f"style = {style!r} must be one of {', '.join(plot.STYLES)}")
    chosen = gallery.parse_settings(entries, settings or [])
    for setting in settings or []:
        takers = [name for name, values in chosen.items() if setting.partition("=")[0] in values]
        print(f"{setting}: {', '.join(takers)}", file=sys.stderr)
    jax.config.update("jax_enable_x64", True)
    raise typer.Exit(_draw_all(entries, out, kinds, chosen, style, data))


def _text(value: Any) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _draw_all(
    entries: Sequence[gallery.Entry],
    out: Path,
    kinds: Sequence[str],
    chosen: dict[str, dict[str, Any]],
    style: str,
    data: bool,
) -> int:
    """Draw every figure, a failed one not stopping the others; print the summary; return the exit code."""
    table = Table("figure", "seconds", "files")
    console, code = Console(stderr=True), 0
    with _progress(console) as progress:
        task = progress.add_task("figures", total=len(entries))
        for entry in entries:
            progress.update(task, description=entry.name)
            start = time.perf_counter()
            try:
                paths = gallery.make(entry, out, kinds, chosen[entry.name], style, data)
                report = ", ".join(str(path) for path in paths)
            except KeyboardInterrupt:
                console.print("interrupted: the figures in the summary are complete")
                code = INTERRUPTED
                break
            except (Exception, SystemExit) as error:  # whatever one figure does, the others are still drawn
                code, report = 1, f"FAILED: {type(error).__name__}: {error}"
            table.add_row(entry.name, f"{time.perf_counter() - start:.2f}", escape(report))
            progress.advance(task)
    show(table)
    if code == 1:
        console.print("some figures failed; their message is in the summary")
    return code


@app.command()
def check(
    blocks: Annotated[list[str] | None, typer.Argument(metavar="[BLOCK]...", help="Such as A.table.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
    summary: Annotated[bool, typer.Option("--summary", help="One line per block, and the rows that fail.")] = False,
) -> None:
    """Compare the library with its oracles; exit code 1 if any row fails."""
    from . import check as oracle

    jax.config.update("jax_enable_x64", True)
    chosen = oracle.select(blocks)
    rows: list[oracle.Row] = []
    interrupted = False
    with _progress(Console(stderr=True)) as progress:
        task = progress.add_task("check", total=len(chosen))
        for name in chosen:
            progress.update(task, description=name)
            try:
                rows += oracle.evaluate(name)
            except KeyboardInterrupt:
                interrupted = True
                break
            progress.advance(task)
    failed = [row for row in rows if not row.ok]
    if as_json:
        print(json.dumps({"version": __version__, "ok": not failed, "rows": [row._asdict() for row in rows]}, indent=1))
    else:
        if shown := failed if summary else rows:
            show(_row_table(shown))
        show(_block_table(rows))
        print(f"{len(rows)} rows, {len(failed)} failed{', interrupted' if interrupted else ''}")
    raise typer.Exit(INTERRUPTED if interrupted else 1 if failed else 0)


def _row_table(rows: Sequence[Any]) -> Table:
    table = Table("block", "quantity", "value", "oracle", "error", "tolerance", "verdict", "source")
    for r in rows:
        verdict = "ok" if r.ok else "FAILED"
        quantity = f"{r.quantity} ({r.label})"
        numbers = f"{r.value:.15g}", f"{r.oracle:.15g}", f"{r.error:.1e}", f"{r.tolerance:.0e}"
        table.add_row(r.block, escape(quantity), *numbers, verdict, escape(r.source))
    return table


def _block_table(rows: Sequence[Any]) -> Table:
    table = Table("block", "rows", "worst error", "worst error / tolerance", "failed")
    for block in dict.fromkeys(row.block for row in rows):
        mine = [row for row in rows if row.block == block]
        worst, ratio = max(row.error for row in mine), max(row.error / row.tolerance for row in mine)
        table.add_row(block, str(len(mine)), f"{worst:.1e}", f"{ratio:.2g}", str(sum(not row.ok for row in mine)))
    return table


@app.command()
def info(as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False) -> None:
    """Versions, devices and default dtype: what to put into a bug report."""
    packages = ("jax", "jaxlib", "numpy", "matplotlib", "colour-science", "optimistix", "pydantic", "imageio", "pillow")
    facts: dict[str, Any] = {
        "jaxrefl": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        **{name: metadata.version(name) for name in packages},
        "backend": jax.default_backend(),
        "devices": [str(device) for device in jax.devices()],
        "default float": str(jax.numpy.zeros(()).dtype),
        "x64 in figures and check": True,
        "figure files": str(gallery.directory()),
    }
    if as_json:
        print(json.dumps(facts, indent=1))
        return
    table = Table(show_header=False)
    for name, value in facts.items():
        table.add_row(name, escape(", ".join(value) if isinstance(value, list) else str(value)))
    show(table)
