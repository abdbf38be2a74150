"""Reference vectors as files: CSV, JSON, or a C header; each states its conventions."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..files import write_atomically
from .vectors import Vectors

SCHEMA = 1
"""Version of the JSON layout."""
ENDINGS = (".csv", ".json", ".h")
FORMAT = "jaxrefl reference vectors"

CONVENTIONS = {
    "frame": "z is the surface normal, x the tangent, right-handed; every direction here is above the surface",
    "wi, wo": "unit vectors to the light and to the viewer, BOTH LEAVING the surface",
    "f": "value of the model in 1/sr, linear, the cosine of wi NOT included, delta (mirror) parts not in it",
    "pdf": "density of wi, given wo, per solid angle, 1/sr; of the smooth part",
    "mirror": "share of the light of the mirror direction of wo that is seen from wo; a delta part, no unit",
    "through": "share of the light from straight behind that is seen from wo; a delta part, no unit",
    "albedo": "integral over wi of f(wi, wo) cos(theta_i), plus mirror: the radiance seen from wo in a white world",
    "albedo_error": "bound on the error of albedo",
    "parameters": "a width is called alpha (alpha = roughness^2, if yours is a roughness); one called roughness is "
    "that of the model's own paper",
    "angles": "radians",
    "numbers": "float64 with 17 significant digits",
}
"""What a reader in another language has to know, by topic."""


def check_path(path: Path) -> None:
    """Raise `ValueError` for a file that `write` would not know how to write."""
    if path.suffix not in ENDINGS:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join(ENDINGS)}")


def conventions(vectors: Vectors) -> dict[str, str]:
    """Those that concern the quantities that are there."""
    absent = {"pdf", "mirror", "through"} - set(vectors.values)
    return {topic: text for topic, text in CONVENTIONS.items() if topic not in absent}


def write(vectors: Vectors, path: Path | str) -> None:
    """Write reference vectors to a .csv, .json or .h (C89 and C++).

    Raises:
        ValueError: another ending.
    """
    path = Path(path)
    check_path(path)
    text = {".csv": _csv, ".json": _json, ".h": _header}[path.suffix](vectors)
    write_atomically(path, lambda part: part.write_text(text, encoding="utf-8", newline="\n"))


def _number(x: Any) -> str:
    return format(float(x), ".17g")


def _parameter(value: Any) -> str:
    if isinstance(value, list):
        return ",".join(map(_parameter, value))
    if isinstance(value, str):
        return value
    return str(value).lower() if isinstance(value, bool) else _number(value)


def _heading(vectors: Vectors) -> Iterator[str]:
    yield f"{FORMAT}, {__version__}"
    yield f"model: {vectors.model}"
    for name, value in vectors.parameters.items():
        yield f"parameter: {name}={_parameter(value)}"
    for topic, text in conventions(vectors).items():
        yield f"{topic}: {text}"


def _columns(vectors: Vectors) -> dict[str, np.ndarray]:
    """Scalar columns by name; of a quantity with one channel the name has no number."""
    columns = {f"{w}_{axis}": getattr(vectors, w)[:, i] for w in ("wi", "wo") for i, axis in enumerate("xyz")}
    for name, table in vectors.values.items():
        channels = table.shape[1]
        columns |= {name if channels == 1 else f"{name}_{c}": table[:, c] for c in range(channels)}
    return columns


def _csv(vectors: Vectors) -> str:
    columns = _columns(vectors)
    lines = [f"# {line}" for line in _heading(vectors)]
    lines.append(",".join(columns))
    lines += [",".join(map(_number, row)) for row in zip(*columns.values(), strict=True)]
    return "\n".join(lines) + "\n"


def _json(vectors: Vectors) -> str:
    document = {
        "format": FORMAT,
        "schema": SCHEMA,
        "version": __version__,
        "model": vectors.model,
        "parameters": vectors.parameters,
        "conventions": conventions(vectors),
        "count": len(vectors.wi),
        "channels": {name: table.shape[1] for name, table in vectors.values.items()},
        "wi": vectors.wi.tolist(),
        "wo": vectors.wo.tolist(),
        **{name: table.tolist() for name, table in vectors.values.items()},
    }
    entries = (f"{json.dumps(name)}: {json.dumps(value, allow_nan=False)}" for name, value in document.items())
    return "{\n" + ",\n".join(entries) + "\n}\n"


def identifier(name: str) -> str:
    """Name of a model as a C identifier: ``d3d9_repaired``; of ``path/to/file.py:Name`` the Name."""
    return re.sub(r"\W+", "_", name.rpartition(":")[2], flags=re.ASCII).lower()


def _header(vectors: Vectors) -> str:
    name = f"jaxrefl_{identifier(vectors.model)}"
    upper = name.upper()
    comment = "\n".join(" * " + line.replace("*/", "* /").replace("/*", "/ *") for line in _heading(vectors))
    tables = {"wi": vectors.wi, "wo": vectors.wo, **vectors.values}
    fields = "\n".join(f"    double {quantity}[{table.shape[1]}];" for quantity, table in tables.items())
    rows = (
        ", ".join("{" + ", ".join(map(_number, table[i])) + "}" for table in tables.values())
        for i in range(len(vectors.wi))
    )
    body = ",\n".join(f"    {{{row}}}" for row in rows)
    return f"""/*
{comment}
 */
#ifndef {upper}_H
#define {upper}_H

#define {upper}_COUNT {len(vectors.wi)}
#define {upper}_CHANNELS {vectors.values["f"].shape[1]}

struct {name}_vector {{
{fields}
}};

static const struct {name}_vector {name}[{upper}_COUNT] = {{
{body}
}};

#endif
"""
