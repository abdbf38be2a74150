"""The scenes that ship with the package, and the one to begin with."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from . import catalog
from .tables import keys, table
from .write import value_text

DATA = Path(__file__).resolve().parent.parent / "data"


def examples() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in (DATA / "scenes").glob("*.toml"))


def example(name: str) -> Path:
    """File of a shipped scene.

    Raises:
        ValueError: no such scene; the message lists them.
    """
    if name not in examples():
        raise ValueError(f"name = {name!r} is not a shipped scene; there are {', '.join(examples())}")
    return DATA / "scenes" / f"{name}.toml"


def find(scene: str | Path) -> Path:
    """Scene file of a path, or of the name of a shipped scene; a file wins.

    Raises:
        ValueError: neither.
    """
    if Path(scene).is_file():
        return Path(scene)
    if str(scene) in examples():
        return example(str(scene))
    raise ValueError(f"scene = {str(scene)!r} is no file and no shipped scene; there are {', '.join(examples())}")


def starter() -> str:
    """Scene to begin with, commented, with a list of every model, its keys and their ranges at its end."""
    return (DATA / "starter.toml").read_text(encoding="utf-8") + "\n".join(_reference()) + "\n"


def _reference() -> Iterator[str]:
    yield "\n# Every model and its keys; a model may stand wherever its kind may.\n#"
    groups = {
        "shape": (catalog.SHAPES, True, False),
        "surface": (catalog.SURFACES, True, True),
        "light": (catalog.LIGHTS, False, False),
        "camera": (catalog.CAMERAS, False, False),
        "background": (catalog.BACKGROUNDS, False, False),
        "texture": ({"Checker": catalog.TEXTURES["Checker"]}, False, False),
    }
    for group, (models, many, textures) in groups.items():
        for name, cls in models.items():
            yield f"# {group} {name}"
            model = table(name, cls, many, textures)
            for (key, words), field in zip(keys(model).items(), model.model_fields.values(), strict=True):
                if key != "type":
                    yield f"#     {key:18} {words}{_default(field)}"


def _default(field: Any) -> str:
    if field.is_required():
        return "; required"
    return "" if field.default_factory else f"; {value_text(field.default)} if not given"
