"""The commands of reflection models: numbers against closed forms, what is refused, what an interrupt leaves."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image as Pillow
from typer.testing import CliRunner

from jaxrefl import audit as audit_package
from jaxrefl import certified, cli
from jaxrefl.audit import Report, Row

run = CliRunner().invoke

USER = """
import jax.numpy as jnp
import numpy as np
from jaxrefl.audit import from_numpy
from jaxrefl.params import param, pytree


@pytree
class Tilted:
    rho: object = param("[0, 1]", spectral=True, default=0.5, doc="share [of all]")
    b: object = param("[0, 1]", default=0.3, doc="slope")

    def __call__(self, wi, wo):
        value = self.rho / jnp.pi * (1 + self.b * (wi.x * wo.x + wi.y * wo.y + wi.z * wo.z))
        return jnp.where((wi.z < 0) | (wo.z < 0), 0.0, value)


def grey(wi, wo):
    return jnp.where((wi.z < 0) | (wo.z < 0), 0.0, 0.25 / jnp.pi)


class Bare:
    def __call__(self, wi, wo):
        return 0.1


plain = from_numpy(lambda wi, wo: np.where((wi[:, 2] < 0) | (wo[:, 2] < 0), 0.0, 0.25 / np.pi))
"""


@pytest.fixture
def user_file(tmp_path):
    path = tmp_path / "my models" / "tilted.py"
    path.parent.mkdir()
    path.write_text(USER)
    return path


def invoke(*arguments):
    return run(cli.app, [str(a) for a in arguments])


def cells(output):
    """Rows of a printed table, without its frame."""
    rows = [line.split("│")[1:-1] for line in output.splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in row] for row in rows]


def test_albedo_prints_the_closed_forms_of_modified_phong_with_their_errors():
    result = invoke("albedo", "modified-phong", "shininess=10", "--theta", "0,60,90")
    assert result.exit_code == 0, result.output
    rows = cells(result.output)
    assert [row[0] for row in rows] == ["0°", "60°", "90°", "bihemispherical"]
    exact = [1, 0.50473594665527344, 0.123046875, 0.6735026041666667]
    for row, value in zip(rows, exact, strict=True):
        error = float(row[2])
        assert abs(float(row[1]) - value) <= error + 1e-15
        assert 0 < error <= 1e-10
    for row in rows[:3]:
        assert row[3].startswith("mirror ")
        assert int(row[4]) > 1000
        assert row[5] == "normal"


def test_albedo_takes_spectra_and_a_range_of_angles():
    rows = cells(invoke("albedo", "lambert", "rho=0.75,0.5,0.25", "--theta", "0:90:3", "--rtol", "1e-6").output)
    assert [row[0] for row in rows] == ["0°", "45°", "90°", "bihemispherical"]
    for row in rows:
        np.testing.assert_allclose([float(x) for x in row[1].split(",")], [0.75, 0.5, 0.25], rtol=1e-6)


def test_albedo_holds_the_light_and_counts_what_is_transmitted_when_asked_to():
    light = cells(invoke("albedo", "d3d9", "sun_fresnel=true", "--fixed", "light", "--theta", "90").output)
    assert abs(float(light[0][1]) - 1) < 1e-12
    both = cells(invoke("albedo", "slab", "--part", "both", "--theta", "60").output)
    assert abs(float(both[0][1]) - 1) < 1e-12
    one = cells(invoke("albedo", "slab", "--theta", "60").output)
    assert abs(float(one[0][1]) - 0.15187159027119984) < 1e-14


def test_a_tolerance_that_is_not_met_is_said(user_file):
    user_file.write_text(USER + "def jump(wi, wo):\n    return jnp.where(wi.z > 0.6, 0.3, 0.1)\n")
    rows = cells(invoke("albedo", f'"{user_file}:jump"', "--theta", "30", "--rtol", "1e-10").output)
    assert rows[0][5].endswith("rtol not met")
    exact = np.pi * (0.1 + 0.2 * (1 - 0.36))
    assert abs(float(rows[0][1]) - exact) < 4 * float(rows[0][2]) < 0.1


def test_a_table_over_a_parameter_is_written_with_its_error(tmp_path):
    path = tmp_path / "out" / "table.csv"
    result = invoke(
        "albedo", "ashikhmin-shirley-diffuse", "rho=0.5", "--theta", "0,60", "--over", "f0=0:1:3", "-o", path
    )
    assert result.exit_code == 0, result.output
    assert "3 values of f0, 2 angles" in result.output
    with path.open(newline="") as file:
        rows = [{key: float(x) for key, x in row.items()} for row in csv.DictReader(file)]
    assert len(rows) == 6
    for row in rows:
        exact = 0.5 * (1 - row["f0"]) * (1 - (1 - row["cos_theta_o"] / 2) ** 5)
        assert abs(row["albedo"] - exact) <= row["error"] + 1e-15


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("albedo", "phong"), ("model = 'phong' must be one of lambert",)),
        (("albedo", "eon", "sigma=1"), ("'sigma=1' is not a parameter of eon", "roughness in [0, 1]")),
        (("albedo", "eon", "rho=2"), ("rho = 2.0 is outside [0, 1]", "roughness in [0, 1]")),
        (("audit", "literal-phong", "highlight=none"), ("must be one of mirror, half_vector",)),
        (("albedo", "eon", "--theta", "0,91"), ("theta = '0,91' must be angles in degrees in [0, 90]",)),
        (("albedo", "eon", "--theta", "ten"), ("theta = 'ten' must be numbers",)),
        (("albedo", "eon", "--part", "all"), ("part = 'all' must be one of reflected, transmitted, both",)),
        (("albedo", "eon", "--rtol", "1e-20"), ("rtol = 1e-20 is outside",)),
        (("albedo", "eon", "-o", "t.csv"), ("-o FILE and --over",)),
        (("albedo", "eon", "-o", "t.csv", "--over", "rho=0:2:3"), ("rho = 2.0 is outside [0, 1]",)),
        (("albedo", "eon", "-o", "t.csv", "--over", "sigma=0:1:3"), ("'sigma=0.0' is not a parameter of eon",)),
        (("albedo", "eon", "-o", "t.csv", "--over", "rho"), ("over = 'rho' must be written NAME=LOW:HIGH:N",)),
        (("albedo", "eon", "-o", "t.txt", "--over", "rho=0:1:3"), ("out = 't.txt' must end in .npz, .csv, .exr",)),
        (("audit", "eon", "--part", "lit"), ("part = 'lit' must be both or reflected",)),
        (("plot", "eon", "-o", "eon.jpg"), ("out = 'eon.jpg' must end in .png, .pdf, .svg",)),
        (("plot", "eon", "-o", "eon.png", "--theta", "95"), ("theta = '95.0' must be angles",)),
        (("plot", "eon", "-o", "eon.png", "--overlay", "eon rho=2"), ("rho = 2.0 is outside [0, 1]",)),
        (("compare", "eon", ""), ("model = '' is empty",)),
        (("compare", "eon", "eon", "--below", "0"), ("below_deg = 0.0 is outside (0, 90]",)),
    ],
    ids=lambda x: " ".join(x) if isinstance(x[0], str) and len(x) > 1 else "",
)
def test_a_wrong_argument_is_answered_with_the_allowed_ones(arguments, parts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = invoke(*arguments)
    assert isinstance(result.exception, ValueError), result.output
    assert all(part in str(result.exception) for part in parts), str(result.exception)
    assert not list(tmp_path.iterdir())


def test_a_wrong_parameter_is_one_message_with_the_list_and_exit_code_2(user_file):
    command = [sys.executable, "-m", "jaxrefl", "audit", f"'{user_file}:Tilted'", "b=3"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    lines = result.stderr.strip().splitlines()
    assert lines[0].startswith("jaxrefl: b = 3.0 is outside [0, 1]; the parameters of ")
    assert lines[1:] == ["  rho in [0, 1], default 0.5: share [of all]", "  b in [0, 1], default 0.3: slope"]


def test_a_class_that_declares_nothing_has_no_parameters(user_file):
    result = invoke("albedo", f"'{user_file}:Bare'", "rho=1")
    assert isinstance(result.exception, ValueError)
    assert "'rho=1' is not a parameter of" in str(result.exception)
    assert str(result.exception).endswith("(none)")


def test_audit_prints_every_property_and_exits_with_its_verdict(tmp_path):
    page, file = tmp_path / "a.html", tmp_path / "a.json"
    result = invoke("audit", "d3d9", "diffuse=1,0.5,0.25", "--json", file, "--html", page)
    assert result.exit_code == 1
    assert "diffuse=[1." in result.output  # not taken for markup
    rows = {row[0]: row for row in cells(result.output)}
    assert set(audit_package.PROPERTIES) <= set(rows)
    assert rows["energy_view"][1:4] == ["fails", "2", "theta = 90°, channel 0"]
    answer = json.loads(file.read_text(encoding="utf-8"))
    assert (answer["schema"], answer["ok"]) == (audit_package.SCHEMA, False)
    assert "energy_view" in page.read_text(encoding="utf-8")


def test_audit_of_a_valid_model_exits_with_0_and_prints_json_alone():
    result = invoke("audit", "lambert", "--json", "-")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["ok"] is True


def test_a_function_of_the_user_and_a_numpy_one_are_audited(user_file):
    for name in ("grey", "plain"):
        result = invoke("audit", f'"{user_file}:{name}"', "--json", "-")
        assert result.exit_code == 0, result.output
        rows = {row["name"]: row for row in json.loads(result.stdout)["rows"]}
        np.testing.assert_allclose(rows["energy_light"]["number"], 0.25, rtol=1e-13)


def test_a_model_of_the_user_has_the_albedo_of_its_closed_form(user_file):
    """f = rho / pi (1 + b wi . wo): rho (1 + 2/3 b cos theta)."""
    rows = cells(invoke("albedo", f"'{user_file}:Tilted'", "rho=0.6", "b=0.5", "--theta", "0,60").output)
    np.testing.assert_allclose([float(r[1]) for r in rows[:2]], [0.6 * (1 + 1 / 3), 0.6 * (1 + 1 / 6)], rtol=1e-13)


def test_compare_prints_the_largest_difference_and_where():
    result = invoke("compare", "lambert rho=0.5", "lambert rho=0.5,0.3")
    assert result.exit_code == 0, result.output
    rows = {row[0]: row for row in cells(result.output)}
    np.testing.assert_allclose(float(rows["of f, 1/sr"][1]), 0.2 / np.pi, rtol=1e-5)
    np.testing.assert_allclose(float(rows["of f, relative"][1]), 0.4, rtol=1e-6)
    value, where, *both = rows["of the albedo"][1:]
    assert (value, *both) == ("0.2", "0.5", "0.3")
    assert where.endswith("°, channel 1")


@pytest.mark.filterwarnings("error")
def test_plot_writes_a_picture_of_a_model_and_others_over_it(tmp_path):
    path = tmp_path / "models.png"
    result = invoke("plot", "d3d9", "-o", path, "--overlay", "eon rho=0.8", "--overlay", "lambert", "--theta", "20")
    assert result.exit_code == 0, result.output
    assert "d3d9, eon rho=0.8, lambert" in result.output
    with Pillow.open(path) as picture:
        colours = {colour for _, colour in picture.convert("RGB").getcolors(1 << 24)}
    assert len(colours) > 50
    assert invoke("plot", "slab", "-o", tmp_path / "slab.svg").exit_code == 0  # its lobe is empty
    assert (tmp_path / "slab.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_an_interrupt_writes_nothing(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(audit_package, "audit", interrupted)
    monkeypatch.setattr(audit_package, "profile", interrupted)
    for command in (("audit", "lambert", "--html", tmp_path / "a.html"), ("plot", "lambert", "-o", tmp_path / "a.png")):
        result = invoke(*command)
        assert result.exit_code == cli.INTERRUPTED
        assert "interrupted" in result.output
    assert not list(tmp_path.iterdir())


def test_an_interrupted_albedo_keeps_the_lines_it_has(monkeypatch):
    albedo_to = certified.albedo_to

    def interrupted(brdf, mu, *arguments, **options):
        if mu < 0.6:
            raise KeyboardInterrupt
        return albedo_to(brdf, mu, *arguments, **options)

    monkeypatch.setattr(certified, "albedo_to", interrupted)
    result = invoke("albedo", "lambert", "--theta", "0,60")
    assert result.exit_code == cli.INTERRUPTED
    assert [row[0] for row in cells(result.output)] == ["0°"]


def test_texts_of_an_audit_are_not_taken_for_markup(monkeypatch):
    rows = (Row("furnace", "ok", 0.5, "[/bold] here", "f in [0, 1]"),)
    monkeypatch.setattr(audit_package, "audit", lambda *_, **__: Report("M[red]", "float64", rows))
    output = invoke("audit", "lambert").output
    assert all(text in output for text in ("M[red]", "[/bold] here", "f in [0, 1]"))
