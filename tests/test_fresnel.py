"""Fresnel in double precision: against 40 digits of the complex formula, closed forms, symmetries and every edge."""

import itertools
import math

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jax.test_util import check_grads

from jaxrefl import fresnel, quadrature

METALS = {"Au": (0.43, 2.455), "Cu": (0.22, 3.747), "Ag": (0.06, 3.586), "Al": (1.0728, 6.7839)}


# ---------------------------------------------------------------- 40 digits


def exact_sp(mu, eta, k=0):
    n = mpmath.mpc(eta, k)
    q = mpmath.sqrt(n * n - 1 + mu * mu)
    return abs((mu - q) / (mu + q)) ** 2, abs((n * n * mu - q) / (n * n * mu + q)) ** 2


def exact_s(*x):
    return exact_sp(*x)[0]


def exact_p(*x):
    return exact_sp(*x)[1]


def exact(*x):
    return sum(exact_sp(*x)) / 2


def hard_points(rng, n: int, metal: bool) -> np.ndarray:
    """Random (mu, eta, k), crowded near normal, grazing, Brewster and critical angles, eta = 1 and k = 0."""
    rows = []
    while len(rows) < n:
        near_one = 1 + rng.choice([-1, 1]) * 10 ** rng.uniform(-8, -2)
        eta = rng.choice([rng.uniform(0.05, 4), np.exp(rng.uniform(np.log(0.05), np.log(50))), near_one])
        critical = np.arcsin(min(eta, 1.0))
        small, sign = 10 ** rng.uniform(-6, -1), rng.choice([-1, 1])
        near = [small, np.pi / 2 - small, np.arctan(eta) + sign * small, critical + sign * 10 ** rng.uniform(-3, -1)]
        theta = rng.choice([rng.uniform(0, np.pi / 2), *near])
        k = rng.choice([rng.uniform(0, 10), 10 ** rng.uniform(-12, -1)]) if metal else 0.0
        if 0 <= theta <= np.pi / 2 and (eta >= 1 or abs(theta - critical) > 1e-3):
            rows.append((np.cos(theta), eta, k))
    return np.array(rows).T


def everywhere(low: float, high: float, n: int = 1000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random mu in [0.05, 1], eta log-uniform in the range, k in [0, 10]."""
    rng = np.random.default_rng(1)
    return rng.uniform(0.05, 1, n), np.exp(rng.uniform(np.log(low), np.log(high), n)), rng.uniform(0, 10, n)


@pytest.fixture(scope="module", params=["dielectric", "conductor"])
def case(request):
    metal = request.param == "conductor"
    points = hard_points(np.random.default_rng(7), 300, metal)[: 3 if metal else 2]
    units = np.eye(len(points), dtype=int).tolist()
    with mpmath.workdps(40):
        rows = [tuple(mpmath.mpf(float(x)) for x in row) for row in points.T]
        sp = np.array([exact_sp(*row) for row in rows]).T
        slopes = [[[mpmath.diff(f, row, u) for row in rows] for u in units] for f in (exact_s, exact_p)]
    return request.param, points, sp.astype(float), np.array(slopes).astype(float)


def test_reflectance_has_thirteen_digits_of_forty(case):
    name, points, (s, p), _ = case
    np.testing.assert_allclose(getattr(fresnel, name)(*points), (s + p) / 2, rtol=1e-13, atol=0)


def test_polarised_reflectances_are_exact_to_rounding_of_the_amplitude(case):
    name, points, truth, _ = case
    error = np.abs(np.array(getattr(fresnel, name + "_sp")(*points)) - truth)
    assert (error <= 1e-13 * truth + 1e-14 * np.sqrt(truth)).all()


@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_derivatives_have_eleven_digits_of_forty_unless_the_slopes_of_s_and_p_cancel(case, jacobian):
    name, points, _, (by_s, by_p) = case
    slopes = jax.jit(jax.vmap(jacobian(getattr(fresnel, name), tuple(range(len(points))))))(*points)
    truth, parts = (by_s + by_p) / 2, np.abs(by_s) + np.abs(by_p)
    assert (np.abs(slopes - truth) <= 1e-11 * np.abs(truth) + 1e-15 * (1 + parts)).all()


def test_the_slope_by_k_keeps_eleven_digits_where_it_vanishes_with_k():
    rng = np.random.default_rng(6)
    points = rng.uniform(0.02, 1, 100), rng.uniform(1.05, 4, 100), 10 ** rng.uniform(-12, -3, 100)
    with mpmath.workdps(40):
        rows = [tuple(mpmath.mpf(float(x)) for x in row) for row in zip(*points, strict=True)]
        truth = np.array([mpmath.diff(exact, row, (0, 0, 1)) for row in rows], float)
    np.testing.assert_allclose(jax.jit(jax.vmap(jax.grad(fresnel.conductor, 2)))(*points), truth, rtol=1e-11)


def test_transmitted_power_has_twelve_digits_of_forty_where_nearly_all_is_reflected():
    mu, eta, k = hard_points(np.random.default_rng(8), 300, metal=True)
    with mpmath.workdps(40):
        sp = [exact_sp(*map(mpmath.mpf, row)) for row in zip(mu.tolist(), eta.tolist(), k.tolist(), strict=True)]
        truth = np.array([[1 - s, 1 - p] for s, p in sp], float).T
    np.testing.assert_allclose(fresnel.transmittance_sp(mu, eta, k), truth, rtol=1e-12)


def test_reflectance_passes_finite_differences_to_second_order():
    at = np.array([0.9, 0.3, 0.95, 0.2]), np.array([1.5, 2.4, 1 / 1.5, 0.5]), np.array([0.1, 2.0, 0.5, 0.3])
    check_grads(jax.jit(fresnel.conductor), at, order=2, modes=["rev"], rtol=2e-4)


def test_the_second_derivatives_of_a_dielectric_are_those_of_a_conductor_without_extinction():
    at = np.array([0.9, 0.3, 0.95, 0.2]), np.array([1.5, 2.4, 1 / 1.5, 0.5])

    @jax.jit
    def hessians(mu, eta):
        without_extinction = jax.vmap(jax.hessian(lambda *x: fresnel.conductor(*x, 0.0), (0, 1)))
        return jax.vmap(jax.hessian(fresnel.dielectric, (0, 1)))(mu, eta), without_extinction(mu, eta)

    found, expected = hessians(*at)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


# ---------------------------------------------------------------- energy and reversal


def test_reflected_and_transmitted_power_of_a_dielectric_add_to_one_by_the_amplitudes():
    mu, eta, _ = everywhere(0.05, 50)
    found = fresnel.amplitudes(mu, eta)
    flux = eta * np.sqrt(np.maximum(0, 1 - (1 - mu * mu) / eta**2)) / mu
    for r, t in ((found.r_s, found.t_s), (found.r_p, found.t_p)):
        np.testing.assert_allclose(abs(r) ** 2 + flux * abs(t) ** 2, 1, rtol=1e-12)


def test_reflected_power_and_power_absorbed_by_a_conductor_add_to_one():
    at = everywhere(0.05, 50)
    reflected, absorbed = fresnel.conductor_sp(*at), fresnel.transmittance_sp(*at)
    np.testing.assert_allclose(np.add(reflected, absorbed), 1, rtol=1e-14)
    assert np.min([reflected, absorbed]) >= 0


def test_reflectance_is_the_squared_modulus_of_the_amplitude():
    at = everywhere(0.05, 50)
    found = fresnel.amplitudes(*at)
    np.testing.assert_allclose(
        fresnel.conductor_sp(*at), [abs(found.r_s) ** 2, abs(found.r_p) ** 2], rtol=1e-12, atol=1e-15
    )


def test_amplitudes_are_those_of_complex_arithmetic_with_the_time_factor_of_a_negative_exponent():
    mu, eta, k = everywhere(0.05, 50)
    n = eta + 1j * k
    cos_t = np.sqrt(1 - (1 - mu * mu) / n**2)
    r_s, r_p = (mu - n * cos_t) / (mu + n * cos_t), (n * mu - cos_t) / (n * mu + cos_t)
    np.testing.assert_allclose(fresnel.amplitudes(mu, eta, k), [r_s, r_p, 1 + r_s, (1 + r_p) / n], rtol=1e-11)


def test_reflectance_is_the_same_from_both_sides_of_a_refracted_ray():
    mu, eta, _ = everywhere(1.01, 10)
    inside = fresnel.cos_theta_t(mu, eta)
    np.testing.assert_allclose(
        fresnel.dielectric_sp(mu, eta), fresnel.dielectric_sp(inside, 1 / eta), rtol=1e-10, atol=1e-13
    )


def test_stokes_relations_of_a_reversed_ray_hold():
    mu, eta, _ = everywhere(1.01, 10)
    there, back = fresnel.amplitudes(mu, eta), fresnel.amplitudes(fresnel.cos_theta_t(mu, eta), 1 / eta)
    for r, t, r_back, t_back in (
        (there.r_s, there.t_s, back.r_s, back.t_s),
        (there.r_p, there.t_p, back.r_p, back.t_p),
    ):
        np.testing.assert_allclose(r_back, -r, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(t * t_back + r * r, 1, rtol=1e-12)


def test_snells_law_holds_for_the_cosine_of_refraction():
    mu, eta, _ = everywhere(1.01, 50)
    sin_t = np.sqrt((1 - mu) * (1 + mu)) / eta
    np.testing.assert_allclose(fresnel.cos_theta_t(mu, eta), np.cos(np.arcsin(sin_t)), rtol=1e-13)


# ---------------------------------------------------------------- total reflection


def total_reflection_points() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    eta = rng.uniform(0.05, 0.99, 1000)
    return np.cos(rng.uniform(np.arcsin(eta) + 1e-3, np.pi / 2 - 1e-3)), eta


def test_total_reflection_reflects_everything_with_zero_slope():
    mu, eta = total_reflection_points()
    np.testing.assert_array_equal(fresnel.dielectric_sp(mu, eta), 1)
    np.testing.assert_array_equal(fresnel.transmittance_sp(mu, eta), 0)
    np.testing.assert_array_equal(fresnel.cos_theta_t(mu, eta), 0)
    np.testing.assert_array_equal(jax.jit(jax.vmap(jax.grad(fresnel.dielectric, (0, 1))))(mu, eta), 0)


def test_total_reflection_turns_the_phase_by_the_closed_form():
    mu, eta = total_reflection_points()
    g = np.sqrt(1 - mu**2 - eta**2)
    found = fresnel.amplitudes(mu, eta)
    np.testing.assert_allclose(np.abs([found.r_s, found.r_p]), 1, rtol=1e-13)
    np.testing.assert_allclose(np.angle(found.r_s), -2 * np.arctan(g / mu), rtol=1e-12)
    np.testing.assert_allclose(np.angle(found.r_p), -2 * np.arctan(g / (eta**2 * mu)), rtol=1e-12)


@pytest.mark.nan_debug
def test_attenuated_total_reflection_starts_with_the_analytic_slope_at_k_zero():
    mu, eta = total_reflection_points()
    g = np.sqrt(1 - mu**2 - eta**2)
    slope_s = 2 * mu * eta / (g * (1 - eta**2))
    slope_p = 2 * eta * mu * (eta**2 / g + 2 * g) / (eta**4 * mu**2 + g**2)
    found = jax.jit(jax.vmap(jax.grad(fresnel.conductor, 2)))(mu, eta, jnp.zeros(1000))
    np.testing.assert_allclose(found, -(slope_s + slope_p), rtol=1e-11)
    np.testing.assert_allclose(fresnel.conductor(mu, eta, 1e-9), 1 + 1e-9 * found, rtol=1e-12)


def test_attenuated_total_reflection_of_half_index_at_sixty_degrees_has_the_known_slope():
    assert math.isclose(jax.jit(jax.grad(fresnel.conductor, 2))(0.5, 0.5, 0.0), -2.6570072990039968, rel_tol=1e-13)


def test_a_conductor_without_extinction_is_the_dielectric():
    mu, eta, _ = hard_points(np.random.default_rng(9), 300, metal=False)
    np.testing.assert_allclose(
        fresnel.conductor_sp(mu, eta, 0.0), fresnel.dielectric_sp(mu, eta), rtol=1e-13, atol=1e-28
    )


# ---------------------------------------------------------------- special angles


def test_p_polarised_light_is_not_reflected_at_brewsters_angle():
    eta = everywhere(0.05, 50)[1]
    s, p = fresnel.dielectric_sp(np.cos(fresnel.brewster_angle(eta)), eta)
    assert p.max() < 1e-22
    np.testing.assert_allclose(s, ((eta**2 - 1) / (eta**2 + 1)) ** 2, rtol=1e-9)


def test_brewsters_angles_of_the_two_sides_add_to_a_right_angle():
    np.testing.assert_allclose(
        np.degrees([fresnel.brewster_angle(1.5), fresnel.brewster_angle(1 / 1.5)]),
        [56.309932474020213, 33.690067525979787],
        rtol=1e-15,
    )


def test_reflection_is_total_just_beyond_the_critical_angle_and_partial_just_before():
    eta = everywhere(0.05, 0.999)[1]
    critical = fresnel.critical_angle(eta)
    np.testing.assert_allclose(np.sin(critical), eta, rtol=1e-14)
    np.testing.assert_array_equal(fresnel.dielectric(np.cos(critical + 1e-6), eta), 1)
    assert (fresnel.dielectric(np.cos(critical - 1e-6), eta) < 1).all()


@pytest.mark.nan_debug
def test_the_critical_angle_of_index_one_is_a_right_angle_with_slope_zero():
    assert fresnel.critical_angle(1.0) == np.pi / 2
    assert jax.grad(fresnel.critical_angle)(1.0) == 0
    assert jax.jit(fresnel.critical_angle)(1.5) == np.pi / 2
    assert math.isclose(jax.grad(fresnel.critical_angle)(0.8), 1 / 0.6, rel_tol=1e-14)


def test_the_slope_at_grazing_incidence_is_the_closed_form():
    eta = everywhere(1.05, 50)[1]
    slope = jax.jit(jax.vmap(jax.grad(fresnel.dielectric)))(np.zeros_like(eta), eta)
    np.testing.assert_allclose(slope, -2 * (1 + eta**2) / np.sqrt(eta**2 - 1), rtol=1e-12)


def test_the_slopes_of_a_dielectric_and_of_a_metal_vanish_at_normal_incidence_although_those_of_s_do_not():
    eta, k = np.array([*METALS.values(), (1 / 1.5, 0), (1.33, 0), (1.5, 0), (2.4, 0)]).T
    for f, rest in ((fresnel.dielectric_sp, (eta,)), (fresnel.conductor_sp, (eta, k))):
        by_s, by_p = (
            jax.jit(jax.vmap(jax.grad(lambda mu, *x, f=f, i=i: f(mu, *x)[i])))(np.ones(8), *rest) for i in (0, 1)
        )
        np.testing.assert_allclose(by_s + by_p, 0, atol=1e-15)
        assert (abs(by_s) > 1e-3).all()


def test_reflectance_leaves_its_normal_value_with_the_fourth_power_of_the_angle():
    curvature = jax.jit(jax.vmap(jax.grad(jax.grad(fresnel.dielectric))))(np.ones(3), np.array([1.33, 1.5, 2.4]))
    # theta^4 = 4 (1 - mu)^2 to leading order
    np.testing.assert_allclose(curvature / 8, [0.0108757346229375, 11 / 675, 0.0174161780725362], rtol=1e-12)


def test_reflectance_at_normal_incidence_is_f0():
    _, eta, k = everywhere(0.05, 50)
    metal, glass = abs((eta + 1j * k - 1) / (eta + 1j * k + 1)) ** 2, ((1 - eta) / (1 + eta)) ** 2
    for found in (fresnel.f0_conductor(eta, k), *fresnel.conductor_sp(1.0, eta, k)):
        np.testing.assert_allclose(found, metal, rtol=1e-12)
    for found in (fresnel.f0_dielectric(eta), *fresnel.dielectric_sp(1.0, eta)):
        np.testing.assert_allclose(found, glass, rtol=1e-13)


def test_f0_has_the_analytic_slope():
    eta = everywhere(0.05, 50)[1]
    slope = jax.jit(jax.vmap(jax.grad(fresnel.f0_dielectric)))(eta)
    np.testing.assert_allclose(slope, 4 * (eta - 1) / (eta + 1) ** 3, rtol=1e-12)


def test_everything_is_reflected_at_grazing_incidence():
    _, eta, k = everywhere(0.05, 50)
    np.testing.assert_array_equal(fresnel.dielectric_sp(0.0, eta), 1)
    np.testing.assert_array_equal(fresnel.conductor_sp(0.0, eta, k), 1)


@pytest.mark.nan_debug
def test_an_interface_between_equal_media_does_not_exist():
    def both(mu, eta):
        return jnp.stack([fresnel.dielectric(mu, eta), fresnel.conductor(mu, eta, 0.0)])

    def value_and_slopes(*x):
        return both(*x), jax.jacfwd(both, (0, 1))(*x), jax.jacrev(both, (0, 1))(*x)

    mu = np.array([0.0, 1e-20, 1e-8, 0.5, 1.0])
    for leaf in jax.tree.leaves(jax.jit(jax.vmap(value_and_slopes))(mu, np.ones(5))):
        np.testing.assert_array_equal(leaf, 0)


# ---------------------------------------------------------------- the lattice of edges

FORMULAS = {
    "dielectric": (2, fresnel.dielectric_sp),
    "conductor": (3, fresnel.conductor_sp),
    "transmittance": (3, fresnel.transmittance_sp),
    "amplitudes": (3, lambda *x: [(a.real, a.imag) for a in fresnel.amplitudes(*x)]),
    "cos_theta_t": (2, fresnel.cos_theta_t),
    "schlick_dielectric": (2, fresnel.schlick_dielectric),
}


def lattice(dtype, dimension: int) -> list[jax.Array]:
    eps = float(jnp.finfo(dtype).eps)
    etas = [1e-4, 0.05, 0.5, math.sqrt(0.75), 1 - eps, 1.0, 1 + eps, 1.5, 50.0, 1e4]
    edges = [math.sqrt(1 - eta * eta) for eta in etas if eta < 1] + [1 / math.sqrt(1 + eta * eta) for eta in etas]
    mus = [0.0, 1e-30, 1e-20, 1e-10, eps, 0.5, 1 - eps, 1.0, *edges]
    ks = [0.0, 1e-38, 1e-30, 1e-20, 1e-10, eps, 1e-3, 1.0, 50.0, 1e4]
    return [jnp.array(column, dtype) for column in zip(*itertools.product(*(mus, etas, ks)[:dimension]), strict=True)]


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
@pytest.mark.parametrize("name", FORMULAS)
def test_value_and_slopes_are_finite_at_every_edge(name, dtype):
    dimension, f = FORMULAS[name]
    points, numbers = lattice(dtype, dimension), tuple(range(dimension))

    def total(*x):
        return sum(jax.tree.leaves(f(*x)))

    def value_and_slopes(*x):
        return total(*x), jax.jacfwd(total, numbers)(*x), jax.grad(total, numbers)(*x)

    for leaf in jax.tree.leaves(jax.jit(jax.vmap(value_and_slopes))(*points)):
        bad = ~jnp.isfinite(leaf)
        assert leaf.dtype == dtype
        assert not bad.any(), [[float(x) for x in row] for row in zip(*(p[bad][:5] for p in points), strict=True)]


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_reflectances_stay_between_zero_and_one_at_every_edge(dtype):
    both = jax.jit(fresnel.dielectric_sp)(*lattice(dtype, 2)), jax.jit(fresnel.conductor_sp)(*lattice(dtype, 3))
    for r in jax.tree.leaves(both):
        assert r.min() >= 0
        assert r.max() <= 1 + 4 * jnp.finfo(dtype).eps


@pytest.mark.parametrize("name", FORMULAS)
def test_jit_vmap_and_broadcasting_return_what_the_eager_call_returns(name):
    dimension, f = FORMULAS[name]
    points = everywhere(0.05, 50)[:dimension]
    column = (points[0][:30, None], *(x[:30] for x in points[1:]))
    compiled = jax.jit(lambda points, column: (f(*points), jax.vmap(f)(*points), f(*column)))(points, column)
    eager, jitted, mapped, grid = map(jax.tree.leaves, (f(*points), *compiled))
    for a, b, c, d in zip(eager, jitted, mapped, grid, strict=True):
        np.testing.assert_allclose(b, a, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(c, a, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(d.diagonal(), a[:30], rtol=1e-12, atol=1e-14)
        assert d.shape == (30, 30)


# ---------------------------------------------------------------- averages


average = jax.jit(fresnel.average_dielectric)
average_slope = jax.jit(jax.grad(fresnel.average_dielectric))


def average_by_quadrature(eta: float) -> float:
    """2 int R mu dmu by tanh-sinh, split where R turns fast."""
    with mpmath.workdps(30):
        eta = mpmath.mpf(eta)
        critical = mpmath.sqrt(abs(1 - eta * eta))
        ends = sorted({x for x in (critical / 10, critical, critical * 10, mpmath.mpf("0.1")) if x < 1})
        return float(mpmath.quad(lambda mu: 2 * mu * exact(mu, eta), [0, *ends, 1]))


def walsh(n):
    n2, n4 = n**2, n**4
    return (
        mpmath.mpf(1) / 2
        + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
        + n2 * (n2 - 1) ** 2 / (n2 + 1) ** 3 * mpmath.log((n - 1) / (n + 1))
        - 2 * n**3 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1))
        + 8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) ** 2) * mpmath.log(n)
    )


def average_of_sixty_digits(eta):
    return walsh(eta) if eta > 1 else 1 - (1 - walsh(1 / eta)) * eta**2


@pytest.mark.parametrize("eta", [0.2, 0.7, 0.95, 1 - 1e-6, 1 + 1e-6, 1.001, 1.1, 1.5, 2.4, 2.5, 2.6, 7.0, 50.0])
def test_the_average_is_the_integral_of_the_reflectance(eta):
    assert math.isclose(average(np.float64(eta)), average_by_quadrature(eta), rel_tol=2e-14)


@pytest.mark.parametrize(
    "eta", [0.01, 0.2, 0.9, 1 - 1e-6, 1 + 1e-10, 1 + 1e-6, 1.01, 1.5, 2.499999, 2.5, 4.0, 50.0, 1e4]
)
def test_the_average_and_its_slope_agree_with_walsh_in_sixty_digits(eta):
    with mpmath.workdps(60):
        value, slope = (float(x) for x in mpmath.taylor(average_of_sixty_digits, mpmath.mpf(eta), 1))
    assert math.isclose(average(np.float64(eta)), value, rel_tol=2e-14)
    assert math.isclose(average_slope(np.float64(eta)), slope, rel_tol=1e-11)


@pytest.mark.parametrize("eta", [0.05, 0.9, 1 - 1e-3, 1 - 1e-6, 1 + 1e-6, 1 + 1e-3, 1.1, 1.5, 2.4, 2.6, 10.0, 1e4])
def test_the_average_has_the_relative_accuracy_of_single_precision(eta):
    eta = np.float32(eta)
    with mpmath.workdps(60):
        value, slope = (float(x) for x in mpmath.taylor(average_of_sixty_digits, mpmath.mpf(float(eta)), 1))
    assert average(eta).dtype == np.float32
    assert math.isclose(average(eta), value, rel_tol=2e-6)
    assert math.isclose(average_slope(eta), slope, rel_tol=2e-5)


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_the_average_of_equal_media_is_zero_with_the_right_hand_slope(dtype):
    assert average(dtype(1)) == 0
    np.testing.assert_allclose(average_slope(dtype(1)), 1 / 3, rtol=1e-6)


def test_the_average_leaves_zero_seven_times_as_fast_to_the_inside():
    assert math.isclose(average(np.float64(1 - 1e-9)), 7 / 3 * 1e-9, rel_tol=1e-6)
    assert math.isclose(average(np.float64(1 + 1e-9)), 1 / 3 * 1e-9, rel_tol=1e-6)


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_the_average_and_its_slope_are_finite_over_the_whole_range(dtype):
    for eta in (1e-30, 1e-10, 1e-3, 0.5, 1 - 1e-7, 1.0, 1 + 1e-7, 2.5, 1e3, 1e10, 1e30):
        assert np.isfinite([average(dtype(eta)), average_slope(dtype(eta))]).all(), eta


@given(st.floats(0, 1), st.floats(0, 2), st.sampled_from([0, 1, 2, 5, 2.5]))
def test_the_averages_of_the_schlick_family_are_their_integrals(f0, f90, p):
    mu, weight = np.polynomial.legendre.leggauss(64)
    mu, weight = (mu + 1) / 2, weight * (mu + 1) / 2
    integral = np.sum(weight * (f0 + (f90 - f0) * (1 - mu) ** p))
    assert math.isclose(fresnel.average_schlick(f0, f90, p), integral, rel_tol=1e-9, abs_tol=1e-12)
    assert math.isclose(fresnel.average_d3d9(f0, f90 - f0, p), integral, rel_tol=1e-9, abs_tol=1e-12)


def test_the_average_of_schlick_is_f0_and_a_twenty_first_of_the_rest():
    assert math.isclose(fresnel.average_schlick(0.04), 3 / 35, rel_tol=1e-15)


# ---------------------------------------------------------------- Schlick's family


@pytest.mark.nan_debug
@pytest.mark.parametrize(
    "f", [lambda mu, p: fresnel.schlick(mu, 0.04, p=p), lambda mu, p: fresnel.d3d9(mu, 0.04, 0.96, p)]
)
def test_schlick_at_normal_incidence_has_the_documented_value_and_slope_for_whole_real_and_traced_exponents(f):
    def at_normal(p):
        return f(1.0, p), jax.grad(f)(1.0, p), jax.jacfwd(f)(1.0, p)

    documented = {0: (1, 0, 0), 0.5: (0.04, 0, 0), 1: (0.04, -0.96, -0.96), 2: (0.04, 0, 0), 5: (0.04, 0, 0)}
    truth = list(documented.values())
    fixed = jax.jit(lambda: ([at_normal(p) for p in documented], [at_normal(float(p)) for p in documented]))()
    traced = jax.jit(jax.vmap(at_normal))(jnp.array(list(documented), float))
    for found in (*fixed, np.transpose(traced)):
        np.testing.assert_allclose(found, truth, rtol=1e-15)


@pytest.mark.nan_debug
def test_the_slope_by_the_exponent_is_zero_at_normal_and_exact_elsewhere():
    p = np.array([0.0, 0.5, 1.0, 2.0, 5.0])
    slope = jax.jit(jax.vmap(jax.grad(fresnel.d3d9, 3), (None, None, None, 0)))
    np.testing.assert_array_equal(slope(1.0, 0.04, 0.96, p), 0)
    np.testing.assert_allclose(slope(0.3, 0.04, 0.96, p), 0.96 * 0.7**p * np.log(0.7), rtol=1e-13)


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 2), st.integers(0, 8))
def test_schlick_and_d3d9_are_their_formulas_for_a_whole_and_a_real_exponent(mu, f0, f90, p):
    for exponent in (p, float(p)):
        assert math.isclose(fresnel.schlick(mu, f0, f90, exponent), f0 + (f90 - f0) * (1 - mu) ** p, abs_tol=1e-15)
        assert math.isclose(fresnel.d3d9(mu, f0, f90 - f0, exponent), f0 + (f90 - f0) * (1 - mu) ** p, abs_tol=1e-15)


def test_schlick_from_the_denser_side_takes_the_angle_of_refraction():
    mu = math.cos(math.radians(40))
    assert math.isclose(fresnel.schlick_dielectric(mu, 1 / 1.5), 0.2455833506024279, rel_tol=1e-13)
    assert math.isclose(fresnel.schlick(mu, 0.04), 0.040672881, rel_tol=1e-7)


def test_schlicks_dielectric_is_the_same_from_both_sides():
    mu, eta, _ = everywhere(1.01, 10)
    inside = fresnel.schlick_dielectric(fresnel.cos_theta_t(mu, eta), 1 / eta)
    np.testing.assert_allclose(inside, fresnel.schlick_dielectric(mu, eta), rtol=1e-10)


def test_schlicks_dielectric_is_one_under_total_reflection():
    np.testing.assert_allclose(fresnel.schlick_dielectric(*total_reflection_points()), 1, rtol=1e-15)


@given(st.floats(0, 1), st.floats(0, 2))
def test_f82_hits_its_tint_near_eighty_two_degrees_and_keeps_both_ends(f0, tint):
    at = fresnel.f82_tint(jnp.array([0.0, 1 / 7, 1.0]), f0, tint)
    np.testing.assert_allclose(at, [1, tint * (f0 + (1 - f0) * (6 / 7) ** 5), f0], rtol=1e-13, atol=1e-15)


def test_f82_and_lazanyi_differ_from_schlick_by_their_integrals():
    rule = quadrature.cosine_rule(32)
    a = 1.726325611
    tint = 1 - a * (6**6 / 7**7) / float(fresnel.schlick(1 / 7, 0.9147180505))
    f82 = quadrature.integrate(lambda mu: fresnel.f82_tint(mu, 0.9147180505, tint), rule)
    assert math.isclose(f82, fresnel.average_schlick(0.9147180505) - a / 126, rel_tol=1e-13)
    lazanyi = quadrature.integrate(lambda mu: fresnel.lazanyi(mu, 0.9, 1.8, 7), rule)
    assert math.isclose(lazanyi, fresnel.average_schlick(0.9) - 4 * 1.8 / (8 * 9 * 10), rel_tol=1e-13)


def test_f82_of_aluminium_has_the_published_coefficient_and_error():
    eta, k = METALS["Al"]
    f0, edge = float(fresnel.f0_conductor(eta, k)), float(fresnel.conductor(1 / 7, eta, k))
    tint = edge / (f0 + (1 - f0) * (6 / 7) ** 5)
    assert math.isclose(tint, 0.8975018762, rel_tol=1e-9)
    assert math.isclose(fresnel.f82_tint(1 / 7, f0, tint), edge, rel_tol=1e-14)


@given(st.floats(0.01, 0.99), st.floats(0.01, 1))
def test_gulbrandsen_and_its_inverse_undo_each_other(r, g):
    eta, k = fresnel.gulbrandsen(r, g)
    np.testing.assert_allclose(fresnel.gulbrandsen_inverse(eta, k), [r, g], rtol=1e-9, atol=1e-12)
    assert math.isclose(fresnel.conductor(1.0, eta, k), r, rel_tol=1e-11)


@given(st.floats(0.01, 0.95), st.floats(0.05, 1))
def test_gulbrandsens_index_satisfies_the_printed_formulas(r, g):
    eta, k = fresnel.gulbrandsen(r, g)
    root = math.sqrt(r)
    assert math.isclose(eta, g * (1 - r) / (1 + r) + (1 - g) * (1 + root) / (1 - root), rel_tol=1e-13)
    assert math.isclose(k * k, (r * (eta + 1) ** 2 - (eta - 1) ** 2) / (1 - r), rel_tol=1e-8)


def test_gulbrandsens_gold_like_example_has_the_known_index():
    np.testing.assert_allclose(fresnel.gulbrandsen(0.9, 0.5), [19.013148769978822, 18.973661404954186], rtol=1e-14)


def test_gulbrandsens_jacobian_is_the_inverse_of_its_inverses_jacobian():
    at = 0.7, 0.4
    forward = np.array(jax.jit(jax.jacfwd(fresnel.gulbrandsen, (0, 1)))(*at))
    backward = np.array(jax.jit(jax.jacrev(fresnel.gulbrandsen_inverse, (0, 1)))(*fresnel.gulbrandsen(*at)))
    np.testing.assert_allclose(forward @ backward, np.eye(2), atol=1e-12)


@pytest.mark.nan_debug
def test_gulbrandsen_without_edge_tint_is_a_dielectric_with_finite_slopes():
    r, g = np.array([0.0, 0.5, 0.99]), np.zeros(3)
    eta, k = fresnel.gulbrandsen(r, g)
    np.testing.assert_array_equal(k, 0)
    np.testing.assert_allclose(eta, (1 + np.sqrt(r)) / (1 - np.sqrt(r)), rtol=1e-14)
    for mode in (jax.jacfwd, jax.jacrev):
        assert np.isfinite(jax.jit(jax.vmap(mode(fresnel.gulbrandsen, (0, 1))))(r, g)).all()


@pytest.mark.nan_debug
def test_gulbrandsens_inverse_of_equal_media_is_zero_with_finite_slopes():
    assert fresnel.gulbrandsen_inverse(1.0, 0.0) == (0, 0)
    assert np.isfinite(jax.jit(jax.jacrev(fresnel.gulbrandsen_inverse, (0, 1)))(1.0, 0.0)).all()


# ---------------------------------------------------------------- errors and types


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fresnel.dielectric(1.5, 1.5), "cos_theta_i = 1.5 is outside [0, 1]"),
        (lambda: fresnel.dielectric_sp(0.5, 0.0), "eta = 0.0 is outside (0, inf)"),
        (lambda: fresnel.conductor(-0.5, 1.5, 1.0), "cos_theta_i = -0.5 is outside [0, 1]"),
        (lambda: fresnel.conductor_sp(0.5, 1.5, -1.0), "k = -1.0 is outside [0, inf)"),
        (lambda: fresnel.amplitudes(0.5, 1.5, k=-2.0), "k = -2.0 is outside [0, inf)"),
        (lambda: fresnel.transmittance_sp(0.5, -1.0), "eta = -1.0 is outside (0, inf)"),
        (lambda: fresnel.cos_theta_t(2.0, 1.5), "cos_theta_i = 2.0 is outside [0, 1]"),
        (lambda: fresnel.schlick(0.5, -0.1), "f0 = -0.1 is outside [0, inf)"),
        (lambda: fresnel.schlick(0.5, 0.1, p=-1), "p = -1 is outside [0, inf)"),
        (lambda: fresnel.schlick_dielectric(0.5, np.inf), "eta = inf is outside (0, inf)"),
        (lambda: fresnel.d3d9(np.nan, 0.1, 0.9, 5), "cos_theta = nan is outside [0, 1]"),
        (lambda: fresnel.f82_tint(0.5, 0.9, -1.0), "tint = -1.0 is outside [0, inf)"),
        (lambda: fresnel.lazanyi(0.5, 0.9, 1.0, -1.0), "exponent = -1.0 is outside [0, inf)"),
        (lambda: fresnel.gulbrandsen(1.0, 0.5), "r = 1.0 is outside [0, 1)"),
        (lambda: fresnel.gulbrandsen_inverse(1.0, -1.0), "k = -1.0 is outside [0, inf)"),
        (lambda: fresnel.average_dielectric(0.0), "eta = 0.0 is outside (0, inf)"),
        (lambda: fresnel.average_schlick(-1.0), "f0 = -1.0 is outside [0, inf)"),
        (lambda: fresnel.average_d3d9(0.1, np.nan, 5), "m = nan is outside (-inf, inf)"),
        (lambda: fresnel.f0_dielectric(-1.0), "eta = -1.0 is outside (0, inf)"),
        (lambda: fresnel.f0_conductor(1.0, -1.0), "k = -1.0 is outside [0, inf)"),
        (lambda: fresnel.brewster_angle(0.0), "eta = 0.0 is outside (0, inf)"),
        (lambda: fresnel.critical_angle(1.5), "eta = 1.5 is outside (0, 1]"),
    ],
)
def test_an_argument_outside_its_range_is_named_with_value_and_range(call, message):
    with pytest.raises(ValueError) as refusal:
        call()
    assert str(refusal.value) == message


@pytest.mark.usefixtures("float32")
@pytest.mark.parametrize(
    ("f", "arguments"),
    [
        *((f, (0.5, 1.5, 0.3)[:n]) for n, f in FORMULAS.values()),
        (fresnel.schlick, (0.5, 0.04)),
        (fresnel.f82_tint, (0.5, 0.9, 0.9)),
        (fresnel.lazanyi, (0.5, 0.9, 0.9, 7)),
        (fresnel.gulbrandsen, (0.9, 0.5)),
        (fresnel.gulbrandsen_inverse, (0.9, 0.5)),
        (fresnel.average_dielectric, (1.5,)),
        (fresnel.average_schlick, (0.04,)),
        (fresnel.brewster_angle, (1.5,)),
        (fresnel.critical_angle, (0.5,)),
    ],
)
def test_every_formula_is_single_precision_in_the_default_mode_of_jax(f, arguments):
    results = jax.eval_shape(f, *(np.float64(x) for x in arguments))
    assert {leaf.dtype for leaf in jax.tree.leaves(results)} == {jnp.dtype("float32")}


def test_integers_and_lists_are_accepted():
    np.testing.assert_allclose(fresnel.schlick([1, 0], 1 / 9), [1 / 9, 1], rtol=1e-15)
    np.testing.assert_allclose(fresnel.f0_dielectric([2, 3]), [1 / 9, 1 / 4], rtol=1e-15)
