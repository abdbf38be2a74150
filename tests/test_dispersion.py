"""Dispersion models against 40 digits of mpmath, SciPy, published tables and catalogue values; ranges and edges."""

import dataclasses

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from jaxrefl import dispersion as d
from jaxrefl import fresnel

pytestmark = pytest.mark.usefixtures("quick_compilation")

N_BK7 = d.Sellmeier(
    [1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653], 1.0, 300.0, 2500.0
)
SF11 = d.Sellmeier([1.73848403, 0.311168974, 1.17490871], [0.0136068604, 0.0615960463, 121.922711])
BEADIE = d.Polynomial(
    2.1778, [6.1209e-3, -1.5004e-3, 2.3678e-2, -4.2137e-3, 7.3417e-4, -4.5042e-5], [2, 4, -2, -4, -6, -8]
)
RUTILE = d.Devore(5.913, 0.2441, 0.0803, 430.0, 1530.0)
BK7_CAUCHY = d.Cauchy(1.50433, 0.004349198, -1.876977e-05)
# A. D. Rakic et al., Appl. Opt. 37, 5271 (1998), tables 1 and 2
TUNGSTEN = d.DrudeLorentz(
    13.22, 0.206, 0.064, [0.054, 0.166, 0.706, 2.590], [1.004, 1.917, 3.580, 7.498], [0.530, 1.281, 3.332, 5.836]
)
PLATINUM = d.DrudeLorentz(
    9.59, 0.333, 0.080, [0.191, 0.659, 0.547, 3.576], [0.780, 1.314, 3.141, 9.249], [0.517, 1.838, 3.668, 8.517]
)


def mp_n(model, nm):
    """n of a closed form at 40 digits, from its published shape."""
    with mpmath.workdps(40):
        x = mpmath.mpf(nm) / 1000
        exact = [[mpmath.mpf(float(v)) for v in np.ravel(leaf)] for leaf in (model.b, model.c)]
        if isinstance(model, d.Sellmeier):
            return mpmath.sqrt(1 + sum(b * x**2 / (x**2 - c) for b, c in zip(*exact, strict=True)))
        if isinstance(model, d.Devore):
            return mpmath.sqrt(mpmath.mpf(model.a) + exact[0][0] / (x**2 - exact[1][0]))
        return mpmath.mpf(model.a) + exact[0][0] / x**2 + exact[1][0] / x**4


def test_closed_forms_equal_forty_digits():
    nm = np.array([450.0, 587.5618, 700.0, 1200.0])
    for model in (N_BK7, SF11, RUTILE, BK7_CAUCHY):
        exact = [float(mp_n(model, x)) for x in nm]
        np.testing.assert_allclose(model(nm).n, exact, rtol=4e-16)
        np.testing.assert_array_equal(model(nm).k, 0)
    with mpmath.workdps(40):
        terms = [(mpmath.mpf(c), p) for c, p in zip(BEADIE.c, BEADIE.p, strict=True)]
        exact = [
            float(mpmath.sqrt(mpmath.mpf(2.1778) + sum(c * mpmath.mpf(x / 1000) ** p for c, p in terms))) for x in nm
        ]
    np.testing.assert_allclose(BEADIE(nm).n, exact, rtol=1e-15)


def test_glasses_have_the_indices_and_abbe_numbers_of_their_catalogues():
    for model, n_d, v_d in ((N_BK7, 1.51680, 64.17), (SF11, 1.78472, 25.76)):
        assert float(model(587.5618).n) == pytest.approx(n_d, abs=5e-6)
        assert float(d.abbe_number(model)) == pytest.approx(v_d, abs=5e-3)
    assert [float(d.abbe_number(d.Constant(n))) for n in (1.0, 1.5)] == [np.inf, np.inf]
    # F, d, D, C at 486.13, 587.56, 589.3, 656.27 nm, computed from the same coefficients elsewhere
    lines = np.array([486.13, 587.56, 589.3, 656.27])
    np.testing.assert_allclose(
        N_BK7(lines).n, [1.5223764850741002, 1.5168001097398938, 1.5167276734322366, 1.514322425203109], rtol=1e-15
    )
    assert float(RUTILE(589.3).n) == pytest.approx(2.612913999089378, rel=1e-15)


def test_group_index_equals_the_derivative_at_forty_digits():
    nm = np.array([450.0, 587.5618, 1000.0])
    with mpmath.workdps(40):
        pairs = [(mpmath.mpf(b), mpmath.mpf(c)) for b, c in zip(SF11.b, SF11.c, strict=True)]
        x = [mpmath.mpf(value) / 1000 for value in nm]
        # n dn/dx = -sum b c x / (x^2 - c)^2
        exact = [
            float(mp_n(SF11, y) + z * z * sum(b * c / (z * z - c) ** 2 for b, c in pairs) / mp_n(SF11, y))
            for y, z in zip(nm, x, strict=True)
        ]
    np.testing.assert_allclose(d.group_index(SF11, nm), exact, rtol=1e-14)


def test_drude_lorentz_equals_the_published_tables_of_its_parameters():
    # rows of the Lorentz-Drude tables computed by the database's authors, 4 decimals
    nm = np.array([351.36, 444.42, 562.13, 711.01, 848.02])
    tungsten = [3.1512, 3.3673, 3.4831, 3.775, 3.4458], [2.5383, 2.5213, 2.789, 2.8235, 2.8352]
    platinum = [1.5917, 1.8376, 2.1218, 2.5618, 3.003], [2.5449, 3.1083, 3.7721, 4.5623, 5.1627]
    for model, rows in ((TUNGSTEN, tungsten), (PLATINUM, platinum)):
        np.testing.assert_allclose(model(nm), rows, atol=1.2e-4)  # the rounding of the rows, in both columns


def test_drude_lorentz_equals_complex_arithmetic_at_forty_digits():
    with mpmath.workdps(40):
        w = mpmath.mpf(d.HC_EV_NM) / 550
        plasma = mpmath.mpf(13.22) ** 2
        eps = 1 - mpmath.mpf(0.206) * plasma / (w * (w + 1j * mpmath.mpf(0.064)))
        for f, e, g in zip(TUNGSTEN.f, TUNGSTEN.energy_ev, TUNGSTEN.gamma_ev, strict=True):
            eps += mpmath.mpf(f) * plasma / (mpmath.mpf(e) ** 2 - w**2 - 1j * w * mpmath.mpf(g))
        exact = mpmath.sqrt(eps)
    n, k = TUNGSTEN(550.0)
    np.testing.assert_allclose([n, k], [float(exact.real), float(exact.imag)], rtol=2e-15)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_root_of_the_permittivity_keeps_a_small_part_to_its_last_digits(dtype):
    re = np.array([2.25, 2.25, -10.0, -10.0, 1e-3, -0.5, 1e6], dtype)
    im = np.array([1e-9, 0.0, 1e-9, 0.0, 1e-3, 0.5, 1e5], dtype)
    n, k = d.from_permittivity(re, im)
    assert n.dtype == k.dtype == dtype
    with mpmath.workdps(40):
        exact = [mpmath.sqrt(mpmath.mpc(float(a), float(b))) for a, b in zip(re, im, strict=True)]
    for found, part in ((n, "real"), (k, "imag")):
        np.testing.assert_allclose(found, [float(getattr(z, part)) for z in exact], rtol=6 * np.finfo(dtype).eps)


def test_relative_index_gives_the_fresnel_reflectance_of_complex_arithmetic():
    gold, glass = d.Index(np.array([0.43, 1.38]), np.array([2.455, 1.914])), d.Index(np.array([1.52, 1.53]), 0.0)
    cosine, n1, n2 = 0.4, 1j * gold.k + gold.n, glass.n
    inner = np.sqrt(n1**2 - n2**2 * (1 - cosine**2))
    r_s = (n2 * cosine - inner) / (n2 * cosine + inner)
    r_p = (n1**2 * cosine - n2 * inner) / (n1**2 * cosine + n2 * inner)
    found = fresnel.conductor_sp(cosine, *d.relative(gold, glass))
    np.testing.assert_allclose(found, [abs(r_s) ** 2, abs(r_p) ** 2], rtol=1e-14)
    absorbing = d.Index(1.4, 0.3)
    np.testing.assert_allclose(d.relative(gold, absorbing).complex, n1 / (1.4 + 0.3j), rtol=1e-15)
    with pytest.raises(ValueError, match=r"outside.n = 0.0 is outside \(0, inf\)"):
        d.relative(gold, d.Index(0.0, 1.0))


def rough_table(method="linear"):
    rng = np.random.default_rng(0)
    nm = np.sort(rng.uniform(300, 900, 30))
    return d.Tabulated(nm, rng.uniform(0, 3, 30), np.cumsum(rng.uniform(0, 1, 30)), method)


def test_tables_interpolate_as_numpy_and_scipy_do():
    linear, cubic = rough_table(), rough_table("cubic")
    at = np.linspace(linear.wavelength_nm[0], linear.wavelength_nm[-1], 501)
    for column in ("n", "k"):
        y = getattr(linear, column)
        np.testing.assert_allclose(getattr(linear(at), column), np.interp(at, linear.wavelength_nm, y), rtol=1e-13)
        np.testing.assert_allclose(
            getattr(cubic(at), column), PchipInterpolator(linear.wavelength_nm, y)(at), rtol=1e-12, atol=1e-14
        )
    np.testing.assert_array_equal(linear(linear.wavelength_nm).n, linear.n)
    two = d.Tabulated([400.0, 500.0], [1.0, 2.0], method="cubic")
    assert float(two(425.0).n) == pytest.approx(1.25, rel=1e-15)


def test_a_table_is_differentiable_in_its_values_and_the_wavelength():
    for method in ("linear", "cubic"):
        table = rough_table(method)
        at = np.random.default_rng(1).uniform(310, 890, 40)

        def total(n, at, table=table, method=method):
            return jnp.sum(jnp.sin(d.Tabulated(table.wavelength_nm, n, 0.0, method)(at).n))

        value = jax.jit(total)
        by_n, by_at = jax.jit(jax.grad(total, (0, 1)))(table.n, at)
        rng = np.random.default_rng(2)
        u, v = rng.normal(size=30), rng.normal(size=40)
        h = 1e-6
        numeric = (value(table.n + h * u, at + h * v) - value(table.n - h * u, at - h * v)) / (2 * h)
        assert float(by_n @ u + by_at @ v) == pytest.approx(float(numeric), rel=1e-6)
    slope = PchipInterpolator(table.wavelength_nm, table.n).derivative()(at) * np.cos(table(at).n)
    np.testing.assert_allclose(by_at, slope, rtol=1e-9, atol=1e-12)


def test_outside_its_range_a_model_is_an_error_and_under_jit_its_end_with_slope_zero_and_a_mask():
    table = rough_table()
    low, high = table.wavelength_nm[[0, -1]]
    joined = d.WithExtinction(N_BK7, table)
    for model, ends in ((table, (low, high)), (N_BK7, (300.0, 2500.0)), (joined, (max(low, 300.0), high))):
        for nm in (ends[0] - 1, ends[1] + 1):
            with pytest.raises(ValueError, match=rf"wavelength_nm = .* is outside \[{ends[0]:g}, {ends[1]:g}\]"):
                model(nm)
        at = np.array([ends[0] - 50, *ends, ends[1] + 50])
        np.testing.assert_array_equal(d.in_range(model, at), [False, True, True, False])
        n, slope = jax.jit(lambda at, model=model: jax.jvp(lambda x: model(x).n, (at,), (jnp.ones_like(at),)))(at)
        np.testing.assert_allclose(n, np.asarray(model(np.array([ends[0], *ends, ends[1]])).n), rtol=1e-15)
        np.testing.assert_array_equal(slope[jnp.array([0, 3])], 0)
        assert (np.asarray(slope[1:3]) != 0).all()
    assert np.asarray(d.in_range(SF11, [1.0, 1e6])).all()
    narrow = d.Cauchy(1.5, low_nm=203.3, high_nm=203.7)
    assert not np.asarray(d.in_range(narrow, [203, 204])).any()  # whole numbers do not round the ends
    with pytest.raises(ValueError, match=r"wavelength_nm = 0.0 is outside \(0, inf\)"):
        SF11(0.0)
    with pytest.raises(ValueError, match=r"wavelength_nm = nan"):
        N_BK7(float("nan"))


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (d.Constant(1.5, -0.1), r"k = -0.1 is outside \[0, inf\)"),
        (d.DrudeLorentz(-9.0), r"plasma_ev = -9.0 is outside \(0, inf\)"),
        (d.Tabulated([400.0, 500.0, 500.0], [1.0, 1.0, 1.0]), r"wavelength_nm\[2\] = 500.0 does not ascend"),
        (d.Tabulated([400.0], [1.0]), r"have shapes"),
        (d.Tabulated([400.0, 500.0], [1.0, 1.0, 1.0]), r"have shapes"),
        (d.Tabulated([400.0, 500.0], [1.0, 1.0], method="spline"), r"method = 'spline' must be one of linear, cubic"),
        (d.Tabulated([400.0, 500.0], [1.0, -1.0]), r"n = -1.0 is outside \[0, inf\)"),
        (d.Sellmeier([1.0, 2.0], [0.01]), r"shapes b \(2,\), c \(1,\) differ; each holds one number for every term"),
        (d.Devore(2.0, [1.0, 2.0], 0.01), r"shapes b \(2,\), c \(\) differ"),
        (d.Polynomial(1.0, [1.0, 2.0], [2.0]), r"shapes c \(2,\), p \(1,\) differ"),
        (
            d.DrudeLorentz(9.0, f=[1.0], energy_ev=[2.0], gamma_ev=()),
            r"f \(1,\), energy_ev \(1,\), gamma_ev \(0,\) differ",
        ),
        (
            d.Sellmeier([1.0], [0.01], 1.0, 500.0, 400.0),
            "empty: its lower end, 500 nm, is not below the upper one, 400",
        ),
        (
            d.WithExtinction(RUTILE, d.Tabulated([300.0, 400.0], [0.0, 0.0])),
            "lower end, 430 nm, is not below .*, 400 nm",
        ),
        (d.Cauchy(1.5, low_nm=0.0), r"low_nm = 0.0 is outside \(0, inf\)"),
        (d.Cauchy([1.5, 1.6]), r"a has shape \(2,\); it is a scalar"),
    ],
)
def test_bad_parameters_are_named(model, message):
    with pytest.raises(ValueError, match=message):
        model(450.0)


EDGES = [
    d.Constant(1.5, 0.0),
    d.Sellmeier([1.0, 0.5], [0.25, 100.0]),  # at its resonance at 500 nm; just below it n^2 < 0
    d.Devore(2.0, -1.0, 0.04),
    d.Polynomial(1.0, [0.0, 0.1], [2.0, -2.0]),
    d.DrudeLorentz(3.0, 1.0, 0.0, [1.0], [d.HC_EV_NM / 400], [0.0]),  # no damping, at its resonance
    d.DrudeLorentz(d.HC_EV_NM / 400, 1.0, 0.0),  # eps = 0 at 400 nm
    d.DrudeLorentz(9.0, 0.0, 0.0),
    d.Tabulated([200.0, 400.0, 450.0, 1200.0], [1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 2.0, 0.0], "cubic"),
    d.Tabulated([200.0, 400.0, 450.0, 1200.0], [0.0, 1e-12, 1.0, 1.0], [0.0, 1e-20, 3e-20, 1e3]),
    d.WithExtinction(RUTILE, d.Tabulated([430.0, 1200.0], [0.0, 0.0], [0.0, 1e-7], "cubic")),
]


@pytest.mark.parametrize("x64", [False, True])
def test_value_and_every_gradient_are_finite_at_the_edges(x64):
    with jax.enable_x64(x64):
        dtype = np.float64 if x64 else np.float32
        models = [jax.tree.map(lambda x: np.asarray(x, dtype), model) for model in EDGES]
        at = np.array([200.0, 250.0, 399.99, 400.0, 400.01, 450.0, 500.0, 1200.0], dtype)

        def total(models, at):  # an infinite slope stays one in a sum, or becomes a NaN
            values = [m(at) for m in models]
            return sum(jnp.sum(n + 0.7 * k) for n, k in values), values

        (_, values), slopes = jax.jit(jax.value_and_grad(total, (0, 1), has_aux=True))(models, at)
        by_one = jax.jit(jax.vmap(jax.grad(lambda x: total(models, x)[0])))(at)
        assert np.isfinite(by_one).all()
        for model, value, slope in zip(EDGES, values, slopes[0], strict=True):
            assert value.n.dtype == dtype
            for leaf in jax.tree.leaves((value, slope)):
                assert np.isfinite(leaf).all(), model
            assert (value.n >= 0).all(), model
            assert (value.k >= 0).all(), model


def test_a_negative_square_is_total_reflection_and_not_a_nan():
    n, k = EDGES[1](np.array([480.0, 499.0]))
    exact = [1 + x * x / (x * x - 0.25) + 0.5 * x * x / (x * x - 100) for x in (0.48, 0.499)]
    np.testing.assert_array_equal(n, 0)
    np.testing.assert_allclose(k, np.sqrt(np.negative(exact)), rtol=1e-12)
    assert float(d.normal_reflectance(EDGES[1], 499.0)) == 1


def test_python_numbers_adapt_and_arrays_decide_the_dtype():
    def dtype(model, nm):
        return jax.eval_shape(lambda at: model(at).n, nm).dtype

    assert dtype(N_BK7, np.float32([500.0])) == np.float32
    assert dtype(N_BK7, 500.0) == np.float64
    assert dtype(rough_table(), np.float32([500.0])) == np.float64  # its columns are float64 arrays
    assert jax.eval_shape(N_BK7, np.arange(400, 406).reshape(2, 3)).n.shape == (2, 3)
    assert jax.eval_shape(lambda at: d.group_index(N_BK7, at), np.array(500)).dtype == np.float64


def test_a_fit_finds_the_model_its_data_came_from():
    truth = d.DrudeLorentz(9.0, 1.0, 0.2, [0.3, 0.8], [2.6, 4.5], [0.6, 1.5], 1.2)
    nm = np.geomspace(220.0, 1900.0, 45)
    fit = d.fit_drude_lorentz(nm, *truth(nm), n_oscillators=2)
    assert fit.converged
    assert max(fit.n.max, fit.k.max, fit.reflectance.max) < 1e-6
    for name in ("plasma_ev", "f0", "gamma0_ev", "f", "energy_ev", "gamma_ev", "eps_inf"):
        np.testing.assert_allclose(getattr(fit.model, name), getattr(truth, name), rtol=1e-4)
    assert fit.model.range_nm == (220.0, 1900.0)
    noise = 0.02 * np.cos(40 * nm)  # what no smooth model follows
    n, k = (np.asarray(column) for column in truth(nm))
    noisy = d.fit_drude_lorentz(nm, n, k + noise, n_oscillators=2)
    found = noisy.model(nm)
    residual = np.asarray(found.k) - k - noise
    assert noisy.k.rms == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-9)
    assert noisy.k.max == pytest.approx(np.abs(residual).max(), rel=1e-9)
    measured, fitted = (abs((z - 1) / (z + 1)) ** 2 for z in (n + 1j * (k + noise), np.asarray(found.complex)))
    assert noisy.reflectance.max == pytest.approx(np.abs(fitted - measured).max(), rel=1e-6)
    assert 0.003 < noisy.k.rms < 0.02

    def squares(factor):  # what is minimised, with the plasma energy changed by a factor
        changed = dataclasses.replace(noisy.model, plasma_ev=noisy.model.plasma_ev * factor)
        z, data = np.asarray(changed(nm).complex), n + 1j * (k + noise)
        by_r = abs((z - 1) / (z + 1)) ** 2 - abs((data - 1) / (data + 1)) ** 2
        return (abs((z - data) / data) ** 2 + by_r**2).sum()

    below, here, above = (squares(1 + x) for x in (-1e-3, 0.0, 1e-3))
    assert 1e-3 * abs(below - above) / (2 * (below + above - 2 * here)) < 1e-6  # where their parabola has its minimum


def test_a_fit_refuses_what_it_cannot_use():
    nm = np.linspace(400, 700, 4)
    with pytest.raises(ValueError, match="3 oscillators need"):
        d.fit_drude_lorentz(nm, nm / 400, nm / 400)
    with pytest.raises(ValueError, match=r"k = -1.0 is outside"):
        d.fit_drude_lorentz(nm, nm / 400, nm * 0 - 1)
    with pytest.raises(ValueError, match=r"wavelength_nm = 400 is there twice"):
        d.fit_drude_lorentz(np.full(20, 400.0), np.ones(20), np.ones(20))
    for name, value, message in (
        ("n_oscillators", 1.5, "= 1.5 is not a whole number"),
        ("n_oscillators", 0, r"= 0 is outside \[1, inf\)"),
        ("max_steps", 0, r"= 0 is outside \[1, inf\)"),
    ):
        with pytest.raises(ValueError, match=f"{name} {message}"):
            d.fit_drude_lorentz(np.linspace(400, 700, 20), np.ones(20), np.ones(20), **{name: value})
    with pytest.raises(ValueError, match=r"1 oscillators need \(N,\) with N >= 4"):  # six parameters
        d.fit_drude_lorentz(nm[:3], nm[:3] / 400, nm[:3] / 400, n_oscillators=1)
