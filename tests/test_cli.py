"""The command line, run in-process: what it prints, what it writes, how it fails."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import jaxrefl
from jaxrefl import check, cli, gallery, plot

run = CliRunner().invoke


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A gallery of four figures: two good ones, one that fails, one that cannot even be loaded."""
    good = (
        "import numpy as np\n"
        "from jaxrefl import plot\n"
        "CAPTION = '''A line\n of some slope.'''\n"
        "def compute(slope: float = 2.0, terms: tuple[float, ...] = (1.0, 2.0), name: str = 'x'):\n"
        "    return {'y': slope * np.arange(3.0), 'terms': terms}\n"
        "def draw(data, fig):\n"
        "    plot.cartesian([0, 1, 2], data['y'], ax=fig.subplots())\n"
    )
    gallery_folder = tmp_path / "gallery"
    gallery_folder.mkdir()
    for name, text in {
        "aaa": good,
        "bad": good.replace("    return", "    raise RuntimeError('it broke')\n    return"),
        "unreadable": "CAPTION = (\n",
        "zzz": good.replace("slope: float = 2.0", "count: int = 3").replace("slope *", "count *"),
        "_helper": "raise SystemExit",
    }.items():
        (gallery_folder / f"{name}.py").write_text(text)
    monkeypatch.setattr(gallery, "directory", lambda: gallery_folder)
    return gallery_folder


def invoke(*arguments):
    return run(cli.app, [str(a) for a in arguments])


def test_one_failing_figure_does_not_stop_the_others_and_sets_the_exit_code(folder, tmp_path):
    out = tmp_path / "out"
    result = invoke("figures", "--out", out)
    assert result.exit_code == 1
    assert "RuntimeError: it broke" in result.output
    assert "SyntaxError" in result.output
    assert sorted(path.name for path in out.iterdir()) == ["aaa.png", "zzz.png"]


def test_formats_data_and_settings_reach_the_files(folder, tmp_path):
    out = tmp_path / "out"
    arguments = ("--format", "png,pdf,svg", "--data", "--set", "slope=3.5", "--set", "terms=4,5,6", "--style", "dark")
    result = invoke("figures", "aaa", "--out", out, *arguments)
    assert result.exit_code == 0, result.output
    assert {path.suffix for path in out.iterdir()} == {".png", ".pdf", ".svg", ".npz", ".csv"}
    with np.load(out / "aaa.npz") as data:
        np.testing.assert_array_equal(data["y"], [0, 3.5, 7])
        np.testing.assert_array_equal(data["terms"], [4, 5, 6])
    with (out / "aaa.csv").open(newline="") as file:
        rows = [(row["name"], row["value"], row["i"]) for row in csv.DictReader(file)]
    assert ("y", "3.5", "1") in rows
    assert len(rows) == 6
    assert {line.count(",") for line in (out / "aaa.csv").read_text().splitlines()} == {4}


def test_a_path_in_square_brackets_is_printed_as_it_is(folder, tmp_path):
    for name in ("run[best]", "a[/b]"):
        result = invoke("figures", "aaa", "--out", tmp_path / name)
        assert result.exit_code == 0
        assert name in result.output.replace("\n", "")


def test_a_format_given_twice_is_written_once(folder, tmp_path):
    assert invoke("figures", "aaa", "--out", tmp_path / "out", "--format", "png, png").output.count("aaa.png") == 1


def test_a_setting_names_the_figures_that_took_it(folder, tmp_path):
    assert "count=5: zzz" in invoke("figures", "aaa", "zzz", "--out", tmp_path / "out", "--set", "count=5").output


def test_equal_figures_are_equal_files(folder, tmp_path):
    for name in ("one", "two"):
        assert invoke("figures", "aaa", "--out", tmp_path / name, "--format", "png,pdf,svg").exit_code == 0
    for kind in gallery.FORMATS:
        assert (tmp_path / f"one/aaa.{kind}").read_bytes() == (tmp_path / f"two/aaa.{kind}").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("nothing",), ("'nothing'", "aaa, bad")),
        (("aaa", "--set", "eta=2"), ("'eta=2'", "aaa: slope, terms, name")),
        (("aaa", "--set", "slope"), ("'slope'", "key=value")),
        (("aaa", "--set", "slope=steep"), ("'slope=steep'", "float")),
        (("zzz", "--set", "count=2.5"), ("'count=2.5'", "int")),
        (("aaa", "--set", "slope=1,2"), ("'slope=1,2'", "one value")),
        (("aaa", "--format", "jpg"), ("'jpg'", "png, pdf, svg")),
        (("aaa", "--style", "fancy"), ("'fancy'", "paper, slide, dark")),
    ],
)
def test_a_wrong_argument_is_answered_with_the_allowed_ones(folder, tmp_path, arguments, parts):
    result = invoke("figures", *arguments, "--out", tmp_path / "out")
    assert isinstance(result.exception, ValueError)
    assert all(part in str(result.exception) for part in parts), str(result.exception)
    assert not (tmp_path / "out").exists()


def test_a_value_error_is_one_plain_line_and_exit_code_2():
    command = [sys.executable, "-m", "jaxrefl", "figures", "nothing"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr.startswith("jaxrefl: name = 'nothing' is not a figure")
    assert len(result.stderr.strip().splitlines()) == 1


def test_the_list_shows_names_parameters_and_captions(folder):
    result = invoke("figures", "aaa", "--list")
    assert result.output.splitlines() == ["aaa (slope=2.0, terms=1.0,2.0, name=x)", "    A line of some slope."]


def test_an_interrupt_keeps_the_finished_figures_and_leaves_no_half_written_file(folder, tmp_path, monkeypatch):
    save = plot.save

    def interrupted(figure, path):
        if path.name == "zzz.png":

            def savefig(temporary, **_):
                temporary.write_bytes(b"half")
                raise KeyboardInterrupt

            monkeypatch.setattr(figure, "savefig", savefig)
        return save(figure, path)

    monkeypatch.setattr(plot, "save", interrupted)
    result = invoke("figures", "aaa", "zzz", "--out", tmp_path / "out")
    assert result.exit_code == cli.INTERRUPTED
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["aaa.png"]
    assert "aaa" in result.output


def test_check_prints_one_row_per_oracle_and_passes():
    result = invoke("check", "H.jhu", "--json")
    assert result.exit_code == 0
    answer = json.loads(result.stdout)
    assert answer["ok"] is True
    assert answer["version"] == jaxrefl.__version__
    assert {"block", "quantity", "value", "oracle", "source", "error", "tolerance", "ok"} <= set(answer["rows"][0])
    assert any(row["oracle"] == 0.83 for row in answer["rows"])
    table = invoke("check", "H.jhu").stdout
    assert "0.83" in table
    assert "0 failed" in table


def test_check_fails_when_a_row_fails(monkeypatch):
    rows = [row._replace(ok=False) for row in check.evaluate("H.jhu")]
    monkeypatch.setattr(check, "evaluate", lambda name: rows)
    result = invoke("check", "H.jhu", "--summary")
    assert result.exit_code == 1
    assert "FAILED" in result.output
    assert f"{len(rows)} failed" in result.output


def test_an_interrupted_check_keeps_the_rows_it_has(monkeypatch):
    evaluate = check.evaluate

    def interrupted(name):
        if name == "H.tree":
            raise KeyboardInterrupt
        return evaluate(name)

    monkeypatch.setattr(check, "evaluate", interrupted)
    result = invoke("check", "H.jhu", "H.tree")
    assert result.exit_code == cli.INTERRUPTED
    assert "0.83" in result.output
    assert "interrupted" in result.output


def test_check_names_the_blocks_when_asked_for_an_unknown_one():
    result = invoke("check", "Z.nothing")
    assert isinstance(result.exception, ValueError)
    assert "Z.nothing" in str(result.exception)
    assert "A.table" in str(result.exception)


def test_info_names_versions_devices_and_dtype():
    facts = json.loads(invoke("info", "--json").stdout)
    assert facts["jaxrefl"] == jaxrefl.__version__
    assert facts["devices"]
    assert facts["default float"] in ("float32", "float64")
    assert "jaxlib" in invoke("info").stdout


def test_version_is_printed():
    assert invoke("--version").stdout == f"jaxrefl {jaxrefl.__version__}\n"
