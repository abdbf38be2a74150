"""Integrals of the models against closed forms, and the error that they state against the true one."""

from typing import Any

import closed_albedos as closed
import jax
import jax.numpy as jnp
import mpmath as mp
import numpy as np
import pytest

from jaxrefl import brdf
from jaxrefl.albedo import bihemispherical_albedo, directional_albedo, rule_for
from jaxrefl.certified import albedo_to
from jaxrefl.chart import albedo_rule
from jaxrefl.params import param, pytree

COSINES = (1.0, 0.5, 0.05)
PHONG = [(n, closed.modified_phong, brdf.ModifiedPhong, (0.7, n)) for n in (0.0, 0.5, 1.0, 2.5, 10.0, 1000.0)]
CASES = [
    *((f"modified Phong {n:g}", model, truth, values) for n, truth, model, values in PHONG),
    *((f"Blinn-Phong {n:g}", brdf.BlinnPhong, closed.blinn, (0.9, n)) for n in (0.0, 3.5)),
    *((f"EON {r}", brdf.EON, closed.eon, (0.8, r)) for r in (0.0, 0.3, 1.0)),
    ("Oren-Nayar", brdf.OrenNayar, closed.oren_nayar, (0.8, 0.5)),
    ("Lommel-Seeliger", brdf.LommelSeeliger, closed.lommel_seeliger, (0.9,)),
    *((f"Minnaert {k}", brdf.Minnaert, closed.minnaert, (0.9, k)) for k in (0.1, 0.8, 1.0, 2.7)),
    ("Ashikhmin-Shirley", brdf.AshikhminShirleyDiffuse, closed.ashikhmin_shirley, (0.8, 0.1)),
    *((f"coat {n}", brdf.CoatedLambert, closed.coat, (0.7, n)) for n in (1.05, 1.5, 2.4)),
    ("Lambert", brdf.Lambert, closed.lambert, (0.3,)),
]
estimate = jax.jit(directional_albedo, static_argnames=("part", "fixed"))
slopes = jax.jit(jax.jacfwd(lambda model, mu, rule: directional_albedo(model, mu, rule).value, (0, 1)))


@pytest.mark.parametrize(("model", "truth", "values"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_an_albedo_is_its_closed_form_to_twelve_digits_and_never_farther_than_it_says(model, truth, values):
    for mu in COSINES:
        with mp.workdps(30):
            exact = float(truth(mp.mpf(mu), *values))
        found = albedo_to(model(*values), mu, 1e-12)
        assert abs(found.value - exact) <= min(found.error, 1e-12 * exact)


def test_the_derivative_of_an_albedo_is_that_of_its_closed_form():
    for _, model, truth, values in CASES[2::3]:
        if values[-1] > 50:
            continue
        by_model, by_mu = slopes(model(*values), 0.4, rule_for(model(*values), 4))
        with mp.workdps(30):
            arguments = [mp.mpf(0.4), *map(mp.mpf, values)]
            for i, got in enumerate([by_mu, *jax.tree.leaves(by_model)]):
                order = tuple(int(j == i) for j in range(len(arguments)))
                exact = float(mp.diff(truth, tuple(arguments), order))
                assert abs(got - exact) <= 1e-9 * max(1, abs(exact)), (model, i)


def test_single_precision_has_five_digits_and_says_no_more():
    for _, model, truth, values in CASES[::4]:
        if values[-1] == 1000:
            continue
        narrow = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), model(*values))
        rule = rule_for(narrow, 4, jnp.float32)
        for mu in (1.0, 0.1):
            found = estimate(narrow, jnp.float32(mu), rule)
            with mp.workdps(30):
                exact = float(truth(mp.mpf(mu), *values))
            assert found.value.dtype == jnp.float32
            assert abs(found.value - exact) <= min(1e-5 * exact, float(found.error))


def test_a_slab_reflects_and_transmits_what_its_series_says_and_all_together_where_nothing_absorbs():
    for depth in (0.0, 0.5):
        for mu in COSINES:
            with mp.workdps(30):
                exact = [float(x) for x in closed.slab(mp.mpf(mu), 1.5, depth)]
            model = brdf.Slab(1.5, depth)
            rule = rule_for(model, 1)
            for part, value in zip(("reflected", "transmitted", "both"), (*exact, sum(exact)), strict=True):
                found = estimate(model, mu, rule, part=part)
                assert abs(found.value - value) <= 1e-12 * max(value, 1e-3)


def test_d3d9_adds_the_reflection_to_the_whole_base_and_its_repaired_form_does_not():
    for mu in COSINES:
        r = closed.d3d9_reflectance(mu, 0.04, 0.96, 5)
        assert abs(estimate(brdf.D3D9(), mu, rule_for(brdf.D3D9(), 4)).value - float(1 + r)) < 1e-12
        repaired = estimate(brdf.D3D9Repaired(0.5, 0.3), mu, rule_for(brdf.D3D9Repaired(), 4)).value
        exact = 0.3 + 0.7 * r + 0.5 * 0.7 * (1 - r)
        assert abs(repaired - float(exact)) < 1e-12


def test_with_the_sun_held_equation_8_sends_out_what_it_gets_and_with_the_view_held_it_does_not():
    model = brdf.D3D9(1.0, 0.2, sun_fresnel=True)
    rule, average = rule_for(model, 4), closed.d3d9_average(0.04, 0.96, 5)
    for mu in COSINES:
        sent, seen = (estimate(model, mu, rule, fixed=fixed).value for fixed in ("light", "view"))
        assert abs(sent - 1) < 1e-12
        r = closed.d3d9_reflectance(mu, 0.04, 0.96, 5)
        assert abs(seen - float(1 + 0.8 * (r - average))) < 1e-12


def test_bihemispherical_albedos_are_the_averages_of_the_closed_forms():
    for model, exact in (
        (brdf.Lambert(0.4), 0.4),
        (brdf.LommelSeeliger(1.0), 2 / 3 * (1 - np.log(2))),
        (brdf.Minnaert(1.0, 0.3), 2 / 1.3),
        (brdf.EON(1.0, 0.8), 1.0),
        (brdf.ModifiedPhong(1.0, 10.0), 0.67350260416666667),
    ):
        found = jax.jit(bihemispherical_albedo)(model, rule_for(model, 3))
        assert abs(found.value - exact) <= min(found.error, 1e-7)


@pytree
class Brushed:
    """f = (1 + x_i^2 x_o) / (2 pi)."""

    def __call__(self, wi, wo):
        return jnp.where(wi.z < 0, 0.0, (1 + wi.x * wi.x * wo.x) / (2 * jnp.pi))


def test_an_anisotropic_model_is_seen_from_its_azimuth():
    """int x^2 cos over the hemisphere = pi / 4, so that the albedo is 1/2 + sin theta_o cos phi_o / 8."""
    mu, rule = 0.6, rule_for(Brushed(), 4)
    for phi in (0.0, 0.7, 2.5, 4.0):
        found = estimate(Brushed(), mu, rule, phi_o=phi)
        assert abs(found.value - (0.5 + 0.8 * np.cos(phi) / 8)) <= 1e-13


def test_the_lower_hemisphere_is_the_transmitted_part():
    def both(wi, wo):
        return jnp.where(wi.z > 0, 0.3, 0.6) / jnp.pi

    rule = albedo_rule("normal", 4)
    got = [float(directional_albedo(both, 0.5, rule, part=part).value) for part in ("reflected", "transmitted", "both")]
    np.testing.assert_allclose(got, [0.3, 0.6, 0.9], rtol=1e-13)


@pytree
class Step:
    """Jumps where it says so."""

    edge: Any = param("[0, 1]", default=0.3)

    def kinks(self):
        return (self.edge,)

    def __call__(self, wi, wo):
        return jnp.where(wi.z > self.edge, 1.0, 0.0) / jnp.pi


def test_a_kink_that_a_model_names_is_an_edge_of_a_panel():
    for mu in (0.2, 0.3, 0.8):
        found = estimate(Step(0.3), mu, rule_for(Step(0.3), 4))
        assert abs(found.value - (1 - 0.09)) <= min(1e-13, found.error)
    with pytest.raises(ValueError, match="rule has panels for 0 kinks, the model has 1"):
        directional_albedo(Step(), 0.5, albedo_rule("normal", 3))


@pytest.mark.parametrize("a", [1.2, 1.5, 1.8, 1.9])
def test_a_power_at_the_horizon_is_never_stated_better_than_it_is(a):
    """f cos ~ mu^(1 - a), normalised."""

    def power(wi, wo):
        return jnp.where(wi.z > 0, (2 - a) / (2 * jnp.pi) * jnp.where(wi.z > 0, wi.z, 1.0) ** (-a), 0.0)

    for level in (3, 4):
        found = directional_albedo(power, 0.6, albedo_rule("normal", level))
        assert abs(found.value - 1) <= found.error


@pytest.mark.parametrize("shininess", [1e3, 1e6])
@pytest.mark.parametrize("mu", [1.0, 0.1])
def test_a_narrow_lobe_is_never_stated_better_than_it_is(shininess, mu):
    with mp.workdps(30):  # at 1e6 nothing of the lobe is below the horizon, to e^-5000: cos theta is left
        exact = mu if shininess == 1e6 else float(closed.modified_phong(mp.mpf(mu), 1, shininess))
    found = albedo_to(brdf.ModifiedPhong(1.0, shininess), mu, 1e-9)
    assert abs(found.value - exact) <= found.error
    assert found.converged or shininess > 1e5


@pytest.mark.parametrize("cut", [0.111, 0.5, 0.777])
def test_an_unnamed_jump_is_not_certified_to_many_digits(cut):
    found = albedo_to(lambda wi, wo: jnp.where(wi.z > cut, 1.0, 0.0) / jnp.pi, 0.6, 1e-8)
    assert not found.converged
    assert abs(found.value - (1 - cut * cut)) <= 4 * found.error


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda rule: directional_albedo(brdf.Lambert(), 1.5, rule), r"^cos_theta_o = 1.5 is outside \[0, 1\]"),
        (lambda rule: directional_albedo(brdf.Lambert(), [0.2, 0.3], rule), r"^cos_theta_o has shape \(2,\)"),
        (
            lambda rule: directional_albedo(brdf.Lambert(), 0.5, rule, part="up"),
            "^part = 'up' must be one of reflected",
        ),
        (lambda rule: directional_albedo(brdf.Lambert(), 0.5, rule, fixed="eye"), "^fixed = 'eye' must be one of view"),
        (lambda rule: albedo_rule("polar"), "^chart = 'polar' must be one of normal"),
        (lambda rule: albedo_rule("half", 9), r"^level = 9 must be an integer in \[0, 7\]"),
        (lambda rule: albedo_to(brdf.Lambert(7.0), 0.5), r"^rho = 7.0 is outside \[0, 1\]"),
        (lambda rule: albedo_to(brdf.Lambert(), 0.5, chart="polar"), "^chart = 'polar' must be one of normal"),
    ],
)
def test_what_is_out_of_range_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(albedo_rule("normal", 2))


@pytest.mark.parametrize("chart", ["normal", "mirror", "half", "product"])
def test_the_directions_of_every_chart_are_unit_and_cover_the_hemisphere_once(chart):
    """int cos = pi and int x^2 cos = pi / 4 by each, for any view."""
    rule = albedo_rule(chart, 4)

    def moments(wi, wo):
        return jnp.stack([jnp.ones(()), 4 * wi.x**2, (wi.x**2 + wi.y**2 + wi.z**2) ** 4]) / jnp.pi

    value = jax.jit(lambda mu: directional_albedo(moments, mu, rule).value)
    for mu in (1.0, 0.6, 0.05):
        np.testing.assert_allclose(value(mu), 1, rtol=1e-8)
