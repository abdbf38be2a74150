"""The documentation says what is: its examples run, its names exist, its numbers are the code's."""

import ast
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from jaxrefl import gallery

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")] + sorted(
    (ROOT / "docs").glob("*.md")
)
COLUMNS = ("source", "what it says", "code", "test", "figure", "misprint or gap")
LATER = "later"


def blocks(path, language):
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def source_rows():
    lines = (ROOT / "docs" / "sources.md").read_text(encoding="utf-8").splitlines()
    tables = [[cell.strip() for cell in line.strip().strip("|").split(" | ")] for line in lines if line.startswith("|")]
    return [row for row in tables if row != list(COLUMNS) and not set("".join(row)) <= set("-|: ")]


def names(cell):
    return re.findall(r"`([^`]+)`", cell)


def exists(name):
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:end]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[end:]:
            if not hasattr(found, attribute):
                return False
            found = getattr(found, attribute)
        return True
    return False


def test_the_readme_opens_with_exactly_two_commands():
    first = re.search(r"^```\w*\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    commands = first.group(1).splitlines()
    assert len(commands) == 2
    assert commands[0].endswith("jaxrefl figures")
    assert commands[1].endswith("pytest")


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=lambda page: page.name)
def test_the_python_examples_run_in_a_fresh_interpreter(page, tmp_path):
    for code in blocks(page, "python"):
        command = [sys.executable, "-W", "error", "-c", code]
        environment = {**os.environ, "MPLBACKEND": "Agg", "JAX_ENABLE_X64": "0"}
        result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
        assert result.returncode == 0, result.stderr
        printed = re.findall(r"[-+]?\d+\.\d+", result.stdout)
        promised = re.findall(r"^print\(.*#.*?([-+]?\d+\.\d+)$", code, re.MULTILINE)
        assert [round(float(p), len(q.partition(".")[2])) for p, q in zip(printed, promised, strict=True)] == [
            float(q) for q in promised
        ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_point_to_files(page):
    for target in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


def test_every_row_of_the_sources_has_its_six_columns():
    rows = source_rows()
    assert len(rows) > 60
    assert all(len(row) == len(COLUMNS) for row in rows), [row for row in rows if len(row) != len(COLUMNS)]


def test_the_names_in_the_sources_exist():
    functions = {
        f"{path.name}::{node.name}"
        for path in (ROOT / "tests").glob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    }
    figures = set(gallery.names())
    for source, _, code, test, figure, _ in source_rows():
        assert all(exists(f"jaxrefl.{name}") for name in names(code)), (source, code)
        assert set(names(test)) <= functions, (source, set(names(test)) - functions)
        assert set(names(figure)) <= figures, (source, figure)


def test_a_row_of_the_sources_is_implemented_and_tested_or_says_that_it_waits():
    for source, _, code, test, *_ in source_rows():
        assert (names(code) and names(test)) or code.startswith(LATER), (source, code, test)


def test_every_equation_and_every_misprint_of_the_sources_has_a_row():
    rows = source_rows()
    equations = [f"D3D9 ({i})" for i in range(1, 9)] + [f"PERRIN ({i})" for i in range(1, 7)]
    assert set(equations) <= {row[0] for row in rows}
    assert sum(row[0].startswith("JHU") for row in rows) >= 20
    assert sum(row[0].startswith("LAMBERT-FRESNEL") for row in rows) >= 10
    listed = {int(number) for row in rows for number in re.findall(r"\bS(\d+)\b", row[-1])}
    assert listed == set(range(1, 43))


def test_the_names_in_the_conventions_are_in_the_code():
    text = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
    code = " ".join(path.read_text(encoding="utf-8") for path in (ROOT / "jaxrefl").rglob("*.py"))
    first_columns = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    for name in (name for cell in first_columns for name in names(cell)):
        assert re.search(rf"\b{name}\b", code), name


def test_no_page_speaks_of_anything_outside_the_project():
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert "../shared" not in text
        assert not re.search(r"https?://", text), page
