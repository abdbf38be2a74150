"""A model drawn four ways: what is drawn is what the model is, at the angles that the axes say."""

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpl_toolkits.mplot3d import Axes3D

from jaxrefl import brdf, plot
from jaxrefl.vec import dot

pytestmark = pytest.mark.usefixtures("quick_compilation")


@pytest.fixture(autouse=True)
def close_figures():
    matplotlib.use("Agg")
    yield
    plt.close("all")


def sloped(rho=0.5, b=0.5):
    """A model that is a plain function; its albedo is rho (1 + 2/3 b cos theta)."""
    return lambda wi, wo: rho / np.pi * (1 + b * dot(wi, wo))


def half(wi, wo):
    h = wi + wo
    return h * (1 / dot(h, h) ** 0.5)


def test_albedos_are_those_of_the_closed_forms_of_classes_and_of_plain_functions():
    theta = np.array([0.0, 30.0, 60.0, 85.0])
    mu = np.cos(np.deg2rad(theta))
    models = {"minnaert": brdf.Minnaert(0.7, 1.5), "seeliger": brdf.LommelSeeliger(0.8), "own": sloped()}
    found = plot.albedos(models, theta)
    np.testing.assert_allclose(found["minnaert"].value, 0.7 * mu**0.5, rtol=1e-9)
    np.testing.assert_allclose(found["seeliger"].value, 0.4 * (1 - mu * np.log1p(1 / mu)), rtol=1e-9)
    np.testing.assert_allclose(found["own"].value, 0.5 * (1 + mu / 3), rtol=1e-9)
    assert all((estimate.error < 1e-6).all() for estimate in found.values())


def test_albedos_take_one_model_and_its_channels_and_reach_from_0_to_90_degrees():
    found = plot.albedos(brdf.D3D9(diffuse=np.array([0.2, 1.0])))
    assert found.value.shape == (91, 2)
    np.testing.assert_allclose(found.value[0], [0.24, 1.04], rtol=1e-9)
    np.testing.assert_allclose(found.value[-1], [1.2, 2.0], rtol=1e-9)


def test_albedos_by_the_light_differ_from_those_by_the_view_where_a_model_is_not_reciprocal():
    model = brdf.D3D9(sun_fresnel=True)
    np.testing.assert_allclose(plot.albedos(model, [0, 80], fixed="light").value, 1.0, rtol=1e-9)
    np.testing.assert_allclose(
        plot.albedos(model, [0, 90], fixed="view").value, [1 - 4.8 / 105, 1 + 96 / 105], rtol=1e-9
    )


def test_albedo_draws_a_line_per_model_and_channel_and_one_at_1():
    ax = plot.axes()
    lines = plot.albedo({"white": brdf.Lambert(1.0), "color": brdf.Lambert([0.2, 0.4])}, ax=ax, legend=True)
    assert [line.axes for line in lines] == [ax] * 3
    np.testing.assert_allclose([line.get_ydata()[45] for line in lines], [1.0, 0.2, 0.4], rtol=1e-9)
    np.testing.assert_array_equal(lines[0].get_xdata(), np.arange(91))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["white", "color"]
    assert list(ax.lines[-1].get_ydata()) == [1, 1]
    assert ax.get_xlabel() == "angle of view θ (degrees)"


def test_albedo_draws_values_as_they_are_evenly_over_the_angles():
    (line,) = plot.albedo([0.5, 0.75, 1.0], label="mine")
    np.testing.assert_array_equal(line.get_xydata(), [[0, 0.5], [45, 0.75], [90, 1.0]])
    (other,) = plot.albedo([0.5, 1.0], [10, 20], fixed="light")
    np.testing.assert_array_equal(other.get_xdata(), [10, 20])
    assert other.axes.get_xlabel() == "angle of light θ (degrees)"


def test_the_cells_of_a_slice_have_the_angles_of_half_vector_and_difference():
    middle = np.deg2rad((np.arange(18) + 0.5) * 5)
    cos_h = plot.slice_values(lambda wi, wo: half(wi, wo).z, samples=18)
    cos_d = plot.slice_values(lambda wi, wo: dot(half(wi, wo), wi), samples=18)
    np.testing.assert_allclose(cos_h, np.broadcast_to(np.cos(middle), (18, 18)), rtol=1e-12)
    np.testing.assert_allclose(cos_d, np.broadcast_to(np.cos(middle)[:, None], (18, 18)), rtol=1e-12)


def test_a_slice_leaves_out_directions_below_the_surface_and_at_90_degrees_there_are_none():
    middle = (np.arange(9) + 0.5) * 10
    inside = plot.slice_values(brdf.Lambert([1.0, 0.5]), samples=9, phi_d_deg=0.0)
    np.testing.assert_array_equal(np.isnan(inside[..., 0]), middle[:, None] + middle > 90 + 1e-9)
    np.testing.assert_allclose(inside[0, 0], [1 / np.pi, 0.5 / np.pi], rtol=1e-12)
    assert np.isfinite(plot.slice_values(brdf.Lambert(1.0), samples=9)).all()


def test_image_slice_draws_pi_f_between_the_ends_of_its_scale():
    mesh = plot.image_slice(np.array([[1 / np.pi, 1e-9], [1e9, 2 / np.pi]]), range=(0.1, 10.0), bar=False)
    np.testing.assert_allclose(np.ravel(mesh.get_array()), [1, 0.1, 10, 2], rtol=1e-12)
    white = plot.image_slice(brdf.Lambert([1.0, 0.5]), title="Lambert")
    np.testing.assert_allclose(np.ravel(white.get_array()), 0.75, rtol=1e-12)
    assert white.axes.get_xlabel() == r"$\theta_h$ (degrees)"
    assert (white.axes.get_xlim(), white.axes.get_ylim()) == ((0, 90), (0, 90))


def test_the_values_of_a_lobe_have_the_light_at_their_left_and_the_view_over_the_hemisphere():
    incidence = plot.lobe_values(lambda wi, wo: wi.z + 0 * wo.x, 30.0, samples=4)
    np.testing.assert_allclose(incidence, np.cos(np.pi / 6), rtol=1e-12)
    height = plot.lobe_values(lambda wi, wo: wo.z, samples=4)
    np.testing.assert_allclose(height, np.cos(np.deg2rad([[0], [30], [60], [90]])) * np.ones(7), atol=1e-15)
    toward = plot.lobe_values(dot, 90.0, samples=4)
    np.testing.assert_allclose(toward[3, [0, 3]], [-1, 1], rtol=1e-12)  # away from the light, and back to it


def test_lobe3d_puts_the_value_at_its_direction_in_the_place_of_the_plain_axes(monkeypatch):
    seen = []
    draw = Axes3D.plot_surface
    monkeypatch.setattr(Axes3D, "plot_surface", lambda ax, *xyz, **kw: seen.append(xyz) or draw(ax, *xyz, **kw))
    figure = plt.figure()
    left, right = figure.subplots(1, 2)
    artist = plot.lobe3d(lambda wi, wo: 2.0 + 0 * wi.z, ax=left, reach=4.0, title="half")
    np.testing.assert_allclose(np.linalg.norm(seen[0], axis=0), 0.5, rtol=1e-12)
    assert (seen[0][2] > -1e-12).all()
    assert artist.axes.name == "3d"
    assert artist.axes.get_subplotspec() == left.get_subplotspec()
    assert set(figure.axes) == {right, artist.axes}
    plot.lobe3d(brdf.ModifiedPhong(1.0, 50.0), 40.0, ax=artist.axes)
    x, y, z = seen[1]
    tip = np.unravel_index(np.argmax(x**2 + y**2 + z**2), x.shape)
    assert np.linalg.norm([x[tip], y[tip], z[tip]]) == pytest.approx(1, rel=1e-12)
    assert np.rad2deg(np.arctan2(x[tip], z[tip])) == pytest.approx(40, abs=1.6)  # mirrored to the right; a cell


def test_a_lobe_that_is_nothing_is_drawn_as_nothing():
    assert plot.lobe3d(brdf.Slab()).axes.name == "3d"


def test_a_white_sphere_vanishes_in_the_furnace():
    assert np.abs(plot.furnace(brdf.CoatedLambert(1.0), bar=False).get_array()).max() < 1e-6


def test_a_pixel_of_the_furnace_shows_the_albedo_at_the_angle_of_its_offset():
    theta, mu = plot.angles(901)
    artist = plot.furnace(1 + 0.5 * mu, pixels=221)
    image = np.asarray(artist.get_array())
    s = np.abs((np.arange(221) + 0.5) * (2.2 / 221) - 1.1)
    row = image[110]
    inside = s < 0.999
    np.testing.assert_allclose(row[inside], 50 * np.sqrt(1 - s[inside] ** 2), atol=0.05)
    assert (row[s > 1] == 0).all()
    assert image[0, 0] == 0
    assert theta.size == 901


def test_rows_have_names_dots_and_texts_from_top_to_bottom():
    ax = plot.axes()
    dots = plot.rows(ax, ["a", "b"], [2.0, 0.5], base=1.0, colors=["C0", "C1"], texts=["two", ""], log=True)
    assert [tuple(dot.get_xydata()[0]) for dot in dots] == [(2.0, 0.0), (0.5, 1.0)]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["a", "b"]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]
    assert ax.get_xscale() == "log"
    assert "two" in [text.get_text() for text in ax.texts]
