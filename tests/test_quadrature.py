"""Quadrature rules: exact where they say so and not beyond, the Lambertian pi by each, and Lambert's albedo."""

import itertools
import math
import random

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxrefl import quadrature
from jaxrefl.albedo import hemispherical_directional_albedo
from jaxrefl.brdf import BRDF, Lambert
from jaxrefl.quadrature import (
    accurate_sum,
    cosine_integral,
    cosine_integral_1d,
    cosine_integral_mc,
    cosine_rule,
    gauss_legendre,
    hemisphere_rule,
    integrate,
    midpoint,
    monte_carlo,
    simpson,
    trapezoid,
    uniform_cosine_rule,
    uniform_theta_rule,
)


def moment(rule, degree: int) -> float:
    return math.fsum(np.asarray(rule.weight) * np.asarray(rule.node) ** degree)


# ---------------------------------------------------------------- rules on an interval


@pytest.mark.parametrize("n", [1, 2, 3, 8, 20])
def test_gauss_legendre_is_exact_up_to_degree_two_n_minus_one(n):
    for degree in range(2 * n):
        assert math.isclose(moment(gauss_legendre(n), degree), 1 / (degree + 1), rel_tol=1e-15)


@pytest.mark.parametrize("n", [1, 2, 3, 8])
def test_gauss_legendre_misses_degree_two_n_by_the_known_error(n):
    error = math.factorial(n) ** 4 / ((2 * n + 1) * math.factorial(2 * n) ** 2)
    assert math.isclose(1 / (2 * n + 1) - moment(gauss_legendre(n), 2 * n), error, rel_tol=1e-4)


@pytest.mark.parametrize("n", [1, 2, 5, 16, 33])
def test_gauss_legendre_nodes_and_weights_are_correctly_rounded(n):
    rule = gauss_legendre(n)
    with mpmath.workdps(50):
        for i, guess in enumerate(np.polynomial.legendre.leggauss(n)[0]):
            x = mpmath.findroot(lambda x: mpmath.legendre(n, x), mpmath.mpf(float(guess)))
            slope = n * (mpmath.legendre(n - 1, x) - x * mpmath.legendre(n, x)) / (1 - x * x)
            assert float((1 + x) / 2) == rule.node[i]
            assert float(1 / ((1 - x * x) * slope**2)) == rule.weight[i]


@pytest.mark.parametrize("rule", [gauss_legendre, midpoint, trapezoid, simpson])
def test_a_rule_on_an_interval_is_the_unit_rule_moved_there(rule):
    unit, moved = rule(4), rule(4, -1.0, 3.0)
    np.testing.assert_allclose(moved.node, -1 + 4 * np.asarray(unit.node), rtol=1e-15)
    np.testing.assert_allclose(moved.weight, 4 * np.asarray(unit.weight), rtol=1e-15)


@pytest.mark.parametrize(("rule", "order"), [(midpoint, 2), (trapezoid, 2), (simpson, 4)])
def test_the_error_of_a_composite_rule_falls_with_its_order(rule, order):
    sums = (math.fsum(np.asarray(rule(n).weight) * np.exp(rule(n).node)) for n in (8, 16))
    coarse, fine = (abs(total - (math.e - 1)) for total in sums)
    assert math.isclose(math.log2(coarse / fine), order, abs_tol=0.02)


@pytest.mark.parametrize(("rule", "degree"), [(midpoint, 1), (trapezoid, 1), (simpson, 3)])
def test_a_composite_rule_is_exact_up_to_its_degree_and_not_beyond(rule, degree):
    for exact in range(degree + 1):
        assert math.isclose(moment(rule(6), exact), 1 / (exact + 1), rel_tol=1e-15)
    assert abs(moment(rule(6), degree + 1) - 1 / (degree + 2)) > 1e-6


def test_the_trapezoid_is_spectral_for_a_periodic_integrand():
    value = integrate(lambda t: jnp.exp(jnp.cos(t)), trapezoid(16, 0, 2 * np.pi))
    assert math.isclose(value, 2 * math.pi * float(mpmath.besseli(0, 1)), rel_tol=1e-15)


@pytest.mark.parametrize(
    "rule", [gauss_legendre, midpoint, trapezoid, cosine_rule, uniform_cosine_rule, uniform_theta_rule]
)
@pytest.mark.parametrize("n", [0, -1, 2.0, "3"])
def test_a_number_of_nodes_that_is_no_positive_integer_is_named(rule, n):
    with pytest.raises(ValueError, match=rf"n = {n!r} must be an integer in \[1, inf\)"):
        rule(n)


@pytest.mark.parametrize("n", [1, 3, 0])
def test_simpson_needs_an_even_number_of_panels(n):
    with pytest.raises(ValueError, match=r"n = "):
        simpson(n)


# ---------------------------------------------------------------- averages over the cosine


@pytest.mark.parametrize(
    ("rule", "moments"),
    [
        (cosine_rule, lambda j: 2 / (j + 2)),
        (uniform_cosine_rule, lambda j: 1 / (j + 1)),
        (uniform_theta_rule, lambda j: math.gamma((j + 1) / 2) / (math.sqrt(math.pi) * math.gamma(j / 2 + 1))),
    ],
)
def test_an_average_has_the_moments_of_its_density(rule, moments):
    for degree in range(11):
        assert math.isclose(moment(rule(24), degree), moments(degree), rel_tol=4e-15)


def test_the_cosine_rule_is_exact_up_to_degree_two_n_minus_two_and_not_beyond():
    assert math.isclose(moment(cosine_rule(3), 4), 2 / 6, rel_tol=1e-15)
    assert abs(moment(cosine_rule(3), 5) - 2 / 7) > 1e-5


# ---------------------------------------------------------------- the hemisphere


def hemisphere_moment(a: int, b: int, c: int) -> float:
    """Integral of x^a y^b z^c over the unit hemisphere z > 0."""
    if a % 2 or b % 2:
        return 0.0
    gammas = [math.gamma((e + 1) / 2) for e in (a, b, c)]
    return math.prod(gammas) / math.gamma((a + b + c + 3) / 2)


def test_the_hemisphere_rule_integrates_every_polynomial_of_its_degree():
    rule = hemisphere_rule(4, 6)
    x, y, z = (np.asarray(v) for v in (rule.wi.x, rule.wi.y, rule.wi.z))
    for a, b, c in itertools.product(range(6), range(6), range(8)):
        if a + b < 6 and a + b + c <= 7:
            value = math.fsum(np.asarray(rule.weight) * x**a * y**b * z**c)
            assert math.isclose(value, hemisphere_moment(a, b, c), rel_tol=2e-15, abs_tol=1e-15), (a, b, c)


def test_the_hemisphere_rule_fails_beyond_its_degree_in_the_cosine_and_in_the_azimuth():
    rule = hemisphere_rule(4, 6)
    assert abs(integrate(lambda wi: wi.z**8, rule) - 2 * np.pi / 9) > 1e-5
    sixfold = integrate(lambda wi: ((wi.x + 1j * wi.y) ** 6).real, rule)
    assert abs(sixfold) > 0.1


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (8, 16)])
def test_the_hemisphere_rule_has_unit_directions_above_the_horizon_and_the_solid_angle_of_it(shape):
    rule = hemisphere_rule(*shape)
    x, y, z, weight = map(np.asarray, (rule.wi.x, rule.wi.y, rule.wi.z, rule.weight))
    assert weight.shape == (shape[0] * shape[1],)
    assert z.min() > 0
    np.testing.assert_allclose(x**2 + y**2 + z**2, 1, rtol=1e-15)
    assert math.isclose(math.fsum(weight), 2 * math.pi, rel_tol=4e-16)


@pytest.mark.parametrize(("shape", "name"), [((0, 4), "n_theta"), ((4, 0), "n_phi"), ((4, 2.0), "n_phi")])
def test_the_hemisphere_rule_names_a_bad_count(shape, name):
    with pytest.raises(ValueError, match=f"^{name} = "):
        hemisphere_rule(*shape)


@pytest.mark.parametrize("rule", [gauss_legendre, uniform_theta_rule, lambda n, dtype: hemisphere_rule(n, n, dtype)])
def test_a_rule_has_the_dtype_asked_for(rule):
    for dtype in (jnp.float32, jnp.float64):
        assert {leaf.dtype for leaf in jax.tree.leaves(rule(2, dtype=dtype))} == {jnp.dtype(dtype)}


@pytest.mark.usefixtures("float32")
def test_a_rule_is_single_precision_in_the_default_mode_of_jax():
    assert {leaf.dtype for leaf in jax.tree.leaves((midpoint(4), hemisphere_rule(2, 3)))} == {jnp.dtype("float32")}


# ---------------------------------------------------------------- integrals


def test_an_integral_of_an_array_is_the_array_of_the_integrals():
    found = integrate(lambda x: jnp.stack([jnp.ones_like(x), x, x * x]).reshape(3, 1), gauss_legendre(4))
    np.testing.assert_allclose(found, [[1], [1 / 2], [1 / 3]], rtol=1e-15)


def test_an_integral_can_be_differentiated_jitted_and_mapped():
    f = jax.jit(jax.vmap(jax.grad(lambda a: integrate(lambda x: jnp.exp(a * x), gauss_legendre(16)))))
    a = np.array([0.5, 1.0, 2.0])
    np.testing.assert_allclose(f(a), np.exp(a) / a - (np.exp(a) - 1) / a**2, rtol=1e-14)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 100])
def test_a_well_behaved_sum_is_the_correctly_rounded_one(n):
    terms = np.random.default_rng(n).uniform(0, 1, n)
    assert accurate_sum(jnp.asarray(terms)) == math.fsum(terms)


@given(st.randoms(use_true_random=False), st.integers(1, 20))
def test_an_ill_conditioned_sum_keeps_what_a_plain_sum_loses(shuffler: random.Random, n):
    terms = [1.0, 1e16, -1e16, 0.1] * n
    shuffler.shuffle(terms)
    padded = np.zeros(128)
    padded[: len(terms)] = terms
    assert math.isclose(summed(padded), math.fsum(terms), rel_tol=1e-14)


summed = jax.jit(accurate_sum)


def test_a_plain_sum_loses_what_an_accurate_one_keeps():
    terms = jnp.array([1.0, 1e16, -1e16])
    assert (jnp.cumsum(terms)[-1], accurate_sum(terms), summed(terms)) == (0, 1, 1)


@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_the_derivative_of_an_accurate_sum_is_that_of_a_sum(jacobian):
    np.testing.assert_array_equal(jax.jit(jacobian(accurate_sum))(jnp.array([1.0, 1e16, -1e16, 3.0, 1e-16])), 1)


def test_an_accurate_sum_runs_over_the_first_axis_and_keeps_the_dtype():
    terms = np.random.default_rng(0).uniform(-1, 1, (5, 3)).astype(np.float32)
    found = accurate_sum(jnp.asarray(terms))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, [np.float32(math.fsum(column)) for column in terms.T.tolist()])


# ---------------------------------------------------------------- the Lambertian pi


@pytest.mark.parametrize("shape", [(1, 1), (2, 4), (7, 5), (16, 32), (64, 128)])
def test_the_integral_of_the_cosine_is_pi_to_the_last_digit(shape):
    assert math.isclose(cosine_integral(hemisphere_rule(*shape)), math.pi, rel_tol=4e-16)


@pytest.mark.parametrize("rule", [gauss_legendre(12), gauss_legendre(40), trapezoid(4096)])
def test_the_one_dimensional_integral_of_the_notes_converges_to_pi(rule):
    assert math.isclose(cosine_integral_1d(rule), math.pi, rel_tol=4e-16 if rule.node.size < 100 else 1e-7)


def test_the_one_dimensional_integral_with_few_nodes_is_not_pi():
    assert abs(cosine_integral_1d(gauss_legendre(3)) - math.pi) > 1e-4


estimate_pi = jax.jit(cosine_integral_mc, static_argnums=1)


def test_monte_carlo_finds_pi_within_its_error_and_the_error_is_the_exact_sigma():
    for seed in range(4):
        n = 20_000
        value, error = estimate_pi(jax.random.key(seed), n)
        assert abs(value - math.pi) < 5 * error
        assert math.isclose(error, math.pi / math.sqrt(3 * n), rel_tol=0.05)


def test_the_error_of_monte_carlo_is_the_spread_of_its_estimates():
    keys = jax.random.split(jax.random.key(1), 2000)
    values = jax.jit(jax.vmap(lambda key: cosine_integral_mc(key, 100).value))(keys)
    assert math.isclose(values.std(), math.pi / math.sqrt(300), rel_tol=0.08)
    assert abs(values.mean() - math.pi) < 5 * math.pi / math.sqrt(3 * 200_000)


def test_monte_carlo_is_a_function_of_its_key():
    first, again, other = (estimate_pi(jax.random.key(seed), 20_000) for seed in (0, 0, 1))
    assert first == again
    assert first.value != other.value


def test_monte_carlo_integrates_arrays_over_uniform_directions():
    estimate = jax.jit(lambda key: monte_carlo(lambda wi: jnp.stack([wi.x, wi.y, wi.z**2, wi.x**2]), key, 20_000))(
        jax.random.key(2)
    )
    truth = [0, 0, 2 * math.pi / 3, 2 * math.pi / 3]
    assert (abs(estimate.value - jnp.array(truth)) < 5 * estimate.error).all()


def test_monte_carlo_needs_two_samples():
    with pytest.raises(ValueError, match=r"^n = 1 must be an integer in \[2, inf\)"):
        cosine_integral_mc(jax.random.key(0), 1)


@pytest.mark.nan_debug
@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_monte_carlo_of_a_black_surface_is_zero_without_error_and_with_finite_derivatives(jacobian):
    def estimate(rho):
        return monte_carlo(lambda wi: rho * wi.z, jax.random.key(0), 16)

    value, slope = jax.jit(lambda rho: (estimate(rho), jacobian(estimate)(rho)))(0.0)
    assert value == (0, 0)
    assert np.isfinite(slope).all()


# ---------------------------------------------------------------- Lambert's albedo

RULE = hemisphere_rule(8, 16)


@pytest.mark.parametrize("cos_theta_o", [1.0, 0.7, 0.1, 1e-6])
@pytest.mark.parametrize("rho", [0.0, 0.18, 0.5, 1.0])
def test_the_albedo_of_lambert_is_its_parameter_from_every_direction(rho, cos_theta_o):
    found = albedo(jnp.float64(rho), cos_theta_o)
    assert math.isclose(found, rho, rel_tol=1e-15)


albedo = jax.jit(lambda rho, cos_theta_o: hemispherical_directional_albedo(Lambert(rho), cos_theta_o, RULE))


def test_the_albedo_of_a_spectrum_is_the_spectrum():
    rho = np.array([0.1, 0.5, 0.9])
    np.testing.assert_allclose(hemispherical_directional_albedo(Lambert(rho), 0.3, RULE), rho, rtol=1e-15)


@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_the_derivative_of_lamberts_albedo_by_its_parameter_is_one(jacobian):
    slope = jax.jit(jacobian(albedo))
    assert math.isclose(slope(0.3, 0.7), 1, rel_tol=1e-15)
    np.testing.assert_allclose(slope(np.array([0.1, 0.5, 0.9]), 0.7), np.eye(3), atol=1e-15)


def test_lamberts_albedo_does_not_depend_on_the_direction_of_view():
    assert jax.grad(albedo, 1)(0.3, 0.7) == 0


def test_lamberts_albedo_is_single_precision_with_a_rule_that_is():
    found = hemispherical_directional_albedo(
        Lambert(np.float32(0.3)), np.float32(0.5), hemisphere_rule(8, 16, jnp.float32)
    )
    assert found.dtype == jnp.float32
    assert math.isclose(found, np.float32(0.3), rel_tol=2e-7)


def test_the_albedo_names_a_cosine_out_of_range():
    with pytest.raises(ValueError, match=r"^cos_theta_o = -0\.5 is outside \[0, 1\]"):
        hemispherical_directional_albedo(Lambert(0.5), -0.5, RULE)


def test_lambert_is_a_brdf_and_so_is_a_users_own_function():
    assert isinstance(Lambert(0.5), BRDF)
    retro = hemispherical_directional_albedo(lambda wi, wo: wi.z * wo.z, 0.5, RULE)
    assert math.isclose(retro, 0.5 * 2 * math.pi / 3, rel_tol=1e-15)


@pytest.mark.parametrize(("z_i", "z_o"), [(-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-1e-9, 0.5), (0.5, -1e-9)])
def test_lambert_reflects_nothing_below_the_horizon(z_i, z_o):
    wi, wo = (quadrature.Vec3.from_spherical(z, 0.3) for z in (z_i, z_o))
    np.testing.assert_array_equal(Lambert(np.array([0.5, 0.6]))(wi, wo), [0, 0])


def test_evenly_spread_directions_are_unbiased_and_closer_than_random_ones_by_the_error_that_they_state():
    keys = jax.random.split(jax.random.key(5), 64)  # of 64 estimates the mean is 8 times as good
    found = jax.jit(jax.vmap(lambda key: quadrature.quasi_monte_carlo(lambda wi: wi.z, key, 16384)))(keys)
    random = jax.jit(jax.vmap(lambda key: quadrature.monte_carlo(lambda wi: wi.z, key, 16384)))(keys)
    assert abs(found.value.mean() - np.pi) < 4 * found.value.std() / 8
    assert 0.7 < found.value.std() / found.error.mean() < 1.4
    assert found.error.mean() < 0.15 * random.error.mean()
    with pytest.raises(ValueError, match=r"n = 8 must be an integer in \[16, inf\)"):
        quadrature.quasi_monte_carlo(lambda wi: wi.z, keys[0], 8)
