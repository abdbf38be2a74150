"""Tables of another renderer: CSV or JSON with directions and values; what is wrong is named by file, line, column."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

_UNIT = 1e-3  # a direction may be this much longer or shorter than 1: it is written with few digits
_EXACT = 1e-14
_VECTORS = tuple(f"{w}{axis}" for w in ("wi", "wo") for axis in "xyz")
_ANGLES = ("thetai", "phii", "thetao", "phio")
_QUANTITY = re.compile(r"(f|pdf|mirror|through)(\d+|[rgb])?")
_NEEDED = "wi_x, wi_y, wi_z, wo_x, wo_y, wo_z (or theta_i, phi_i, theta_o, phi_o) and f (or f_0, f_1, ...)"


class Given(NamedTuple):
    """Table of another renderer."""

    path: str
    wi: np.ndarray
    """(N, 3) unit vectors; if the file has angles, taken as radians."""
    wo: np.ndarray
    values: dict[str, np.ndarray]
    """Quantity to (N, C); a value may be NaN or infinite."""
    where: list[str]
    """Of each row: "line 12"."""
    angles: np.ndarray | None
    """(N, 4) theta_i, phi_i, theta_o, phi_o as they stand in the file, or None."""


def read(path: Path | str) -> Given:
    """Table of a .json file of the layout of `write`, or else a CSV: comments with #, a header row, names in any case.

    Separators are commas, semicolons or tabs. Columns that are not known are left alone.

    Raises:
        ValueError: no such file, a column missing, a cell that is not a number, a direction that is not a unit vector:
            naming file, line and column.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"there is no file {path}")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not a text file: {error}") from None
    columns, where = (_json if path.suffix.lower() == ".json" else _csv)(str(path), text)
    if not where:
        raise ValueError(f"{path} has no rows")
    return _assemble(str(path), columns, where)


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _csv(path: str, text: str) -> tuple[dict[str, np.ndarray], list[str]]:
    rows = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not rows:
        raise ValueError(f"{path} has no header row; needed are the columns {_NEEDED}")
    separator = max(",;\t", key=rows[0][1].count)
    names = [name.strip().strip('"') for name in rows[0][1].split(separator)]
    keys = [_key(name) for name in names]
    wanted = [j for j, key in enumerate(keys) if key in _VECTORS + _ANGLES or _QUANTITY.fullmatch(key)]
    twice = sorted({names[j] for j in wanted if keys.count(keys[j]) > 1})
    if twice:
        raise ValueError(f"{path}, line {rows[0][0]}: the column {', '.join(twice)} is there more than once")
    table = np.empty((len(rows) - 1, len(wanted)))
    for i, (line, row) in enumerate(rows[1:]):
        cells = row.split(separator)
        if len(cells) != len(names):
            raise ValueError(f"{path}, line {line}: {len(cells)} cells where the header has {len(names)}")
        for k, j in enumerate(wanted):
            try:
                table[i, k] = float(cells[j])
            except ValueError:
                cell = cells[j].strip()
                raise ValueError(f"{path}, line {line}, column {names[j]}: {cell!r} is not a number") from None
    return {keys[j]: table[:, k] for k, j in enumerate(wanted)}, [f"line {line}" for line, _ in rows[1:]]


def _json(path: str, text: str) -> tuple[dict[str, np.ndarray], list[str]]:
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}, line {error.lineno}: {error.msg}") from None
    if not isinstance(document, dict):
        raise ValueError(f"{path} is not an object with wi, wo and f")
    columns: dict[str, np.ndarray] = {}
    n = 0
    for name, value in document.items():
        key = _key(name)
        if key not in ("wi", "wo") and not _QUANTITY.fullmatch(key):
            continue
        try:
            array = np.asarray(value, np.float64)
        except (TypeError, ValueError):
            raise ValueError(f"{path}, {name}: it is not an array of numbers, or its rows differ in length") from None
        array = array[:, None] if array.ndim == 1 else array
        if array.ndim != 2 or (key in ("wi", "wo") and array.shape[1] != 3):
            raise ValueError(f"{path}, {name}: its shape is {array.shape}; wi and wo are (N, 3), f is (N,) or (N, C)")
        n = n or len(array)
        if len(array) != n:
            raise ValueError(f"{path}, {name}: {len(array)} rows where the others have {n}")
        names = [f"{key}{axis}" for axis in "xyz"] if key in ("wi", "wo") else _numbered(key, array.shape[1])
        columns |= dict(zip(names, array.T, strict=True))
    return columns, [f"row {i}" for i in range(n)]


def _numbered(key: str, channels: int) -> list[str]:
    return [key] if channels == 1 else [f"{key}{c}" for c in range(channels)]


def _assemble(path: str, columns: dict[str, np.ndarray], where: list[str]) -> Given:
    angles = None
    if all(name in columns for name in _VECTORS):
        wi, wo = (np.stack([columns[f"{w}{axis}"] for axis in "xyz"], axis=-1) for w in ("wi", "wo"))
        wi, wo = (_normalized(path, name, w, where) for name, w in (("wi", wi), ("wo", wo)))
    elif all(name in columns for name in _ANGLES):
        angles = np.stack([columns[name] for name in _ANGLES], axis=-1)
        _refuse(path, "an angle", angles, ~np.isfinite(angles).all(axis=1), where, "is not finite")
        wi, wo = from_angles(angles)
    else:
        raise ValueError(f"{path} has of the needed columns only {', '.join(columns) or 'none'}; needed are {_NEEDED}")
    values = {name: _channels(name, columns) for name in ("f", "pdf", "mirror", "through")}
    values = {name: table for name, table in values.items() if table.size}
    if "f" not in values:
        raise ValueError(f"{path} has no column f (or f_0, f_1, ...; f_r, f_g, f_b)")
    return Given(path, wi, wo, values, where, angles)


def from_angles(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions wi, wo (N, 3) of theta_i, phi_i, theta_o, phi_o (N, 4) in radians."""

    def unit(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)

    return unit(*angles.T[:2]), unit(*angles.T[2:])


def _channels(name: str, columns: dict[str, np.ndarray]) -> np.ndarray:
    """Columns of one quantity in the order of their channels, (N, C); C = 0 if there is none."""
    found = {}
    for key, column in columns.items():
        match = _QUANTITY.fullmatch(key)
        if match and match[1] == name:
            label = match[2] or "0"
            found["rgb".index(label) if label in "rgb" else int(label)] = column
    return np.stack([found[c] for c in sorted(found)], axis=-1) if found else np.empty((0, 0))


def _normalized(path: str, name: str, w: np.ndarray, where: Sequence[str]) -> np.ndarray:
    length = np.linalg.norm(w, axis=1)
    _refuse(path, name, w, ~(abs(length - 1) <= _UNIT), where, lambda i: f"has length {length[i]:.6g}, not 1")
    return w / np.where(abs(length - 1) > _EXACT, length, 1.0)[:, None]  # bits that are right stay as they are


def _refuse(
    path: str, name: str, table: np.ndarray, bad: np.ndarray, where: Sequence[str], why: str | Callable[[int], Any]
) -> None:
    if bad.any():
        i = int(np.argmax(bad))
        text = why if isinstance(why, str) else why(i)
        raise ValueError(f"{path}, {where[i]}, {name} = {', '.join(format(x, '.6g') for x in table[i])}: {text}")
