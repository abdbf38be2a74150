"""The claims of the captions about pictures by wavelength."""

import numpy as np
from figure_claims import says

from jaxrefl import colour


def test_rainbow(figure):
    data, caption = figure("rainbow")
    index = np.sin(np.arccos(np.sqrt((data["n"] ** 2 - 1) / 3))), np.sin(np.arccos(np.sqrt((data["n"] ** 2 - 1) / 8)))
    for order, sine in enumerate(index, 1):
        i, r = np.arcsin(sine), np.arcsin(sine / data["n"])
        radius = np.rad2deg(np.abs(np.pi - 2 * (i - r) - order * (np.pi - 2 * r)))
        np.testing.assert_allclose(data[f"bow_{order}"], radius, rtol=1e-12)
        np.testing.assert_allclose(data[f"at_{order}"], sine, rtol=1e-6)
        says(caption, f"{radius[0]:.2f}°", f"{radius[-1]:.2f}°")
    # no traced ray leaves between the bows of its own colour
    first, last = data["angle_1"], data["angle_2"]
    bows = [data["bow_1"][[0, 30, 60]], data["bow_2"][[0, 30, 60]]]
    assert (first.max(axis=1) <= bows[0] + 1e-9).all()
    assert (last[:, data["impact"] > 0.5].min(axis=1) >= bows[1] - 1e-9).all()
    np.testing.assert_allclose(data["waves"][[0, 30, 60]], data["wavelength_nm"])
    says(caption, f"{data['bow_2'].min() - data['bow_1'].max():.2f}° wide")
    assert data["bow_1"].argmax() == data["bow_2"].argmin() == 60


def test_spectral_scenes(figure):
    data, caption = figure("spectral_scenes")
    place, day = data["metals_primitive"], data["metals_D65"]
    moved = {}
    for light in ("A", "FL11"):
        seen = data[f"metals_{light}"]
        assert np.ptp(seen[place == 5], axis=-1).max() < 1e-12
        moved |= {
            (light, i): float(colour.colour_difference(seen[place == i].mean(0), day[place == i].mean(0)))
            for i in range(5)
        }
    assert max(moved, key=moved.get) == ("FL11", 0)
    says(caption, f"CIEDE2000 {moved['FL11', 0]:.1f} under the tube, titanium by {moved['FL11', 4]:.1f}")
    assert moved["A", 4] < moved["FL11", 4]
    ball = data["glass"][data["glass_primitive"] == 0]
    assert np.ptp(ball, axis=-1).max() > 0.5
    assert np.ptp(data["glass"][data["glass_primitive"] == 1], axis=-1).max() < 1e-12
    blue, yellow = (data[f"film_{i}"][data[f"film_{i}_primitive"] == 0].mean(axis=0) for i in (0, 1))
    assert blue[2] > 1.3 * blue[1] > 1.3 * 1.3 * blue[0]
    assert yellow[0] > yellow[1] > 3 * yellow[2]


def test_spectral_against_rgb(figure):
    data, caption = figure("spectral_against_rgb")
    difference, place = data["difference"], data["primitive"]
    assert difference[(place == 5) | (place < 0)].max() < 1e-9
    titanium, aluminium, gold = (difference[place == i] for i in (4, 3, 0))
    says(
        caption,
        f"{titanium.max():.1f} at its rim",
        f"by {aluminium.max():.1f}",
        f"off by {np.median(gold):.1f} all over",
    )
    assert difference.max() == aluminium.max()
    rows, columns = np.nonzero(place == 4)
    centre, width = (rows.mean(), columns.mean()), np.ptp(columns) / 2
    worst = np.argwhere((difference == titanium.max()) & (place == 4))[0]
    assert np.hypot(*(worst - centre)) > 0.85 * width
    bright = data["spectral"][place == 0].min(axis=-1) > 0.1
    assert np.quantile(gold[bright], 0.1) > 0.7
    assert data["red_of_gold"] > 1
    says(caption, f"{data['red_of_gold']:.2f} of red")
