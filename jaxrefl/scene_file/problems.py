"""What is wrong with a scene file, one line per problem: path, value, and what is allowed there."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from .forms import form_of
from .tables import keys, table_at
from .write import key, value_text

Path = tuple[str | int, ...]
LONGEST = 60
WANTED = {
    "float_type": "a number",
    "int_type": "an integer",
    "bool_type": "true or false",
    "string_type": "a string",
    "list_type": "a list",
    "model_type": "a table",
    "dict_type": "a table",
}


def path_text(path: Sequence[str | int]) -> str:
    """Path as it is written everywhere: ``objects.glass.surface.k_d[1]``."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{key(step)}" for step in path).removeprefix(".")


def shown(value: Any) -> str:
    """Value as TOML writes it, a long one cut."""
    text = value_text(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def node_at(document: Any, path: Sequence[str | int]) -> Any:
    """What stands at a path of a document; None if nothing does."""
    for step in path:
        try:
            document = document[step]
        except (KeyError, IndexError, TypeError):
            return None
    return document


def _path(loc: Path) -> Path:
    """Path of an error: its location without the tags of the forms that were tried."""
    return tuple(step for step in loc[:-1] if isinstance(step, int) or not re.fullmatch(r"<.*>", step)) + tuple(
        step for step in loc[-1:] if step != "[key]" and (isinstance(step, int) or not re.fullmatch(r"<\w*>", step))
    )


def _description(document: Any, path: Path) -> str:
    """What the key at a path is for, and what it may hold."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    if len(path) == 2 and path[0] in ("objects", "lights"):
        path = path[:1]  # a name
    if not path:
        return "a table"
    model = table_at(path[:-1], node_at(document, path[:-1]))
    return keys(model).get(str(path[-1]), "") if model else ""


def explain(error: Mapping[str, Any], document: Mapping[str, Any]) -> str:
    """Line for one error of a validation."""
    kind, path, value = error["type"], _path(error["loc"]), error["input"]
    where, context = path_text(path), error.get("ctx", {})
    means = _description(document, path)
    means = f": {means}" if means else ""
    if error["loc"][-1:] == ("[key]",):
        return f"{where} is no name: letters, digits, _ and - are allowed"
    if kind == "missing":
        return f"{where} is missing{means}"
    if kind == "extra_forbidden":
        model = table_at(path[:-1], node_at(document, path[:-1]))
        owner = path_text(path[:-1]) or "the file"
        allowed = f"; {owner} has the keys {', '.join(keys(model))}" if model else ""
        return f"{where} = {shown(value)} is an unknown key{allowed}"
    if kind in ("too_short", "too_long"):
        return f"{where} has {context['actual_length']} elements{means}"
    if kind == "literal_error":
        return f"{where} = {shown(value)} is not {context['expected']}"
    if kind == "union_tag_invalid":
        return _wrong_form(where, value, context["expected_tags"], means)
    if kind in WANTED:
        return f"{where} = {shown(value)} is not {WANTED[kind]}{means}"
    return f"{where} = {shown(value)} {error['msg']}"


def _wrong_form(where: str, value: Any, expected_tags: str, means: str) -> str:
    """Line for a table of a wrong type, or for a value that is none of the forms that are accepted."""
    models = [name for name in re.findall(r"<(\w+)>", expected_tags) if name[0].isupper()]
    if not isinstance(value, dict):
        wanted = "a table" if form_of(value) == "<number>" and not re.search("<[a-z]", expected_tags) else "accepted"
        return f"{where} = {shown(value)} is not {wanted}{means}"
    if not models:
        return f"{where} is a table, which is not accepted{means}"
    if "type" not in value:
        return f"{where}.type is missing: {', '.join(models)}"
    return f"{where}.type = {shown(value['type'])} is not one of {', '.join(models)}"


def raise_problems(name: str, problems: Sequence[str]) -> None:
    """Raise one `ValueError` with a line per problem, each with the name of the file; nothing if there is none."""
    if problems:
        raise ValueError("\n".join(f"{name}: {problem}" for problem in problems))
