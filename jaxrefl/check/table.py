"""The oracle table, the register of evaluators, and the comparison of the two."""

from __future__ import annotations

import functools
import importlib.resources
import json
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike

VALUE_RTOL = 1e-13  # float64 through a few dozen operations
DERIVATIVE_RTOL = 1e-11  # the same through automatic differentiation

Columns: TypeAlias = Mapping[str, Array]
"""Input columns of a block by name, each (rows,)."""
HostColumns: TypeAlias = dict[str, Any]
"""The same as NumPy arrays, for a computation on the host."""
Compute: TypeAlias = Callable[[Any], Mapping[str, ArrayLike]]
"""From the input columns to the computed ones, (rows,) or a number where the table has a single one."""


class Row(NamedTuple):
    """One number of the table, computed."""

    block: str
    """Block of the data file, such as ``"A.table"``."""
    label: str
    """Inputs, such as ``"eta=1.5, theta=60 deg"``."""
    quantity: str
    """Column of the block."""
    value: float
    """What the library computes."""
    oracle: float
    """What the table says."""
    source: str
    """How the oracle was computed, and to what relative accuracy."""
    error: float
    """|value - oracle| / |oracle|; without the denominator where the oracle is 0."""
    tolerance: float
    """Largest allowed error."""
    ok: bool
    """True if the error is within the tolerance; False for NaN."""


class Evaluator(NamedTuple):
    """How a block is computed, and what each of its columns is: input, skipped, or computed."""

    compute: Compute
    inputs: tuple[str, ...]
    derivatives: tuple[str, ...]
    skipped: Mapping[str, str]
    looser: Mapping[str, float]
    given: str
    jit: bool


class Block(NamedTuple):
    """Block of the data file as text: ``fields`` name the columns that have one entry per row."""

    how: str
    rtol: float
    fields: tuple[str, ...]
    columns: dict[str, list[str | None]]


evaluators: dict[str, Evaluator] = {}


def evaluates(
    block: str,
    inputs: str = "",
    *,
    derivatives: str = "",
    looser: Mapping[str, float] | None = None,
    skipped: Mapping[str, str] | None = None,
    given: str = "",
    jit: bool = True,
) -> Callable[[Compute], Compute]:
    """Decorator that registers the evaluator of a block.

    Args:
        block: its name.
        inputs: columns that are given, separated by spaces; they make the label.
        derivatives: computed columns that come from automatic differentiation, likewise.
        looser: computed columns that cannot be had as accurately, with their tolerance; the reason stands beside it.
        skipped: columns that are not computed, or labels of rows that are not compared, with the reason.
        given: inputs that the block states in words, for the label.
        jit: False for a computation on the host; only such a one sees inputs that are words.
    """

    def register(compute: Compute) -> Compute:
        columns = tuple(inputs.split()), tuple(derivatives.split())
        evaluators[block] = Evaluator(compute, *columns, skipped or {}, looser or {}, given, jit)
        return compute

    return register


@functools.cache
def _blocks() -> dict[str, Block]:
    text = importlib.resources.files("jaxrefl").joinpath("data/oracles.json").read_text("utf-8")
    found = {}
    for section, members in json.loads(text)["sections"].items():
        for key, block in members.items():
            words = {word: block.pop(word, ()) for word in ("about", "how", "rtol", "fields", "rows", "values")}
            columns = {name: [row[i] for row in words["rows"]] for i, name in enumerate(words["fields"])}
            columns |= {name: [value] for name, value in {**dict(words["values"]), **block}.items()}
            found[f"{section[0]}.{key}"] = Block(words["how"], words["rtol"], tuple(words["fields"]), columns)
    return found


def block_names() -> list[str]:
    """Names of the blocks, in the order of the data file."""
    return list(_blocks())


def select(names: Iterable[str] | None = None) -> list[str]:
    """Blocks named by themselves or by the letter of their section, in the order of the data file; all if none is.

    Raises:
        ValueError: a name that is neither.
    """
    wanted = set(names or ())
    known = {name for block in _blocks() for name in (block, block[0])}
    if wanted - known:
        raise ValueError(f"names = {sorted(wanted - known)} are no blocks; the blocks are {', '.join(block_names())}")
    return [block for block in block_names() if not wanted or wanted & {block, block[0]}]


def _exact(text: str) -> Fraction:
    """Number as written; a fraction such as ``"1/1.5"`` is divided exactly."""
    numerator, _, denominator = text.partition("/")
    return Fraction(numerator) / Fraction(denominator or 1)


def _float(text: str) -> float:
    return float(text) if text == "inf" else float(_exact(text))


def _inputs(block: str) -> dict[str, np.ndarray]:
    """Input columns of a block: numbers where they are numbers, with cosine and sine beside every angle.

    An angle ``name_deg`` comes as ``cos_name`` and ``sin_name`` too. The cosine is the sine of 90 - angle, subtracted
    exactly: it keeps its relative accuracy at grazing incidence and is 0 at 90 degrees. A metal comes with the ``eta``
    and ``k`` of B.metals.
    """
    texts = {name: [str(text) for text in _blocks()[block].columns[name]] for name in evaluators[block].inputs}
    if "metal@nm" in texts and "eta" not in texts:
        metals = _blocks()["B.metals"].columns
        where = [metals["metal@nm"].index(metal) for metal in texts["metal@nm"]]
        texts |= {name: [str(metals[name][i]) for i in where] for name in ("eta", "k")}
    columns = {}
    for name, entries in texts.items():
        try:
            columns[name] = np.array([_float(text) for text in entries])
        except ValueError:
            columns[name] = np.array(entries)
        if name.endswith("_deg"):
            angle = name.removesuffix("_deg")
            columns["cos_" + angle] = np.sin(np.deg2rad([float(90 - _exact(text)) for text in entries]))
            columns["sin_" + angle] = np.sin(np.deg2rad(columns[name]))
    return columns


def _label(block: str, row: int | None) -> str:
    """Inputs as they stand in the table, after what the block states in words; the latter alone without a row."""
    evaluator, parts = evaluators[block], []
    if evaluator.given:
        parts.append(evaluator.given)
    for name in evaluator.inputs if row is not None else ():
        text, angle = str(_blocks()[block].columns[name][row or 0]), name.removesuffix("_deg")
        unit = " deg" if angle != name else ""
        parts.append(text if name in ("material", "metal@nm") else f"{angle}={text}{unit}")
    return ", ".join(parts)


def _computed(block: str) -> dict[str, np.ndarray]:
    columns, evaluator = _inputs(block), evaluators[block]
    if not evaluator.jit:
        values = evaluator.compute(columns)
    else:  # a new function each time: one compilation, of the library as it is now
        numbers = {name: column for name, column in columns.items() if column.dtype.kind == "f"}
        values = jax.jit(lambda numbers: evaluator.compute(numbers))(numbers)
    return {name: np.asarray(value) for name, value in values.items()}


def evaluate(name: str) -> list[Row]:
    """Rows of one block, computed. A number that the table leaves undefined has no row.

    Args:
        name: one of `block_names`.

    Raises:
        ValueError: no such block.
        RuntimeError: 64-bit types are off.
    """
    if name not in _blocks():
        raise ValueError(f"name = {name!r} is not one of {block_names()}")
    if jnp.result_type(float) != jnp.float64:
        raise RuntimeError("the check compares in float64: call jax.config.update('jax_enable_x64', True) first")
    block, evaluator, computed, rows = _blocks()[name], evaluators[name], _computed(name), []
    for quantity in sorted(computed, key=list(block.columns).index):
        texts, values = block.columns[quantity], computed[quantity]
        reached = DERIVATIVE_RTOL if quantity in evaluator.derivatives else VALUE_RTOL
        rtol = max(block.rtol, evaluator.looser.get(quantity, reached))
        for i, (value, text) in enumerate(zip(np.broadcast_to(values, len(texts)).tolist(), texts, strict=True)):
            label = _label(name, i if quantity in block.fields else None)
            if text is None or label in evaluator.skipped:
                continue
            oracle = _float(text)
            error = abs(value - oracle) / (abs(oracle) or 1.0)
            source = f"{block.how}, rtol {block.rtol:g}"
            rows.append(Row(name, label, quantity, value, oracle, source, error, rtol, error <= rtol))
    return rows


def run(names: Iterable[str] | None = None) -> list[Row]:
    """Rows of the blocks that `select` finds; to show progress, call `evaluate` for each of these."""
    return [row for name in select(names) for row in evaluate(name)]
