"""Lights: what reaches a point, alone and all together on a floor under a ball that casts shadows."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import ABOVE, DOWN, ORIGIN, UP, ball, plane, rays_of, vec

from jaxrefl import Vec3
from jaxrefl.light import Ambient, Directional, PointLight, Spot, attenuation, spot_effect
from jaxrefl.scene import Scene
from jaxrefl.surface import Phong
from jaxrefl.trace import trace

pytestmark = pytest.mark.usefixtures("quick_compilation")
OFF = {"diffuse": 0.0, "specular": 0.0, "ambient": 0.0}


def array(v) -> np.ndarray:
    return np.stack([np.asarray(x) for x in (v.x, v.y, v.z)], axis=-1)


# ---------------------------------------------------------------- what reaches a point


@pytest.mark.parametrize(
    ("terms", "expected"),
    [((1, 0, 0), 1), ((0.5, 0, 0), 2), ((0, 2, 0), 1 / 6), ((0, 0, 1), 1 / 9), ((1, 0.5, 0.25), 1 / 4.75)],
)
def test_attenuation_at_three_units_is_one_over_the_polynomial(terms, expected):
    assert math.isclose(attenuation(jnp.asarray(3.0), *terms), expected, rel_tol=1e-15)


def test_at_distance_zero_the_attenuation_is_that_of_the_constant_and_zero_without_one():
    slopes = jax.value_and_grad(attenuation, (0, 1, 2, 3))
    value, by = slopes(0.0, 0.5, 1.0, 1.0)
    assert (value, by) == (2, (-4, -4, 0, 0))
    value, by = slopes(0.0, 0.0, 0.0, 1.0)
    assert (value, by) == (0, (0, 0, 0, 0))


def test_a_point_light_shines_the_same_in_every_direction_and_falls_off_with_the_square():
    light = PointLight(Vec3(1.0, 2.0, 3.0), constant=0.0, quadratic=1.0)
    away = np.array([[2.0, 0, 0], [0, -2.0, 0], [0, 0, 2.0], [0, -6.0, 8.0]])
    sent = jax.vmap(light.at)(vec(np.array([1.0, 2.0, 3.0]) + away))
    np.testing.assert_allclose(sent.distance, [2, 2, 2, 10], rtol=1e-15)
    np.testing.assert_allclose(sent.factor, [0.25, 0.25, 0.25, 0.01], rtol=1e-15)
    np.testing.assert_allclose(array(sent.wi), -away / np.linalg.norm(away, axis=1)[:, None], atol=1e-15)


def test_without_numbers_a_point_light_is_not_attenuated():
    assert PointLight(ORIGIN).at(Vec3(*map(jnp.asarray, (1e3, 0.0, 0.0)))).factor == 1


def test_a_directional_light_is_the_same_everywhere_whatever_the_length_of_its_direction():
    p = vec(np.random.default_rng(0).normal(size=(20, 3)) * 1e6)
    for length in (1e-3, 1.0, 1e3):
        sent = jax.vmap(Directional(Vec3(0.0, 0.6 * length, -0.8 * length)).at)(p)
        np.testing.assert_allclose(array(sent.wi), np.tile([0, -0.6, 0.8], (20, 1)), atol=1e-15)
        assert (sent.distance == jnp.inf).all()
        assert (sent.factor == 1).all()


def test_a_spot_falls_off_with_the_power_of_the_cosine_from_its_axis_and_stops_at_its_cutoff():
    spot = Spot(ORIGIN, Vec3(0.0, 0.0, -7.0), exponent=3.5, cutoff=0.6, constant=0.5)
    angle = np.array([0.0, 0.2, 0.59, 0.6, 0.61, 1.5, 2.0, np.pi])
    sent = jax.vmap(spot.at)(vec(np.stack([2 * np.sin(angle), 0 * angle, -2 * np.cos(angle)], axis=-1)))
    expected = np.where(angle <= 0.6, 2 * np.maximum(np.cos(angle), 0) ** 3.5, 0)
    np.testing.assert_allclose(sent.factor, expected, rtol=1e-14)


def test_a_spot_of_exponent_zero_is_a_uniform_cone_and_one_without_cutoff_still_has_a_dark_back():
    cos_angle = jnp.array([1.0, 0.9, 0.5, 0.1, -0.5, -1.0])
    np.testing.assert_array_equal(spot_effect(cos_angle, 0.0, 1.2), [1, 1, 1, 0, 0, 0])
    np.testing.assert_allclose(spot_effect(cos_angle, 2.0, math.pi), [1, 0.81, 0.25, 0.01, 0, 0], rtol=1e-14)


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_every_derivative_of_a_light_is_finite_even_in_the_light_itself(dtype):
    places = vec(np.array([[0, 0, 0], [0, 0, -1], [0, 0, 1], [1, 0, 0], [0.6, 0, -0.8], [1e-12, 0, 0]], dtype))
    spot = Spot(ORIGIN, DOWN, 2.5, math.acos(0.8), constant=0.0, quadratic=1.0)
    for light in (PointLight(ORIGIN, constant=0.0, quadratic=1.0), PointLight(ORIGIN), spot, Directional(DOWN)):
        light = jax.tree.map(lambda x: jnp.asarray(x, dtype), light)

        def total(light, p):
            sent = light.at(p)
            return sent.factor + sent.wi.x + 2 * sent.wi.y + 3 * sent.wi.z

        values, slopes = jax.vmap(jax.value_and_grad(total, (0, 1)), (None, 0))(light, places)
        assert all(jnp.isfinite(x).all() for x in jax.tree.leaves((values, slopes)))


# ---------------------------------------------------------------- what a floor shows


def floor_under(lights, paint, points):
    """What is seen from straight above at points (n, 2) of a floor, with a ball of radius 0.5 at (0, 0, 2) out of sight.

    One structure for all: two lights of each kind, and one without shadows.
    """
    dark = {
        "ambient": Ambient(0.0),
        "sun_a": Directional(DOWN, **OFF),
        "sun_b": Directional(DOWN, **OFF),
        "bulb_a": PointLight(UP, **OFF),
        "bulb_b": PointLight(UP, **OFF),
        "lamp_a": Spot(UP, DOWN, **OFF),
        "lamp_b": Spot(UP, DOWN, **OFF),
        "through": Directional(DOWN, **OFF, shadows=False),
    }
    assert set(lights) <= set(dark)
    lights = {
        name: jax.tree.map(lambda x: jnp.asarray(x, float), {**dark, **lights}[name]) for name in dark
    }
    wide = {name: _spectral(light) for name, light in lights.items()}
    scene = Scene({"ball": ball(Phong(k_d=0.0), 0.5, Vec3(0.0, 0.0, 2.0)), "floor": plane(paint)}, wide)
    n = 8
    at = np.resize(np.asarray(points, float), (n, 2))
    eye = np.concatenate([at, np.full((n, 1), 1.0)], axis=1)  # under the ball
    from jaxrefl.geometry import Ray

    out = trace(scene, Ray(vec(eye), vec(np.tile([0.0, 0.0, -1.0], (n, 1)))), 0, account=False)
    return np.asarray(out.radiance)[: len(points)]


def _spectral(light):
    """The same light with three channels."""
    import dataclasses

    names = [name for name in ("intensity", "diffuse", "specular", "ambient") if hasattr(light, name)]
    return dataclasses.replace(light, **{name: jnp.broadcast_to(getattr(light, name), (3,)) for name in names})
