"""A user's own table of n and k."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..dispersion import Tabulated
from ..dispersion.lorentz import HC_EV_NM
from ..dispersion.table import METHODS
from .named import Material, Provenance

_UNITS = {"nm": "nm", "nanometer": "nm", "nanometre": "nm", "um": "um", "µm": "um", "μm": "um", "micron": "um"}
_UNITS |= {"micrometer": "um", "micrometre": "um", "ev": "ev"}
UNITS = ("nm", "um", "eV")


def from_csv(path: Path | str, unit: str | None = None, *, method: str = "linear") -> Material:
    """Material of a file with columns wavelength (or energy), n and perhaps k, with commas, semicolons or blanks.

    Args:
        path: text file; lines that begin with # are passed over. A first line that is no number is the header:
            "wavelength_nm,n,k", "wl (um);n;k", "energy_eV n k". Columns named n and k are found wherever they are,
            the first other one whose title names a unit is the abscissa (else the first other one). Without a header
            the columns are abscissa, n, k. UTF-8, or what else old programs write (cp1252).
        unit: of the abscissa, "nm", "um" or "eV"; None takes it from the header. Rows may come in any order.
        method: of interpolation, "linear" or "cubic".

    Returns:
        Material, whose range is that of the file; k = 0 if there is no such column.

    Raises:
        ValueError: naming file, line and column: a cell that is no number, is missing or is out of its range; the same
            wavelength twice; fewer than two rows; a unit neither given nor in the header.
    """
    path = Path(path)
    if method not in METHODS:
        raise ValueError(f"method = {method!r} must be one of {', '.join(METHODS)}")
    if unit is not None and not isinstance(unit, str):
        raise ValueError(f"unit = {unit!r} must be one of {', '.join(UNITS)}")
    lines = [
        (number, _cells(line))
        for number, line in enumerate(_text(path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise ValueError(f"{path} has no rows")
    header = None if _is_number(lines[0][1][0]) else lines.pop(0)[1]
    places = _places(header, len(lines[0][1]) if lines else 0, path)
    kind = _unit(unit, header[places[0]] if header else None, path)
    rows = np.array([_row(path, number, cells, places) for number, cells in lines]).reshape(len(lines), len(places))
    if len(rows) < 2:
        raise ValueError(f"{path} has {len(rows)} rows; a table has at least two")
    with np.errstate(over="ignore"):
        wavelength = {"nm": rows[:, 0], "um": 1000 * rows[:, 0], "ev": HC_EV_NM / rows[:, 0]}[kind]
    for (number, cells), nm in zip(lines, wavelength, strict=True):
        if not 0 < nm < np.inf:
            raise ValueError(f"{path}, line {number}, column {places[0] + 1}: {cells[places[0]]} is {nm:g} nm")
    order = np.argsort(wavelength, kind="stable")
    same = np.flatnonzero(np.diff(wavelength[order]) <= 0)
    if same.size:
        first, second = sorted(lines[i][0] for i in order[same[0] : same[0] + 2])
        raise ValueError(f"{path}, line {second}, column 1: the same wavelength as in line {first}")
    columns = [wavelength[order], *(rows[order, i] for i in range(1, len(places)))]
    ends = (float(columns[0][0]), float(columns[0][-1]))
    about = Provenance(path.stem, path.name, "measured", len(places) == 3, ends, str(path), "", "", "the user's own")
    k = columns[2] if len(places) == 3 else np.zeros(len(rows))
    return Material(Tabulated(columns[0], columns[1], k, method), about)


def _text(path: Path) -> str:
    """Contents: UTF-8, or else cp1252, in which the sign of micro is one byte."""
    content = path.read_bytes()
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise ValueError(f"{path} is no text in UTF-8 or cp1252")


def _cells(line: str) -> list[str]:
    for separator in (";", "\t", ","):
        if separator in line:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    return line.split()


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _places(header: list[str] | None, width: int, path: Path) -> list[int]:
    """Columns of the abscissa, n and (if there is one) k."""
    if header is None:
        if width < 2:
            raise ValueError(f"{path}: a row has {width} columns; there must be abscissa, n and perhaps k")
        return list(range(min(width, 3)))
    names = [name.casefold() for name in header]
    if "n" not in names:
        raise ValueError(f"{path}: the header {', '.join(header)} has no column n")
    others = [i for i, name in enumerate(names) if name not in ("n", "k")]
    if not others:
        raise ValueError(f"{path}: the header {', '.join(header)} has no column of wavelengths or energies")
    named = [i for i in others if _units(header[i])]
    return [(named or others)[0], names.index("n"), *([names.index("k")] if "k" in names else [])]


def _units(title: str) -> set[str]:
    """Units that the title of a column names."""
    words = "".join(c if c.isalpha() else " " for c in title.casefold()).split()
    return {_UNITS[word] for word in words if word in _UNITS}


def _unit(unit: str | None, title: str | None, path: Path) -> str:
    if unit is not None:
        if unit.casefold() not in _UNITS:
            raise ValueError(f"unit = {unit!r} must be one of {', '.join(UNITS)}")
        return _UNITS[unit.casefold()]
    found = _units(title or "")
    if len(found) != 1:
        raise ValueError(f"{path}: the unit of column {title or 1!r} is not clear; give unit = {', '.join(UNITS)}")
    return found.pop()


def _row(path: Path, number: int, cells: list[str], places: list[int]) -> list[float]:
    values = []
    for name, i in zip(("the abscissa", "n", "k"), places, strict=False):
        where = f"{path}, line {number}, column {i + 1}"
        if i >= len(cells) or not _is_number(cells[i]):
            raise ValueError(f"{where}: {cells[i]!r} is not a number" if i < len(cells) else f"{where} is missing")
        value = float(cells[i])
        if not np.isfinite(value) or value < 0 or (value == 0 and name == "the abscissa"):
            raise ValueError(f"{where}: {name} = {cells[i]} is outside {'(0, inf)' if name[0] == 't' else '[0, inf)'}")
        values.append(value)
    return values
