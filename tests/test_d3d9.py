"""The D3D9Client equations (4)-(8) against plain arithmetic, their energy, and the fits a user types in."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxrefl import d3d9, fresnel
from jaxrefl.quadrature import cosine_rule, integrate, uniform_cosine_rule, uniform_theta_rule

R0, M = 0.04, 0.96  # glass, n = 1.5
units = st.floats(0, 1)
RULES = {"theta": uniform_theta_rule(48), "mu": uniform_cosine_rule(48), "cos": cosine_rule(48)}


def glass(theta_deg: float) -> float:
    return R0 + M * (1 - math.cos(math.radians(theta_deg))) ** 5


# ---------------------------------------------------------------- equations (4) to (8)


@given(units, units, st.floats(0, 10), units)
def test_equations_four_and_five_are_their_printed_arithmetic(metallic, reflectance, phi, specular):
    metal = metallic * (1 - reflectance) * phi
    assert math.isclose(d3d9.metallic_reflection(metallic, reflectance, phi), metal, rel_tol=1e-14, abs_tol=1e-300)
    total = d3d9.total_reflection(metallic, reflectance, phi, specular)
    assert math.isclose(total, metal + specular * reflectance * phi, rel_tol=1e-14, abs_tol=1e-300)


@given(st.floats(0, 2), units, st.floats(0, 10), units)
def test_equations_six_and_eight_are_their_printed_arithmetic(diffuse, metallic, r_tot, sun):
    rest = diffuse * (1 - metallic)
    assert math.isclose(d3d9.pixel(diffuse, metallic, r_tot), rest + r_tot, rel_tol=1e-14, abs_tol=1e-300)
    assert math.isclose(
        d3d9.pixel(diffuse, metallic, r_tot, sun), rest * (1 - sun) + r_tot, rel_tol=1e-14, abs_tol=1e-300
    )


def test_colors_are_treated_channel_by_channel():
    metallic, phi, specular = np.array([0.2, 0.5, 0.9]), np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.5, 0.25])
    r_tot = d3d9.total_reflection(metallic, 0.3, phi, specular)
    np.testing.assert_allclose(r_tot, (metallic * 0.7 + specular * 0.3) * phi, rtol=1e-15)
    diffuse = np.array([0.8, 0.6, 0.4])
    np.testing.assert_allclose(d3d9.pixel(diffuse, 0.9, r_tot, 0.5), diffuse * 0.1 * 0.5 + r_tot, rtol=1e-15)


@given(units, units, units)
def test_equation_five_with_a_white_coat_is_schlick_with_a_raised_f0(metallic, r0, mu):
    reflectance = fresnel.d3d9(mu, r0, 1 - r0, 5)
    schlick = fresnel.schlick(mu, d3d9.schlick_f0(metallic, r0))
    assert math.isclose(d3d9.total_reflection(metallic, reflectance), schlick, abs_tol=4e-15)


def test_the_identity_of_equation_five_has_its_documented_number():
    assert math.isclose(d3d9.total_reflection(0.7, glass(60)), 0.721, rel_tol=1e-14)
    assert math.isclose(d3d9.schlick_f0(0.7, 0.04), 0.712, rel_tol=1e-15)


def test_the_norm_of_a_color_is_its_largest_channel_or_the_number_itself():
    assert d3d9.max_norm([0.2, 0.9, 0.5]) == 0.9
    assert d3d9.max_norm(0.3) == 0.3


def test_the_slope_of_the_largest_channel_is_shared_at_a_tie():
    assert jax.grad(d3d9.max_norm)(jnp.array([0.2, 0.9, 0.5])).tolist() == [0, 1, 0]
    assert jax.grad(d3d9.max_norm)(jnp.array([0.9, 0.9, 0.5])).tolist() == [0.5, 0.5, 0]


def test_the_euclidean_norm_of_a_light_grey_makes_the_diffuse_weight_negative():
    assert math.isclose(d3d9.euclidean_norm(np.ones(3)), math.sqrt(3), rel_tol=1e-15)
    grey = np.full(3, 1 / math.sqrt(3))
    assert (
        d3d9.pixel(1.0, d3d9.euclidean_norm(grey * 1.001), 0.0)
        < 0
        < d3d9.pixel(1.0, d3d9.euclidean_norm(grey * 0.999), 0.0)
    )
    assert math.isclose(d3d9.pixel(1.0, d3d9.euclidean_norm(np.ones(3)), 0.0), 1 - math.sqrt(3), rel_tol=1e-15)


@pytest.mark.nan_debug
@pytest.mark.parametrize("norm", [d3d9.max_norm, d3d9.euclidean_norm])
@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_both_norms_of_black_are_zero_with_finite_slopes(jacobian, norm):
    value, slope = jax.jit(lambda color: (norm(color), jacobian(norm)(color)))(jnp.zeros(3))
    assert value == 0
    assert np.isfinite(slope).all()


def test_an_offset_and_multiplier_above_one_make_the_transmitted_fraction_negative():
    reflectance = fresnel.d3d9(0.0, 0.5, 0.75, 5)
    assert d3d9.metallic_reflection(1.0, reflectance) == -0.25


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: d3d9.metallic_reflection(1.5, 0.5), "metallic = 1.5 is outside [0, 1]"),
        (lambda: d3d9.total_reflection(0.5, 0.5, specular=-1.0), "specular = -1.0 is outside [0, 1]"),
        (lambda: d3d9.pixel(-1.0, 0.5, 0.1), "diffuse = -1.0 is outside [0, inf)"),
        (lambda: d3d9.alpha_printed(2.0, 0.1), "diffuse_alpha = 2.0 is outside [0, 1]"),
        (lambda: d3d9.alpha_premultiplied(0.5, 1.5), "reflectance = 1.5 is outside [0, 1]"),
        (lambda: d3d9.best_fit(0.9, RULES["mu"]), "eta = 0.9 is outside [1.001, 10]"),
        (lambda: d3d9.energy_exponent(1.0), "eta = 1.0 is outside (1, 4.4]"),
    ],
)
def test_an_argument_outside_its_range_is_named_with_value_and_range(call, message):
    with pytest.raises(ValueError) as refusal:
        call()
    assert str(refusal.value) == message


@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_every_equation_keeps_the_dtype_under_jit_grad_and_vmap(dtype):
    def shade(metallic, mu):
        r_tot = d3d9.total_reflection(metallic, fresnel.d3d9(mu, R0, M, 5), 1.0, 1.0)
        color = d3d9.pixel(0.5, d3d9.max_norm(metallic), r_tot, fresnel.d3d9(mu, R0, M, 5))
        return d3d9.blend(color, d3d9.alpha_printed(0.5, r_tot), 0.5).sum()

    colors, mu = jnp.full((4, 3), 0.3, dtype), jnp.linspace(0, 1, 4, dtype=dtype)
    by_color, by_mu = jax.jit(jax.vmap(jax.grad(shade, (0, 1))))(colors, mu)
    assert (by_color.dtype, by_mu.dtype) == (dtype, dtype)
    assert jnp.isfinite(by_color).all()
    assert jnp.isfinite(by_mu).all()


# ---------------------------------------------------------------- energy in a white furnace


def furnace(metallic: float, theta_deg: float, norm=d3d9.max_norm) -> float:
    """Equation (6) for a grey metal part, white diffuse colour and white light."""
    r_tot = d3d9.total_reflection(metallic, glass(theta_deg))
    return d3d9.pixel(1.0, norm(np.full(3, metallic)), r_tot)


@pytest.mark.parametrize(
    ("metallic", "theta", "maximum", "euclidean"),
    [
        (0.0, 0, 1.04, 1.04),
        (0.0, 80, 1.40991009102, 1.40991009102),
        (0.0, 90, 2.0, 2.0),
        (0.3, 80, 1.28693706372, 1.06732182145),
        (0.9, 90, 1.1, 0.441154273188),
    ],
)
def test_equation_six_returns_more_light_than_it_gets(metallic, theta, maximum, euclidean):
    assert math.isclose(furnace(metallic, theta), maximum, rel_tol=1e-11)
    assert math.isclose(furnace(metallic, theta, d3d9.euclidean_norm), euclidean, rel_tol=1e-11)
    assert math.isclose(furnace(metallic, theta), 1 + glass(theta) * (1 - metallic), rel_tol=1e-14)


def test_equation_six_gains_eight_and_a_half_percent_in_diffuse_light():
    gain = integrate(lambda mu: d3d9.pixel(1.0, 0.0, fresnel.d3d9(mu, R0, M, 5)) - 1, cosine_rule(16))
    assert math.isclose(100 * gain, 8.571428571428571, rel_tol=1e-13)


@given(units, st.floats(0, 90))
def test_equation_eight_sends_all_the_light_of_one_direction_into_the_hemisphere(metallic, sigma):
    sun = glass(sigma)
    mirrored = d3d9.total_reflection(metallic, sun)
    assert math.isclose(d3d9.pixel(1.0, metallic, mirrored, sun), 1, rel_tol=1e-14)


@pytest.mark.parametrize(
    ("metallic", "theta", "value"), [(0, 0, 0.954285714286), (0, 80, 1.32419580531), (0.3, 90, 1.64)]
)
def test_equation_eight_shows_more_or_less_than_the_hemisphere_sends(metallic, theta, value):
    r_tot = d3d9.total_reflection(metallic, glass(theta))
    seen = integrate(lambda mu: d3d9.pixel(1.0, metallic, r_tot, fresnel.d3d9(mu, R0, M, 5)), cosine_rule(16))
    average = fresnel.average_d3d9(R0, M, 5)
    assert math.isclose(seen, value, rel_tol=1e-11)
    assert math.isclose(seen, 1 + (1 - metallic) * (glass(theta) - average), rel_tol=1e-13)


def test_equation_eight_conserves_energy_in_diffuse_light():
    def seen(mu):
        r_tot = fresnel.d3d9(mu, R0, M, 5)
        return integrate(lambda sun: d3d9.pixel(1.0, 0.0, r_tot, fresnel.d3d9(sun, R0, M, 5)), cosine_rule(16))

    assert math.isclose(jax.jit(lambda: integrate(seen, cosine_rule(16)))(), 1, rel_tol=1e-14)


@pytest.mark.parametrize(("theta", "ratio"), [(80, 1.62687072833238), (89, 11.86677935191443)])
def test_equation_eight_is_not_reciprocal(theta, ratio):
    there, back = (d3d9.pixel(1.0, 0.0, 0.0, glass(sigma)) for sigma in (0, theta))
    assert math.isclose(there / back, ratio, rel_tol=1e-12)


# ---------------------------------------------------------------- alpha


def test_the_printed_alpha_counts_the_reflection_of_glass_twice():
    for theta, printed, correct in ((0, 0.04**2 + 0.96 * 0.5, 0.04 + 0.96 * 0.5), (80, 0.46307124, 0.70495505)):
        r_tot = d3d9.total_reflection(0.0, glass(theta))
        straight = d3d9.blend(r_tot, d3d9.alpha_printed(0.0, r_tot), 0.5)
        premultiplied = d3d9.blend_premultiplied(r_tot, d3d9.alpha_premultiplied(0.0, r_tot), 0.5)
        np.testing.assert_allclose([straight, premultiplied], [printed, correct], rtol=2e-8)


def test_the_printed_alpha_exceeds_one_in_bright_light_and_the_corrected_one_does_not():
    assert d3d9.alpha_printed(0.0, d3d9.total_reflection(0.0, 0.5, phi=10.0)) == 5
    assert d3d9.alpha_premultiplied(0.0, d3d9.total_reflection(0.0, 0.5)) == 0.5


@given(units, units)
def test_premultiplied_alpha_conserves_light_for_every_coverage(coverage, reflectance):
    color = reflectance + coverage * (1 - reflectance)
    alpha = d3d9.alpha_premultiplied(coverage, reflectance)
    assert math.isclose(d3d9.blend_premultiplied(color, alpha, 1.0), 1, rel_tol=4e-16)


@given(st.floats(0.01, 0.99), st.floats(0.01, 0.99))
def test_the_maximum_of_equation_seven_does_not_conserve_light_for_a_partial_coverage(coverage, reflectance):
    color = reflectance + coverage * (1 - reflectance)
    excess = d3d9.blend_premultiplied(color, d3d9.alpha_printed(coverage, reflectance), 1.0) - 1
    assert math.isclose(excess, min(coverage, reflectance) - coverage * reflectance, rel_tol=1e-9)
    assert excess > 0


@given(st.sampled_from([0.0, 1.0]), units)
def test_the_corrected_alpha_is_the_maximum_of_equation_seven_for_no_and_for_full_coverage(coverage, reflectance):
    corrected = d3d9.alpha_premultiplied(coverage, reflectance)
    assert math.isclose(corrected, max(coverage, reflectance), abs_tol=2e-16)


# ---------------------------------------------------------------- what a user types

FITS = [
    (1.33, "theta", 5.31828984, 0.937108951, 0.00927602, 5.59524007, 0.0115487981),
    (1.33, "mu", 5.33723903, 0.938484135, 0.0110982174, 5.60903223, 0.0138601008),
    (1.33, "cos", 4.8877146, 0.867664944, 0.0069115211, 5.39175687, 0.0101964065),
    (1.5, "theta", 4.82476922, 0.911950944, 0.0102418983, 5.11795644, 0.0130222084),
    (1.5, "mu", 4.84637118, 0.913618834, 0.0122165806, 5.13397698, 0.0155810037),
    (1.5, "cos", 4.40301821, 0.839499952, 0.0075000875, 4.91447777, 0.0115280137),
    (2.4, "theta", 5.26751844, 0.766017046, 0.0124928411, 5.79319174, 0.016080305),
    (2.4, "mu", 5.30000159, 0.767967165, 0.0149955386, 5.81657718, 0.0193568365),
    (2.4, "cos", 4.53587825, 0.670119704, 0.00857409262, 5.4285538, 0.013765713),
]


@pytest.mark.parametrize(("eta", "metric", "p", "m", "rms", "p_fixed", "rms_fixed"), FITS)
def test_the_best_fits_to_water_glass_and_diamond_are_the_documented_ones(eta, metric, p, m, rms, p_fixed, rms_fixed):
    free, fixed = (d3d9.best_fit(eta, RULES[metric], free_multiplier=free) for free in (True, False))
    r0 = ((1 - eta) / (1 + eta)) ** 2
    np.testing.assert_allclose(free, [r0, m, p, rms], rtol=2e-8)
    np.testing.assert_allclose(fixed, [r0, 1 - r0, p_fixed, rms_fixed], rtol=2e-8)


def above_normal(mu, eta):
    cos_t = np.sqrt(1 - (1 - mu**2) / eta**2)
    exact = (((mu - eta * cos_t) / (mu + eta * cos_t)) ** 2 + ((eta * mu - cos_t) / (eta * mu + cos_t)) ** 2) / 2
    return exact - ((1 - eta) / (1 + eta)) ** 2


def root_mean_square(eta, metric, m, p):
    mu, weight = (np.asarray(x) for x in RULES[metric])
    error = m * (1 - mu) ** p - above_normal(mu, eta)
    return np.sqrt(np.sum(weight * error**2) / np.sum(weight))


@pytest.mark.parametrize("metric", RULES)
@pytest.mark.parametrize("eta", [1.02, 1.1, 1.5, 2.4, 3.5])
def test_no_small_change_of_the_best_fit_lowers_the_residual(eta, metric):
    fit = d3d9.best_fit(eta, RULES[metric])
    m, p = float(fit.m), float(fit.p)
    best = root_mean_square(eta, metric, m, p)
    assert math.isclose(best, fit.rms, rel_tol=1e-10)
    for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        assert root_mean_square(eta, metric, m + 1e-4 * np.cos(angle), p + 1e-3 * np.sin(angle)) > best


@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("eta", [1.005, 1.05, 1.5, 4.0, 6.0, 10.0])
def test_the_best_fit_is_the_best_of_every_exponent_on_a_grid(eta, free):
    r0 = ((1 - eta) / (1 + eta)) ** 2
    for metric, rule in RULES.items():
        mu, weight = (np.asarray(x) for x in rule)
        target = above_normal(mu, eta)
        base = (1 - mu) ** np.geomspace(0.5, 150, 2000)[:, None]
        m = (base * target) @ weight / (base**2 @ weight) if free else np.full(2000, 1 - r0)
        best_of_grid = np.sqrt((m[:, None] * base - target) ** 2 @ weight / weight.sum()).min()
        rms = float(d3d9.best_fit(eta, rule, free_multiplier=free).rms)
        assert rms <= best_of_grid * (1 + 1e-4), metric


def test_the_best_fit_can_be_mapped_over_the_index():
    fits = jax.jit(jax.vmap(lambda eta: d3d9.best_fit(eta, RULES["cos"])))(jnp.array([1.33, 1.5]))
    np.testing.assert_allclose(fits.p, [4.8877146, 4.40301821], rtol=2e-8)


@pytest.mark.parametrize(
    ("eta", "exponent"), [(1.33, 5.055565191179175), (1.5, 4.609943946898795), (2.4, 4.913073888049383)]
)
def test_the_energy_exponent_has_the_documented_value_and_the_exact_average(eta, exponent):
    p = d3d9.energy_exponent(eta)
    assert math.isclose(p, exponent, rel_tol=1e-13)
    r0 = fresnel.f0_dielectric(eta)
    assert math.isclose(fresnel.average_d3d9(r0, 1 - r0, p), fresnel.average_dielectric(eta), rel_tol=1e-14)


def test_metallic_reflection_alone_does_not_depend_on_the_angle():
    metallic, light = np.array([0.8, 0.5, 0.2]), np.array([1.0, 2.0, 0.5])
    np.testing.assert_array_equal(d3d9.metallic_reflection(metallic, 0.0, light), metallic * light)


def test_the_energy_exponent_is_finite_up_to_the_index_beyond_which_there_is_none():
    """Where the average falls below R0, at 4.448, no exponent has it."""
    p = d3d9.energy_exponent(np.linspace(1.01, 4.4, 200))
    assert np.isfinite(p).all()
    assert fresnel.average_dielectric(4.448) > fresnel.f0_dielectric(4.448)
    assert fresnel.average_dielectric(4.449) < fresnel.f0_dielectric(4.449)
    with pytest.raises(ValueError, match=r"\(1, 4\.4\]"):
        d3d9.energy_exponent(4.45)
