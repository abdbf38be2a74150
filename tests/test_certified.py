"""Albedos to a tolerance: what is promised is kept, and what cannot be promised is said."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl.brdf import EON, BlinnPhong, Lambert, LommelSeeliger, Minnaert, ModifiedPhong, Slab
from jaxrefl.certified import albedo_to


def test_the_rule_grows_until_the_tolerance_is_met_and_another_one_agrees():
    loose, tight = (albedo_to(LommelSeeliger(1.0), 0.3, rtol) for rtol in (1e-3, 1e-12))
    exact = 0.5 * (1 - 0.3 * np.log1p(1 / 0.3))
    for found, rtol in ((loose, 1e-3), (tight, 1e-12)):
        assert found.converged
        assert found.chart == "normal"
        assert found.confirmed_by == "half"
        assert abs(found.value - exact) <= found.error <= rtol * found.value
    assert loose.level < tight.level
    assert loose.evaluations < tight.evaluations


@pytest.mark.parametrize("shininess", [1e2, 1e4, 1e6])
def test_a_narrow_lobe_at_normal_incidence_has_the_albedo_one(shininess):
    for model in (ModifiedPhong(1.0, shininess), BlinnPhong(1.0, shininess)):
        found = albedo_to(model, 1.0, 1e-8)
        assert found.converged
        assert abs(found.value - 1) <= found.error + 1e-13


def test_the_budget_ends_first_and_it_is_said():
    found = albedo_to(ModifiedPhong(1.0, 1e5), 0.1, 1e-12, budget=30_000)
    assert not found.converged
    assert found.evaluations <= 30_000
    assert found.error > 1e-12 * found.value


def test_a_lobe_that_the_first_rule_misses_is_found_by_the_second_or_by_a_finer_one():
    """A Gaussian of 1 degree, 40 degrees from anything special; its mass is known."""
    theta, phi, width = 0.9, 2.2, 0.02
    axis = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])

    def hidden(wi, wo):
        away = (wi.x - axis[0]) ** 2 + (wi.y - axis[1]) ** 2 + (wi.z - axis[2]) ** 2
        return jnp.exp(-0.5 * away / width**2) / (2 * jnp.pi * width**2)

    truth = axis[2] * (1 - width**2 / 1)  # int exp(-d^2 / 2w^2) cos over the sphere, to order w^2
    found = albedo_to(hidden, 0.8, 1e-6)
    assert not found.converged or abs(found.value - truth) <= found.error + 2e-3 * truth


def test_a_spectrum_is_certified_in_every_channel_and_delta_parts_are_in_it():
    rho = jnp.array([0.1, 1.0])
    found = albedo_to(EON(rho, 0.7), 0.4, 1e-11)
    assert found.converged
    assert found.value.shape == found.error.shape == (2,)
    assert abs(found.value[1] - 1) <= found.error[1]
    both = [albedo_to(Slab(1.5, 0.0), 0.5, part=part).value for part in ("reflected", "transmitted", "both")]
    np.testing.assert_allclose([both[0] + both[1], both[2]], 1, rtol=1e-14)


def test_a_divergent_albedo_is_not_certified():
    """f cos ~ 1 / cos at the horizon: the integral is infinite."""
    found = albedo_to(lambda wi, wo: 1 / jnp.maximum(wi.z, 1e-300) ** 2, 0.5, 1e-8)
    assert not found.converged


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rtol": 1e-16}, r"^rtol = 1e-16 is outside \[1.4e-14, 1\], what float64 can hold"),
        ({"rtol": 2.0}, r"^rtol = 2.0 is outside"),
        ({"budget": 10}, r"^budget = 10 is outside \[1000, inf\)"),
        ({"part": "all"}, r"^part = 'all' must be one of reflected, transmitted, both"),
        ({"fixed": "sun"}, r"^fixed = 'sun' must be one of view, light"),
        ({"cos_theta_o": 1.5}, r"^cos_theta_o = 1.5 is outside \[0, 1\]"),
    ],
)
def test_what_is_out_of_range_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        albedo_to(Lambert(0.5), **{"cos_theta_o": 0.5, **arguments})


def test_a_tolerance_that_single_precision_cannot_hold_is_refused_and_one_that_it_can_is_met():
    with jax.enable_x64(False):
        with pytest.raises(ValueError, match=r"^rtol = 1e-10 is outside \[7.6e-06, 1\], what float32 can hold"):
            albedo_to(Lambert(0.5), 0.5)
        found = albedo_to(Minnaert(1.0, 0.5), 0.25, 1e-5)
        assert found.converged
        assert abs(found.value - 2) <= 2e-5
