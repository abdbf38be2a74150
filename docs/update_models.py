"""Writes the tables of parameters into docs/models.md: `python docs/update_models.py`."""

import dataclasses
import re
from pathlib import Path

from jaxrefl import brdf, catalog
from jaxrefl.params import parameters

PAGE = Path(__file__).with_name("models.md")
CARDS = catalog.MODELS | {"mix": brdf.Mix, "scaled": brdf.Scaled}
_CARD = re.compile(r"(^## `([^`]+)`.*?<!-- parameters -->\n).*?(<!-- end of parameters -->)", re.MULTILINE | re.DOTALL)


def table(model: type) -> str:
    """Parameters of a model as a table: those declared, then nested models and choices."""
    declared = {p.name: p for p in parameters(model)}
    lines = ["| parameter | range | per channel | default | meaning |", "|---|---|---|---|---|"]
    for field in dataclasses.fields(model):
        if field.name in declared:
            p = declared[field.name]
            unit = f" {p.unit}" if p.unit else ""
            cells = (f"{p.interval}{unit}", "yes" if p.spectral else "no", f"{p.default:g}", p.doc)
        elif field.metadata.get("static"):
            choices = field.metadata.get("choices", ("false", "true"))
            cells = (" or ".join(choices), "no", str(field.default).lower(), "choice, no number")
        else:
            cells = ("a model", "", type(field.default_factory()).__name__, "model")
        lines.append(f"| `{field.name}` | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def updated(text: str) -> str:
    """The page with every table as it has to be."""
    return _CARD.sub(lambda card: card[1] + table(CARDS[card[2]]) + card[3], text)


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
