"""Tables of albedos: the numbers of single calls, and the files that they are saved in."""

import csv

import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl.albedo import directional_albedo, rule_for
from jaxrefl.brdf import Lambert, Minnaert, Mix, Scaled
from jaxrefl.tabulate import albedo_table, replaced

MU = np.array([0.2, 0.6, 1.0])


@pytest.fixture(scope="module")
def table():
    return albedo_table(Minnaert(), "k", [0.5, 1.0, 2.5], MU)


def test_a_table_has_the_closed_albedo_of_every_value_and_angle_with_its_error(table):
    exact = MU[None] ** (np.array([0.5, 1.0, 2.5])[:, None] - 1)
    assert table.albedo.shape == (3, 3)
    assert (np.abs(table.albedo - exact) <= table.error).all()
    np.testing.assert_allclose(table.albedo, exact, rtol=1e-13)


def test_a_table_of_spectra_and_of_a_nested_parameter_is_that_of_single_calls():
    brdf = Mix(Lambert(jnp.array([0.2, 0.9])), Scaled(Lambert(0.5), 0.3), 0.25)
    rule = rule_for(brdf, 2)
    table = albedo_table(brdf, "b.factor", [0.0, 0.8], MU, rule)
    assert table.albedo.shape == (2, 3, 2)
    single = directional_albedo(Mix(brdf.a, Scaled(Lambert(0.5), 0.8), 0.25), 0.6, rule)
    np.testing.assert_allclose(table.albedo[1, 1], single.value, rtol=1e-14)
    np.testing.assert_allclose(table.albedo[1, 1], 0.75 * np.array([0.2, 0.9]) + 0.25 * 0.4, rtol=1e-7)


@pytest.mark.parametrize("ending", ["npz", "csv", "exr"])
def test_a_table_is_read_back_as_it_was_saved(table, tmp_path, ending):
    path = tmp_path / f"minnaert.{ending}"
    table.save(path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    if ending == "npz":
        with np.load(path) as file:
            assert str(file["parameter"]) == "k"
            for name in ("values", "cos_theta_o", "albedo", "error"):
                np.testing.assert_array_equal(file[name], getattr(table, name))
    elif ending == "csv":
        with path.open() as file:
            head, *rows = csv.reader(file)
        assert head == ["k", "cos_theta_o", "albedo", "error"]
        np.testing.assert_array_equal(np.array(rows, float)[:, 2].reshape(3, 3), table.albedo)
    else:
        channels = pytest.importorskip("OpenEXR").File(str(path)).channels()
        np.testing.assert_array_equal(channels["albedo"].pixels, table.albedo.astype(np.float32))
        np.testing.assert_array_equal(channels["error"].pixels, table.error.astype(np.float32))


def test_what_cannot_be_tabulated_or_saved_is_named(table, tmp_path):
    with pytest.raises(ValueError, match=r"^parameter = 'kk' is not one of Minnaert: scale, k"):
        albedo_table(Minnaert(), "kk", [0.5], MU)
    with pytest.raises(ValueError, match=r"^cos_theta_o = 1.5 is outside \[0, 1\]"):
        albedo_table(Minnaert(), "k", [0.5], [1.5])
    with pytest.raises(ValueError, match=r"must end in .npz, .csv, .exr"):
        table.save(tmp_path / "table.txt")
    assert not list(tmp_path.iterdir())


def test_a_parameter_out_of_its_range_is_refused():
    with pytest.raises(ValueError, match=r"k = -1.0 is outside \(0, inf\)"):
        albedo_table(Minnaert(), "k", [0.5, -1.0], MU)


def test_replaced_follows_a_path_and_leaves_the_rest():
    model = replaced(Scaled(Lambert(0.5), 0.3), "base.rho", 0.7)
    assert (model.base.rho, model.factor) == (0.7, 0.3)
