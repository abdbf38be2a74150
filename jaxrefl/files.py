"""Files: those written are complete or not there, and the small tables that ship with the package."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any


def write_atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Call ``write`` with a temporary name beside ``path``, then rename; on an error or Ctrl-C nothing is left."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        write(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def read_table(name: str) -> list[dict[str, str]]:
    """Rows of a table ``data/NAME.csv`` of the package, by column; lines that begin with # are its sources."""
    text = resources.files("jaxrefl").joinpath(f"data/{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
