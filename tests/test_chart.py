"""Charts of the hemisphere: whatever the view, they cover it once, and know the distance to the horizon."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl.chart import CHARTS, LEVELS, albedo_rule, direction, spread_rule

VIEWS = (0.0, 1e-6, 0.02, 0.5, 0.93, 1.0)
NO_KINKS = jnp.zeros(0)


@jax.jit
def nodes(rule, mu, kinks):
    """Directions (M,) of a rule and their weights in steradians by the finest of its rules."""
    found = jax.vmap(lambda node: direction(node, mu, kinks))(rule)
    return found.wi, found.solid_angle, found.solid_angle * rule.weight


def as_numpy(rule, mu, kinks=NO_KINKS):
    wi, solid_angle, weight = nodes(rule, jnp.asarray(mu, rule.weight.dtype), kinks.astype(rule.weight.dtype))
    return *(np.asarray(x) for x in (wi.x, wi.y, wi.z)), np.asarray(weight), np.asarray(solid_angle)


@pytest.fixture(scope="module")
def rules():
    return {chart: albedo_rule(chart, 4) for chart in CHARTS}


@pytest.mark.parametrize("mu", VIEWS)
@pytest.mark.parametrize("chart", CHARTS)
def test_the_moments_of_the_hemisphere_come_out_in_every_chart_and_for_every_view(rules, chart, mu):
    x, y, z, weight, _ = as_numpy(rules[chart], mu)
    moments = {
        "area": (1, 2 * np.pi),
        "cos": (z, np.pi),
        "cos^2": (z * z, 2 * np.pi / 3),
        "x^2": (x * x, 2 * np.pi / 3),
        "y^2 z": (y * y * z, np.pi / 4),
        "x": (x, 0.0),
        "x y": (x * y, 0.0),
        "x^3": (x**3, 0.0),
    }
    digits = 1e-9 if mu == 1e-6 else 1e-12  # the horizon turns within a millionth of the azimuth there
    for name, (value, expected) in moments.items():
        assert np.sum(value * weight) == pytest.approx(expected, rel=digits, abs=digits), name


@pytest.mark.parametrize("mu", VIEWS)
@pytest.mark.parametrize("chart", CHARTS)
def test_directions_are_unit_vectors_above_the_surface_and_weights_are_positive(rules, chart, mu):
    x, y, z, _, solid_angle = as_numpy(rules[chart], mu)
    np.testing.assert_allclose(x * x + y * y + z * z, 1, atol=2e-15)
    assert z.min() >= 0
    assert solid_angle.min() >= 0
    assert np.isfinite(solid_angle).all()


@pytest.mark.parametrize("chart", ["normal", "mirror", "half"])
def test_the_height_above_the_horizon_has_full_relative_accuracy_in_single_precision(chart):
    """An absolute rounding of 6e-8 would leave nothing of the lowest nodes, at 1e-14."""
    rule = albedo_rule(chart, 3, dtype=jnp.float32)
    single = as_numpy(rule, 0.25)[2]
    widened = {name: jnp.asarray(getattr(rule, name), jnp.float64) for name in ("u", "u_rest", "v", "v_rest", "weight")}
    double = as_numpy(dataclasses.replace(rule, **widened), 0.25)[2]
    lowest = double > 1e-30  # a panel may have no width
    assert double[lowest].min() < 1e-13
    np.testing.assert_allclose(single[lowest], double[lowest], rtol=2e-5)


def test_the_directions_have_the_dtype_of_the_rule():
    for chart in CHARTS:
        for dtype in (jnp.float32, jnp.float64):
            rule = albedo_rule(chart, 0, dtype=dtype)
            assert {x.dtype for x in as_numpy(rule, 0.5)} == {jnp.dtype(dtype)}
            assert rule.panel_u.dtype == rule.panel_v.dtype == jnp.int32


def test_the_peak_of_a_lobe_is_an_edge_of_a_panel():
    """The first nodes lie at the mirror direction, and halfway to it at the normal; the panels of theta meet at it."""
    for mu in (0.1, 0.7):
        mirror = np.array([-np.sqrt(1 - mu * mu), 0.0, mu])
        for chart in ("mirror", "half"):
            rule = albedo_rule(chart, 3)
            wi = np.stack(as_numpy(rule, mu)[:3], axis=1)
            at_edge = (np.asarray(rule.u) < 1e-14) & (np.asarray(rule.panel_u) == 0)
            np.testing.assert_allclose(wi[at_edge], np.tile(mirror, (at_edge.sum(), 1)), atol=1e-13)
        rule = albedo_rule("normal", 3)
        z, below = as_numpy(rule, mu)[2], np.asarray(rule.panel_u) == 1
        assert z[~below].min() == pytest.approx(mu, abs=1e-13)
        assert z[below].max() == pytest.approx(mu, abs=1e-13)


def test_a_kink_that_is_named_is_an_edge_and_one_that_is_not_costs_digits():
    """The integral of |cos - 0.4| over the hemisphere, in a chart with and without the panel."""
    exact = 2 * np.pi * (0.4**2 + 0.6**2) / 2
    errors = []
    for kinks in (jnp.array([0.4]), NO_KINKS):
        _, _, z, weight, _ = as_numpy(albedo_rule("normal", 4, kinks.size), 0.7, kinks)
        errors.append(abs(np.sum(weight * abs(z - 0.4)) - exact))
    assert errors[0] < 1e-13 < 1e-6 < errors[1]


@pytest.mark.parametrize("order", [[0.2, 0.8], [0.8, 0.2], [0.5, 0.5]])
def test_several_kinks_may_come_in_any_order_and_coincide_with_the_view(order):
    _, _, z, weight, _ = as_numpy(albedo_rule("normal", 4, 2), 0.5, jnp.array(order))
    exact = sum(np.pi * (k**2 + (1 - k) ** 2) for k in order)
    assert np.sum(weight * sum(abs(z - k) for k in order)) == pytest.approx(exact, rel=1e-13)


def test_the_product_rule_is_exact_for_polynomials_up_to_its_degree():
    _, _, z, weight, _ = as_numpy(albedo_rule("product", 0), 0.3)  # 4 cosines, 8 azimuths
    for degree in range(8):
        assert np.sum(weight * z**degree) == pytest.approx(2 * np.pi / (degree + 1), rel=1e-14)
    assert abs(np.sum(weight * z**8) - 2 * np.pi / 9) > 1e-5


@pytest.mark.parametrize("chart", CHARTS)
def test_each_of_the_three_nested_rules_has_the_weights_of_a_mean_over_every_panel(chart):
    rule = albedo_rule(chart, 3)
    panels = len({*zip(np.asarray(rule.panel_u).tolist(), np.asarray(rule.panel_v).tolist(), strict=True)})
    for weight, digits in ((rule.weight, 1e-14), (rule.coarse, 1e-7), (rule.coarsest, 2e-2)):
        assert np.sum(weight) == pytest.approx(panels, rel=digits)
    used = [np.count_nonzero(weight) for weight in (rule.weight, rule.coarse, rule.coarsest)]
    assert used == sorted(used, reverse=True)
    assert used[0] > 3 * used[1] > 9 * used[2]
    np.testing.assert_allclose(rule.u + rule.u_rest, 1, rtol=1e-15)
    np.testing.assert_allclose(rule.v + rule.v_rest, 1, rtol=1e-15)


def test_every_level_has_four_times_the_nodes_and_says_how_many_evaluations_it_takes():
    counts = [albedo_rule("mirror", level).evaluations for level in range(4)]
    assert counts == [8 * (2 * reach + 1) ** 2 for reach in (3, 7, 14, 28)]  # up to t = 3.5
    assert albedo_rule("normal", 1, 3).evaluations == 20 * 15**2
    assert albedo_rule("product", 1).evaluations == 8 * 16 + 4 * 8 + 2 * 4
    assert LEVELS == (0, 7)


def test_spread_directions_come_closer_to_the_moments_than_random_ones_do():
    x, y, z, weight, _ = as_numpy(spread_rule(4096), 0.3)
    assert np.sum(weight) == pytest.approx(2 * np.pi, rel=1e-14)
    one_sigma = 2 * np.pi / np.sqrt(12 * 4096)  # of the mean of cos over so many random directions
    assert abs(np.sum(weight * z) - np.pi) < 0.1 * one_sigma
    assert abs(np.sum(weight * x * y)) < one_sigma
    nearest = np.sort(x[:, None] * x + y[:, None] * y + z[:, None] * z, axis=1)[:, -2]
    assert np.rad2deg(np.arccos(nearest.min())) < 4  # nowhere a gap


@pytest.mark.parametrize("chart", ["polar", "", None])
def test_another_chart_is_refused_with_the_list(chart):
    with pytest.raises(ValueError, match=r"chart = .* must be one of normal, mirror, half, product"):
        albedo_rule(chart)


@pytest.mark.parametrize("level", [-1, 8, 2.0, "3"])
def test_a_level_out_of_its_range_is_refused(level):
    with pytest.raises(ValueError, match=r"level = .* must be an integer in \[0, 7\]"):
        albedo_rule("normal", level)
