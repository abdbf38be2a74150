"""The claims of the captions about thin films."""

import numpy as np
import pytest
from figure_claims import says

from jaxrefl import colour

pytestmark = pytest.mark.usefixtures("quick_compilation")


def test_antireflection(figure):
    data, caption = figure("antireflection")
    bare, one, two, three = 100 * data["over_wavelength"]
    w, glass = data["wavelength_nm"], data["glass"]
    centre = np.argmin(np.abs(w - data["design_nm"]))
    says(caption, f"n = {glass:g}", f"{bare[centre]:.2f} %", f"{one[centre]:.2f} % at 550 nm")
    np.testing.assert_allclose(bare, 100 * ((glass - 1) / (glass + 1)) ** 2, rtol=1e-12)
    np.testing.assert_allclose(one[centre], 100 * ((glass - 1.38**2) / (glass + 1.38**2)) ** 2, rtol=1e-12)
    np.testing.assert_allclose(
        two[centre], 100 * ((1.38**2 * glass / 1.7**2 - 1) / (1.38**2 * glass / 1.7**2 + 1)) ** 2
    )
    assert two[centre] < 1e-3
    better, low = w[two < one], w[three < 0.8]
    says(caption, f"below {better[0]:.0f} nm and above {better[-1]:.0f} nm")
    says(caption, f"below 0.8 % from {low[0]:.0f} to {low[-1]:.0f} nm")
    assert ((three < 0.8) == ((w >= low[0]) & (w <= low[-1]))).all()
    aslant = 100 * data["over_angle"][:, data["theta_deg"] == 60][:, 0]
    says(caption, ", ".join(f"{r:.2f}" for r in aslant[:3]) + f" and {aslant[3]:.2f} %")
    np.testing.assert_allclose(data["over_angle"][:, -1], 1, rtol=1e-12)


def test_soap_film(figure):
    data, caption = figure("soap_film")
    d, bands, brightest = data["thickness_nm"], data["bands"], data["brightest_nm"]
    n = np.interp(data["wavelength_nm"], np.arange(380, 781, 5), data["index"])
    r2 = ((n - 1) / (n + 1)) ** 2
    airy = 4 * r2 * np.sin(2 * np.pi * n * d[:, None] / data["wavelength_nm"]) ** 2  # over (1 - r^2)^2 + the same
    np.testing.assert_allclose(bands, airy / ((1 - r2) ** 2 + airy), rtol=1e-10, atol=1e-15)
    says(caption, "under 12 nm is black, R < 0.5 %", f"{100 * data['luminance'].max():.1f} %", f"at {brightest:.0f} nm")
    assert bands[d <= 12].max() < 0.005
    assert abs(brightest - 550 / (4 * n[1])) < 3
    chroma = data["chroma"]
    says(caption, f"reached {chroma.max():.0f}", "beyond 1200 nm", "below 18")
    assert chroma[d >= 1200].max() < 18
    assert chroma[np.argmax(d >= brightest)] < 12  # nearly white
    purple = (d > 150) & (d < 400)  # the first of them, between the first two orders: the least share of green
    share = data["shown"][:, purple, 1] / data["shown"][:, purple].sum(axis=-1)
    thickness = d[purple][share.argmin(axis=1)]
    cosine = np.sqrt(1 - (np.sin(np.deg2rad(data["theta_deg"])) / n[1]) ** 2)
    np.testing.assert_allclose(thickness * cosine, thickness[0], rtol=0.04)  # what the path difference depends on


def test_anodised_titanium(figure):
    data, caption = figure("anodised_titanium")
    d, rgb, lowest = data["thickness_nm"], data["rgb"][0], data["lowest_nm"]
    index = np.interp(550, data["wavelength_nm"], data["index"])
    flat, aslant = lowest[0, d == 50][0], lowest[data["theta_deg"] == 60][0, d == 50][0]
    says(
        caption,
        f"at {aslant:.0f} nm, not at {flat:.0f} nm",
        f"{100 * (1 - aslant / flat):.0f} % only",
        f"{index:.2f} at 550",
    )
    assert aslant / flat == pytest.approx(np.sqrt(1 - 0.75 / index**2), abs=0.01)
    for name, where, order in (
        ("bronze", 28, "RGB"),
        ("purple", 40, "BRG"),
        ("blue", 52, "BGR"),
        ("yellow", 116, "RGB"),
        ("pink", 150, "BRG"),
    ):
        says(caption, f"{name} ({where} nm)")
        assert "".join("RGB"[i] for i in np.argsort(-rgb[d == where][0])) == order
    bare = rgb[0]
    assert bare.max() / bare.min() < 1.15  # the metal is nearly grey
    first = lowest[0, (d >= 22) & (d <= 60)]
    assert (np.diff(first) > 0).all()
    assert (first[0], first[-1]) == pytest.approx((390, 745), abs=10)


def test_bragg_mirror(figure):
    data, caption = figure("bragg_mirror")
    high, low, glass = data["n"]
    edges, w = data["band_nm"], data["wavelength_nm"]
    says(caption, f"from {edges[0]:.0f} to {edges[1]:.0f} nm")
    inside = (w > edges[0]) & (w < edges[1])
    least = data["over_wavelength"][:, inside].min(axis=1)
    assert (np.diff(least) > 0).all()
    assert least[-1] > 0.99
    assert data["over_wavelength"][-1, ~inside].max() < 0.995
    cosine = np.cos(np.pi / 2 * 550 / w) ** 2 - 0.5 * (high / low + low / high) * np.sin(np.pi / 2 * 550 / w) ** 2
    np.testing.assert_array_equal(np.abs(cosine) > 1, inside)  # Bloch waves of endless pairs decay there
    y = glass * (high / low) ** (2 * data["pairs"].astype(float))
    np.testing.assert_allclose(data["through"], 4 * y / (1 + y) ** 2, rtol=1e-10)
    orders = np.log10(data["through"][0] / data["through"][-1])
    says(caption, f"{(low / high) ** 2:.2f} of what", f"through {orders:.0f} orders of magnitude")
    r_s, r_p = data["over_angle"]
    says(caption, "R > 0.999", f"at {data['theta_deg'][r_p.argmin()]:.1f}°", "R < 0.001")
    assert r_s.min() > 0.999
    assert r_p.min() < 0.001


def test_film_design(figure):
    data, caption = figure("film_design")
    start, ends = data["rgb"][:, 0], data["rgb"][:, -1]
    np.testing.assert_array_equal(start, start[:1].repeat(3, axis=0))
    lab = np.asarray(colour.rgb_to_lab(start[0]))
    says(caption, f"chroma {np.hypot(*lab[1:]):.1f}", "300 steps", "within 0.04 of CIEDE2000", "(0.3 nm)")
    assert start.max() / start.min() < 1.1
    assert data["rgb"].shape == (3, 300, 3)
    np.testing.assert_allclose(ends, data["targets"], atol=1e-3)
    assert data["ciede2000"].max() < 0.04
    assert data["ciede2000"].max() > 0.02
    assert (data["distance"][:, 0] > 30).all()
    assert data["thickness_nm"][1, 0] == pytest.approx(0.3, abs=0.05)
    assert (data["thickness_nm"] >= 0).all()
