"""`jaxrefl oracle` and `jaxrefl verify`, run in-process: what they write, print and return."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from jaxrefl import cli
from jaxrefl.reference import read

MODEL = ("modified-phong", "k_s=0.7", "shininess=3")


def invoke(*arguments):
    return CliRunner().invoke(cli.app, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Reference vectors in all formats, and a file of theirs with the cosine in it."""
    folder = tmp_path_factory.mktemp("reference")
    endings = ("csv", "json", "h")
    out = [x for ending in endings for x in ("-o", folder / f"ref.{ending}")]
    result = invoke("oracle", *MODEL, "-n", 120, "--seed", 3, *out)
    assert result.exit_code == 0, result.output
    assert "120 pairs of directions, f (1), pdf (1), albedo (1), albedo_error (1); albedos within" in result.output
    assert sorted(path.name for path in folder.iterdir()) == ["ref.csv", "ref.h", "ref.json"]
    given = read(folder / "ref.csv")
    table = np.column_stack([given.wi, given.wo, given.values["f"] * given.wi[:, 2:]])
    header = "WI_X,WI_Y,WI_Z,WO_X,WO_Y,WO_Z,F"
    np.savetxt(folder / "theirs.csv", table, "%.9g", ",", header=header, comments="")
    return folder


def test_what_oracle_writes_verify_accepts_to_sixteen_digits(folder):
    for name in ("ref.csv", "ref.json"):
        result = invoke("verify", folder / name, "--model", *MODEL, "--digits", 16)
        assert result.exit_code == 0, result.output
        assert "agrees to 16 digits" in result.output


def test_the_file_says_which_model_with_which_parameters(folder):
    lines = (folder / "ref.csv").read_text().splitlines()
    assert lines[:4] == [
        "# jaxrefl reference vectors, 0.1.0",
        "# model: modified-phong",
        "# parameter: k_s=0.69999999999999996",
        "# parameter: shininess=3",
    ]


def test_a_difference_of_convention_is_named_and_the_exit_code_is_one(folder):
    result = invoke("verify", folder / "theirs.csv", "--model", *MODEL)
    assert result.exit_code == 1, result.output
    assert "RECOGNISED: the cosine of wi is included" in result.output
    assert "DOES NOT agree to 5 digits" in result.output
    assert "f is worst at line" in result.output


def test_a_constant_factor_is_given_as_a_number(folder):
    result = invoke("verify", folder / "ref.csv", "--model", "modified-phong", "k_s=0.5", "shininess=3")
    assert result.exit_code == 1
    assert "RECOGNISED: constant factor 1.4\n" in result.output


def test_another_model_is_not_explained(folder):
    result = invoke("verify", folder / "ref.csv", "--model", "burley")
    assert result.exit_code == 1
    assert "no difference of convention that is known explains it" in result.output


def test_the_json_says_the_same(folder):
    result = invoke("verify", folder / "theirs.csv", "--model", *MODEL, "--json")
    document = json.loads(result.output)
    assert (result.exit_code, document["schema"], document["ok"]) == (1, 1, False)
    assert document["explanations"]["f"]["names"] == ["the cosine of wi is included"]
    assert document["comparisons"][0]["quantity"] == "f"
    assert document["comparisons"][0]["worst_at"].startswith("line ")


def test_fewer_digits_are_asked_for_with_an_option(folder):
    given = read(folder / "ref.csv")
    table = np.column_stack([given.wi, given.wo, given.values["f"] * (1 + 1e-4)])
    np.savetxt(folder / "near.csv", table, "%.17g", ",", header="wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f", comments="")
    assert invoke("verify", folder / "near.csv", "--model", *MODEL, "--digits", 3.9).exit_code == 0
    assert invoke("verify", folder / "near.csv", "--model", *MODEL, "--digits", 4.1).exit_code == 1


BAD = {
    ("oracle", "lambert", "-n", "0"): "n = 0 must be an integer",
    ("oracle", "lambert", "-o", "ref.xml"): r"'ref.xml' must end in .csv, .json, .h",
    ("oracle", "lambert", "rho=2"): "rho = 2.0 is outside [0, 1]; the parameters of lambert are",
    ("oracle", "lambert", "colour=1"): "'colour=1' is not a parameter of lambert",
    ("oracle", "ward"): "model = 'ward' must be one of lambert",
    ("verify", "nowhere.csv", "--model", "lambert"): "there is no file nowhere.csv",
    ("verify", "nowhere.csv", "--model", "lambert", "rho=x"): "'rho=x' is not a number",
}


@pytest.mark.parametrize(("arguments", "message"), BAD.items(), ids=lambda x: x[-1] if isinstance(x, tuple) else "")
def test_what_is_wrong_is_said_before_anything_is_written(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    result = invoke(*arguments)
    assert isinstance(result.exception, ValueError)
    assert message in str(result.exception)
    assert not list(tmp_path.iterdir())


def test_a_users_own_model_is_tabulated_under_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(
        "import jax.numpy as jnp\n\n\ndef flat(wi, wo):\n    return 0.25 / jnp.pi + 0 * wi.z\n"
    )
    result = invoke("oracle", "mine.py:flat", "-n", 5)
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(read(tmp_path / "flat.csv").values["f"], 0.25 / np.pi, rtol=1e-15)
