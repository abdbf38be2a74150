"""Forms of a value in a scene file, as pydantic types made from a declaration: a number, a list, a table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, Union

from pydantic import AfterValidator, Discriminator, Field, Tag, WithJsonSchema
from pydantic_core import PydanticCustomError

from ..params import Interval, Param
from ..vec import Vec3

FLOAT32_MAX = 3.4028234e38
Forms = dict[str, tuple[Any, str]]
"""Accepted forms of a value: name, type, and how the form is called in a message; a model is called by its name."""


def in_degrees(declared: Param) -> Param:
    """Declaration of an angle as the file has it, its range in whole degrees; any other declaration unchanged."""
    if declared.unit != "rad":
        return declared
    low, high = (float(round(math.degrees(end))) for end in declared.interval[:2])
    shown = declared._replace(name=f"{declared.name}_deg", unit="degrees")
    shown = shown._replace(interval=declared.interval._replace(low=low, high=high))
    known = declared.default is not None and declared.default is not dataclasses.MISSING
    return shown._replace(default=round(math.degrees(declared.default), 6)) if known else shown


def tag(name: Any) -> str:
    """Name of a form or of a model, as it stands in the location of an error."""
    return f"<{name}>"


def form_of(value: Any, default: str | None = None) -> str:
    """Tag of the form that a value has: its type if it is a table, rows if it is a list of lists."""
    if isinstance(value, dict):
        return tag(value.get("type", default))
    if isinstance(value, list):
        return tag("rows" if value and isinstance(value[0], list) else "list")
    return tag("number")


def generic(kind: Any, *arguments: Any) -> Any:
    """Generic type of types that are made here: ``kind[arguments]``, which is no annotation."""
    return kind[arguments]


def one_of(forms: Mapping[str, Any]) -> Any:
    """Type of a value that has one of several forms."""
    if len(forms) == 1:
        return next(iter(forms.values()))
    tagged = (generic(Annotated, kind, Tag(tag(name))) for name, kind in forms.items())
    return generic(Annotated, generic(Union, *tagged), Discriminator(form_of))


def _number(interval: Interval, kind: type = float) -> Any:
    """Type of a number in an interval."""

    def inside(value: float) -> float:
        above = value > interval.low if interval.low_open else value >= interval.low
        below = value < interval.high if interval.high_open else value <= interval.high
        if not (above and below):
            raise PydanticCustomError("outside", "is outside {interval}", {"interval": str(interval)})
        if abs(value) > FLOAT32_MAX:
            raise PydanticCustomError("outside", "is too large for float32")
        return value

    schema: dict[str, Any] = {"type": "number" if kind is float else "integer"}
    if math.isfinite(interval.low):
        schema["exclusiveMinimum" if interval.low_open else "minimum"] = interval.low
    if math.isfinite(interval.high):
        schema["exclusiveMaximum" if interval.high_open else "maximum"] = interval.high
    return generic(Annotated, kind, AfterValidator(inside), WithJsonSchema(schema))


def _list(item: Any) -> Any:
    return generic(list, item)


def _equally_long(rows: list[list[float]]) -> list[list[float]]:
    if len({len(row) for row in rows}) > 1:
        raise PydanticCustomError("outside", "has rows of different lengths")
    return rows


def _rows(row: Any) -> Any:
    return generic(Annotated, _list(row), Field(min_length=1), AfterValidator(_equally_long))


def forms_of(declared: Param, many: bool, kind: type = float) -> Forms:
    """Forms that a number may have: many for one value per primitive."""
    number = _number(declared.interval, kind)
    word = "a number" if kind is float else "an integer"
    if declared.vector:
        vector = generic(Annotated, _list(number), Field(min_length=3, max_length=3))
        forms: Forms = {"list": (vector, "3 numbers")}
        return forms | ({"rows": (_rows(vector), "a list of 3 numbers for each primitive")} if many else {})
    forms = {"number": (number, word)}
    spectrum = generic(Annotated, _list(number), Field(min_length=1))
    if declared.spectral:
        forms["list"] = spectrum, "a list with one for each channel"
        if many:
            forms["rows"] = _rows(spectrum), "a list of such lists for each primitive"
    elif many:
        forms["list"] = spectrum, "a list with one for each primitive"
    return forms


def description(declared: Param, forms: Forms) -> str:
    """Meaning, accepted forms, range and unit of a key."""
    words = [word for name, (_, word) in forms.items() if not name[0].isupper()]
    if models := [name for name in forms if name[0].isupper()]:
        words.append(f"a table of type {' or '.join(models)}")
    accepted = " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))
    where = "" if math.isinf(declared.interval.low) else f", in {declared.interval}"
    return f"{declared.doc}: {accepted}{where}{f', {declared.unit}' if declared.unit else ''}"


def default_of(value: Any) -> dict[str, Any]:
    """Default of a key, shown in the schema if it can be written down."""
    if value is dataclasses.MISSING:
        return {}
    if isinstance(value, Vec3):
        return {"default": [float(x) for x in (value.x, value.y, value.z)]}
    return {"default_factory": lambda: None} if value is None else {"default": value}
