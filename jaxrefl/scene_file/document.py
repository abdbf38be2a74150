"""Scene files read: text -> document -> tables -> scene, with every problem named."""

from __future__ import annotations

import copy
import hashlib
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from ..scene import Scene
from .build import build
from .catalog import Settings
from .problems import explain, path_text, raise_problems, shown
from .tables import Table, document_table, keys, table_at


class SceneFile(NamedTuple):
    """Scene file that was read and found right."""

    name: str
    """File name, or what stood for it."""
    scene: Scene
    """Its numbers are arrays of JAX's default float."""
    camera: Any
    settings: Settings
    channels: int
    """C."""
    document: dict[str, Any]
    """What was validated: the file, with the values that were set."""
    source_text: str
    sha256: str
    """Hash of the document without its table ``render``, and of the pictures it names."""


def parse(text: str, name: str) -> dict[str, Any]:
    """Document of a TOML text.

    Raises:
        ValueError: not TOML; the message names line and column.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"{name}: nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", str(error), re.DOTALL)
        if not found:
            message = str(error).removesuffix(" (at end of document)")
            raise ValueError(f"{name}: line {text.count(chr(10)) + 1}, at the end: {message}") from None
        message, line, column = found.groups()
        source = text.split("\n")[int(line) - 1].strip()
        raise ValueError(f"{name}: line {line}, column {column}: {message}: {source}") from None


def set_values(document: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """Document with values replaced, each written ``objects.glass.surface.eta=1.33`` with a value of TOML.

    A value that is not TOML is taken as a string: ``render.alpha=printed``.

    Raises:
        ValueError: no ``=``, or a path that does not exist; the message lists what exists there.
    """
    changed: dict[str, Any] = copy.deepcopy(dict(document))
    for setting in settings:
        path, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or not path:
            raise ValueError(f"setting = {setting!r}: write path=value, such as render.width=320")
        node, steps = changed, path.split(".")
        for depth, step in enumerate(steps):
            _require_key(setting, node, steps[:depth], step)
            if depth < len(steps) - 1:
                node = node.setdefault(step, {})
        node[steps[-1]] = _value(text)
    return changed


def _require_key(setting: str, node: Any, path: Sequence[str], step: str) -> None:
    where = path_text(path)
    if not isinstance(node, dict):
        raise ValueError(f"setting = {setting!r}: {where} = {shown(node)} is not a table")
    model = table_at(path, node)
    known = list(dict.fromkeys([*(keys(model) if model else ()), *node]))
    if step not in known:
        there = ", ".join(known) or "nothing"
        raise ValueError(f"setting = {setting!r}: {where or 'the file'} has no {step!r}, it has {there}")


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def validated(document: Mapping[str, Any], name: str) -> Table:
    """Tables of a document.

    Raises:
        ValueError: one line per problem.
    """
    try:
        return document_table().model_validate(document)
    except ValidationError as error:
        raise_problems(name, [explain(dict(item), document) for item in error.errors(include_url=False)])
        raise


def loads(text: str, name: str = "scene", *, settings: Sequence[str] = (), folder: Path | None = None) -> SceneFile:
    """Scene of a TOML text.

    Args:
        text: what stands in the file.
        name: its name, for messages.
        settings: values to replace before anything is checked, see `set_values`.
        folder: where the paths of pictures begin; the working folder if none is given.

    Raises:
        ValueError: one line per problem, each with file, path, value and what is allowed.
    """
    document = set_values(parse(text, name), settings)
    tables = validated(document, name)
    built, problems = build(tables, folder or Path())
    raise_problems(name, problems)
    return SceneFile(name, *built, document, text, _hash(document, folder or Path()))


def load(path: str | Path, *, settings: Sequence[str] = ()) -> SceneFile:
    """Scene of a file; see `loads`."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not UTF-8 text: byte {error.start}") from None
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from None
    return loads(text, str(path), settings=settings, folder=path.parent)


def _hash(document: Mapping[str, Any], folder: Path) -> str:
    """SHA-256 of what is seen: all but the table ``render``, numbers as numbers, and the pictures."""
    seen = {key: value for key, value in document.items() if key != "render"}
    digest = hashlib.sha256(json.dumps(seen, sort_keys=True, default=str).encode())
    for path in sorted(set(_pictures(seen))):
        digest.update((folder / path).read_bytes())
    return digest.hexdigest()


def _pictures(node: Any) -> list[str]:
    if isinstance(node, dict):
        own = [node["path"]] if node.get("type") == "Image" else []
        return own + [path for value in node.values() for path in _pictures(value)]
    return []


def json_schema() -> dict[str, Any]:
    """JSON schema (2020-12) of scene files, with ranges, units and meanings, for editors that check a file."""
    return document_table().model_json_schema()
