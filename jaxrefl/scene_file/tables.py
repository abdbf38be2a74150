"""Tables of a scene file: pydantic models made from the declarations of the dataclasses that they stand for.

No field is listed here. Range, unit, default and meaning of a key are those of `jaxrefl.params.param`; an angle, which
the dataclass keeps in radians, is a key in degrees that ends in ``_deg``.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, create_model

from ..params import Interval, Param, parameters
from . import catalog
from .forms import default_of, description, forms_of, generic, in_degrees, one_of


class Table(BaseModel):
    """One table of a scene file."""

    model_config = ConfigDict(extra="forbid", strict=True)
    builds: ClassVar[Any] = None
    """Dataclass that the table stands for."""
    interval: ClassVar[Interval | None] = None
    """Of a texture: the range of the parameter in whose place it stands."""


def _quantity(declared: Param, many: bool, textured: bool, kind: type) -> tuple[Any, Any]:
    """Type and field of a declared parameter."""
    shown = in_degrees(declared)
    forms = forms_of(shown, many, kind)
    if textured:
        for name in catalog.TEXTURES:
            forms[name] = texture(name, declared.interval, many), ""
    field = Field(alias=shown.name, description=description(shown, forms), **default_of(shown.default))
    return one_of({name: kind for name, (kind, _) in forms.items()}), field


def _plain(field: dataclasses.Field[Any]) -> tuple[Any, Any]:
    """Type and field of what is not a number: a choice, a switch, or the base of a layered surface."""
    doc = field.metadata.get("doc", field.name.replace("_", " "))
    if choices := field.metadata.get("choices"):
        words = f"{doc}: {' or '.join(choices)}"
        return generic(Literal, *choices), Field(default=field.default, description=words)
    if field.type == "bool":
        return bool, Field(default=field.default, description=f"{doc}: true or false")
    if field.metadata.get("models") == "brdf":
        kind, words = _choice(catalog.BRDFS, "reflection model", many=True)
        return kind, Field(default_factory=lambda: None, description=words)
    base = table("Phong", catalog.BASES["Phong"], many=True, textures=True, optional_type=True)
    return base, Field(default_factory=lambda: None, description="what is under the layer: a table of type Phong")


def _fields(cls: Any, many: bool, textures: bool) -> dict[str, tuple[Any, Any]]:
    declared = {p.name: p for p in parameters(cls)}
    fields = {}
    for field in dataclasses.fields(cls):
        if field.name not in declared:
            fields[field.name] = _plain(field)
            continue
        p = declared[field.name]
        textured = textures and (p.spectral or (cls, p.name) in catalog.TEXTURED_SCALARS)
        fields[field.name] = _quantity(p, many, textured, int if field.type == "int" else float)
    return fields


def _summary(cls: Any) -> str:
    return (cls.__doc__ or "").strip().partition("\n")[0]


def _typed(name: str, title: str, cls: Any, fields: dict[str, Any], optional_type: bool = False) -> type[Table]:
    words = f"which model: {name}"
    field = Field(default=name, description=words) if optional_type else Field(description=words)
    return _table_of(cls, title, _summary(cls), {"type": (generic(Literal, name), field), **fields})


def _table_of(cls: Any, name: str, summary: str, fields: dict[str, Any]) -> type[Table]:
    model = create_model(name, __base__=Table, __doc__=summary, **fields)
    model.builds = cls
    return model


@functools.cache
def table(name: str, cls: Any, many: bool = False, textures: bool = False, optional_type: bool = False) -> type[Table]:
    """Table of a dataclass.

    Args:
        name: its type in the file.
        cls: dataclass with fields made by `param`.
        many: True if a key may hold one value per primitive.
        textures: True if its spectral keys may hold textures.
        optional_type: True if the key ``type`` may be left out.
    """
    title = f"{name} as a base" if optional_type else f"{name} as a BRDF" if cls in catalog.BRDFS.values() else name
    return _typed(name, title, cls, _fields(cls, many, textures), optional_type)


@functools.cache
def texture(name: str, interval: Interval, many: bool) -> type[Table]:
    """Table of a texture in the place of a parameter whose range its colours have to keep."""
    cls = catalog.TEXTURES[name]
    fields: dict[str, Any] = {}
    for declared in parameters(cls):
        if declared.name == "pixels":
            fields["path"] = (str, Field(description="image file, relative to the scene file: a string"))
            words = f"what its numbers are: {' or '.join(catalog.COLORSPACES)}"
            fields["colorspace"] = (generic(Literal, *catalog.COLORSPACES), Field(default="sRGB", description=words))
        else:
            own = declared._replace(interval=interval) if declared.spectral else declared
            fields[declared.name] = _quantity(own, many and name != "Image", False, float)
    model = _typed(name, f"{name} from {interval.low:g} to {interval.high:g}", cls, fields)
    model.interval = interval
    return model


def _choice(models: Mapping[str, Any], what: str, **options: bool) -> tuple[Any, str]:
    kinds = {name: table(name, cls, **options) for name, cls in models.items()}
    return one_of(kinds), f"{what}: a table of type {', '.join(models)}"


def _required(choice: tuple[Any, str]) -> tuple[Any, Any]:
    return choice[0], Field(description=choice[1])


Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_-]+$")]


@functools.cache
def object_table() -> type[Table]:
    """Table of one object."""
    shape = _required(_choice(catalog.SHAPES, "where it is", many=True))
    surface = _required(_choice(catalog.SURFACES, "what it does to a ray", many=True, textures=True))
    return _table_of(None, "Object", "Shape and surface of an object.", {"shape": shape, "surface": surface})


@functools.cache
def settings_table() -> type[Table]:
    """Table of the settings."""
    fields = _fields(catalog.Settings, False, False)
    return _table_of(catalog.Settings, "Render", _summary(catalog.Settings), fields)


@functools.cache
def document_table() -> type[Table]:
    """Table of a whole file."""
    declared = Param(
        "background", Interval.parse("[0, inf)"), "", True, False, False, 0.0, "radiance behind everything"
    )
    forms = forms_of(declared, False)
    for name, cls in catalog.BACKGROUNDS.items():
        forms[name] = table(name, cls), ""
    background = one_of({name: kind for name, (kind, _) in forms.items()})
    light, light_words = _choice(catalog.LIGHTS, "lights by name, each")
    objects = generic(Annotated, generic(dict, Name, object_table()), Field(min_length=1))
    fields = {
        "objects": (objects, Field(description="objects by name, at least one, each: a table with shape and surface")),
        "lights": (generic(dict, Name, light), Field(default_factory=dict, description=light_words)),
        "background": (background, Field(default=0.0, description=description(declared, forms))),
        "camera": _required(_choice(catalog.CAMERAS, "what looks at the scene")),
        "render": (settings_table(), Field(default_factory=lambda: None, description=_summary(catalog.Settings))),
    }
    return _table_of(None, "Scene", "Scene file of jaxrefl.", fields)


def table_at(path: Sequence[str | int], node: Any) -> type[Table] | None:
    """Table that stands at a path of a document; None where keys are names, where there is none, or it is unknown."""
    match tuple(path):
        case ():
            return document_table()
        case ("objects", _):
            return object_table()
        case ("render",):
            return settings_table()
        case ("objects" | "lights",):
            return None
    kind = node.get("type", "Phong" if path[-1] == "base" else None) if isinstance(node, Mapping) else None
    if not isinstance(kind, str):
        return None
    if path[-1] == "brdf":
        return table(kind, catalog.BRDFS[kind], many=True) if kind in catalog.BRDFS else None
    for group in (catalog.SHAPES, catalog.SURFACES, catalog.LIGHTS, catalog.CAMERAS, catalog.BACKGROUNDS):
        if kind in group:
            inside = path[0] == "objects"
            return table(kind, group[kind], many=inside, textures=inside and group is catalog.SURFACES)
    return texture(kind, Interval.parse("[0, inf)"), True) if kind in catalog.TEXTURES else None


def keys(model: type[Table]) -> dict[str, str]:
    """Keys of a table and their descriptions."""
    return {field.alias or name: field.description or "" for name, field in model.model_fields.items()}
