"""For authors of other renderers: `jaxrefl oracle` writes reference vectors, `jaxrefl verify` reads theirs."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import jax
import typer
from rich.table import Table

from . import __version__
from .cli_model import Model, Settings, show

app = typer.Typer()

SCHEMA = 1
"""Version of the JSON that `verify --json` prints."""


@app.command()
def oracle(
    model: Model,
    settings: Settings = None,
    n: Annotated[int, typer.Option("-n", help="Pairs of directions.")] = 1000,
    seed: Annotated[int, typer.Option(help="Of the directions.")] = 0,
    out: Annotated[list[Path] | None, typer.Option("-o", "--out", help="A .csv, .json or .h; several times.")] = None,
) -> None:
    """Write reference vectors of a model: wi, wo, f, pdf, albedo, with their conventions."""
    from . import catalog, reference

    jax.config.update("jax_enable_x64", True)
    paths = list(dict.fromkeys(out or [Path(f"{reference.identifier(model)}.csv")]))
    for path in paths:
        reference.check_path(path)
    vectors = reference.reference_vectors(catalog.build(model, settings or []), n, seed, name=model)
    for path in paths:
        reference.write(vectors, path)
    quantities = ", ".join(f"{name} ({table.shape[1]})" for name, table in vectors.values.items())
    worst = vectors.values["albedo_error"].max()
    print(f"{', '.join(map(str, paths))}: {n} pairs of directions, {quantities}; albedos within {worst:.1e}")


@app.command()
def verify(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="CSV or JSON with wi, wo, f and perhaps pdf.")],
    model: Annotated[str, typer.Option("--model", help="A name of the catalog, or path/to/file.py:Name.")],
    settings: Settings = None,
    digits: Annotated[float, typer.Option(help="Digits to which every row has to agree.")] = 5.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Compare a file of another renderer with a model; exit code 1 if any row agrees to fewer digits."""
    from . import catalog, reference

    jax.config.update("jax_enable_x64", True)
    brdf = catalog.build(model, settings or [])
    given = reference.read(path)
    found = reference.compare(brdf, given, digits)
    failed = [c.quantity for c in found.comparisons if c.failing]
    explanations = {q: reference.explain(brdf, given, q) for q in failed if q in ("f", "pdf")}
    if as_json:
        print(json.dumps(_document(model, found, explanations), indent=1))
    else:
        _report(found, explanations)
    raise typer.Exit(0 if found.ok else 1)


def _document(model: str, found: Any, explanations: dict[str, Any]) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "version": __version__,
        "file": found.path,
        "model": model,
        "digits": found.digits,
        "ok": found.ok,
        "comparisons": [
            c._asdict() | {"theirs": [x if isfinite(x) else str(x) for x in c.theirs]} for c in found.comparisons
        ],
        "explanations": {q: e and e._asdict() for q, e in explanations.items()},
        "left_out": found.left_out,
    }


def _report(found: Any, explanations: dict[str, Any]) -> None:
    table = Table("quantity", "rows", f"below {found.digits:g} digits", "median", "worst")
    for c in found.comparisons:
        table.add_row(c.quantity, str(c.points), str(c.failing), f"{c.median:.1f} digits", f"{c.worst:.1f} digits")
    show(table)
    for c in found.comparisons:
        if c.failing:
            print(f"{c.quantity} is worst at {c.worst_at}: wi = {_text(c.wi)}; wo = {_text(c.wo)}")
            print(f"    theirs {_text(c.theirs)}; ours {_text(c.ours)}")
            if c.quantity in explanations:
                _explain(c, explanations[c.quantity])
    if found.left_out:
        print(f"not compared, for the model has none: {', '.join(found.left_out)}")
    print(f"{found.path} {'agrees' if found.ok else 'DOES NOT agree'} to {found.digits:g} digits")


def _text(numbers: list[float]) -> str:
    return ", ".join(format(x, ".9g") for x in numbers)


def _explain(c: Any, explanation: Any) -> None:
    from .reference import CONSTANT, SHARE

    if explanation is not None:
        names = [f"{x} {explanation.factor:.9g}" if x == CONSTANT else x for x in explanation.names]
        print(f"    RECOGNISED: {'; '.join(names)}")
        print(f"    with that, the median is {explanation.median:.1f} digits and the worst {explanation.worst:.1f}")
    elif c.failing <= SHARE / 100 * c.points:
        print("    the other rows agree: it is no difference of convention")
    else:
        print("    no difference of convention that is known explains it")
