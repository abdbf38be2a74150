"""The figures: found, computed, drawn, written.

A figure is one file of `figures/` with ``compute(**parameters) -> dict`` (arrays and headline numbers), ``draw(data,
fig)`` and ``CAPTION``, whose claim a test asserts from what ``compute`` returns; ``SIZE`` in inches is optional. In a
clone the files lie beside the package, in an installed wheel inside it.
"""

from __future__ import annotations

import csv
import importlib.util
import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .files import write_atomically

FORMATS = ("png", "pdf", "svg")
CSV_LIMIT = 100_000


class Entry(NamedTuple):
    """One figure of the gallery."""

    name: str
    compute: Callable[..., dict[str, Any]]
    draw: Callable[[dict[str, Any], Any], None]
    caption: str
    size: tuple[float, float]

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of ``compute`` and their defaults."""
        return {name: p.default for name, p in inspect.signature(self.compute).parameters.items()}


def directory() -> Path:
    """Folder that holds the figure files."""
    package = Path(__file__).resolve().parent
    installed = package / "_figures"
    return installed if installed.is_dir() else package.parent / "figures"


def names() -> list[str]:
    """Names of all figures, in alphabetical order."""
    return sorted(path.stem for path in directory().glob("*.py") if not path.stem.startswith("_"))


def load(name: str) -> Entry:
    """Figure of a name.

    Raises:
        ValueError: no such figure; the message lists the names.
    """
    if name not in names():
        raise ValueError(f"name = {name!r} is not a figure; there are {', '.join(names())}")
    spec = importlib.util.spec_from_file_location(f"jaxrefl_figure_{name}", directory() / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    caption = " ".join(module.CAPTION.split())
    return Entry(name, module.compute, module.draw, caption, getattr(module, "SIZE", (6.4, 4.0)))


def load_all(wanted: Sequence[str]) -> list[Entry]:
    """Figures of several names, each once; one whose file cannot be loaded fails when it is computed, not before.

    Raises:
        ValueError: no such figure.
    """
    entries = []
    for name in dict.fromkeys(wanted):
        if name not in names():
            load(name)
        try:
            entries.append(load(name))
        except Exception as error:
            entries.append(_broken(name, error))
    return entries


def _broken(name: str, error: Exception) -> Entry:
    def compute() -> dict[str, Any]:
        raise error

    return Entry(name, compute, lambda data, fig: None, f"cannot be loaded: {error}", (1.0, 1.0))


def parse_settings(entries: Sequence[Entry], settings: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Values of ``key=value`` for each figure that has the parameter, converted to the type of its default.

    A tuple is written with commas, ``eta=1.33,1.5``.

    Raises:
        ValueError: no ``=``, a key that none of the figures has, or a value of another type.
    """
    chosen: dict[str, dict[str, Any]] = {entry.name: {} for entry in entries}
    for setting in settings:
        key, equals, text = setting.partition("=")
        takers = [entry for entry in entries if key in entry.parameters]
        if not equals or not takers:
            known = "; ".join(f"{e.name}: {', '.join(e.parameters) or 'none'}" for e in entries)
            raise ValueError(f"setting = {setting!r}: write key=value with a parameter of a chosen figure ({known})")
        for entry in takers:
            chosen[entry.name][key] = _convert(setting, text, entry.parameters[key])
    return chosen


def _convert(setting: str, text: str, default: Any) -> Any:
    kind = type(default[0] if isinstance(default, tuple) else default)
    try:
        values = tuple(kind(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError(
            f"setting = {setting!r}: the value must be of type {kind.__name__}, such as {default}"
        ) from error
    if isinstance(default, tuple):
        return values
    if len(values) != 1:
        raise ValueError(f"setting = {setting!r}: one value of type {kind.__name__} is needed, such as {default}")
    return values[0]


def make(
    entry: Entry,
    out: Path,
    formats: Sequence[str] = ("png",),
    settings: Mapping[str, Any] | None = None,
    style: str = "paper",
    data: bool = False,
) -> list[Path]:
    """Compute and draw one figure and write it in every format; with ``data`` what was computed as well.

    Returns:
        the files written, each complete.
    """
    from . import plot

    computed = entry.compute(**(settings or {}))
    paths = []
    with plot.style(style):
        figure = plot.figure(entry.size)
        entry.draw(computed, figure)
        for kind in formats:
            paths.append(plot.save(figure, out / f"{entry.name}.{kind}"))
    if data:
        paths += write_data(computed, out / entry.name)
    return paths


def write_data(computed: Mapping[str, Any], stem: Path) -> list[Path]:
    """What ``compute`` returned, as STEM.npz (arrays as they are) and STEM.csv (one row per element).

    The columns of the CSV are name, value and the indices i, j, k of the element, empty where it has fewer; an array of
    more than `CSV_LIMIT` elements is left to the NPZ.
    """
    arrays = {name: np.asarray(value) for name, value in computed.items()}
    npz, table = stem.with_name(f"{stem.name}.npz"), stem.with_name(f"{stem.name}.csv")

    def write_npz(path: Path) -> None:
        with path.open("wb") as file:
            np.savez_compressed(file, **arrays)  # type: ignore[arg-type]

    def write_csv(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow(["name", "value", "i", "j", "k"])
            for name, array in arrays.items():
                if array.size <= CSV_LIMIT:
                    for index, value in np.ndenumerate(array):
                        rows.writerow([name, np.asarray(value).item(), *index, *[""] * (3 - len(index))])

    write_atomically(npz, write_npz)
    write_atomically(table, write_csv)
    return [npz, table]
