"""PERRIN's bounce series and the additive rule of JHU, against exact rationals, closed forms and long sums."""

import itertools
import math
import operator
import os
import subprocess
import sys
from fractions import Fraction

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxrefl import fresnel, series
from jaxrefl.series import additive, after_last_hit, bounces_needed, convex, iterative, periodic_limit, recursive, tree

ALPHA = np.array([0.5, 0.8, 0.3, 0.9, 0.6])
COLOR = np.array([0.2, 0.9, 0.4, 0.7, 0.1])
units = st.floats(0, 1)
paths = st.integers(1, 6).flatmap(lambda n: st.tuples(*[st.lists(units, min_size=n, max_size=n)] * 2))


@jax.jit
def both_forms(color, alpha, tail):
    layers = convex(color, alpha)
    return iterative(layers, tail), recursive(layers, tail)


def rational(color, alpha, tail) -> list[Fraction]:
    """c^N+1 ... c^0 of PERRIN (1) in exact arithmetic."""
    values = [Fraction(tail)]
    for c, a in zip(map(Fraction, reversed(color)), map(Fraction, reversed(alpha)), strict=True):
        values.append((1 - a) * c + a * values[-1])
    return values


def pixel(color, alpha, tail=0.0):
    return iterative(convex(color, alpha), tail).radiance


# ---------------------------------------------------------------- the sum and its parts


@given(paths, units)
def test_recursive_and_iterative_form_equal_the_exact_rational_recursion(path, tail):
    color, alpha = path
    exact = [float(x) for x in rational(color, alpha, tail)]
    total, levels = both_forms(np.array(color), np.array(alpha), tail)
    np.testing.assert_allclose(levels, exact[:0:-1], rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(total.radiance, exact[-1], rtol=1e-14, atol=1e-15)


@given(paths)
def test_the_weights_are_the_products_of_the_reflectivities_before_them(path):
    color, alpha = map(np.array, path)
    total, _ = both_forms(color, alpha, 0.0)
    before = np.cumprod([1.0, *alpha])
    np.testing.assert_allclose(total.weights, (1 - alpha) * before[:-1], rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(total.remainder, before[-1], rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(total.partial, np.cumsum(total.weights * color), rtol=1e-14, atol=1e-300)


@given(paths)
def test_the_weights_telescope_to_one_with_the_remainder(path):
    total, _ = both_forms(*map(np.array, path), 0.0)
    assert abs(total.weights.sum() + total.remainder - 1) < 1e-15 * 8


@given(paths)
def test_the_folded_sum_is_a_weighted_mean_of_the_colors(path):
    color, alpha = map(np.array, path)
    folded = folded_sum(color, alpha)
    assert abs(folded.weights.sum() - 1) < 1e-14
    assert folded.remainder == 0
    assert color.min() - 1e-15 <= folded.radiance <= color.max() + 1e-15


folded_sum = jax.jit(lambda color, alpha: iterative(convex(color, alpha, fold=True)))


def test_the_documented_example_has_its_numbers_with_both_tails():
    total = iterative(convex(COLOR, ALPHA))
    np.testing.assert_allclose([total.radiance, total.remainder], [0.31472, 0.0648], rtol=1e-14)
    np.testing.assert_allclose(total.partial, [0.1, 0.19, 0.302, 0.3104, 0.31472], rtol=1e-13)
    np.testing.assert_allclose(folded_sum(COLOR, ALPHA).radiance, 0.3212, rtol=1e-14)


@given(paths, units)
def test_a_tail_adds_the_remainder_times_its_color(path, tail):
    color, alpha = map(np.array, path)
    with_tail, without = both_forms(color, alpha, tail)[0], both_forms(color, alpha, 0.0)[0]
    np.testing.assert_allclose(with_tail.radiance, without.radiance + without.remainder * tail, rtol=1e-14)


def test_folding_is_the_tail_of_the_last_color():
    np.testing.assert_allclose(folded_sum(COLOR, ALPHA).radiance, pixel(COLOR, ALPHA, COLOR[-1]), rtol=1e-15)


def test_one_bounce_step_adds_the_local_color_and_then_dims_the_rest():
    state = series.bounce_step(series.State(1.0, 0.5), series.Layers(color=0.25, local=0.75, reflected=0.125))
    assert state == (1.0 + 0.5 * 0.75 * 0.25, 0.5 * 0.125)


# ---------------------------------------------------------------- truncation


@given(paths, st.lists(units, min_size=12, max_size=12))
def test_what_truncation_leaves_out_is_within_the_bound(path, rest):
    color, alpha = path
    n, alpha_max, color_max = len(color) - 1, max(*alpha, *rest[6:], 0), max(*color, *rest[:6])
    missing = rational([*color, *rest[:6]], [*alpha, *rest[6:]], 0)[-1] - rational(color, alpha, 0)[-1]
    assert 0 <= missing <= float(series.truncation_bound(n, alpha_max, color_max)) * (1 + 1e-13)


def test_the_truncation_bound_is_attained_by_constants():
    for n, alpha, color in itertools.product([0, 1, 7], [0.1, 0.9], [0.5, 2.0]):
        truncated = both_forms(np.full(n + 1, color), np.full(n + 1, alpha), 0.0)[0].radiance
        np.testing.assert_allclose(color - truncated, series.truncation_bound(n, alpha, color), atol=4e-16 * color)


def test_the_slope_of_the_truncation_bound_is_that_of_the_power():
    assert math.isclose(jax.grad(series.truncation_bound, 1)(3, 0.5, 2.0), 2 * 4 * 0.5**3, rel_tol=1e-15)


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("epsilon", [1e-6, 1 / 256, 0.1, 0.5, 2.0])
def test_bounces_needed_is_the_smallest_number_found_by_counting(epsilon, alpha):
    with mpmath.workdps(60):
        bounds = itertools.accumulate(itertools.repeat(mpmath.mpf(alpha)), operator.mul)
        counted = next(n for n, power in enumerate(bounds) if power * mpmath.mpf(1.7) <= epsilon)
    assert bounces_needed(epsilon, alpha, 1.7) == counted


@pytest.mark.parametrize(("alpha", "largest"), [(0.5, 1000), (0.25, 500), (0.75, 32), (0.875, 17), (0.9375, 12)])
def test_bounces_needed_is_exact_where_the_bound_is_met_with_equality(alpha, largest):
    for n in range(1, largest):
        power = alpha ** (n + 1)
        assert Fraction(power) == Fraction(alpha) ** (n + 1)
        assert bounces_needed(power, alpha) == n
        assert bounces_needed(math.nextafter(power, 1), alpha) == n
        assert bounces_needed(math.nextafter(power, 0), alpha) == n + 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 0.5), r"epsilon = 0\.0 is outside \(0, inf\)"),
        ((0.1, 1.0), r"reflectivity_max = 1\.0 is outside \[0, 1\)"),
        ((0.1, 0.5, 0.0), r"color_max = 0\.0 is outside \(0, inf\)"),
    ],
)
def test_bounces_needed_names_what_is_out_of_range(arguments, message):
    with pytest.raises(ValueError, match=message):
        bounces_needed(*arguments)


# ---------------------------------------------------------------- derivatives

second_derivatives = jax.jit(jax.hessian(pixel, 1))
SPECIAL = [ALPHA, np.array([0.5, 0, 0.3, 0, 0.6]), np.array([0.5, 1, 0.3, 1, 1]), np.zeros(5), np.ones(5)]


@pytest.mark.nan_debug
@pytest.mark.parametrize("alpha", SPECIAL)
@pytest.mark.parametrize("jacobian", [jax.jit(jax.jacfwd(pixel, (0, 1))), jax.jit(jax.jacrev(pixel, (0, 1)))])
def test_the_gradient_is_the_analytic_one_also_at_reflectivities_zero_and_one(jacobian, alpha):
    by_color, by_alpha = jacobian(COLOR, alpha)
    before = np.cumprod([1.0, *alpha])[:-1]
    behind = [float(x) for x in rational(COLOR.tolist(), alpha.tolist(), 0)][-2::-1]
    np.testing.assert_allclose(by_color, (1 - alpha) * before, atol=1e-15)
    np.testing.assert_allclose(by_alpha, before * (behind - COLOR), atol=1e-15)


def test_the_gradient_of_the_documented_example_has_its_numbers():
    by_color, by_alpha = jax.grad(pixel, (0, 1))(COLOR, ALPHA)
    np.testing.assert_allclose(by_color, [0.5, 0.1, 0.28, 0.012, 0.0432], rtol=1e-13)
    np.testing.assert_allclose(by_alpha, [0.22944, -0.2941, -0.1176, -0.0792, -0.0108], rtol=1e-13)


@pytest.mark.nan_debug
@pytest.mark.parametrize("alpha", SPECIAL)
def test_the_hessian_is_the_analytic_one_without_division(alpha):
    hessian = second_derivatives(COLOR, alpha)
    behind = [float(x) for x in rational(COLOR.tolist(), alpha.tolist(), 0)][-2::-1]
    exact = np.zeros((5, 5))
    for j, k in itertools.combinations(range(5), 2):
        exact[j, k] = exact[k, j] = np.prod(np.delete(alpha[:k], j)) * (behind[k] - COLOR[k])
    np.testing.assert_allclose(hessian, exact, atol=1e-15)


def test_the_mixed_second_derivative_of_the_documented_example_has_its_number():
    assert math.isclose(second_derivatives(COLOR, ALPHA)[0, 3], -0.1584, rel_tol=1e-13)


def test_the_gradient_behind_a_weak_mirror_vanishes_with_its_weight():
    alpha = np.array([0.5, 1e-6, 0.3, 0.9, 0.6])
    assert (abs(jax.grad(pixel, 1)(COLOR, alpha)[2:]) <= 0.5e-6).all()


def test_a_fresnel_reflectivity_is_differentiated_by_the_chain_rule():
    mu, eta = np.array([0.9, 0.4, 0.2]), 1.5
    color = COLOR[:3]
    alpha, slopes = map(np.asarray, jax.jit(jax.vmap(jax.value_and_grad(fresnel.dielectric, 1), (0, None)))(mu, eta))
    behind = [float(x) for x in rational(color.tolist(), alpha.tolist(), 0)][-2::-1]
    exact = np.sum(np.cumprod([1.0, *alpha])[:-1] * (behind - color) * slopes)
    found = jax.jit(jax.grad(lambda n: pixel(color, fresnel.dielectric(mu, n))))(eta)
    assert math.isclose(found, exact, rel_tol=1e-13)


# ---------------------------------------------------------------- spectra, misses, types


def test_a_spectral_reflectivity_is_one_series_per_channel():
    alpha = np.stack([ALPHA, ALPHA[::-1], np.zeros(5)], axis=1)
    color = np.stack([COLOR, COLOR, COLOR], axis=1)
    single = [iterative(convex(COLOR, alpha[:, c])) for c in range(3)]
    for found, expected in zip(iterative(convex(color, alpha)), zip(*single, strict=True), strict=True):
        np.testing.assert_allclose(found, np.stack(expected, axis=-1), rtol=1e-15)


@pytest.mark.parametrize("tail", [0.0, 0.3])
def test_a_scalar_per_hit_broadcasts_against_a_spectrum_per_hit(tail):
    spectrum = np.stack([COLOR, COLOR[::-1]], axis=1)
    scalar = np.broadcast_to(ALPHA[:, None], (5, 2))
    for mixed, full in (((spectrum, ALPHA), (spectrum, scalar)), ((ALPHA, spectrum), (scalar, spectrum))):
        for a, b in zip(*map(jax.tree.leaves, (both_forms(*mixed, tail), both_forms(*full, tail))), strict=True):
            np.testing.assert_allclose(a, b if a.ndim == b.ndim else b[..., :1], rtol=1e-15)


def test_a_spectral_tail_shines_through_scalar_layers_in_both_forms():
    tail = np.array([0.1, 0.5, 0.9])
    expected = pixel(COLOR, ALPHA) + 0.0648 * tail
    np.testing.assert_allclose(pixel(COLOR, ALPHA, tail), expected, rtol=1e-14)
    np.testing.assert_allclose(recursive(convex(COLOR, ALPHA), tail)[0], expected, rtol=1e-14)


@pytest.mark.parametrize("n_hits", range(7))
@pytest.mark.parametrize("after", [lambda n: seen_after(n), jax.jit(lambda n: seen_after(n))], ids=["int", "traced"])
def test_after_the_last_hit_only_the_background_follows(after, n_hits):
    total = total_of(after(n_hits))
    exact = rational(COLOR[:n_hits].tolist(), ALPHA[:n_hits].tolist(), 0.35 if n_hits < 5 else 0)[-1]
    np.testing.assert_allclose(total.radiance, float(exact), rtol=1e-14)
    np.testing.assert_allclose(total.remainder, 0 if n_hits < 5 else 0.0648, rtol=1e-14)


def seen_after(n_hits):
    return after_last_hit(convex(COLOR, ALPHA), n_hits, background=0.35)


total_of = jax.jit(iterative)


def test_more_hits_than_layers_leave_the_layers_as_they_are():
    layers = convex(COLOR, ALPHA)
    for a, b in zip(after_last_hit(layers, 9, background=0.35), layers, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_spectral_background_is_seen_through_scalar_hits_and_the_number_of_hits_can_be_mapped():
    color = np.broadcast_to(COLOR[:, None], (5, 3))
    background = np.array([0.1, 0.2, 0.3])
    layers = convex(color, ALPHA)
    mapped = jax.jit(jax.vmap(lambda n: iterative(after_last_hit(layers, n, background)).radiance))(jnp.arange(3))
    exact = [[float(rational(COLOR[:n].tolist(), ALPHA[:n].tolist(), b)[-1]) for b in background] for n in range(3)]
    np.testing.assert_allclose(mapped, exact, rtol=1e-14)


def test_without_a_background_a_miss_is_black_as_in_equation_four():
    assert iterative(after_last_hit(convex(COLOR, ALPHA), 0)).radiance == 0
    total = iterative(after_last_hit(convex(COLOR, ALPHA), 3)).radiance
    np.testing.assert_allclose(total, pixel(COLOR[:3], ALPHA[:3]), rtol=1e-15)


def test_jit_vmap_and_the_eager_call_agree():
    batch = np.stack([ALPHA, ALPHA[::-1]])
    eager = [pixel(COLOR, alpha) for alpha in batch]
    np.testing.assert_allclose(jax.jit(jax.vmap(pixel, (None, 0)))(COLOR, batch), eager, rtol=1e-15)


@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_the_dtype_of_the_layers_is_kept(dtype):
    layers = jax.eval_shape(convex, jnp.ones(5, dtype), jnp.ones((5, 3), dtype))
    total = jax.eval_shape(lambda x: (iterative(x), recursive(x), periodic_limit(x), after_last_hit(x, 2)), layers)
    assert {leaf.dtype for leaf in jax.tree.leaves(total)} == {jnp.dtype(dtype)}


@pytest.mark.parametrize("rule", [convex, additive])
@pytest.mark.parametrize(
    ("color", "weight"), [([], []), (0.5, 0.5), (0.5, [0.5]), ([0.5], 0.5), ([1, 2, 3], [0.5, 0.5])]
)
def test_layers_of_no_hit_or_of_different_numbers_of_hits_are_refused(rule, color, weight):
    with pytest.raises(ValueError, match="number of hits >= 1"):
        rule(color, weight)


def test_a_reflectivity_outside_its_range_is_named():
    with pytest.raises(ValueError, match=r"^reflectivity = 1\.1 is outside \[0, 1\]"):
        convex(COLOR, ALPHA + 0.2)
    with pytest.raises(ValueError, match=r"^reflected = -0\.1"):
        additive([0.5], [-0.1])


# ---------------------------------------------------------------- the additive rule


def attenuated(local, k1, k2):
    return iterative(additive(local, jnp.stack([k1, k2, jnp.zeros_like(k1)]))).radiance


def test_the_slide_on_attenuation_adds_up_to_its_number_with_its_gradients():
    local = np.array([0.6, 0.3, 0.8])
    value, (by_local, by_k1, by_k2) = jax.value_and_grad(attenuated, (0, 1, 2))(local, 0.5, 0.2)
    np.testing.assert_allclose([value, by_k1, by_k2], [0.83, 0.46, 0.4], rtol=1e-15)
    np.testing.assert_allclose(by_local, [1, 0.5, 0.1], rtol=1e-15)


def test_the_convex_rule_on_the_same_numbers_gives_a_half():
    assert math.isclose(pixel([0.6, 0.3, 0.8], [0.5, 0.2, 0.0]), 0.5, rel_tol=1e-15)


def test_the_convex_rule_reaches_the_additive_sum_with_colors_above_one():
    assert math.isclose(pixel([1.2, 0.375, 0.8], [0.5, 0.2, 0.0]), 0.83, rel_tol=1e-15)


def test_additive_weights_are_not_bounded_by_one():
    total = iterative(additive([1.0, 1.0, 1.0], [2.0, 2.0, 2.0]))
    assert [total.weights.tolist(), float(total.radiance), float(total.remainder)] == [[1, 2, 4], 7, 8]


# ---------------------------------------------------------------- infinite series


@pytest.mark.parametrize(("alpha", "color"), [(0.0, 0.3), (0.5, 0.3), (0.99, 2.0)])
def test_a_constant_series_has_the_limit_of_the_geometric_series(alpha, color):
    assert math.isclose(periodic_limit(convex([color], [alpha])), color, rel_tol=1e-13)
    assert math.isclose(periodic_limit(additive([color], [alpha])), color / (1 - alpha), rel_tol=1e-13)
    n = 9
    assert math.isclose(
        pixel(np.full(n + 1, color), np.full(n + 1, alpha)), color * (1 - alpha ** (n + 1)), rel_tol=1e-13
    )


@pytest.mark.parametrize(
    ("rule", "limit", "tenth"), [(convex, 39 / 70, 0.455145056256), (additive, 93 / 28, 2.73680702976)]
)
def test_the_corridor_between_two_mirrors_has_the_closed_limit_of_a_long_sum(rule, limit, tenth):
    colors, weights = np.array([0.3, 0.7]), np.array([0.9, 0.8])
    long = iterative(rule(np.tile(colors, 100), np.tile(weights, 100)))
    np.testing.assert_allclose(periodic_limit(rule(colors, weights)), limit, rtol=1e-14)
    np.testing.assert_allclose(long.radiance, limit, rtol=1e-13)
    np.testing.assert_allclose(long.partial[10], tenth, rtol=1e-11)


def test_the_corridor_has_the_known_slopes():
    slope = jax.grad(lambda alpha: periodic_limit(convex([0.3, 0.7], alpha)))(np.array([0.9, 0.8]))
    np.testing.assert_allclose(slope, [1.0204081632653061, -0.45918367346938776], rtol=1e-13)


endless = jax.jit(lambda color, alpha: periodic_limit(convex(color, alpha)))


@given(st.lists(st.floats(0, 0.9), min_size=3, max_size=3), st.lists(units, min_size=3, max_size=3))
def test_the_periodic_limit_solves_its_own_equation(alpha, color):
    limit = endless(np.array(color), np.array(alpha))
    assert math.isclose(
        both_forms(np.array(color), np.array(alpha), limit)[0].radiance, limit, rel_tol=1e-13, abs_tol=1e-300
    )


@pytest.mark.parametrize("layers", [convex([0.5], [1.0]), additive([1.0, 1.0], [2.0, 0.5]), additive([1.0], [1.5])])
def test_a_period_that_loses_nothing_has_no_limit(layers):
    with pytest.raises(ValueError, match=r"product of the reflected weights = .* is outside \[0, 1\)"):
        periodic_limit(layers)


def recursive_tree(local, k_r, k_t, depth):
    behind = recursive_tree(local, k_r, k_t, depth - 1) if depth else 0.0
    return local + k_r * behind + k_t * behind


@pytest.mark.parametrize("depth", [0, 1, 5, 9])
def test_a_tree_is_the_recursion_of_the_slide(depth):
    assert math.isclose(tree(0.1, 0.3, 0.5, depth).radiance, recursive_tree(0.1, 0.3, 0.5, depth), rel_tol=1e-14)


def test_a_tree_of_depth_five_and_an_endless_one_have_the_known_sums():
    total = tree(0.1, 0.3, 0.5, 5)
    np.testing.assert_allclose([total.radiance, total.remainder], [0.368928, 0.8**6], rtol=1e-14)
    assert math.isclose(tree(0.1, 0.3, 0.5, 300).radiance, 0.5, rel_tol=1e-13)
    assert math.isclose(periodic_limit(additive([0.1], [0.8])), 0.5, rel_tol=1e-14)


def test_a_tree_takes_spectra_and_differentiates():
    total = tree(np.array([0.1, 0.2, 0.3]), 0.3, np.array([0.5, 0.4, 0.3]), 2).radiance
    k = np.array([0.8, 0.7, 0.6])
    np.testing.assert_allclose(total, np.array([0.1, 0.2, 0.3]) * (1 + k + k**2), rtol=1e-15)
    assert math.isclose(jax.grad(lambda k: tree(0.1, k, 0.5, 2).radiance)(0.3), 0.1 * (1 + 2 * 0.8), rel_tol=1e-14)


def test_a_tree_of_negative_depth_is_refused():
    with pytest.raises(ValueError, match="depth = -1"):
        tree(0.1, 0.3, 0.5, -1)


def test_with_every_mirror_perfect_only_the_tail_is_seen_whatever_it_is():
    """Where alpha_i = 1 for all i the recursion leaves the pixel to its tail (S14)."""
    layers = convex(COLOR, np.ones(5))
    for tail in (0.0, 0.3, 7.0):
        assert pixel(COLOR, np.ones(5), tail) == tail
        np.testing.assert_array_equal(recursive(layers, tail), tail)


def test_a_second_call_compiles_nothing():
    compilations = []
    jax.monitoring.register_event_duration_secs_listener(
        lambda event, *_, **__: compilations.append(event) if "backend_compile" in event else None
    )
    layers = convex(np.linspace(0, 1, 2 * 37).reshape(37, 2), np.linspace(0.1, 0.9, 37))  # a shape of its own
    iterative(layers), recursive(layers), periodic_limit(layers)
    assert compilations
    compilations.clear()
    iterative(layers), recursive(layers), periodic_limit(layers)
    assert not compilations


def test_both_forms_run_sharded_over_two_devices(tmp_path):
    script = """
import jax, jax.numpy as jnp, numpy as np
from jax.sharding import Mesh, PartitionSpec as P
from jaxrefl.series import convex, iterative, recursive
def both(c, a):
    return iterative(convex(c, a)).radiance, recursive(convex(c, a), 0.25)[0]
c, a = jnp.linspace(0, 1, 20).reshape(4, 5), jnp.linspace(0.1, 0.9, 20).reshape(4, 5)
mesh = Mesh(np.array(jax.devices()), ("tile",))
sharded = jax.jit(jax.shard_map(jax.vmap(both), mesh=mesh, in_specs=P("tile"), out_specs=P("tile")))(c, a)
np.testing.assert_array_equal(sharded, jax.jit(jax.vmap(both))(c, a))
print(len(jax.devices()))
"""
    environment = {**os.environ, "XLA_FLAGS": "--xla_force_host_platform_device_count=2", "JAX_PLATFORMS": "cpu"}
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "2"), done.stderr


def test_bounces_needed_takes_extreme_numbers_and_the_bound_no_negative_count():
    assert bounces_needed(1e-300, 0.5, 1e300) == math.ceil(600 / math.log10(2) - 1)
    assert bounces_needed(1e300, 0.5, 1e-300) == 0
    with pytest.raises(ValueError, match="n_bounces = -1"):
        series.truncation_bound(-1, 0.5)
