"""The claims of the captions about the reflection models: their albedos, verdicts, derivatives, and the rules."""

import numpy as np
import pytest
from figure_claims import at, says

from jaxrefl import brdf, fresnel, gallery, plot
from jaxrefl.catalog import MODELS, white


def angles(data):
    return np.deg2rad(data["theta_deg"]), np.sin(np.deg2rad(90 - data["theta_deg"]))


def oren_nayar(theta, sigma):
    """A + B / pi (sin (theta - sin cos) + 2/3 tan (1 - sin^3)), below 90 degrees."""
    s2, sine, mu = sigma**2, np.sin(theta), np.cos(theta)
    g = sine * (theta - sine * mu) + 2 / 3 * np.tan(theta) * (1 - sine**3)
    return 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) * g / np.pi


def coat(mu, rho, eta=1.5):
    f, inside = fresnel.dielectric(mu, eta), fresnel.average_dielectric(1 / eta)
    return np.asarray(f + (1 - f) * rho * (1 - inside) / (1 - rho * inside))


def test_albedo_models(figure):
    data, caption = figure("albedo_models")
    curve = dict(zip(data["name"], data["albedo"], strict=True))
    theta, mu = angles(data)
    below = data["theta_deg"] < 90
    expected = {
        "diffuse: Lambert": np.ones(mu.size),
        "diffuse: EON, r = 1": np.ones(mu.size),
        "diffuse: Ashikhmin-Shirley diffuse": 1 - (1 - 0.5 * mu) ** 5,
        "planetary: Minnaert, k = 0.8": np.where(below, np.maximum(mu, 1e-9) ** -0.2, np.nan),
        "planetary: Minnaert, k = 1.5": np.where(below, mu**0.5, np.nan),
        "layers: D3D9 (6)": 1 + 0.04 + 0.96 * (1 - mu) ** 5,
    }
    for name, values in expected.items():
        np.testing.assert_allclose(curve[name], values, rtol=1e-9, err_msg=name)
    (rough,) = (values for name, values in curve.items() if "Oren-Nayar" in name)
    np.testing.assert_allclose(
        [x for name, x in curve.items() if "coat" in name], [mu * 0 + 1, coat(mu, 0.5)], rtol=1e-9
    )
    np.testing.assert_allclose(rough[below], oren_nayar(theta[below], 0.3), rtol=1e-9)
    seeliger = 0.5 * (1 - mu[below] * np.log1p(1 / mu[below]))
    np.testing.assert_allclose(curve["planetary: Lommel-Seeliger, w = 1"][below], seeliger, rtol=1e-9)
    np.testing.assert_allclose(curve["layers: slab, R"] + curve["layers: slab, T"], 1, rtol=1e-12)
    says(caption, f"{rough[-1]:.3f} and {curve['diffuse: Burley, roughness 1'][-1]:.3f}")
    phong = [curve[f"mirror lobe: n = {n}"] for n in (1, 10, 100)]
    for n, value in ((1, 0.60899778104422936), (10, 0.50473594665527344)):
        assert at(data | {"x": curve[f"mirror lobe: n = {n}"]}, "x", 60) == pytest.approx(value, rel=1e-8)
    gap = [np.abs(one - mu).max() for one in phong]
    assert gap == sorted(gap, reverse=True)
    blinn = curve["half vector: n = 100"]
    says(caption, f"to {blinn[data['theta_deg'] == 60][0]:.3f} at 60°")
    assert (np.diff(blinn) < 0).all()
    for name, first in (("Phong", "88.7"), ("OpenGL", "86.6")):
        assert np.nanmax(curve[f"literal: {name}"]) < 1
        lit = curve[f"literal: {name}, lit"]
        crossing = np.interp(1.0, lit[40:-1], data["theta_deg"][40:-1])
        says(caption, first)
        assert f"{crossing:.1f}" == first


def test_energy_verdicts(figure):
    data, caption = figure("energy_verdicts")
    models = list(data["model"])
    largest, ratio = (dict(zip(models, data[key], strict=True)) for key in ("largest", "ratio"))
    assert {type(model) for model in white().values()} == set(MODELS.values())
    conserving = {"Lambert", "EON", "Ashikhmin-Shirley", "Lommel-Seeliger", "coated Lambert", "modified Phong"}
    conserving |= {"Blinn-Phong", "slab", "D3D9 repaired"}
    assert {name for name in models if largest[name] <= 1 + 1e-9} == conserving
    assert {name for name in models if ratio[name] > 1 + 1e-9} == {"literal Phong", "literal OpenGL", "D3D9 (8)"}
    for name, percent in (("Oren-Nayar", "0.5 %"), ("Burley", "55.8 %"), ("D3D9 (6)", "100 %")):
        assert f"{100 * (largest[name] - 1):.{0 if name == 'D3D9 (6)' else 1}f} %" == percent
        says(caption, percent)
    assert largest["Minnaert"] == pytest.approx(np.cos(np.deg2rad(89)) ** -0.2, rel=1e-9)
    for name in ("literal Phong", "literal OpenGL"):  # the light that leaves has a limit, what comes goes to 0
        lit = data["lit"][models.index(name)] * np.sin(np.deg2rad(90 - data["theta_deg"]))
        assert lit[89] == pytest.approx(lit[88], rel=0.1)
        assert lit[89] > 0.01
        assert ratio[name] == pytest.approx(1 / np.cos(np.deg2rad(89)), rel=1e-9)
    r_89 = 0.04 + 0.96 * (1 - np.cos(np.deg2rad(89))) ** 5
    assert ratio["D3D9 (8)"] == pytest.approx(0.96 / (1 - r_89), rel=1e-9)


def test_furnace_poster(figure):
    data, caption = figure("furnace_poster")
    models = list(data["model"])
    vanish = {
        name for name, low, high in zip(models, data["lowest"], data["highest"], strict=True) if high - low < 1e-6
    }
    assert vanish == {"Lambert", "EON", "coated Lambert", "slab", "D3D9 repaired"}
    low, high = (dict(zip(models, data[key], strict=True)) for key in ("lowest", "highest"))
    says(caption, f"loses {-low['Oren-Nayar']:.1f} % in the middle and gains {high['Oren-Nayar']:.1f} % at the rim")
    says(caption, f"gains {low['D3D9 (6)']:.0f} % to {high['D3D9 (6)']:.1f} %")
    assert max(high["modified Phong"], high["Blinn-Phong"], high["literal Phong"], high["literal OpenGL"]) < 1e-6
    np.testing.assert_allclose(data["albedo"][models.index("slab")], 1, rtol=1e-12)


def test_coat_and_slab(figure):
    data, caption = figure("coat_and_slab")
    few = np.isin(data["theta_deg"], data["few_deg"])
    for key, rho in (("grey", 0.5), ("white", 1.0)):
        np.testing.assert_allclose(data[f"coat_{key}"], data[f"formula_{key}"][few], rtol=1e-9)
        np.testing.assert_allclose(data[f"formula_{key}"], coat(angles(data)[1], rho), rtol=1e-12)
    np.testing.assert_allclose(data["formula_white"], 1, rtol=1e-12)
    normal = [at(data, f"{name}_grey", 0) for name in ("formula", "once", "dimmed")]
    says(caption, f"{normal[0]:.3f} at normal", f"it is {normal[1]:.3f}", f"it is {normal[2]:.2f}")
    says(caption, f"ends at {data['added_grey'][-1]:.1f}", f"{data['once_white'][0]:.3f} is left")
    says(caption, f"{at(data, 'slab_R', 60):.3f} at 60°", f"it is {at(data, 'slab_wrong', 60):.3f}")
    assert at(data, "slab_R", 60) == pytest.approx(0.15187159027119984, rel=1e-12)
    says(caption, f"{data['apart']:.3f} off, at {data['apart_deg']:.0f}°", f"{data['brewster_deg']:.1f}°")
    np.testing.assert_allclose(data["slab_R"], 0.5 * (data["slab_s"] + data["slab_p"]), rtol=1e-12)
    np.testing.assert_allclose(data["slab_R"] + data["slab_T"], 1, rtol=1e-12)
    assert data["slab_p"].min() < 1e-6


def test_d3d9_repaired(figure):
    data, caption = figure("d3d9_repaired")
    r = 0.04 + 0.96 * (1 - angles(data)[1]) ** 5
    for key, metallic in (("", 0.0), ("_metallic", 0.5)):
        for fixed in ("view", "light"):
            np.testing.assert_allclose(data[f"eq6{key}_by_{fixed}"], 1 + r * (1 - metallic), rtol=1e-9)
            np.testing.assert_allclose(data[f"repaired{key}_by_{fixed}"], 1, rtol=1e-9)
        viewed = 1 + (1 - metallic) * (r - (0.04 + 0.96 * 2 / 42))
        np.testing.assert_allclose(data[f"eq8{key}_by_view"], viewed, rtol=1e-9)
        np.testing.assert_allclose(data[f"eq8{key}_by_light"], 1, rtol=1e-9)
    says(caption, f"{data['eq8_by_view'].min():.3f} to {data['eq8_by_view'].max():.3f}")
    np.testing.assert_allclose(data["eq8_ratio"], (1 - r[0]) / (1 - r[:-1]), rtol=1e-9)
    np.testing.assert_allclose([data["eq6_ratio"], data["repaired_ratio"]], 1, rtol=1e-12)
    says(caption, f"by {data['eq8_ratio'][-1]:.1f} between", "between 0° and 89°")


def test_oren_nayar_above_1(figure):
    data, caption = figure("oren_nayar_above_1")
    theta, _ = angles(data)
    for sigma, curve in zip(data["sigmas"], data["albedo"], strict=True):
        np.testing.assert_allclose(curve[:-1], oren_nayar(theta[:-1], sigma), rtol=1e-9)
        grazing = data["grazing"][np.argmin(np.abs(data["sigma"] - sigma))]
        assert curve[-1] == pytest.approx(grazing, rel=1e-9)
    np.testing.assert_allclose(data["eon"], 1, rtol=1e-9)
    says(caption, f"up to {data['last_above']:.3f}", f"up to {100 * (1 - data['smallest_at_normal']):.0f} % is missing")
    says(caption, f"{data['largest_sigma']:.2f} with {data['largest']:.3f}")
    above = (data["grazing"] > 1) & (data["sigma"] > 0)
    assert data["sigma"][above].min() < 0.001
    assert np.diff(above.astype(int)).tolist().count(-1) == 1  # and never again


def test_albedo_derivatives(figure):
    data, caption = figure("albedo_derivatives")
    assert data["largest_difference"] < 1e-9
    says(caption, "agrees to 1e-9")
    models = [name.split(",")[0] for name in data["name"]]
    slope, known = (dict(zip(models, data[key], strict=True)) for key in ("slope", "closed"))
    assert {name for name in known if not np.isfinite(known[name]).all()} == {"Blinn-Phong"}
    mu = np.cos(np.deg2rad(data["theta_deg"]))
    np.testing.assert_allclose(slope["Minnaert"], mu**0.5 * np.log(mu), atol=1e-9)
    step, near = 1e-4, {}
    for sign in (-1, 1):
        near[f"coat {sign}"] = brdf.CoatedLambert(0.5, 1.5 + sign * step)
        near[f"blinn {sign}"] = brdf.BlinnPhong(1.0, 10 + sign * step)
    found = plot.albedos(near, data["theta_deg"])
    for name, key in (("coat", "coated Lambert"), ("blinn", "Blinn-Phong")):
        quotient = (found[f"{name} 1"].value - found[f"{name} -1"].value) / (2 * step)
        np.testing.assert_allclose(slope[key], quotient, atol=1e-7)
    assert abs(slope["Blinn-Phong"][0]) < 1e-4
    assert (slope["Blinn-Phong"] < 0).all()
    assert (slope["modified Phong"][40:] < 0).all()
    assert slope["Oren-Nayar"][0] < -0.4
    assert abs(slope["Oren-Nayar"][-1]) < 0.01
    assert (slope["coated Lambert"] < 0).all()
    says(caption, f"by {-slope['coated Lambert'][0]:.3f} per unit", f"{slope['EON'][0]:.2f} at 1°")
    assert (slope["EON"] > 1).all()


def test_blinn_normalisation(figure):
    data, caption = figure("blinn_normalisation")
    n = data["few"]
    exact = (n + 2) * (n + 4) / (8 * np.pi * (2 ** (-n / 2) + n))
    for i, factor in enumerate([exact, (n + 8) / (8 * np.pi), (n + 2) / (8 * np.pi), (n + 2) / (2 * np.pi)]):
        np.testing.assert_allclose(data["integrals"][i], factor / exact, rtol=1e-4)
        np.testing.assert_allclose(
            data["at_normal"][i][np.searchsorted(data["dense"], n[:-1])], (factor / exact)[:-1], rtol=0.02
        )
    np.testing.assert_allclose(data["at_normal"][0], 1, rtol=1e-12)
    says(caption, f"at most {100 * (data['largest_gain'] - 1):.1f} %, at n = {data['largest_gain_n']:.1f}")
    assert data["at_normal"][1, [0, -1]] == pytest.approx([1, 1], abs=0.003)
    says(caption, f"{100 * (1 - data['over_angle'][2, 0]):.0f} % at n = 10")
    assert data["at_normal"][3, -1] == pytest.approx(4, abs=0.02)
    assert (np.diff(data["over_angle"], axis=1) < 0).all()


def test_model_slices(figure):
    data, caption = figure("model_slices")
    values = {name.split(",")[0]: f for name, f in zip(data["name"], data["slice"], strict=True)}
    middle = np.deg2rad(np.arange(90) + 0.5)
    d, h = np.meshgrid(middle, middle, indexing="ij")
    mu = np.cos(d) * np.cos(h)  # of light and view alike
    np.testing.assert_allclose(values["Lommel-Seeliger"], 1 / (4 * np.pi * 2 * mu), rtol=1e-9)
    blinn = values["Blinn-Phong"]
    np.testing.assert_allclose(blinn, np.broadcast_to(blinn[0], blinn.shape), rtol=1e-9)
    half = [np.interp(-0.5, -row / row[0], np.rad2deg(middle)) for row in (blinn[0], values["modified Phong"][0])]
    assert half[0] == pytest.approx(half[1], rel=0.03)
    says(caption, "a fourth of the exponent")
    assert "n = 10" in data["name"][3]
    assert "n = 40" in data["name"][4]
    wide = [np.interp(-0.5, -row / row[0], np.rad2deg(middle)) for row in values["modified Phong"][[0, 40, 60]]]
    assert wide == sorted(wide)
    for name in ("Oren-Nayar", "Burley"):
        assert np.unravel_index(values[name].argmax(), (90, 90)) == (0, 89)
    literal = np.maximum(2 * mu**2 - np.cos(2 * d), 0) ** 10 / (np.pi * mu)
    np.testing.assert_allclose(values["literal Phong"], literal, rtol=1e-9, atol=1e-12)
    lobe = data["lobe"][3]
    tip = np.unravel_index(lobe.argmax(), lobe.shape)
    assert 90 * tip[0] / 60 == pytest.approx(float(data["incident_deg"]), abs=1.6)
    assert tip[1] in (0, lobe.shape[1] - 1)


OWN = {"Oren-Nayar": "normal", "modified Phong": "mirror", "Minnaert": "normal", "Lommel-Seeliger": "normal"}


def test_albedo_convergence(figure):
    data, caption = figure("albedo_convergence")
    names = [name.split(",")[0] for name in data["model"]]
    np.testing.assert_allclose(data["exact"][0], oren_nayar(np.pi / 3, 0.5), rtol=1e-12)
    np.testing.assert_allclose(data["exact"][1:], [0.500000000612319, 2**0.7, 0.5 - 0.25 * np.log(3)], rtol=1e-12)
    for name, chart in OWN.items():
        true, stated = (data[f"{kind}_{chart}"][names.index(name)] for kind in ("true", "stated"))
        assert (stated >= true).all(), name
        assert true[-1] < 1e-13
    digits = -np.log10(np.maximum(data["true_normal"][:, :3], 1e-16))
    assert (digits[[0, 2, 3], 1:] > np.minimum(2 * digits[[0, 2, 3], :-1], 15)).all()
    kinks = names.index("Oren-Nayar")
    assert min(data[f"true_{chart}"][kinks].min() for chart in ("mirror", "half", "product")) > 1e-7
    power = names.index("Minnaert")
    assert max(data[f"true_{chart}"][power][-1] for chart in ("normal", "mirror", "half")) < 1e-13
    counts = data["n_product"]
    for i in (kinks, power):
        order = np.polyfit(np.log(counts[1:]), np.log(data["true_product"][i][1:]), 1)[0]
        assert -2 < order < -1
    lobe = names.index("modified Phong")
    assert data["true_product"][lobe][3] < 1e-11
    assert data["n_product"][3] < data["n_mirror"][2]
    order = np.polyfit(np.log(data["n_monte_carlo"]), np.log(data["stated_monte_carlo"].T), 1)[0]
    np.testing.assert_allclose(order, -0.5, atol=0.05)
    assert (np.abs(np.log2(data["true_monte_carlo"] / data["stated_monte_carlo"])) < 1).all()  # rms of eight, and sigma
    assert (data["true_quasi_monte_carlo"][:, -1] < 0.2 * data["true_monte_carlo"][:, -1]).all()
    says(caption, "n^-1/2", "n = 100", "60°")
    others = [data[f"stated_{c}"][kinks] < data[f"true_{c}"][kinks] for c in ("mirror", "half")]
    assert np.any(others)  # "in a chart that cuts across kinks it can be"


DRAWN = {
    "albedo_models": ("albedo",),
    "coat_and_slab": ("formula_grey", "once_white", "coat_white", "slab_R", "slab_T", "slab_wrong"),
    "d3d9_repaired": ("eq6_by_view", "eq8_by_view", "repaired_by_light", "eq8_metallic_by_view", "eq8_ratio"),
    "oren_nayar_above_1": ("albedo", "eon", "grazing"),
    "albedo_derivatives": ("slope",),
    "blinn_normalisation": ("integrals", "over_angle"),
    "albedo_convergence": ("stated_normal", "stated_product", "true_monte_carlo", "true_quasi_monte_carlo"),
}


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_what_the_caption_speaks_of_is_what_is_drawn(figure, name):
    data, _ = figure(name)
    with plot.style():
        picture = plot.figure((8, 4))
        gallery.load(name).draw(data, picture)
    lines = [np.asarray(line.get_ydata(), float) for ax in picture.axes for line in ax.lines]
    for key in DRAWN[name]:
        for row in np.atleast_2d(data[key]):
            same = [line.shape == row.shape and np.allclose(line, row, rtol=1e-12, equal_nan=True) for line in lines]
            assert any(same), key


def test_the_verdicts_and_the_spheres_that_are_drawn_are_those_computed(figure):
    for name in ("energy_verdicts", "furnace_poster", "model_slices"):
        data, _ = figure(name)
        with plot.style("dark"):
            picture = plot.figure((8, 8))
            gallery.load(name).draw(data, picture)
        texts = [text.get_text() for ax in picture.axes for text in ax.texts]
        if name == "energy_verdicts":
            assert {"1.005 at 90°", "over 2.247 at 89°", "2 at 90°", "11.9", "57.3"} <= set(texts)
            dots = [line.get_xydata()[0] for line in picture.axes[0].lines if line.get_marker() == "o"]
            np.testing.assert_allclose([x for x, _ in dots], data["largest"], rtol=1e-12)
        if name == "furnace_poster":
            titles = [ax.get_title(loc="left") for ax in picture.axes[:16]]
            assert titles[0] == "Lambert\n0 %"
            assert titles[1] == "Oren-Nayar\n\N{MINUS SIGN}10.7 to +0.4 %"
        if name == "model_slices":
            meshes = [
                np.ravel(m.get_array()) for ax in picture.axes for m in ax.collections if m.get_array() is not None
            ]
            wanted = np.clip(np.pi * data["slice"], 0.05, 20.0).reshape(6, -1)
            assert all(any(m.shape == w.shape and np.allclose(m, w) for m in meshes) for w in wanted)
