"""Lambert's BRDF: what makes it Lambert's, beyond its albedo."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl.albedo import hemispherical_directional_albedo
from jaxrefl.brdf import BRDF, Lambert
from jaxrefl.params import parameters, validate
from jaxrefl.quadrature import cosine_rule, hemisphere_rule, integrate
from jaxrefl.vec import Vec3


def directions(seed, n=200):
    rng = np.random.default_rng(seed)
    return Vec3.from_spherical(rng.uniform(1e-6, 1, n), rng.uniform(0, 2 * np.pi, n))


@jax.jit
def pairwise(rho, wi, wo):
    return jax.vmap(Lambert(rho))(wi, wo)


def test_lambert_is_rho_over_pi_for_every_pair_of_directions_and_so_reciprocal():
    rho, wi, wo = jnp.array([0.2, 0.5, 1.0]), directions(1), directions(2)
    np.testing.assert_allclose(pairwise(rho, wi, wo), np.tile(np.array([0.2, 0.5, 1.0]) / np.pi, (200, 1)), rtol=1e-15)
    np.testing.assert_array_equal(pairwise(rho, wi, wo), pairwise(rho, wo, wi))


def test_lambert_is_zero_on_the_far_side_of_either_direction():
    wi, wo = directions(3), directions(4)
    for pair in ((-wi, wo), (wi, -wo), (-wi, -wo)):
        assert not pairwise(0.7, *pair).any()


def test_the_three_albedos_of_lambert_are_the_same_number():
    """Hemispherical-directional by view, directional-hemispherical by reciprocity, bihemispherical as its average."""
    rule, brdf = hemisphere_rule(6, 8), Lambert(0.3)
    views = jnp.array([0.0, 0.2, 1.0])
    seen = jax.vmap(lambda mu: hemispherical_directional_albedo(brdf, mu, rule))(views)
    np.testing.assert_allclose(seen, 0.3, rtol=1e-15)

    def sent(wi):
        return integrate(lambda wo: brdf(wi, wo) * wo.z, rule)

    np.testing.assert_allclose(sent(Vec3.from_spherical(0.4, 1.0)), 0.3, rtol=1e-15)
    both = integrate(lambda mu: hemispherical_directional_albedo(brdf, mu, rule), cosine_rule(4))
    np.testing.assert_allclose(both, 0.3, rtol=1e-15)


def test_a_cosine_inside_the_brdf_would_not_be_lambert():
    """Negative control: f = 3 rho cos / (2 pi) has the same albedo from every view, and is not constant."""
    rule = hemisphere_rule(6, 8)

    def impostor(wi, wo):
        return 0.3 * 1.5 * wi.z / jnp.pi

    np.testing.assert_allclose(hemispherical_directional_albedo(impostor, 0.5, rule), 0.3, rtol=1e-15)
    wi, wo = directions(5), directions(6)
    assert np.abs(jax.vmap(impostor)(wi, wo) - jax.vmap(impostor)(wo, wi)).max() > 0.05


@pytest.mark.parametrize("rho", [-0.1, 1.5, np.nan, [0.2, 1.2, 0.3]])
def test_a_reflectance_outside_zero_to_one_is_refused_by_name(rho):
    with pytest.raises(ValueError, match=r"^rho = .* is outside \[0, 1\]"):
        validate(Lambert(np.asarray(rho)))


def test_lambert_declares_its_parameter_and_is_a_brdf():
    (declared,) = parameters(Lambert)
    assert (declared.name, str(declared.interval), declared.spectral) == ("rho", "[0, 1]", True)
    assert isinstance(Lambert(), BRDF)
    validate(Lambert(np.array([0.0, 0.5, 1.0])))
