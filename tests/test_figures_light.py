"""The claims of the captions about lights, local illumination, self-shadowing, the source scenes and bounces."""

import numpy as np
import pytest
from figure_claims import says

from jaxrefl import gallery, plot, scene, scene_file
from jaxrefl.image import encode_srgb


def test_phong_lobes(figure):
    data, caption = figure("phong_lobes")
    half = np.rad2deg(np.arccos(0.5 ** (1 / data["many"])))
    np.testing.assert_allclose(data["blinn_radius_deg"], half, rtol=1e-12)
    np.testing.assert_allclose(data["phong_radius_deg"], half / 2, rtol=1e-12)
    small, large = data["phong_n_radius_deg"], data["blinn_n_radius_deg"]
    says(caption, f"n = {data['n']:g}", f"{large:.1f}°, Phong's at {small:.1f}°")
    np.testing.assert_allclose(data["picture_radius_deg"], [small, large, small], atol=0.25)  # a pixel is 0.8 degrees
    tilt, n = np.deg2rad(data["tilt_deg"]), data["n"]
    np.testing.assert_allclose(data["phong_n"], np.cos(2 * tilt) ** n, rtol=1e-12)
    np.testing.assert_allclose(data["blinn_n"], np.cos(tilt) ** n, rtol=1e-12)
    np.testing.assert_allclose(data["blinn_4n"], np.cos(tilt) ** (4 * n), rtol=1e-12)
    for lobe in (*data["phong"], *data["blinn"]):
        assert np.rad2deg(data["out"][lobe.argmax()]) == pytest.approx(data["incident_deg"])
    says(caption, f"from {data['incident_deg']:g}°", f"{data['gap']:.4f} at most", "e^-2 / n")
    assert np.abs(data["blinn_4n"] - data["phong_n"]).max() == pytest.approx(float(data["gap"]), rel=1e-4)
    times_n = data["difference"] * data["many"]
    assert (np.diff(times_n) < 0).all()
    assert times_n[-1] == pytest.approx(np.exp(-2), rel=1e-3)


def test_light_profiles(figure):
    data, caption = figure("light_profiles")
    cosine = np.cos(np.deg2rad(data["angle_deg"]))[None]
    np.testing.assert_allclose(data["effect"], cosine ** data["exponents"][:, None], rtol=1e-12, atol=1e-15)
    (_, (s, cutoff), _), inside = data["spots"], data["angle_deg"] <= data["cutoff_deg"]
    np.testing.assert_allclose(data["effect_cut"], np.where(inside, cosine[0] ** s, 0), rtol=1e-12)
    half = data["angle_deg"][np.argmin(np.abs(data["effect"][2] - 0.5))]
    says(caption, f"s = {data['exponents'][2]:g}", f"half {half:.1f}°", f"at {cutoff:g}°")
    d, fall = data["distance"], data["attenuation"]
    np.testing.assert_allclose(fall * (data["laws"] @ [np.ones_like(d), d, d * d]), 1, rtol=1e-12)
    slope = np.diff(np.log2(fall), axis=1) / np.diff(np.log2(d))
    np.testing.assert_allclose(slope[-1], -2, rtol=1e-10)  # a fourth at twice the distance
    assert (slope[:-1] > -1.95).all()
    assert (fall[:-1] <= 1).all()
    np.testing.assert_array_equal(fall[-1] > 1 + 1e-12, d < 1 - 1e-12)
    expected = np.zeros_like(data["x"])
    for (s, cutoff), place in zip(data["spots"], data["below"], strict=True):
        angle = np.arctan(np.abs(data["x"] - place) / data["height"])
        expected += np.where(angle <= np.deg2rad(cutoff), np.cos(angle) ** (s + 3), 0)
    np.testing.assert_allclose(data["row"], expected, atol=1e-12)
    np.testing.assert_allclose(data["expected"], expected, atol=1e-12)
    says(caption, f"ends it {data['edge']:.2f} m", f"s = 0 still shows {data['at_edge'][1]:.2f}")
    says(caption, f"s = 10 only {data['at_edge'][0]:.2f}", f"{data['height']:g} m high")
    reach = np.abs(data["x"][data["row"] > 0.5] - data["below"][2])
    assert reach[reach < 1.5].max() == pytest.approx(float(data["edge"]), abs=0.03)  # a pixel


def test_local_illumination(figure):
    data, caption = figure("local_illumination")
    assert data["defect"] < 1e-6
    for name in ("diffuse", "specular"):
        says(caption, "1 : " + " : ".join(f"{x:.2f}".rstrip("0").rstrip(".") for x in data[f"{name}_ratio"][1:]))
    on = data["ambient"][..., 0] > 0
    assert 0.5 < on.mean() < 0.7
    np.testing.assert_allclose(data["emission"][on], np.broadcast_to([0, 0.006, 0.05], (on.sum(), 3)), rtol=1e-12)
    np.testing.assert_allclose(data["ambient"][on], np.broadcast_to(0.15 * np.array([0.75, 0.05, 0.05]), (on.sum(), 3)))
    np.testing.assert_allclose(data["diffuse"][..., 0], 15 * data["diffuse"][..., 1], rtol=1e-12)
    assert data["diffuse"].max() == pytest.approx(0.75, rel=1e-3)
    assert data["specular"].max() == pytest.approx(0.8, rel=1e-3)
    for name in ("emission", "ambient", "diffuse", "specular"):
        assert (data[name][~on] == 0).all()
    without, lifted = data["without_highlight"], data["with_highlight"]
    says(caption, f"green from {without[1]:.2f} to {lifted[1]:.2f}", f"to {lifted[0]:.2f}")
    assert lifted[0] - without[0] == pytest.approx(lifted[1] - without[1], rel=1e-12)


def test_self_shadowing(figure):
    data, caption = figure("self_shadowing")
    assert (data["pictures"].dtype, data["exact"].dtype) == (np.float32, np.float64)
    np.testing.assert_array_equal(data["places"], [0, 2e4])
    says(caption, "2 m wide", "1 mm", "20 km", "steps of 2 mm", "more than 0.05")
    assert data["epsilon"] == 1e-3
    assert data["step"] == pytest.approx(2e-3, rel=0.05)
    names = list(data["remedies"])
    ball, glass = (dict(zip(names, data[f"wrong_{what}"].T, strict=True)) for what in ("ball", "glass"))
    says(caption, "more than 20 % of the orange one and 70 % of the glass", "leaves less than 0.1 %")
    assert (ball["none"] > 0.2).all()
    assert (glass["none"] > 0.7).all()
    for name in ("tolerance", "nudge", "offset"):
        assert max(ball[name][0], glass[name][0]) < 1e-3
        assert ball[name][1] > 0.15
        assert glass[name][1] > 0.2
    says(caption, "each leaves more than 15 % and 20 %", "less than 0.2 % there", "more than 95 % of the glass")
    assert ball["skip"][0] == glass["skip"][0] == 0
    assert max(ball["skip"][1], glass["skip"][1]) < 2e-3
    assert (glass["left_out"] > 0.95).all()
    assert (ball["left_out"] < 0.1).all()


def test_source_scenes(figure):
    data, caption = figure("source_scenes")
    assert sorted(data["names"]) == scene_file.examples()
    primitives = {}
    for name in data["names"]:
        numbers = scene.primitive_names(scene_file.load(scene_file.example(name)).scene)
        primitives[name] = np.array([*numbers, "none"])[data[f"{name}_primitive"]]
    assert np.abs(data["perrin_excess"]).max() < 1e-14
    worst = {name: data[f"{name}_excess"].max() for name in ("jhu", "d3d9")}
    says(caption, f"up to {worst['jhu']:.1f} too much", f"up to {worst['d3d9']:.1f} too much")
    assert primitives["jhu"].ravel()[data["jhu_excess"].argmax()] == "glass"
    sea = np.where(primitives["d3d9"] == "sea", data["d3d9_excess"], np.nan)
    middle = np.nanmedian(sea[~np.isnan(sea).all(axis=1)], axis=1)
    assert middle[0] > 0.9
    assert middle[0] > 4 * middle[-1] > 0
    assert data["fresnel_excess"].max() < 1e-14
    says(caption, f"up to {-data['fresnel_excess'].min():.2f}")
    for name in ("aluminium", "copper", "gold", "droplets"):
        assert (data["fresnel_excess"][primitives["fresnel"] == name] < -1e-3).all()


def test_bounces(figure):
    data, caption = figure("bounces")
    assert data["defect"] < 1e-14
    alpha, n = data["reflectivity"], data["bounce"][1:]
    bound = alpha**n * data["brightest"]
    np.testing.assert_allclose(data["bound"][:-1], bound, rtol=1e-13)
    largest, mean = data["change_max"][1:], data["change_mean"][1:]
    assert (largest <= bound).all()
    assert (largest > 0.6 * bound).all()
    says(caption, f" = {alpha:g}: ", f"{largest[9]:.3f} under {bound[9]:.3f} at n = 10")
    says(caption, f"from {mean[0]:.3f} at n = 1", f"to {mean[9]:.4f} at n = 10")
    assert (mean[1:10] / mean[:9] < alpha).all()
    assert data["left"].max() == pytest.approx(alpha**11, rel=1e-12)
    says(caption, f"{data['left'].max():.3f} = ")
    np.testing.assert_array_equal(data["shown"], [0, 1, 2, 3, 5, 10])
    sums = np.cumsum(data["change_mean"])
    np.testing.assert_allclose(data["pictures"].mean(axis=(1, 2, 3)), sums[data["shown"]], rtol=1e-12)


DRAWN = {
    "bounces": ("pictures", "left", "bound:head", "change_max:tail", "change_mean:tail"),
    "light_profiles": ("effect:rows", "effect_cut", "attenuation:rows", "row", "expected"),
    "local_illumination": ("emission", "ambient", "diffuse", "specular", "full"),
    "phong_lobes": ("phong_n", "blinn_n", "blinn_4n", "difference", "picture"),
    "self_shadowing": ("pictures:each", "exact"),
    "source_scenes": ("perrin", "jhu", "d3d9", "fresnel", "jhu_excess", "d3d9_excess", "fresnel_excess"),
}


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_what_the_caption_speaks_of_is_what_is_drawn(figure, name):
    data, _ = figure(name)
    with plot.style():
        picture = plot.figure((8, 4))
        gallery.load(name).draw(data, picture)
    shown = [np.asarray(line.get_ydata(), float) for ax in picture.axes for line in ax.lines]
    shown += [np.asarray(image.get_array(), float) for ax in picture.axes for image in ax.images]
    for key, _, how in (entry.partition(":") for entry in DRAWN[name]):
        value = np.asarray(data[key])
        value = {"head": value[:-1], "tail": value[1:]}.get(how, value)
        is_picture = value.ndim > 2
        many = value.reshape(-1, *value.shape[-3:]) if is_picture else value if how == "rows" else [value]
        for wanted in many:
            wanted = np.asarray(encode_srgb(wanted) if is_picture else wanted, float)
            assert any(s.shape == wanted.shape and np.allclose(s, wanted, rtol=1e-6) for s in shown), key
