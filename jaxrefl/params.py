"""Declared ranges: the one place where a parameter says what it is and what it may be.

A model is a class decorated with `pytree`, its fields made by `param`; a formula is decorated with `checked`.
Both state their ranges as intervals written the way a paper writes them, ``"[0, 1]"`` or ``"(0, inf)"``, and both
are checked only on concrete values, outside `jit`: under a transformation the check costs nothing and sees nothing.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, ParamSpec, TypeVar, dataclass_transform

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

Real = Float[ArrayLike, "..."]
"""Argument of a scalar formula: a number or an array; several broadcast against each other."""
Result = Float[Array, "..."]
"""Result of a scalar formula, of the broadcast shape."""

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

_ROUNDING = 8.0  # a closed bound admits a value that a few roundings pushed over it, in units of eps


class Interval(NamedTuple):
    """Range of a real parameter, open or closed at either end."""

    low: float
    high: float
    low_open: bool = False
    high_open: bool = False

    @classmethod
    def parse(cls, text: str) -> Interval:
        """Interval written as ``"[0, 1]"``, ``"(0, inf)"`` or ``"[0, 1)"``."""
        body = text.strip()
        if len(body) < 5 or body[0] not in "[(" or body[-1] not in "])" or body.count(",") != 1:
            raise ValueError(f"text = {text!r} is not an interval such as '[0, 1]' or '(0, inf)'")
        try:
            low, high = (float(part) for part in body[1:-1].split(","))
        except ValueError as error:
            raise ValueError(f"text = {text!r}: the ends must be numbers") from error
        if not low < high:
            raise ValueError(f"text = {text!r}: the lower end must be below the upper end")
        return cls(low, high, body[0] == "(" or low == -np.inf, body[-1] == ")" or high == np.inf)

    def contains(self, values: np.ndarray) -> np.ndarray:
        """Elementwise membership; NaN is outside, a closed end admits a few roundings of the dtype that computes."""
        working = jax.dtypes.canonicalize_dtype(values.dtype if values.dtype.kind == "f" else np.float64)
        eps = _ROUNDING * float(jnp.finfo(working).eps)
        low, high = self.low - eps * max(1.0, abs(self.low)), self.high + eps * max(1.0, abs(self.high))
        above = values > self.low if self.low_open else values >= low
        below = values < self.high if self.high_open else values <= high
        return above & below

    def __str__(self) -> str:
        return f"{'(' if self.low_open else '['}{self.low:g}, {self.high:g}{')' if self.high_open else ']'}"


class Param(NamedTuple):
    """Declaration of one field of a model."""

    name: str
    interval: Interval
    unit: str
    spectral: bool
    vector: bool
    nonzero: bool
    default: Any
    doc: str


def param(
    interval: str,
    *,
    unit: str = "",
    spectral: bool = False,
    vector: bool = False,
    nonzero: bool = False,
    default: Any = dataclasses.MISSING,
    doc: str = "",
) -> Any:
    """Dataclass field with its range, unit and meaning: the only declaration a model's parameter needs.

    Args:
        interval: range, such as ``"[0, 1]"``; checked by `validate` on concrete values.
        unit: unit as printed on an axis; empty for a pure number.
        spectral: True if the field may hold a spectrum (C,), or a texture; False for a scalar.
        vector: True if the field is a `Vec3`, each of whose components has the range.
        nonzero: True if it must not be the zero vector.
        default: value when none is given; without one the field is required. None as default: the field may be absent.
        doc: one line.
    """
    declared = {"interval": Interval.parse(interval), "unit": unit, "spectral": spectral, "doc": doc}
    declared |= {"vector": vector, "nonzero": nonzero}
    return dataclasses.field(default=default, metadata={"param": declared})


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(param, dataclasses.field))
def pytree(cls: type[T]) -> type[T]:
    """Class decorator: a frozen dataclass that JAX can flatten, map and differentiate; the only one that a model needs.

    Fields whose metadata have ``static`` true are structure (hashable, part of what `jit` compiles for), the others
    are leaves or models. In place of ``jax.tree_util.register_dataclass``, whose structures compare equal when two
    classes have the same number of fields: `jit` then takes, now and then, the code that was compiled for another
    class (measured with jax 0.10.2: 65 wrong results in 400 classes of one field).
    """
    cls = dataclasses.dataclass(frozen=True, eq=False)(cls)
    fields = dataclasses.fields(cls)  # type: ignore[arg-type]  # it is one since the line above
    static = tuple(field.name for field in fields if field.metadata.get("static"))
    leaves = tuple(field.name for field in fields if field.name not in static)

    def flatten(model: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        return tuple(getattr(model, name) for name in leaves), tuple(getattr(model, name) for name in static)

    def flatten_with_keys(model: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        children, structure = flatten(model)
        return tuple(zip(map(jax.tree_util.GetAttrKey, leaves), children, strict=True)), structure

    def unflatten(structure: tuple[Any, ...], children: Iterable[Any]) -> T:
        model = object.__new__(cls)
        for name, value in (*zip(leaves, children, strict=True), *zip(static, structure, strict=True)):
            object.__setattr__(model, name, value)
        return model

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
    cls.__pytree__ = True  # type: ignore[attr-defined]
    return cls


def foreign_classes(tree: Any) -> tuple[type, ...]:
    """Dataclasses in a nest that were not made by `pytree`: a static argument that keeps `jit` from confusing them."""
    if isinstance(tree, Mapping):
        return tuple(found for key in sorted(tree) for found in foreign_classes(tree[key]))
    if isinstance(tree, (list, tuple)):
        return tuple(found for item in tree for found in foreign_classes(item))
    if not dataclasses.is_dataclass(tree) or isinstance(tree, type):
        return ()
    own = () if "__pytree__" in type(tree).__dict__ else (type(tree),)
    return own + tuple(c for field in dataclasses.fields(tree) for c in foreign_classes(getattr(tree, field.name)))


def parameters(model: Any) -> Iterator[Param]:
    """Declarations of a model class or instance, in field order."""
    for field in dataclasses.fields(model):
        if "param" in field.metadata:
            yield Param(name=field.name, default=field.default, **field.metadata["param"])


def defaults(model: Any) -> dict[str, Any]:
    """Default values of the fields that have one, by name."""
    return {p.name: p.default for p in parameters(model) if p.default is not dataclasses.MISSING}


def is_concrete(value: Any) -> bool:
    """False for a value that exists only inside a JAX transformation."""
    return not isinstance(value, jax.core.Tracer)


def require(name: str, value: Any, interval: Interval) -> None:
    """Raise `ValueError` naming the argument, the value and the range; a traced value passes unseen."""
    if not is_concrete(value):
        return
    values = np.asarray(value)
    if values.dtype.kind not in "fiub" and values.dtype != jnp.bfloat16:
        raise ValueError(f"{name} = {value!r} is not a real number; allowed range {interval}")
    inside = interval.contains(values if values.dtype.kind == "f" else values.astype(np.float64))
    if not inside.all():
        worst = values[~inside].flat[0]
        where = "" if values.ndim == 0 else f" (first of {int((~inside).sum())} such elements)"
        raise ValueError(f"{name} = {worst} is outside {interval}{where}")


def validate(tree: Any, path: str = "") -> None:
    """Check every declared parameter of a model, or of a nest of models, dicts and sequences.

    Raises:
        ValueError: naming the path (``objects.glass.surface.eta``), the value and the range, or, for a scalar
            field that was given a spectrum, the path and its shape.
    """
    if dataclasses.is_dataclass(tree) and not isinstance(tree, type):
        declared = {p.name: p for p in parameters(tree)}
        for field in dataclasses.fields(tree):
            value, name = getattr(tree, field.name), f"{path}.{field.name}".lstrip(".")
            if field.name in declared:
                if value is None and declared[field.name].default is None:
                    continue
                for x in jax.tree.leaves(value) if declared[field.name].vector else [value]:
                    require(name, x, declared[field.name].interval)
                scalar = not (declared[field.name].spectral or declared[field.name].vector)
                if is_concrete(value) and scalar and np.ndim(value) > 0:
                    raise ValueError(f"{name} has shape {np.shape(value)}; it is a scalar")
            else:
                validate(value, name)
    elif isinstance(tree, Mapping):
        for key, value in tree.items():
            validate(value, f"{path}.{key}".lstrip("."))
    elif isinstance(tree, (list, tuple)):
        for i, value in enumerate(tree):
            validate(value, f"{path}[{i}]")


def checked(**ranges: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator: the named arguments must lie in the given intervals (concrete values only)."""
    intervals = {name: Interval.parse(text) for name, text in ranges.items()}

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        names = tuple(inspect.signature(function).parameters)
        unknown = set(intervals) - set(names)
        if unknown:
            raise ValueError(f"ranges = {sorted(unknown)} are not arguments of {function.__name__}{names}")

        @functools.wraps(function)
        def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
            for name, value in (*zip(names, args, strict=False), *kwargs.items()):
                if name in intervals:
                    require(name, value, intervals[name])
            return function(*args, **kwargs)

        wrapper.ranges = intervals  # type: ignore[attr-defined]  # read by the docs and the tests
        return wrapper

    return decorate


def floats(*values: ArrayLike) -> tuple[Array, ...]:
    """Arguments as arrays of one common floating dtype: integers become floats, Python numbers adapt to the arrays."""
    values = tuple(jnp.asarray(value) if isinstance(value, (list, tuple)) else value for value in values)
    dtype = jnp.result_type(*values, 0.0)
    return tuple(jnp.asarray(value, dtype) for value in values)
