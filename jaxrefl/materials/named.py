"""The materials that ship with the package."""

from __future__ import annotations

import csv
import dataclasses
import difflib
import functools
import json
from importlib import resources
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike
from jaxtyping import Float

from ..dispersion import Index, Tabulated, WithExtinction, from_formula
from ..dispersion.limits import Limits, check_wavelength, limits
from ..dispersion.table import METHODS
from ..params import pytree


class Provenance(NamedTuple):
    """Where the numbers of a material come from."""

    material: str
    """Name in the catalogue."""
    source: str
    """First author, and what tells apart two of the same: "Olmon-ev"."""
    kind: str
    """"measured", "fit" (a formula fitted to measurements) or "model" (of a theory)."""
    has_k: bool
    """False: the source gives n alone, and k = 0."""
    range_nm: tuple[float, float]
    """Wavelengths that the package holds; the database may hold more."""
    citation: str
    note: str
    """Sample, temperature and what else its entry in the database says."""
    page: str
    """Shelf, book and page in the database."""
    licence: str


@pytree
class Material:
    """A dispersion model with its provenance; the model's numbers are leaves, the provenance is not.

    The dtype of the wavelengths rules. Outside its range a concrete wavelength is an error, a traced one is held to
    the nearer end. Differentiable as its model is.
    """

    model: Any
    provenance: Provenance = dataclasses.field(metadata={"static": True})

    @property
    def range_nm(self) -> Limits:
        """Wavelengths for which there is data."""
        return limits(self.model)

    @property
    def citation(self) -> str:
        """Authors, title, journal."""
        return self.provenance.citation

    @property
    def licence(self) -> str:
        """Of the data."""
        return self.provenance.licence

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        try:
            check_wavelength(wavelength_nm, *self.range_nm)
        except ValueError as error:
            raise ValueError(f"{error}, the range of {self.provenance.material} ({self.provenance.source})") from None
        dtype = jnp.result_type(*jax.tree.leaves(wavelength_nm), 0.0)
        return jax.tree.map(lambda x: jnp.asarray(x, dtype), self.model)(wavelength_nm)


@functools.cache
def _catalogue() -> dict[str, Any]:
    text = resources.files("jaxrefl").joinpath("data/materials/catalogue.json").read_text(encoding="utf-8")
    return json.loads(text)


def materials() -> dict[str, tuple[str, ...]]:
    """Names of the materials, each with its sources, of which the first is the default."""
    return {name: tuple(entry["sources"]) for name, entry in _catalogue()["materials"].items()}


def _name(name: str) -> str:
    """Name in the catalogue of a name or an alias, whatever its capitals."""
    entries = _catalogue()["materials"]
    if name in entries:
        return name
    known = {alias.casefold(): key for key, entry in entries.items() for alias in (key, *entry["aliases"])}
    if str(name).casefold() in known:
        return known[str(name).casefold()]
    close = difflib.get_close_matches(str(name).casefold(), known, n=3, cutoff=0.5)
    first = list(dict.fromkeys(known[x] for x in close))
    names = [*first, *(x for x in entries if x not in first)]
    raise ValueError(f"name = {name!r} is not a material; there are {', '.join(names)}")


def _source(name: str, source: str | None) -> str:
    """Key of a source: the default, an exact key, or the only one of an author."""
    keys = list(_catalogue()["materials"][name]["sources"])
    if source is None:
        return keys[0]
    wanted = str(source).casefold()
    found = [key for key in keys if key.casefold() == wanted] or [
        key for key in keys if key.casefold().split("-")[0] == wanted
    ]
    if len(found) != 1:
        close = difflib.get_close_matches(wanted, [key.casefold() for key in keys], n=3)
        keys.sort(key=lambda key: key.casefold() not in close)
        problem = "is more than one" if found else "is not one"
        raise ValueError(f"source = {source!r} {problem} of the sources of {name}: {', '.join(keys)}")
    return found[0]


def provenance(name: str, source: str | None = None) -> Provenance:
    """Citation, range, licence of a material without its numbers; args and errors as in `material`."""
    key = _name(name)
    which = _source(key, source)
    row = _catalogue()["materials"][key]["sources"][which]
    text = (row["citation"], row["note"], row["page"], _catalogue()["licence"])
    return Provenance(key, which, row["kind"], row["has_k"], tuple(row["range_nm"]), *text)


def material(name: str, source: str | None = None, *, method: str = "linear") -> Material:
    """Complex index of a named material as a dispersion model with its provenance.

    Args:
        name: as `materials` lists them, or an alias: "Au" or "gold", "SiO2" or "fused silica", "BK7" for N-BK7.
        source: first author, "Johnson"; None takes the first of the list.
        method: of interpolation in tables, "linear" or "cubic" (monotone); formulas are evaluated as published.

    Returns:
        Material, to be called with wavelengths in nm.

    Raises:
        ValueError: no such material or source; the message lists what there is, the closest first.

    Differentiable in the numbers of the table, or the coefficients, and in the wavelength. Source of the data:
    M. N. Polyanskiy, Refractiveindex.info database, Sci. Data 11, 94 (2024), and the citation of each entry.
    """
    if method not in METHODS:
        raise ValueError(f"method = {method!r} must be one of {', '.join(METHODS)}")
    about = provenance(name, source)
    row = _catalogue()["materials"][about.material]["sources"][about.source]
    parts = [_part(part, method) for part in row["data"]]
    if len(parts) == 1:
        return Material(parts[0], about)
    return Material(WithExtinction(*parts), about)


def _part(part: dict[str, Any], method: str) -> Any:
    if "formula" in part:
        return from_formula(part["formula"], part["coefficients"], *part["range_nm"])
    columns = read_columns(part["table"])
    zero = np.zeros_like(columns["wavelength_nm"])
    n, k = columns.get("n", zero), columns.get("k", zero)
    return Tabulated(columns["wavelength_nm"], n, k, method)


@functools.cache
def read_columns(name: str) -> dict[str, np.ndarray]:
    """Columns of a table of the package."""
    text = resources.files("jaxrefl").joinpath(f"data/materials/{name}").read_text(encoding="utf-8")
    rows = list(csv.reader(line for line in text.splitlines() if not line.startswith("#")))
    columns = {key: np.array([float(row[i]) for row in rows[1:]]) for i, key in enumerate(rows[0])}
    for column in columns.values():
        column.flags.writeable = False
    return columns
