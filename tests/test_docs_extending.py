"""The model of docs/extending.md, taken from the page: its closed form, its audit, the commands that take it."""

import re
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from typer.testing import CliRunner

from jaxrefl import catalog, cli
from jaxrefl.albedo import directional_albedo, rule_for
from jaxrefl.audit import audit
from jaxrefl.reference import read
from jaxrefl.vec import Vec3

PAGE = Path(__file__).resolve().parent.parent / "docs" / "extending.md"
MAIN, SHADED, NUMPY = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The page's first block up to its first result, saved as the page says."""
    path = tmp_path_factory.mktemp("extending") / "tilted.py"
    path.write_text(MAIN.partition("\n\nprint(")[0])
    return path


@pytest.fixture(scope="module")
def tilted(file):
    return catalog.resolve(f"{file}:Tilted")


def test_the_model_takes_about_twenty_lines_from_zero_to_a_picture():
    lines = [line for line in MAIN.splitlines() if line.strip() and not line.startswith(("import", "from", "print("))]
    assert len(lines) <= 22


def test_the_albedo_and_its_derivative_are_the_closed_form_of_the_page(tilted):
    rule = rule_for(tilted())
    mu = jnp.array([0.0, 0.05, 0.3, 0.8, 1.0])

    @jax.jit
    def both(rho, b):
        def one(mu):
            return directional_albedo(tilted(rho, b), mu, rule)

        slope = jax.vmap(lambda mu: jax.grad(lambda b: directional_albedo(tilted(rho, b), mu, rule).value)(b))
        return jax.vmap(one)(mu), slope(mu)

    for rho, b in ((0.6, 0.5), (0.9, 1.0), (0.3, -1.0), (0.5, 0.0)):
        found, slope = both(rho, b)
        exact = rho * (1 + 2 / 3 * b * np.asarray(mu))
        np.testing.assert_allclose(found.value, exact, rtol=1e-14)
        assert (abs(found.value - exact) <= found.error).all()
        np.testing.assert_allclose(slope, rho * 2 / 3 * np.asarray(mu), rtol=1e-12, atol=1e-16)


def test_the_range_of_b_is_where_the_model_is_not_negative(tilted):
    """Light and view opposite each other at the horizon: f = rho / pi (1 - b)."""
    mu = 1e-9
    wi, wo = Vec3(np.sqrt(1 - mu * mu), 0.0, mu), Vec3(-np.sqrt(1 - mu * mu), 0.0, mu)
    assert 0 <= float(tilted(0.5, 1.0)(wi, wo)) < 1e-12
    assert float(tilted(0.5, 1.01)(wi, wo)) < 0
    assert float(tilted(0.5, -1.01)(wi, wi)) < 0


def test_the_audit_passes_it_and_finds_the_parameters_that_create_energy(tilted):
    assert audit(tilted(0.6, 0.5)).ok
    row = audit(tilted(0.9, 1.0), ["energy_view"])["energy_view"]
    assert row.verdict == "fails"
    assert row.number == pytest.approx(1.5, rel=1e-9)


def test_the_commands_take_it_and_answer_a_wrong_parameter_with_the_list(file, tmp_path):
    out = tmp_path / "tilted.csv"
    arguments = ["oracle", f"{file}:Tilted", "rho=0.6", "b=0.5", "-n", "40", "-o", str(out)]
    result = CliRunner().invoke(cli.app, arguments)
    assert result.exit_code == 0, result.output
    given = read(out)
    exact = 0.6 / np.pi * (1 + 0.5 * np.sum(given.wi * given.wo, axis=1))
    np.testing.assert_allclose(given.values["f"][:, 0], exact, rtol=1e-14)
    with pytest.raises(ValueError, match=r"b = 2\.0 is outside \[-1, 1\]; the parameters of .*\n  rho in \[0, 1\]"):
        catalog.build(f"{file}:Tilted", ["b=2"])


def test_the_members_of_the_table_are_those_that_the_library_looks_for():
    """What the page offers is read somewhere."""
    code = " ".join(path.read_text(encoding="utf-8") for path in (PAGE.parent.parent / "jaxrefl").rglob("*.py"))
    table = re.findall(r"^\| `(\w+)[`(]", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert table == ["mirror", "through", "kinks", "chart", "pdf", "sample"]
    for name in table:
        assert re.search(rf'(hasattr|getattr)\([\w.]+, "{name}"', code) or f'("{name}",' in code, name


def test_the_number_that_the_page_gives_for_kinks_is_the_one_that_comes_out():
    namespace: dict = {}
    exec(SHADED.partition("\n\nprint(")[0], namespace)
    albedo_to, model = namespace["albedo_to"], namespace["Shaded"](0.5, 0.6)
    hinted, plain = albedo_to(model, 0.7), albedo_to(lambda wi, wo: model(wi, wo), 0.7)
    assert abs(hinted.value - 0.42) < 1e-15
    assert hinted.converged
    assert hinted.evaluations < 320_000
    assert not plain.converged
    assert abs(plain.value - 0.32) <= plain.error
    assert 1e-4 < plain.error < 1e-2
