"""The distribution: built, installed apart from the sources, and run from a folder of its own."""

import functools
import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def call(*arguments, cwd, env=None):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, cwd=cwd, env=env, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.mark.packaging
def test_the_wheel_and_the_sdist_build_install_and_draw(tmp_path):
    dist = tmp_path / "dist"
    call(sys.executable, "-m", "build", "--outdir", dist, ROOT, cwd=tmp_path)
    (wheel,), (sdist,) = dist.glob("*.whl"), dist.glob("*.tar.gz")
    in_wheel = set(zipfile.ZipFile(wheel).namelist())
    assert {
        "jaxrefl/py.typed",
        "jaxrefl/data/oracles.json",
        "jaxrefl/_figures/why_pi.py",
        "jaxrefl/data/materials/catalogue.json",
    } <= in_wheel
    assert not [name for name in in_wheel if name.startswith(("tests/", "figures/"))]
    with tarfile.open(sdist) as archive:
        in_sdist = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "LICENSE", "figures/why_pi.py", "tests/test_packaging.py", "docs/sources.md"} <= in_sdist

    # into a folder of its own; that the dependencies named are enough is for a fresh environment, the README's, to show
    site = tmp_path / "site"
    call(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", site, wheel, cwd=tmp_path)
    run = functools.partial(call, sys.executable, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(site)})
    assert Path(run("-c", "import jaxrefl; print(jaxrefl.__file__)").strip()).is_relative_to(site)
    run("-m", "jaxrefl", "figures", "jhu_tree", "--out", "out", "--format", "png,svg")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"jhu_tree.png", "jhu_tree.svg"}
    assert "0 failed" in run("-m", "jaxrefl", "check", "H.jhu", "A.special")
    assert (site / "bin" / "jaxrefl").is_file() or (site / "Scripts" / "jaxrefl.exe").is_file()
