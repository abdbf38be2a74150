"""Colours against colour-science called directly, published pairs and values, finite differences."""

import subprocess
import sys

import colour as science
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import colour, fresnel
from jaxrefl.materials import material

GRIDS = [np.arange(360.0, 781, 5), np.arange(360.0, 781, 1)]
OBSERVERS = [colour.OBSERVER, "CIE 1964 10 Degree Standard Observer"]
RNG = np.random.default_rng(7)

# Sharma, Wu & Dalal, Color Research and Application 30(1), 2005, table 1: Lab, Lab, CIEDE2000
SHARMA = np.fromstring(
    """50 2.6772 -79.7751 50 0 -82.7485 2.0425   50 3.1571 -77.2803 50 0 -82.7485 2.8615
    50 2.8361 -74.02 50 0 -82.7485 3.4412   50 -1.3802 -84.2814 50 0 -82.7485 1   50 -1.1848 -84.8006 50 0 -82.7485 1
    50 -.9009 -85.5211 50 0 -82.7485 1   50 0 0 50 -1 2 2.3669   50 -1 2 50 0 0 2.3669
    50 2.49 -.001 50 -2.49 .0009 7.1792   50 2.49 -.001 50 -2.49 .0011 7.2195   50 2.49 -.001 50 -2.49 .0012 7.2195
    50 -.001 2.49 50 .0009 -2.49 4.8045   50 -.001 2.49 50 .0011 -2.49 4.7461   50 2.5 0 50 0 -2.5 4.3065
    50 2.5 0 73 25 -18 27.1492   50 2.5 0 61 -5 29 22.8977   50 2.5 0 56 -27 -3 31.903   50 2.5 0 58 24 15 19.4535
    50 2.5 0 50 3.1736 .5854 1   50 2.5 0 50 3.2972 0 1   50 2.5 0 50 1.8634 .5757 1   50 2.5 0 50 3.2592 .335 1
    60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644   63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.263
    61.2901 3.7196 -5.3901 61.4292 2.248 -4.962 1.8731   35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
    22.7233 20.0904 -46.694 23.0331 14.973 -42.5619 2.0373   36.4612 47.858 18.3852 36.2715 50.5065 21.2231 1.4146
    90.8027 -2.0831 1.441 91.1528 -1.6435 .0447 1.4441   90.9257 -.5406 -.9208 88.6381 -.8985 -.7239 1.5381
    6.7747 -.2908 -2.4247 5.8714 -.0985 -2.2286 .6377   2.0776 .0795 -1.135 .9033 -.0636 -.5514 .9082""",
    sep=" ",
).reshape(-1, 7)

# physicallybased.info, version 2, linear sRGB, and the measurement that reproduces it
PUBLISHED = {
    "Au": ("Babar", (1.059, 0.773, 0.307)),
    "Ag": ("Babar", (0.991, 0.985, 0.974)),
    "Cu": ("Johnson", (0.932, 0.623, 0.522)),
}


def integrated(w, reflectance, illuminant, observer):
    """XYZ by colour-science's own sum."""
    shape = science.SpectralShape(w[0], w[-1], w[1] - w[0])
    seen = science.MSDS_CMFS[observer].copy().align(shape)
    light = science.SDS_ILLUMINANTS[illuminant].copy().align(shape)
    spectrum = science.SpectralDistribution(reflectance, w)
    return science.sd_to_XYZ(spectrum, seen, light, method="Integration") / 100


def reflectance(w, name, source=None):
    """At normal incidence."""
    index = material(name, source)(w)
    complex_index = np.asarray(index.n) + 1j * np.asarray(index.k)
    return np.abs((complex_index - 1) / (complex_index + 1)) ** 2


@pytest.mark.parametrize("w", GRIDS, ids=["5 nm", "1 nm"])
@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("illuminant", ["D65", "A", "FL11", "LED-B3"])
def test_the_matrix_is_the_sum_of_colour_science_on_its_grids(w, illuminant, observer):
    spectrum = RNG.uniform(size=w.size)
    expected = integrated(w, spectrum, illuminant, observer)
    np.testing.assert_allclose(spectrum @ colour.xyz_matrix(w, illuminant, observer), expected, rtol=1e-13)
    np.testing.assert_allclose(colour.spectrum_to_xyz(spectrum, w, illuminant, observer), expected, rtol=1e-13)


@pytest.mark.parametrize(
    "w", [[550.0], [440, 540, 640], [300, 401.5, 402, 577.25, 779, 900], np.linspace(420, 680, 16)]
)
def test_between_the_wavelengths_a_spectrum_is_linear_and_outside_them_constant(w):
    w, fine = np.asarray(w, float), GRIDS[1]
    spectrum = RNG.uniform(size=w.size)
    expected = integrated(fine, np.interp(fine, w, spectrum), "FL11", colour.OBSERVER)
    np.testing.assert_allclose(spectrum @ colour.xyz_matrix(w, "FL11"), expected, rtol=1e-13)


def test_a_perfect_reflector_is_exactly_white_under_every_light_for_every_observer():
    w = np.linspace(400, 700, 7)
    for illuminant in colour.illuminants():
        for observer in colour.observers():
            white = np.ones(7) @ colour.rgb_matrix(w, illuminant, observer)
            np.testing.assert_allclose(white, 1, rtol=0, atol=1e-15, err_msg=f"{illuminant}, {observer}")
            assert colour.xyz_matrix(w, illuminant, observer)[:, 1].sum() == pytest.approx(1, abs=1e-15)
    assert len(colour.illuminants()) > 50


@pytest.mark.parametrize("illuminant", ["D65", "A", "FL11"])
def test_the_light_is_adapted_to_by_bradford_and_otherwise_kept(illuminant):
    w, spectrum = GRIDS[0], RNG.uniform(size=GRIDS[0].size)
    xyz = integrated(w, spectrum, illuminant, colour.OBSERVER)
    white = integrated(w, np.ones(w.size), illuminant, colour.OBSERVER)
    target = science.xyY_to_XYZ([0.3127, 0.3290, 1])
    np.testing.assert_allclose(colour.WHITE, target, rtol=1e-15)
    adapted = science.adaptation.chromatic_adaptation_VonKries(xyz, white, target, transform="Bradford")
    exact = science.models.normalised_primary_matrix([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]], [0.3127, 0.3290])
    rgb = {
        "exact": np.linalg.solve(exact, adapted),
        "light": np.linalg.solve(exact, xyz),
        "colour": science.XYZ_to_sRGB(xyz, apply_cctf_encoding=False),
    }
    for white_name, expected in rgb.items():
        got = colour.spectrum_to_rgb(spectrum, w, illuminant, white=white_name)
        np.testing.assert_allclose(got, expected, rtol=1e-12, err_msg=white_name)
        np.testing.assert_allclose(spectrum @ colour.rgb_matrix(w, illuminant, white=white_name), got, rtol=1e-13)
    np.testing.assert_allclose(colour.xyz_to_rgb(xyz, white), rgb["exact"], rtol=1e-12)
    np.testing.assert_allclose(colour.rgb_to_xyz(rgb["light"]), xyz, rtol=1e-13)


def test_a_light_given_by_its_power_has_the_colours_of_its_name():
    w, spectra = GRIDS[0], RNG.uniform(size=(4, GRIDS[0].size))
    for illuminant in ("D65", "FL11"):
        power = 3e-7 * colour.illuminant_power(illuminant, w)
        for white in ("exact", "light"):
            expected = spectra @ colour.rgb_matrix(w, illuminant, white=white)
            np.testing.assert_allclose(colour.spectrum_to_rgb(spectra, w, power, white=white), expected, rtol=1e-12)
        np.testing.assert_allclose(
            colour.spectrum_to_xyz(spectra, w, power), spectra @ colour.xyz_matrix(w, illuminant), rtol=1e-12
        )


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_colours_of_metals_are_reproduced_to_their_digits(name):
    source, published = PUBLISHED[name]
    got = colour.spectrum_to_rgb(reflectance(GRIDS[0], name, source), GRIDS[0])
    np.testing.assert_allclose(got, published, rtol=0, atol=6e-4)


def test_the_published_aluminium_is_that_of_one_measurement_alone():
    published = np.array([0.916, 0.923, 0.924])
    error = {
        source: np.abs(colour.spectrum_to_rgb(reflectance(GRIDS[0], "Al", source), GRIDS[0]) - published).max()
        for source in ("Rakic", "McPeak", "Cheng")
    }
    assert error["Cheng"] < 6e-4
    assert min(error["Rakic"], error["McPeak"]) > 5e-3


def test_colours_have_the_derivatives_of_finite_differences():
    w = np.linspace(420.0, 680, 6)
    index = material("Au")(w)

    def lab(x):
        n, k, power, mu = x[:6], x[6:12], x[12:18], x[18]
        return colour.rgb_to_lab(colour.spectrum_to_rgb(fresnel.conductor(mu, n, k), w, power))

    at = np.concatenate([index.n, index.k, colour.illuminant_power("A", w), [0.6]])
    step = 1e-5 * np.eye(19)
    slopes = np.asarray(jax.jit(jax.jacrev(lab))(at))
    above, below = np.asarray(jax.jit(jax.vmap(lab))(np.stack([at + step, at - step]).reshape(38, 19))).reshape(
        2, 19, 3
    )
    np.testing.assert_allclose(slopes, (above - below).T / 2e-5, rtol=1e-6, atol=1e-7)
    for part in np.split(slopes, [6, 12, 18], axis=1):
        assert np.abs(part).max() > 0.01


def test_lab_is_that_of_colour_science_on_both_branches_and_has_finite_slopes_at_black_and_below():
    xyz = np.concatenate([RNG.uniform(0, 1.2, (50, 3)), RNG.uniform(0, 0.01, (50, 3)), np.zeros((1, 3))])
    expected = science.XYZ_to_Lab(xyz, [0.3127, 0.3290])
    np.testing.assert_allclose(colour.xyz_to_lab(xyz), expected, rtol=1e-12, atol=1e-12)
    white = np.array([1.0985, 1.0, 0.3558])
    expected = science.XYZ_to_Lab(xyz, science.XYZ_to_xy(white))
    np.testing.assert_allclose(colour.xyz_to_lab(xyz, white), expected, rtol=1e-12, atol=1e-12)
    bend = (6 / 29) ** 3
    points = np.array([-0.1, 0.0, bend * (1 - 1e-12), bend * (1 + 1e-12)])[:, None] * colour.WHITE
    slopes = np.asarray(jax.vmap(jax.jacrev(colour.xyz_to_lab))(points))
    np.testing.assert_allclose(slopes, np.broadcast_to(slopes[0], slopes.shape), rtol=1e-9)
    assert slopes[1, 0, 1] == pytest.approx((29 / 3) ** 3, rel=1e-12)


def test_ciede2000_gives_the_published_pairs_and_differences_of_pictures():
    assert SHARMA.shape == (32, 7)
    for first, second in ((0, 3), (3, 0)):
        got = colour.ciede2000(SHARMA[:, first : first + 3], SHARMA[:, second : second + 3])
        np.testing.assert_allclose(got, SHARMA[:, 6], rtol=0, atol=5.1e-5)
    picture = RNG.uniform(-0.1, 1.3, (4, 5, 3))
    assert colour.colour_difference(picture, picture).shape == (4, 5)
    assert colour.colour_difference(picture, picture).max() < 1e-12
    assert colour.colour_difference([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]) == pytest.approx(100, rel=1e-9)


@pytest.mark.usefixtures("float32")
def test_single_precision_goes_in_and_comes_out():
    w = np.linspace(420, 680, 16)
    spectrum = RNG.uniform(size=(3, 16)).astype(np.float32)
    rgb = colour.spectrum_to_rgb(spectrum, w)
    for result in (rgb, colour.rgb_to_lab(rgb), colour.spectrum_to_xyz(spectrum, w, "A"), colour.to_gamut(rgb)):
        assert result.dtype == np.float32
    np.testing.assert_allclose(rgb, spectrum @ colour.rgb_matrix(w), atol=1e-6)


def test_arrays_of_single_precision_stay_so_beside_those_of_double():
    w, spectrum = np.linspace(420, 680, 4), jnp.full(4, 0.5, jnp.float32)
    assert colour.spectrum_to_rgb(spectrum, w).dtype == jnp.float32
    assert colour.spectrum_to_rgb(spectrum, w, jnp.ones(4, jnp.float64)).dtype == jnp.float32
    assert colour.xyz_to_lab(jnp.full(3, 0.5, jnp.float32)).dtype == jnp.float32


def test_every_method_ends_in_the_gamut_and_leaves_what_is_there():
    rgb = RNG.normal(0.5, 1.0, (2000, 3))
    inside = ((rgb >= 0) & (rgb <= 1)).all(axis=1)
    assert 100 < inside.sum() < 1900
    for method in ("desaturate", "clip"):
        shown = colour.to_gamut(rgb, method)
        assert shown.min() >= 0
        assert shown.max() <= 1
        np.testing.assert_array_equal(shown[inside], rgb[inside])
    np.testing.assert_array_equal(colour.to_gamut(rgb, "clip"), np.clip(rgb, 0, 1))
    assert (colour.to_gamut([[2, 3, 2], [-1, 0, -2]]) == [[1, 1, 1], [0, 0, 0]]).all()


def test_desaturation_keeps_luminance_and_stops_at_the_rim_on_the_line_to_grey():
    rgb = RNG.normal(0.5, 1.0, (2000, 3))
    luminance = rgb @ [0.2126, 0.7152, 0.0722]
    rgb = rgb[(luminance > 0.01) & (luminance < 0.99) & ((rgb < 0) | (rgb > 1)).any(axis=1)]
    shown, luminance = colour.to_gamut(rgb), rgb @ [0.212639, 0.715169, 0.072192]
    np.testing.assert_allclose(shown @ [0.212639, 0.715169, 0.072192], luminance, atol=2e-6)
    before, after = rgb - luminance[:, None], shown - luminance[:, None]
    np.testing.assert_allclose(np.cross(before, after), 0, atol=1e-5)
    assert ((before * after).sum(axis=1) > 0).all()
    assert (np.minimum(np.abs(shown), np.abs(1 - shown)).min(axis=1) < 1e-12).all()


def test_few_wavelengths_give_the_colour_of_a_metal_as_said():
    fine, worst = GRIDS[1], {}
    spectra = [reflectance(fine, name) for name in ("Au", "Cu", "brass", "Ti")]
    exact = np.array(spectra) @ colour.rgb_matrix(fine)
    for n in (3, 4, 6, 8, 16, 32):
        w = np.linspace(420.0, 680, n)
        got = np.array([np.interp(w, fine, spectrum) for spectrum in spectra]) @ colour.rgb_matrix(w)
        worst[n] = colour.colour_difference(got, exact).max()
    limits = {3: 6, 4: 6, 6: 2, 8: 1, 16: 0.3, 32: 0.1}  # CIEDE2000; docs/colour.md
    assert all(0.2 * limits[n] < worst[n] < limits[n] for n in worst), worst


def test_tables_are_taken_once_and_cannot_be_changed():
    first = colour.rgb_matrix([450, 550, 650], "A")
    assert colour.rgb_matrix(np.array([450.0, 550, 650]), "A") is first
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: colour.rgb_matrix([500], "F11"), r"illuminant = 'F11' must be one of FL11"),
        (lambda: colour.xyz_matrix([500], observer="CIE 1931 2"), r"observer = .* one of CIE 1931 2 Degree"),
        (lambda: colour.rgb_matrix([500], white="D65"), r"white = 'D65' must be one of"),
        (lambda: colour.xyz_matrix([0.5, 0.6]), r"wavelength_nm = 0.5 is outside \[100, 100000\]"),
        (lambda: colour.xyz_matrix([600, 500]), r"wavelength_nm .*ascending"),
        (lambda: colour.xyz_matrix([[500, 600]]), r"wavelength_nm has shape \(1, 2\)"),
        (lambda: colour.xyz_matrix([900, 1000]), r"wavelength_nm = 900 to 1000: none is within \[360, 780\]"),
        (lambda: jax.jit(colour.xyz_matrix)(jnp.array([500.0])), r"wavelength_nm is traced"),
        (lambda: colour.spectrum_to_rgb([1, 2], [500.0]), r"reflectance has shape \(2,\).* 1 wavelengths"),
        (lambda: colour.spectrum_to_xyz([1.0], [500.0], [-1.0]), r"illuminant = -1.0 is outside \[0, inf\)"),
        (lambda: colour.spectrum_to_xyz([1.0], [500.0], [1.0, 2.0]), r"illuminant has shape \(2,\)"),
        (lambda: colour.spectrum_to_rgb([1.0], [500.0], [1.0], white="colour"), r"white = 'colour' must be one of"),
        (lambda: colour.to_gamut([1, 2]), r"rgb has shape \(2,\)"),
        (lambda: colour.to_gamut([1, 2, 3], "hope"), r"method = 'hope' must be one of desaturate, clip"),
        (lambda: colour.xyz_to_lab([1.0, 1, 1], [1.0, 0, 1]), r"white = 0.0 is outside \(0, inf\)"),
    ],
)
def test_what_is_wrong_is_said(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_numpy_prints_as_before(tmp_path):
    script = (
        "import numpy as np; from jaxrefl import colour; colour.illuminants(); print(np.array([1.0]), np.float64(0.5))"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["[1.]", "0.5"]


def test_a_light_of_any_strength_has_its_colour_and_none_is_refused():
    for scale in (1e-36, 1.0, 1e36):
        xyz = colour.spectrum_to_xyz(
            np.ones(3, np.float32), [450, 550, 650], np.float32(scale) * np.array([1, 3, 1], "f")
        )
        np.testing.assert_allclose(xyz[1], 1.0, rtol=1e-6)
    for call, message in (
        (lambda: colour.spectrum_to_xyz(np.ones(2), [450, 550], np.zeros(2)), "illuminant is 0 at every wavelength"),
        (lambda: colour.rgb_matrix([450, 550], np.ones(2)), "illuminant = .* must be a name"),
        (lambda: colour.xyz_matrix([]), r"wavelength_nm has shape \(0,\)"),
        (lambda: colour.colour_difference(np.ones((4, 2)), np.ones((4, 2))), r"rgb_1 has shape \(4, 2\)"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
