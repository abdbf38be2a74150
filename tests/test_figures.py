"""The claim of every caption, asserted from the numbers that the figure draws; and what `jaxrefl figures` promises."""

import ast
from pathlib import Path

import numpy as np
import pytest
from figure_claims import at, says
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from jaxrefl import fresnel, gallery, plot


def test_every_figure_has_a_claim_asserted_here():
    sources = [ast.parse(path.read_text(encoding="utf-8")) for path in Path(__file__).parent.glob("test_figures*.py")]
    tests = {node.name for source in sources for node in source.body if isinstance(node, ast.FunctionDef)}
    assert {f"test_{name}" for name in gallery.names()} <= tests


def test_d3d9_fresnel(figure):
    data, caption = figure("d3d9_fresnel")
    says(caption, *(f"{value:.2f}" for value in data["at_60_deg"]), "R0 = 0.04")
    figure_1 = Figure()
    gallery.load("d3d9_fresnel").draw(data, figure_1)
    red, blue = figure_1.axes[0].lines
    with plot.style():
        assert (to_hex(red.get_color()), to_hex(blue.get_color())) == ("#d55e00", "#0072b2")
    np.testing.assert_array_equal([red.get_ydata(), blue.get_ydata()], [data["p2"], data["p4"]])
    assert at(data, "p2", 60) == pytest.approx(0.28, rel=1e-12)
    assert at(data, "p4", 60) == pytest.approx(0.10, rel=1e-12)
    assert (np.diff(at(data, "over_p", 60)) < 0).all()
    np.testing.assert_allclose(at(data, "over_m", 90), 0.04 + data["m"], rtol=1e-14)
    np.testing.assert_allclose(at(data, "over_r0", 0), data["r0"], rtol=1e-14)
    for family in ("over_p", "over_r0"):
        np.testing.assert_allclose(at(data, family, 90), 1.0, rtol=1e-14)


def test_d3d9_model(figure):
    data, caption = figure("d3d9_model")
    says(caption, "(0.8, 0.5, 0.2)")
    np.testing.assert_array_equal(data["metallic"], [0.8, 0.5, 0.2])
    np.testing.assert_allclose(data["r"][-1], 0.0, atol=1e-15)
    np.testing.assert_allclose(data["R_tot"][-1], 1.0, rtol=1e-15)
    assert data["pixel_max"] > 1.1


def test_d3d9_energy(figure):
    data, caption = figure("d3d9_energy")
    says(caption, f"{100 * (at(data, 'eq6', 0)[0] - 1):.0f} % too much", f"{100 * (data['eq6_average'] - 1):.2f} %")
    assert at(data, "eq6", 90)[0] == pytest.approx(2.0, rel=1e-14)
    euclidean = at(data, "eq6_euclidean", 0)
    assert (euclidean[1:] < 1).all()
    assert (np.diff(euclidean) < 0).all()
    says(caption, f"{euclidean[-1]:.3f} is left for λ = 0.9")
    np.testing.assert_allclose(data["eq8_sent"], 1.0, rtol=1e-14)
    says(caption, f"{data['eq8_viewed'][0].min():.3f}", f"{data['eq8_viewed'][0].max():.3f}")
    says(caption, f"{float(data['ratio_0_89']):.1f}")


def test_d3d9_fit(figure):
    data, caption = figure("d3d9_fit")
    says(caption, *(f"{rms:.4f}" for rms in (*data["rms"], *data["rms_schlick"])))
    says(caption, *(f"{value:.3f}" for value in data["r0"] + data["m"]))
    assert (data["rms"] < data["rms_tied"]).all()
    assert (data["rms_tied"] < data["rms_schlick"]).all()


def test_fresnel_dielectric(figure):
    data, caption = figure("fresnel_dielectric")
    says(caption, *(f"{angle:.1f}°" for angle in (*data["brewster_deg"], float(data["critical_deg"]))))
    np.testing.assert_allclose(data["normal"], 0.04, rtol=1e-14)
    assert data["brewster_deg"].sum() == pytest.approx(90, rel=1e-14)
    total = data["theta_deg"] > data["critical_deg"]
    assert (data["inside_sp"][:, total] == 1).all()
    assert (data["inside_sp"][:, ~total] < 1).all()
    exact = data["inside_sp"].mean(axis=0)
    assert np.abs(data["schlick_inside"] - exact).max() < 0.05
    assert np.abs(data["schlick_inside_wrong"] - exact).max() > 0.95


def test_fresnel_conductor(figure):
    data, caption = figure("fresnel_conductor")
    worst = data["max_error"].argmax()
    assert (data["metal"][worst], data["wavelength_nm"][worst]) == ("aluminium", 652.25)
    says(caption, f"{data['max_error'][worst]:.3f} at {data['max_error_deg'][worst]:.1f}°")
    assert data["max_error"][data["metal"] == "silver"].max() < 0.01
    dips = data["exact"].min(axis=1) < data["exact"][:, 0] - 1e-6
    assert {*data["metal"][dips]} == {"gold", "silver", "copper", "aluminium"}
    assert (np.diff(data["schlick"], axis=1) >= -1e-15).all()


def test_schlick_atlas(figure):
    data, caption = figure("schlick_atlas")
    worst, best = data["example_error"].argmax(), data["example_error"].argmin()
    assert (data["example"][worst], data["example"][best]) == (1.1, 1.5)
    says(caption, f"off by {data['example_error'][worst]:.2f} at {data['example_deg'][worst]:.1f}°")
    says(caption, f"off by {data['example_error'][best]:.3f} at {data['example_deg'][best]:.1f}°")
    assert data["max_error_below_45_deg"] <= 0.01
    assert data["reversal_defect"] < 1e-14
    row, column = 130, 200  # 19.5 degrees inside n = 1.668
    n, sine = data["eta"][column], np.sin(np.deg2rad(data["theta_deg"][row]))
    cos_t = np.sqrt(1 - (n * sine) ** 2)
    outside = fresnel.schlick(cos_t, fresnel.f0_dielectric(n)) - fresnel.dielectric(cos_t, n)
    assert data["error_inside"][row, column] == pytest.approx(abs(float(outside)), rel=1e-9)


def test_misprints(figure):
    data, caption = figure("misprints")
    squares = complex(data["literal_squares_60"])
    says(caption, f"{squares.real:.3f} + {squares.imag:.3f}i", f"{float(data['R_60']):.3f}")
    says(caption, f"R_p = {float(data['literal_denominator_60']):.2f} instead of {float(data['R_p_60']):.3f}")
    assert squares == pytest.approx(0.0061899208052317663 + 0.41483388302285345j, rel=1e-13)
    assert float(data["literal_denominator_60"]) == pytest.approx(2.2603756365658426, rel=1e-13)
    assert data["literal_denominator"][0] > 1e4


def test_bounce_series(figure):
    data, caption = figure("bounce_series")
    says(caption, f"{float(data['limit']):.4f}", f"{data['truncated'][10]:.4f}", f"{data['folded'][10]:.4f}")
    assert data["limit"] == pytest.approx(39 / 70, rel=1e-15)
    assert (data["truncated"] < data["limit"]).all()
    assert {*np.sign(data["folded"] - data["limit"])} == {-1.0, 1.0}
    assert (data["limit"] - data["truncated"] <= data["bound"]).all()
    says(caption, f"below 1/255 at {int(data['bounces_needed'])} bounces")
    assert data["bound"][data["bounces_needed"]] < 1 / 255 < data["bound"][data["bounces_needed"] - 1]
    alpha, color = np.resize([0.9, 0.8], 61), np.resize([0.3, 0.7], 61)
    seen = {0: 0.3 * 0.1 + 0.9 * (0.7 * 0.2), 1: 0.7 * 0.2 + 0.8 * (0.3 * 0.1)}  # one period, from either mirror
    behind = np.array([seen[(j + 1) % 2] / (1 - 0.72) for j in range(61)])
    weight = np.concatenate([[1], np.cumprod(alpha)[:-1]])
    np.testing.assert_allclose(data["slope"], weight * (behind - color), rtol=1e-12)
    assert data["weights_and_remainder"] == pytest.approx(1, rel=1e-15)
    assert np.abs(data["slope"][::2])[-1] < 1e-2 * np.abs(data["slope"][0])


def test_jhu_tree(figure):
    data, caption = figure("jhu_tree")
    says(caption, f"= {float(data['total']):.2f}", "0.46 and 0.4", "1, 0.5 and 0.1")
    np.testing.assert_allclose(data["d_reflected"][:2], [0.46, 0.4], rtol=1e-15)
    np.testing.assert_allclose(data["d_local"], [1, 0.5, 0.1], rtol=1e-15)
    assert data["convex"] == pytest.approx(0.5, rel=1e-15)
    assert data["limit"] == pytest.approx(0.5, rel=1e-15)
    np.testing.assert_allclose(data["conserving"], 0.1 * (data["depth"] + 1), rtol=1e-14)
    np.testing.assert_allclose(data["exploding"], 1.1 ** (data["depth"] + 1.0) - 1, rtol=1e-13)
    np.testing.assert_allclose(data["converging"], 0.5 * (1 - 0.8 ** (data["depth"] + 1.0)), rtol=1e-14)
    np.testing.assert_allclose(data["k"], [0.8, 1.0, 1.1], rtol=1e-15)
    np.testing.assert_allclose(data["level_sums"], 0.8 ** np.arange(4), rtol=1e-14)
    says(caption, f"to {data['exploding'][30]:.1f} at", *(f"{x:.3g}" for x in data["level_sums"][1:]))


def test_why_pi(figure):
    data, caption = figure("why_pi")
    assert (data["error_gauss_cos"] <= 4e-16).all()
    assert (data["error_gauss_theta"][data["n_gauss_theta"] >= 10] <= 4e-16).all()
    assert (data["error_gauss_theta"][data["n_gauss_theta"] <= 6] > 1e-11).all()

    def order(name):
        n, error = data[f"n_{name}"], data[f"error_{name}"]
        use = (n >= 8) & (error > 1e-13)
        return np.polyfit(np.log(n[use]), np.log(error[use]), 1)[0]

    assert order("midpoint") == pytest.approx(-2, abs=0.02)
    assert order("simpson") == pytest.approx(-4, abs=0.1)
    says(caption, "n^-2", "n^-4", "1/sqrt(3 n)")
    sigma = 1 / np.sqrt(3 * data["n_monte_carlo"])
    assert (np.abs(np.log2(data["error_monte_carlo"] / sigma)) < 1).all()
    assert 1e-4 < data["error_monte_carlo"][-1] < 1e-3


DRAWN = {
    "bounce_series": ("weights", "remainder", "bound", "slope:abs"),
    "d3d9_energy": ("eq6", "eq6_euclidean", "eq8_viewed", "eq8_sent", "reciprocity_ratio"),
    "d3d9_fit": ("exact", "fitted", "tied", "schlick"),
    "d3d9_fresnel": ("p2", "p4", "over_p", "over_m", "over_r0"),
    "d3d9_model": ("r:T", "R_tot:T", "pixel:T"),
    "fresnel_conductor": ("exact", "schlick"),
    "fresnel_dielectric": ("outside_sp", "inside_sp", "schlick_outside", "schlick_inside", "schlick_inside_wrong"),
    "jhu_tree": ("converging", "conserving", "exploding"),
    "misprints": ("R", "R_p", "literal_squares:real", "literal_squares:imag", "literal_denominator"),
    "schlick_atlas": ("error_outside:mesh", "error_inside:mesh"),
    "why_pi": ("error_midpoint", "error_simpson", "error_gauss_theta", "error_gauss_cos", "error_monte_carlo"),
}


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_what_the_caption_speaks_of_is_what_is_drawn(figure, name):
    data, _ = figure(name)
    with plot.style():
        picture = plot.figure((8, 4))
        gallery.load(name).draw(data, picture)
    lines = [np.asarray(line.get_ydata(), float) for ax in picture.axes for line in ax.lines]
    meshes = [np.asarray(mesh.get_array()).ravel() for ax in picture.axes for mesh in ax.collections if mesh.axes]
    take = {"T": np.transpose, "abs": np.abs, "real": np.real, "imag": np.imag, "": np.asarray}
    for key, _, how in (entry.partition(":") for entry in DRAWN[name]):
        if how == "mesh":
            wanted = np.clip(data[key], 1e-4, 0.3).ravel()
            assert any(m.shape == wanted.shape and np.array_equal(m, wanted) for m in meshes), key
            continue
        for row in np.atleast_2d(take[how](data[key])):
            wanted = np.maximum(row, 1e-17) if name == "why_pi" else row
            assert any(line.shape == wanted.shape and np.allclose(line, wanted, rtol=1e-12) for line in lines), key


def test_figures_draw_with_the_plot_module_and_nothing_else():
    """What a figure does to axes or to the figure itself is to ask it for subplots."""
    for path in sorted(gallery.directory().glob("*.py")):
        draw = next(
            node
            for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.FunctionDef) and node.name == "draw"
        )
        calls = {ast.unparse(node.func) for node in ast.walk(draw) if isinstance(node, ast.Call)}
        methods = {*dir(Axes), *dir(Figure)}
        others = {call for call in calls if not call.startswith("plot.") and call.rpartition(".")[2] in methods}
        assert others == {"fig.subplots"}, path.name
