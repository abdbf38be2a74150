"""The reflection models by name, and a user's own from a file: ``"path/to/file.py:Name"``."""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import brdf
from .params import Param, parameters, validate

MODELS: dict[str, type] = {
    "lambert": brdf.Lambert,
    "literal-phong": brdf.LiteralPhong,
    "modified-phong": brdf.ModifiedPhong,
    "blinn-phong": brdf.BlinnPhong,
    "oren-nayar": brdf.OrenNayar,
    "eon": brdf.EON,
    "burley": brdf.Burley,
    "ashikhmin-shirley-diffuse": brdf.AshikhminShirleyDiffuse,
    "lommel-seeliger": brdf.LommelSeeliger,
    "minnaert": brdf.Minnaert,
    "coated-lambert": brdf.CoatedLambert,
    "slab": brdf.Slab,
    "d3d9": brdf.D3D9,
    "d3d9-repaired": brdf.D3D9Repaired,
}
"""Name to class; `Mix` and `Scaled` combine them."""


def resolve(name: str) -> Any:
    """Class, or function f(wi, wo), of a name in `MODELS` or of ``path/to/file.py:Name``.

    Raises:
        ValueError: an unknown name (the known ones are listed), a file that is not there, or has no such name.
    """
    if name in MODELS:
        return MODELS[name]
    path, _, attribute = name.rpartition(":")
    if not path:
        raise ValueError(f"model = {name!r} must be one of {', '.join(MODELS)}, or path/to/file.py:Name")
    if not Path(path).is_file():
        raise ValueError(f"model = {name!r}: there is no file {path}")
    key = f"_jaxrefl_user_{Path(path).stem}_{abs(hash(str(Path(path).resolve())))}"
    spec = importlib.util.spec_from_file_location(key, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"model = {name!r}: {path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[key] = module  # a dataclass looks its module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ValueError(f"model = {name!r}: {path} fails with {type(error).__name__}: {error}") from error
    if not hasattr(module, attribute):
        raise ValueError(f"model = {name!r}: {path} has no {attribute}")
    return getattr(module, attribute)


def describe(model: Any) -> str:
    """Parameters of a model, one line each: name, range, default, meaning."""
    lines = []
    for p in parameters(model) if hasattr(model, "__dataclass_fields__") else ():
        unit = f" {p.unit}" if p.unit else ""
        default = "required" if p.default is dataclasses.MISSING else f"default {p.default}"
        lines.append(f"  {p.name} in {p.interval}{unit}, {default}: {p.doc}")
    lines += [f"  {field} one of {', '.join(choices)}" for field, choices in _choices(model).items()]
    return "\n".join(lines) or "  (none)"


def _choices(model: Any) -> dict[str, tuple[str, ...]]:
    """Static fields with the values that they may have."""
    found = {}
    for field in getattr(model, "__dataclass_fields__", {}).values():
        if field.metadata.get("static"):
            found[field.name] = tuple(field.metadata.get("choices", ("false", "true")))
    return found


def build(name: str, settings: Sequence[str] = ()) -> Any:
    """Model of a name with parameters written ``rho=0.5`` or ``rho=0.9,0.5,0.1``.

    Raises:
        ValueError: an unknown model; an unknown parameter or a value out of its range, answered with the list of those
            that there are.
    """
    model = resolve(name)
    if not isinstance(model, type):
        if settings:
            raise ValueError(f"{settings[0]!r}: {name} is a function and has no parameters")
        return model
    declared = {p.name: p for p in parameters(model)} if hasattr(model, "__dataclass_fields__") else {}
    choices = _choices(model)
    given: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or (key not in declared and key not in choices):
            raise ValueError(f"{setting!r} is not a parameter of {name}; write name=value with\n{describe(model)}")
        given[key] = _parse(setting, text, declared.get(key), choices.get(key))
    try:
        built = model(**given)
        validate(built)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{error}; the parameters of {name} are\n{describe(model)}") from None
    return built


def _parse(setting: str, text: str, declared: Param | None, choices: tuple[str, ...] | None) -> Any:
    if declared is None:
        assert choices is not None
        if text not in choices:
            raise ValueError(f"{setting!r} must be one of {', '.join(choices)}")
        return text == "true" if choices == ("false", "true") else text
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(f"{setting!r} is not a number, or numbers with commas between them") from None
    if len(numbers) == 1:
        return numbers[0]
    if not declared.spectral:
        raise ValueError(f"{setting!r}: {declared.name} is a single number")
    return np.array(numbers)


def white(sigma: float = 0.3, exponent: float = 10.0, k: float = 0.8) -> dict[str, Any]:
    """Every model where it absorbs nothing by its parameters: an albedo other than 1 is the doing of its formula."""
    return {
        "Lambert": brdf.Lambert(1.0),
        "Oren-Nayar": brdf.OrenNayar(1.0, sigma),
        "EON": brdf.EON(1.0, 0.5),
        "Burley": brdf.Burley(1.0, 1.0),
        "Ashikhmin-Shirley": brdf.AshikhminShirleyDiffuse(1.0, 0.0),
        "Lommel-Seeliger": brdf.LommelSeeliger(1.0),
        "Minnaert": brdf.Minnaert(1.0, k),
        "coated Lambert": brdf.CoatedLambert(1.0, 1.5),
        "modified Phong": brdf.ModifiedPhong(1.0, exponent),
        "Blinn-Phong": brdf.BlinnPhong(1.0, exponent),
        "literal Phong": brdf.LiteralPhong(0.0, 1.0, exponent),
        "literal OpenGL": brdf.LiteralPhong(0.0, 1.0, exponent, "half_vector"),
        "slab": brdf.Slab(1.5, 0.0),
        "D3D9 (6)": brdf.D3D9(),
        "D3D9 (8)": brdf.D3D9(sun_fresnel=True),
        "D3D9 repaired": brdf.D3D9Repaired(),
    }
