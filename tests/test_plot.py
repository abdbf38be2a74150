"""The plotting functions: arrays or callables, an optional ax, artists back, nothing global changed."""

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.lines import Line2D

from jaxrefl import fresnel, plot


@pytest.fixture(autouse=True)
def close_figures():
    matplotlib.use("Agg")
    yield
    plt.close("all")


def test_a_callable_and_an_array_draw_the_same_curve():
    x = np.linspace(0, 1, 5)
    (called,) = plot.cartesian(x, np.sqrt)
    (given,) = plot.cartesian(x, np.sqrt(x))
    assert isinstance(called, Line2D)
    np.testing.assert_array_equal(called.get_xydata(), given.get_xydata())


def test_a_dict_draws_one_labelled_curve_per_entry_into_the_given_axes():
    ax = plot.axes()
    artists = plot.cartesian([0, 1], {"a": [0, 1], "b": np.square}, ax=ax, legend=True, xlabel="t (s)", ylabel="L (m)")
    assert [artist.axes for artist in artists] == [ax, ax]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["a", "b"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("t (s)", "L (m)")


@pytest.mark.parametrize(("eta", "k"), [(1.5, None), (1 / 1.5, None), (0.43, 2.455)])
def test_fresnel_draws_the_library_s_reflectance_over_degrees(eta, k):
    ax = plot.axes()
    s, p, mean = plot.fresnel(eta, k, ax=ax, samples=91)
    theta = np.arange(91.0)
    np.testing.assert_array_equal(mean.get_xdata(), theta)
    expected = fresnel.conductor(np.sin(np.deg2rad(90 - theta)), eta, 0.0 if k is None else k)
    np.testing.assert_allclose(mean.get_ydata(), expected, atol=1e-6)
    np.testing.assert_allclose(0.5 * (s.get_ydata() + p.get_ydata()), mean.get_ydata(), rtol=1e-12)
    marks = [text.get_text() for text in ax.texts]
    assert marks == {1.5: ["Brewster 56.3°"], 0.43: []}.get(eta, ["Brewster 33.7°", "critical 41.8°"])


def test_fresnel_refuses_an_unknown_curve():
    with pytest.raises(ValueError, match=r"curves = \['x'\] must be among s, p, mean"):
        plot.fresnel(1.5, curves=("x",))


def test_polar_puts_the_normal_up_and_takes_callables():
    (lobe,) = plot.polar({"cos": np.cos}, incident=0.5)
    theta, r = lobe.get_data()
    np.testing.assert_array_equal(r, np.cos(theta))
    assert (theta[0], theta[-1]) == (-np.pi / 2, np.pi / 2)
    assert lobe.axes.get_theta_offset() == np.pi / 2
    assert lobe.axes.get_theta_direction() == -1


def test_error_map_draws_the_magnitude_and_the_contours():
    mesh, contours = plot.error_map([1, 2, 3], [0, 1], lambda x, y: -0.01 * x * (1 + y), levels=(0.02,))
    assert isinstance(mesh, QuadMesh)
    np.testing.assert_allclose(np.ravel(mesh.get_array()), [0.01, 0.02, 0.03, 0.02, 0.04, 0.06])
    assert list(contours.levels) == [0.02]


def test_convergence_is_logarithmic_and_shows_an_error_of_zero():
    line, other = plot.convergence(
        {"a": [1, 2], "b": [1, 4]}, {"a": [-0.1, 0.0], "b": [1, 1]}, slopes=(-2,), floor=1e-20
    )
    assert (line.axes.get_xscale(), line.axes.get_yscale()) == ("log", "log")
    np.testing.assert_array_equal(line.get_ydata(), [0.1, 1e-20])
    np.testing.assert_array_equal(other.get_xdata(), [1, 4])


def test_angles_come_with_cosines_that_vanish_at_ninety_degrees():
    theta, mu = plot.angles(3)
    np.testing.assert_array_equal(theta, [0, 45, 90])
    np.testing.assert_allclose(mu, [1, 0.5**0.5, 0], rtol=1e-15)
    assert mu[-1] == 0


def test_labels_and_legend_keys_are_what_was_given():
    ax = plot.labels(plot.axes(), xlabel="x", title="t", xlim=(0, 2), yscale="log")
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_xlim(), ax.get_yscale()) == ("x", "", (0, 2), "log")
    keys = plot.legend(ax, {"dashed": {"linestyle": "--"}}, loc="lower left")
    assert [text.get_text() for text in keys.get_texts()] == ["dashed"]


def test_polar_takes_a_label_and_refuses_cartesian_axes():
    (lobe,) = plot.polar(np.cos, label="cos")
    assert lobe.get_label() == "cos"
    with pytest.raises(ValueError, match="polar=True"):
        plot.polar(np.cos, ax=plot.axes())


def test_convergence_takes_callables_and_draws_reference_slopes():
    (line,) = plot.convergence([1, 10, 100], lambda n: n**-2.0, slopes=(-2,))
    np.testing.assert_allclose(line.get_ydata(), [1, 1e-2, 1e-4])
    reference = line.axes.lines[1]
    x, y = reference.get_data()
    assert np.log(y[1] / y[0]) / np.log(x[1] / x[0]) == pytest.approx(-2)


def test_mark_writes_the_number_into_its_text_and_needs_one_coordinate():
    ax = plot.axes()
    line, text = plot.mark(ax, y=0.25, text="at {:g}", side="below")
    assert text.get_text() == "at 0.25"
    assert list(line.get_ydata()) == [0.25, 0.25]
    with pytest.raises(ValueError, match="one of them"):
        plot.mark(ax)


def test_a_diagram_is_made_of_arrows_notes_and_dots():
    ax = plot.canvas(plot.axes(), (-1, 1), (-1, 1), "title")
    plot.arrow(ax, (0, 0), (1, 1), "up", shift=(0.1, 0))
    plot.dot(ax, (0, 0), 0.2, "0.5")
    plot.points(ax, [0.1, 0.2], [0.3, 0.4], ["a", "b"], dy=[3, -3])
    assert {"up", "0.5", "a", "b"} <= {text.get_text() for text in ax.texts}
    assert not ax.axison


def test_the_style_is_a_context_and_leaves_rcparams_alone():
    before = dict(matplotlib.rcParams)
    for name in plot.STYLES:
        with plot.style(name):
            assert matplotlib.rcParams["axes.grid"] is True
    assert dict(matplotlib.rcParams) == before
    with pytest.raises(ValueError, match="paper, slide, dark"), plot.style("fancy"):
        pass


def luminance_after(matrix, rgb):
    return np.clip(np.asarray(matrix) @ rgb, 0, 1)


@pytest.mark.parametrize("name", plot.STYLES)
def test_neighbouring_colours_differ_for_colour_blind_readers(name):
    """Machado, Oliveira & Fernandes 2009, full protanopia and deuteranopia, on linear RGB."""
    deficiencies = {
        "protanopia": [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        "deuteranopia": [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
    }
    with plot.style(name):
        cycle = [np.array(matplotlib.colors.to_rgb(c["color"])) for c in matplotlib.rcParams["axes.prop_cycle"]]
    for matrix in deficiencies.values():
        seen = [np.sqrt(luminance_after(matrix, c**2.2)) for c in cycle]
        distance = [np.linalg.norm(a - b) for i, a in enumerate(seen) for b in seen[:i]]
        assert min(distance) > 0.15


def test_save_leaves_no_half_written_file(tmp_path):
    figure = plot.axes().get_figure()
    plot.save(figure, tmp_path / "folder" / "a.png")
    with pytest.raises(ValueError, match="jpgg"):
        plot.save(figure, tmp_path / "folder" / "b.jpgg")
    assert [path.name for path in (tmp_path / "folder").iterdir()] == ["a.png"]
