"""The claims of the captions of traced pictures, asserted from the numbers that the figures draw."""

import numpy as np
import pytest
from figure_claims import says

from jaxrefl import fresnel, gallery, plot


def test_glass_pane(figure):
    data, caption = figure("glass_pane")
    theta, (printed, premultiplied, exact) = data["theta_deg"], data["shown"]
    r = 0.04 + 0.96 * (1 - np.cos(np.deg2rad(theta))) ** 5
    np.testing.assert_allclose(printed, r * r + (1 - r) / 2, rtol=1e-12)
    np.testing.assert_allclose(premultiplied, r + (1 - r) / 2, rtol=1e-12)
    full = fresnel.dielectric(np.cos(np.deg2rad(theta)), 1.5)
    np.testing.assert_allclose(exact, full + (1 - full) / 2, rtol=1e-12)
    np.testing.assert_allclose(data["shown_0_80"][:2, 1], [0.46307124, 0.70495505], atol=5e-9)  # physics.md, section 4
    says(caption, *(f"{value:.3f}" for value in data["shown_0_80"][:2, 1]))
    np.testing.assert_allclose(data["from_reflection_0"][:2], [0.0016, 0.04], rtol=1e-14)
    says(caption, "0.0016 instead of 0.04", f"{printed.min():.4f} at {theta[printed.argmin()]:.1f}°")
    darker = printed < 0.5
    assert darker[: darker.sum()].all()
    says(caption, f"up to {theta[darker][-1]:.1f}°", f"{np.abs(premultiplied - exact).max():.3f}")
    background = np.where((np.arange(720) // 60 + np.arange(80)[:, None] // 20) % 2 == 0, 0.4, 0.6)
    np.testing.assert_allclose(data["strips"][0][20:], (r * r + (1 - r) * background)[20:], rtol=1e-12)
    np.testing.assert_array_equal(data["strips"][:, :20], np.broadcast_to(background[:20], (3, 20, 720)))


def test_intersection_tests(figure):
    data, caption = figure("intersection_tests")
    n = data["primitives"]
    np.testing.assert_array_equal(n, [2, 4, 8, 16, 32, 64])
    assert data["tests"].size == 43200
    assert data["tests"].sum() == data["total"] == pytest.approx(data["mean"][-1] * 43200)
    says(caption, "43 200", f"{data['mean'][-1]:.0f} tests", f"{data['largest'][-1]:.0f} for the worst")
    says(caption, f"{data['total'] / 1e6:.1f} million")
    np.testing.assert_array_equal(data["largest"], 18 * n)  # six rays, each with a hit that asks two lights
    assert {*np.unique(data["tests"]) / 64} == {1, 4, 7, 10, 13, 16, 18}
    assert (data["tests"][:10, 0] == 64).all()
    assert (np.diff(data["mean"] / n) > 0).all()
    says(caption, "18 tests per primitive", f"from {data['mean'][0] / n[0]:.1f} to {data['mean'][-1] / n[-1]:.1f}")


def test_budget_map(figure):
    data, caption = figure("budget_map")
    perrin, glass, jhu, d3d9 = data["excess"]
    assert max(np.abs(perrin).max(), np.abs(glass).max()) < 1e-14
    says(caption, "none, to 1e-14")
    levels = 1 - 0.5 ** np.arange(9)  # 0.5 + 0.25 + ..., as many as surfaces were met
    np.testing.assert_allclose(jhu, levels[np.abs(jhu[..., None] - levels).argmin(-1)], atol=1e-12)
    says(caption, f"{data['smallest'][2]:.1f} wherever", f"{data['mean'][2]:.3f} on", f"{data['largest'][2]:.3f}")
    assert data["smallest"][3] == pytest.approx(0.04, abs=1e-6)
    assert (d3d9 >= -1e-12).all()
    ground = d3d9[:, 0][d3d9[:, 0] > 0]
    assert (np.diff(ground) < 0).all()
    says(caption, f"{data['smallest'][3]:.3f} where", f"{ground[0]:.2f} on the ground", f"{data['largest'][3]:.3f}")


def test_ray_tracing_deficiencies(figure):
    data, caption = figure("ray_tracing_deficiencies")
    rho = data["rho"][:, None]
    np.testing.assert_allclose(data["traced"], np.broadcast_to(rho, data["traced"].shape), rtol=1e-12)
    np.testing.assert_allclose(data["repaired"], np.broadcast_to(rho / (1 - rho), data["repaired"].shape), rtol=1e-12)
    at = np.argmin(np.abs(data["rho"] - 0.9))
    assert data["repaired"][at, 0] / data["traced"][at, 0] == pytest.approx(10)
    says(caption, "a tenth of the truth")

    eye, lamp, image = np.array([0, -5, 1.6]), np.array([0, 0, 1.3]), np.array([0, 0, -1.3])
    distance = np.linalg.norm(eye - image)
    np.testing.assert_allclose(
        data["image_deg"], 2 * np.rad2deg(np.arcsin(data["radius"] / distance)), rtol=0.015
    )  # a pixel is 1 %
    spot = eye + (image - eye) * 1.6 / 2.9
    x = np.linspace(-2, 2, 40001)[:, None]
    p = spot + x * [1, 0, 0]
    to_eye, to_lamp = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (eye - p, lamp - p))
    half = to_eye + to_lamp
    cosine = (half / np.linalg.norm(half, axis=1, keepdims=True))[:, 2]
    for n, width in zip(data["exponent"], data["highlight_deg"], strict=True):
        reach = np.abs(x[cosine**n >= 0.5]).max()
        assert width == pytest.approx(2 * np.rad2deg(np.arctan(reach / np.linalg.norm(spot - eye))), rel=0.01)
    says(caption, ", ".join(f"{w:.1f}°" for w in data["highlight_deg"]), "n = 30, 120, 480")
    says(caption, f"{data['highlight_deg'][1]:.1f}° wide", f"{2 * np.rad2deg(np.arcsin(0.15 / distance)):.1f}°")
    says(caption, f"({data['image_deg'][0]:.1f}° to {data['image_deg'][-1]:.1f}°)")
    np.testing.assert_allclose(data["pictures"].max((1, 2)) >= 1.0, True)  # the lamp is in each of them


def test_derivative_images(figure):
    data, caption = figure("derivative_images")
    assert data["slopes"].shape == (6, 120, 160)
    np.testing.assert_array_equal(data["compared"], 120 * 160)
    says(caption, "160 by 120", "19 200", "to 1e-7", "to 1e-5")
    assert data["worst"][:4].max() < 1e-7
    assert data["worst"][4:].max() < 1e-5
    assert (np.abs(data["slopes"]).max((1, 2)) > 1e-3).all()


def test_contact_sheet(figure):
    data, caption = figure("contact_sheet")
    primitive, hit = data["primitive"], data["primitive"] >= 0
    assert {*np.unique(primitive)} == set(range(-1, 7))
    for number, distance in enumerate(data["distance"]):
        nearest = data["depth"][primitive == number].min()
        assert distance <= nearest < distance * 1.001
    assert data["distance"].argmin() == 3
    says(caption, f"{data['depth'][primitive == 3].min():.2f} away")
    np.testing.assert_allclose(np.linalg.norm(data["normal"], axis=-1)[hit], 1, rtol=1e-12)
    glass, floor = (data["alpha"][primitive == number] for number in (4, 6))
    assert glass.min() == pytest.approx(1 - 0.9 * 0.96, abs=1e-6)
    says(caption, f"{glass.min():.3f}", f"{glass.max():.2f} at its rim", f"{floor.min():.2f} to {floor.max():.2f}")
    assert data["bounces"].max() == 5
    more = data["hits"] - data["bounces"]
    assert {*np.unique(more)} == {0, 1}
    says(caption, f"{data['bounces'].mean():.2f} bounces", f"{100 * more.mean():.1f} % of pixels")
    assert not (data["primitive_edges"] & ~data["path_edges"]).any()
    for key in ("primitive_edges", "path_edges"):
        says(caption, f"{100 * data[key].mean():.1f} %")


DRAWN = {
    "budget_map": ("excess",),
    "contact_sheet": ("depth", "primitive", "alpha", "bounces", "hits"),
    "derivative_images": ("slopes", "worst"),
    "glass_pane": ("shown",),
    "intersection_tests": ("tests", "mean", "largest"),
    "ray_tracing_deficiencies": ("highlight", "image", "image_deg"),
}


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_what_the_caption_speaks_of_is_what_is_drawn(figure, name):
    data, _ = figure(name)
    with plot.style():
        picture = plot.figure((8, 4))
        gallery.load(name).draw(data, picture)
    shown = [np.asarray(line.get_ydata(), float) for ax in picture.axes for line in ax.lines]
    shown += [np.asarray(image.get_array().filled(np.nan), float) for ax in picture.axes for image in ax.images]
    shown += [np.asarray(dots.get_offsets())[:, 1] for ax in picture.axes for dots in ax.collections]
    for key in DRAWN[name]:
        values = np.asarray(data[key], float)
        for wanted in values if values.ndim == 3 or (name, key) == ("glass_pane", "shown") else [values]:
            wanted = np.where(np.isfinite(wanted), wanted, np.nan)
            assert any(s.shape == wanted.shape and np.array_equal(s, wanted, equal_nan=True) for s in shown), key


def test_normals_categories_strips_and_bars_are_what_they_are_made_of():
    normal = np.zeros((2, 3, 3))
    normal[0, :, 2], normal[1, 0] = 1, [-1, 0, 0]
    shown = np.asarray(plot.normals(normal).get_array())
    np.testing.assert_allclose(shown[0, 0], [0.5, 0.5, 1], atol=1e-6)
    np.testing.assert_allclose(shown[1, 0], [0, 0.5, 0.5], atol=1e-6)
    np.testing.assert_array_equal(shown[1, 1], 0)
    numbers = np.array([[-1, 0, 0], [1, 1, 8]])
    image = plot.categories(numbers, ax=(ax := plot.axes()))
    assert sorted(text.get_text() for text in ax.texts) == ["0", "1", "8"]
    assert len({tuple(image.cmap(image.norm(n))) for n in range(-1, 9)}) == 10
    strip = plot.strip(np.ones((2, 4)), (0, 90))
    assert tuple(strip.get_extent()) == (0, 90, 0, 1)
    bars = plot.bars(ax := plot.axes(), [1, 2], [3.0, 4.0], labels=["a", "b"])
    assert [bar.get_height() for bar in bars] == [3, 4]
    assert [text.get_text() for text in ax.texts] == ["a", "b"]
