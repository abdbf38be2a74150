"""Scenes written as TOML."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..params import parameters
from ..scene import Scene
from ..vec import Vec3
from . import catalog


def key(name: str) -> str:
    """Key as TOML writes it, quoted where it has to be."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _string(name)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def value_text(value: Any) -> str:
    """Value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, list):
        return f"[{', '.join(value_text(item) for item in value)}]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key(k)} = {value_text(v)}" for k, v in value.items()) + "}"
    return str(value)


def document_text(document: Mapping[str, Any]) -> str:
    """Document as TOML: one section for each table."""
    return "\n".join(_lines(document, "")).lstrip("\n") + "\n"


def _lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    plain = {k: v for k, v in table.items() if not isinstance(v, Mapping)}
    if plain:
        if path:
            yield f"\n[{path}]"
        yield from (f"{key(k)} = {value_text(v)}" for k, v in plain.items())
    for k, v in table.items():
        if isinstance(v, Mapping):
            yield from _lines(v, f"{path}.{key(k)}".lstrip("."))


def _number(value: Any) -> Any:
    """Number or nested list of numbers, each the shortest decimal that is read back as it is."""
    array = np.asarray(value)
    if array.ndim:
        return [_number(item) for item in array]
    if array.dtype.kind != "f" or not np.isfinite(array):
        return array.item()
    scalar: Any = array[()]
    return float(np.format_float_scientific(scalar))  # str() is at the mercy of numpy's print options


def _vector(value: Any) -> Any:
    if isinstance(value, Vec3):
        return _number(np.stack(np.broadcast_arrays(*(np.asarray(x) for x in (value.x, value.y, value.z))), axis=-1))
    return _number(value)


def _degrees(radians: Any) -> float:
    """Degrees with few digits, if they are read back as the same radians; else with all of them."""
    angle = np.asarray(radians)
    exact = float(np.degrees(angle.astype(np.float64)))
    short = round(exact, 6)
    return short if np.radians(short).astype(angle.dtype) == angle else exact


def table_of(model: Any, path: str, names: Mapping[str, Any]) -> dict[str, Any]:
    """Table of a model: its type, if it has one in ``names``, and every field that is not None.

    Raises:
        ValueError: a model that a scene file has no name for, or a picture, which is a file of its own.
    """
    kind = next((name for name, cls in names.items() if isinstance(model, cls)), None)
    if kind is None or kind == "Image":
        what = type(model).__name__
        raise ValueError(f"{path} is of type {what}, which cannot be written to a scene file: {', '.join(names)} can")
    declared = {p.name: p for p in parameters(model)}
    table: dict[str, Any] = {"type": kind}
    for field in dataclasses.fields(model):
        value, where = getattr(model, field.name), f"{path}.{field.name}"
        if value is None:
            continue
        if dataclasses.is_dataclass(value) and not isinstance(value, Vec3):
            is_brdf = field.metadata.get("models") == "brdf"
            inner = catalog.TEXTURES if field.name in declared else catalog.BRDFS if is_brdf else catalog.BASES
            table[field.name] = table_of(value, where, inner)
        elif field.name not in declared:
            table[field.name] = value
        elif declared[field.name].unit == "rad":
            table[f"{field.name}_deg"] = _degrees(value)
        else:
            table[field.name] = _vector(value)
    return table


def document_of(scene: Scene, camera: Any, settings: catalog.Settings | None = None) -> dict[str, Any]:
    """Document of a scene, a camera and the settings of a render."""
    objects = {}
    for name, item in scene.objects.items():
        path = f"objects.{name}"
        objects[name] = {
            "shape": table_of(item.shape, f"{path}.shape", catalog.SHAPES),
            "surface": table_of(item.surface, f"{path}.surface", catalog.SURFACES),
        }
    lights = {name: table_of(light, f"lights.{name}", catalog.LIGHTS) for name, light in scene.lights.items()}
    background: Any = scene.background
    if dataclasses.is_dataclass(background):
        background = table_of(background, "background", catalog.BACKGROUNDS)
    else:
        background = _number(background)
    return {
        "background": background,
        "render": dataclasses.asdict(settings or catalog.Settings()),
        "camera": table_of(camera, "camera", catalog.CAMERAS),
        "lights": lights,
        "objects": objects,
    }


def dumps(scene: Scene, camera: Any, settings: catalog.Settings | None = None) -> str:
    """Scene file of a scene: `loads` gives back the same numbers.

    Raises:
        ValueError: a model that a scene file has no name for, or an image texture, which is a file of its own.
    """
    return document_text(document_of(scene, camera, settings))
