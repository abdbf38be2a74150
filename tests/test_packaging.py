"""The distribution: built, installed into a fresh environment, and run from a folder of its own."""

import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def call(*arguments, cwd):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, cwd=cwd, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.mark.packaging
def test_the_wheel_and_the_sdist_build_install_and_draw(tmp_path):
    dist = tmp_path / "dist"
    call(sys.executable, "-m", "build", "--outdir", dist, ROOT, cwd=tmp_path)
    (wheel,), (sdist,) = dist.glob("*.whl"), dist.glob("*.tar.gz")
    in_wheel = set(zipfile.ZipFile(wheel).namelist())
    assert {"jaxrefl/py.typed", "jaxrefl/data/oracles.json", "jaxrefl/_figures/why_pi.py"} <= in_wheel
    assert not [name for name in in_wheel if name.startswith(("tests/", "figures/"))]
    with tarfile.open(sdist) as archive:
        in_sdist = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "LICENSE", "figures/why_pi.py", "tests/test_packaging.py", "docs/sources.md"} <= in_sdist

    venv.create(tmp_path / "fresh", with_pip=True)
    scripts = tmp_path / "fresh" / ("Scripts" if sys.platform == "win32" else "bin")
    call(scripts / "python", "-m", "pip", "install", "--quiet", wheel, cwd=tmp_path)
    where = call(scripts / "python", "-c", "import jaxrefl; print(jaxrefl.__file__)", cwd=tmp_path)
    assert Path(where.strip()).is_relative_to(tmp_path / "fresh")
    call(scripts / "jaxrefl", "figures", "jhu_tree", "--out", "out", "--format", "png,svg", cwd=tmp_path)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"jhu_tree.png", "jhu_tree.svg"}
    assert "0 failed" in call(scripts / "jaxrefl", "check", "H.jhu", "A.special", cwd=tmp_path)
