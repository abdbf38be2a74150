"""The claims of the captions about the colours of metals."""

import colour as science
import numpy as np
import pytest
from figure_claims import at, says

from jaxrefl.materials import materials


def difference(rgb_1, rgb_2):
    """CIEDE2000 by colour-science alone."""
    lab = [science.XYZ_to_Lab(science.sRGB_to_XYZ(rgb, apply_cctf_decoding=False)) for rgb in (rgb_1, rgb_2)]
    return science.delta_E(*lab, method="CIE 2000")


def test_metals_wall(figure):
    data, caption = figure("metals_wall")
    assert (data["metal"].size, data["light"].tolist()) == (12, ["D65", "A", "FL11"])
    says(caption, "Twelve metals", "D65, A and FL11")
    spread, change = data["spread"], data["change"]
    for metal, count, far in zip(data["metal"], data["sources"], spread, strict=True):
        known = materials()[metal]
        assert data["source"][data["metal_of"] == metal][0] == known[0]  # innermost
        assert count <= len(known)
        rgb = data["rgb"][data["metal_of"] == metal][:, 0]
        assert far == pytest.approx(max(difference(a, b) for a in rgb for b in rgb), abs=0.01)
    gold = data["metal"] == "Au"
    says(caption, f"CIEDE2000 {change.max():.1f}, and that is gold")
    assert change[gold] == change.max()
    others = ~gold & (data["sources"] > 1)
    ratio = (spread / change)[others]
    more = ratio[ratio > 1]
    assert (others.sum(), more.size) == (7, 6)
    says(
        caption,
        "seven others",
        f"six differ by them more than by the lights, at least {np.floor(10 * more.min()) / 10:.1f} times",
        f"titanium by {spread.max():.1f}",
    )
    assert data["metal"][spread.argmax()] == "Ti"
    pale = np.isin(data["metal"], ["Ag", "Al"])
    says(caption, f"everywhere to {np.maximum(spread, change)[pale].max():.1f}")
    middle = data["picture"].shape[0] // 6
    first = np.clip(data["rgb"][data["metal_of"] == "Ti"][0, 0], 0, 1)
    column = np.flatnonzero(data["metal"] == "Ti")[0]
    np.testing.assert_allclose(data["picture"][middle, middle * (2 * column + 1)], first, rtol=1e-12)


def test_metal_angles(figure):
    data, caption = figure("metal_angles")
    exact, schlick, f82 = np.moveaxis(data["rgb"], 1, 0)
    for approximate, far in zip((schlick, f82), np.moveaxis(data["difference"], 1, 0), strict=True):
        np.testing.assert_allclose(far, difference(approximate, exact), atol=0.01)
        np.testing.assert_allclose(approximate[:, 0], exact[:, 0], rtol=1e-12)
    names, worst = data["metal"].tolist(), data["difference"].max(axis=-1)
    for name, text in (("titanium", "CIEDE2000 {:.1f} on"), ("aluminium", "{:.1f} on"), ("gold", "{:.1f} on")):
        says(caption, text.format(worst[names.index(name), 0]) + " " + name)
    says(caption, f"{worst[names.index('copper'), 0]:.1f} on copper, all beyond 80°")
    assert (data["theta_deg"][data["difference"][:, 0].argmax(axis=-1)] > 80).all()
    metal, angle = np.unravel_index(data["difference"][:, 1].argmax(), data["difference"][:, 1].shape)
    assert names[metal] == "gold"
    says(caption, f"more than {worst[metal, 1]:.2f}, on gold at {data['theta_deg'][angle]:g}°")
    says(caption, f"where Schlick's is by {data['difference'][metal, 0, angle]:.2f}")
    hit = np.rad2deg(np.arccos(1 / 7))
    says(caption, f"at {hit:.1f}° too")
    assert (at(data, "difference", hit)[:, 1] < 0.12).all()  # the nearest angle is a tenth of a degree away
    assert (schlick.min(axis=1) >= schlick[:, [0, -1]].min(axis=1) - 1e-12).all()
    assert (exact.min(axis=1) < exact[:, 0] - 1e-3).any(axis=1).all()


def test_gold_chromaticity(figure):
    data, caption = figure("gold_chromaticity")
    white = data["white"]
    np.testing.assert_allclose(white, [0.3127, 0.3290], atol=1e-4)
    np.testing.assert_allclose(data["xy"][:, -1], np.broadcast_to(white, (4, 2)), atol=1e-12)
    away = np.linalg.norm(data["xy"][0] - white, axis=-1)
    assert (np.diff(away) < 1e-6).all()
    says(caption, f"half way at {data['theta_deg'][np.argmax(away < away[0] / 2)]:.1f}°")
    corners = data["triangle"][:3]
    np.testing.assert_allclose(corners, [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]], rtol=1e-12)
    edges = np.roll(corners, -1, axis=0) - corners
    offset = data["xy"][..., None, :] - corners
    assert (edges[:, 0] * offset[..., 1] > edges[:, 1] * offset[..., 0]).all()
    red, rest = data["rgb"][0, :, 0], data["rgb"][0, :, 1:]
    assert 0 < rest.min() < rest.max() < 1 + 1e-12
    says(caption, f"{red[0]:.3f} at 0°", f"above 1 up to {data['theta_deg'][np.argmax(red <= 1) - 1]:.1f}°")
    far = dict(zip(data["source"].tolist(), difference(data["rgb"][:, 0], data["rgb"][0, 0]), strict=True))
    says(caption, f"Johnson's gold is CIEDE2000 {far['Johnson']:.1f}", f"McPeak's {far['McPeak']:.1f}")
    says(caption, f"Olmon's {far['Olmon']:.1f}")
    np.testing.assert_allclose(data["difference"], list(far.values()), atol=0.01)
    locus = science.XYZ_to_xy(science.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"][data["wavelength_nm"]])
    np.testing.assert_allclose(data["locus"], locus, rtol=1e-12)
