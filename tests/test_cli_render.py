"""The commands of scene files: what they write, what they refuse, and what an interrupt leaves."""

import json
import subprocess
import sys
import tomllib
import types

import jax
import numpy as np
import pytest
from PIL import Image as Pillow
from typer.testing import CliRunner

from jaxrefl import cli, image, scene_file
from jaxrefl.path import Budget
from jaxrefl.render import Image

run = CliRunner().invoke

# White light from straight above on a grey floor that is seen from straight above: radiance = k_d everywhere.
FLOOR = """
[render]
width = 6
height = 4
spp = 1
n_bounces = 1

[camera]
type = "Orthographic"
position = [0.0, 0.0, 2.0]
up = [0.0, 1.0, 0.0]

[lights.sun]
type = "Directional"
direction = [0.0, 0.0, -3.0]

[objects.floor.shape]
type = "Plane"
point_on = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]

[objects.floor.surface]
type = "Phong"
k_d = [0.5, 0.25, 0.125]
"""
CODES = [188, 137, 99]  # of these three in sRGB, IEC 61966-2-1: 187.5, 137.0, 98.9


def invoke(*arguments):
    return run(cli.app, [str(a) for a in arguments])


@pytest.fixture
def floor(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "floor.toml").write_text(FLOOR)
    return tmp_path


def flat(width, height, channels=3):
    """Picture of constant radiance and no more."""
    one, many = np.ones((height, width), np.float32), np.full((height, width, channels), 0.5, np.float32)
    known = {"radiance": many, "alpha": one / 2, "normal": np.zeros((height, width, 3)), "budget": Budget(*[many] * 4)}
    return Image(*(known.get(name, one) for name in Image._fields))


class Fake(types.ModuleType):
    """A renderer that takes down how it was called, and may be interrupted."""

    def __init__(self):
        super().__init__("jaxrefl.render")
        self.calls = []
        self.interrupt = False

    def render(self, scene, camera, width, height, n_bounces, *, spp, seed, alpha, progress, devices):
        assert devices == jax.devices()
        call = {"width": width, "height": height, "n_bounces": n_bounces, "spp": spp, "seed": seed, "alpha": alpha}
        self.calls.append({"scene": scene, "camera": camera, **call})
        progress(1, 2, 1_000_000)
        if self.interrupt:
            raise KeyboardInterrupt
        progress(2, 2, 3_000_000)
        return flat(width, height)


@pytest.fixture
def fake(monkeypatch):
    module = Fake()
    monkeypatch.setitem(sys.modules, "jaxrefl.render", module)
    return module


def names(folder):
    return sorted(path.name for path in folder.iterdir())


# With the renderer


def test_a_picture_shows_the_radiance_that_the_formula_gives(floor):
    command = [sys.executable, "-m", "jaxrefl", "render", "floor.toml", "-o", "a.png", "-o", "out/a.npz", "-o", "a.exr"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with np.load(floor / "out/a.npz") as arrays:
        np.testing.assert_allclose(arrays["radiance"], np.tile([0.5, 0.25, 0.125], (4, 6, 1)), rtol=1e-6)
        assert arrays["radiance"].dtype == np.float32
        assert not arrays["primitive"].any()
        np.testing.assert_allclose(arrays["depth"], 2.0, rtol=1e-6)
        assert {"bounces", "path_id", "budget.shaded", "budget.truncated"} <= set(arrays)
    with Pillow.open(floor / "a.png") as picture:
        assert np.abs(np.asarray(picture).astype(int) - CODES).max() == 0
    assert "a.png, out/a.npz, a.exr: 6 x 4, 1 bounces, 1 spp" in done.stdout
    assert "Mrays/s" in done.stdout


# With a renderer that only takes notes


def test_options_and_settings_reach_the_renderer(floor, fake):
    options = ["--width", "8", "--height", "5", "--bounces", "3", "--spp", "2", "--seed", "7", "--exposure", "-1"]
    result = invoke(
        "render", "floor.toml", "-o", "a.png", *options, "--set", "objects.floor.surface.k_d=0.75",
        "--set", "render.alpha=printed",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    (call,) = fake.calls
    assert {name: call[name] for name in ("width", "height", "n_bounces", "spp", "seed", "alpha")} == {
        "width": 8, "height": 5, "n_bounces": 3, "spp": 2, "seed": 7, "alpha": "printed",
    }  # fmt: skip
    assert call["scene"].objects["floor"].surface.k_d == 0.75
    with Pillow.open("a.png") as picture:
        assert picture.size == (8, 5)
        assert set(np.asarray(picture).flat) == {137}  # 0.25 in sRGB


def test_what_no_option_says_is_what_the_file_says(floor, fake):
    assert invoke("render", "floor.toml").exit_code == 0
    (call,) = fake.calls
    assert (call["width"], call["height"], call["n_bounces"], call["spp"], call["seed"]) == (6, 4, 1, 1, 0)


def test_without_a_name_the_picture_is_called_as_the_scene(floor, fake):
    assert invoke("render", "jhu", "--width", "4", "--height", "4").exit_code == 0
    assert names(floor) == ["floor.toml", "jhu.png"]


def test_every_shipped_scene_is_known_by_its_name(floor, fake):
    for name in scene_file.examples():
        assert invoke("render", name, "-o", f"{name}.npz", "--width", "2", "--height", "2").exit_code == 0
    assert len(fake.calls) == 4


def test_every_file_says_what_made_it(floor, fake):
    invoke("render", "floor.toml", "-o", "a.png", "-o", "a.npz", "-o", "a.exr", "--set", "render.seed=3")
    facts = [image.read_metadata(floor / f"a.{kind}") for kind in image.FORMATS]
    for found in facts:
        assert found["scene"] == "floor.toml"
        assert found["scene_sha256"] == scene_file.load("floor.toml").sha256
        assert found["settings"]["seed"] == 3
        assert found["settings"]["width"] == 6
        assert found["set"] == ["render.seed=3"]


def test_coverage_and_half_floats_are_written_when_asked_for(floor, fake):
    for options, mode in (((), "RGB"), (("--transparent",), "RGBA")):
        invoke("render", "floor.toml", "-o", "a.png", *options)
        with Pillow.open("a.png") as picture:
            assert picture.mode == mode
    for options, size in (((), 4), (("--half",), 2)):
        invoke("render", "floor.toml", "-o", "a.exr", *options)
        with image.openexr().File("a.exr", separate_channels=True) as file:
            assert file.channels()["R"].pixels.dtype.itemsize == size


@pytest.mark.parametrize(("alpha", "code"), [("premultiplied", 255), ("printed", 188)])
def test_a_transparent_png_divides_by_the_coverage_only_where_the_light_holds_it(floor, fake, alpha, code):
    invoke("render", "floor.toml", "-o", "a.png", "--transparent", "--set", f"render.alpha={alpha}")
    with Pillow.open("a.png") as picture:
        assert np.asarray(picture)[0, 0].tolist() == [code] * 3 + [128]  # 0.5 of light, 0.5 of coverage


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("nothing",), ("'nothing'", "d3d9, fresnel, jhu, perrin")),
        (("floor.toml", "-o", "a.jpg"), ("'a.jpg'", ".png, .exr, .npz")),
        (("floor.toml", "-o", "a.png", "-o", "b"), ("'b'", ".png, .exr, .npz")),
        (("floor.toml", "--width", "0"), ("floor.toml: render.width = 0 is outside [1, 16384]",)),
        (("floor.toml", "--spp", "-1"), ("floor.toml: render.spp = -1 is outside [1, 65536]",)),
        (("floor.toml", "--exposure", "99"), ("floor.toml: render.exposure = 99.0 is outside [-32, 32]",)),
        (("floor.toml", "--set", "objects.flor.x=1"), ("'objects.flor.x=1'", "objects has no 'flor', it has floor")),
        (("floor.toml", "--set", "objects.floor.surface.k_d=-1"), ("floor.surface.k_d = -1 is outside [0, inf)",)),
        (("floor.toml", "--set", "objects.floor.surface.k_d=[1, 2]"), ("a PNG has 1 or 3 channels, not 2",)),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_refused_before_anything_is_rendered(floor, fake, arguments, parts):
    result = invoke("render", *arguments)
    assert isinstance(result.exception, ValueError), result.output
    assert all(part in str(result.exception) for part in parts), str(result.exception)
    assert fake.calls == []
    assert names(floor) == ["floor.toml"]


def test_exr_without_its_package_is_refused_before_anything_is_rendered(floor, fake, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    result = invoke("render", "floor.toml", "-o", "a.exr")
    assert str(result.exception) == 'EXR files need the package OpenEXR: pip install "jaxrefl[image]"'
    assert fake.calls == []


def test_problems_of_a_file_are_plain_lines_and_exit_code_2(floor):
    (floor / "bad.toml").write_text(FLOOR.replace("k_d = [", "kd = [").replace("spp = 1", "spp = 0"))
    command = [sys.executable, "-m", "jaxrefl", "render", "bad.toml"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "jaxrefl: bad.toml: objects.floor.surface.kd = [0.5, 0.25, 0.125] is an unknown key; objects.floor.surface has "
        "the keys type, k_d, k_s, shininess, k_a, emission, highlight",
        "bad.toml: render.spp = 0 is outside [1, 65536]",
    ]


def test_an_interrupted_render_writes_nothing(floor, fake):
    fake.interrupt = True
    result = invoke("render", "floor.toml", "-o", "a.png", "-o", "b.npz")
    assert result.exit_code == cli.INTERRUPTED
    assert "interrupted; nothing was written" in result.output
    assert names(floor) == ["floor.toml"]


def test_an_interrupt_while_writing_keeps_the_complete_files_alone(floor, fake, monkeypatch):
    def half(file, **_):
        file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez_compressed", half)
    result = invoke("render", "floor.toml", "-o", "a.png", "-o", "b.npz", "-o", "c.png")
    assert result.exit_code == cli.INTERRUPTED
    assert "interrupted; complete: a.png" in result.output
    assert names(floor) == ["a.png", "floor.toml"]


def test_the_exit_code_of_an_interrupted_program_is_130(floor):
    script = """
import sys
from jaxrefl import cli, render
def interrupted(*arguments, progress, **options):
    progress(1, 2, 3)
    raise KeyboardInterrupt
render.render = interrupted
sys.argv = ["jaxrefl", "render", "floor.toml", "-o", "a.png"]
cli.main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    assert names(floor) == ["floor.toml"]


def test_the_speed_leaves_the_first_band_out(monkeypatch):
    from jaxrefl import cli_scene

    clock = iter([0.0, 10.0, 11.0, 12.0])
    monkeypatch.setattr(cli_scene.time, "perf_counter", lambda: next(clock))
    meter = cli_scene.Meter()
    meter.note(5_000_000)
    assert str(meter) == "0.50 Mrays/s"
    meter.note(8_000_000)
    meter.note(11_000_000)
    assert str(meter) == "3.00 Mrays/s"


def test_a_render_leaves_the_default_precision_alone(floor, fake):
    before = jax.config.jax_enable_x64
    invoke("render", "floor.toml")
    assert jax.config.jax_enable_x64 == before


# The other two


def test_the_schema_is_printed_as_json():
    assert json.loads(invoke("schema").stdout) == scene_file.json_schema()


def test_a_new_scene_is_the_starter_and_can_be_rendered(floor, fake):
    result = invoke("new-scene", "a.toml")
    assert result.exit_code == 0
    assert (floor / "a.toml").read_text() == scene_file.starter()
    assert "jaxrefl render a.toml -o a.png" in result.stdout
    assert invoke("render", "a.toml", "--width", "4", "--height", "4").exit_code == 0


def test_a_new_scene_may_be_a_shipped_one(floor):
    assert invoke("new-scene", "--from", "perrin").exit_code == 0
    assert tomllib.loads((floor / "scene.toml").read_text())["objects"]["row"]["surface"]["type"] == "Blend"


@pytest.mark.parametrize("arguments", [(), ("--from", "jhu")])
def test_a_new_scene_does_not_overwrite(floor, arguments):
    result = invoke("new-scene", "floor.toml", *arguments)
    assert str(result.exception) == "path = 'floor.toml' exists; it is not overwritten"
    assert (floor / "floor.toml").read_text() == FLOOR


def test_a_new_scene_from_an_unknown_one_is_answered_with_those_there_are(floor):
    result = invoke("new-scene", "a.toml", "--from", "cornell")
    assert "'cornell' is not a shipped scene; there are d3d9, fresnel, jhu, perrin" in str(result.exception)
    assert names(floor) == ["floor.toml"]
