"""Lights: what reaches a point, alone and all together on a floor under a ball that casts shadows."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import ABOVE, DOWN, ORIGIN, UP, ball, plane, rays_of, vec
from tracer_scenes import quick_trace as trace

from jaxrefl import Vec3
from jaxrefl.geometry import Ray
from jaxrefl.light import Ambient, Directional, PointLight, Spot, attenuation, spot_effect
from jaxrefl.scene import Scene
from jaxrefl.surface import Phong

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

WHITE = Phong(k_d=1.0, k_s=0.0, k_a=0.0)
UNDER, BESIDE = (0.1, 0.2), (2.0, 0.0)  # on the floor: in the shadow of what shines straight down, and out of it
RED, GREEN, BLUE = np.eye(3)


def spectral(light):
    """The same light with three channels, all strongly typed: one structure, one compilation."""
    names = [name for name in ("intensity", "diffuse", "specular", "ambient") if hasattr(light, name)]
    wide = {name: np.broadcast_to(getattr(light, name), (3,)) for name in names}
    return jax.tree.map(lambda x: jnp.asarray(x, float), dataclasses.replace(light, **wide))


def floor_shows(paint, *points, **lights):
    """Radiance of points of the floor z = 0 seen from straight above; a ball of radius 0.5 floats at (0, 0, 2)."""
    dark = {
        "ambient": Ambient(0.0),
        "sun_a": Directional(DOWN, **OFF),
        "sun_b": Directional(DOWN, **OFF),
        "bulb_a": PointLight(UP, **OFF),
        "bulb_b": PointLight(UP, **OFF),
        "lamp_a": Spot(UP, DOWN, **OFF),
        "lamp_b": Spot(UP, DOWN, **OFF),
        "ghost": Directional(DOWN, **OFF, shadows=False),
    }
    names = ("k_d", "k_s", "k_a", "emission")
    paint = dataclasses.replace(paint, **{name: np.broadcast_to(getattr(paint, name), (3,)) for name in names})
    assert set(lights) <= set(dark)
    all_lights = {name: spectral(light) for name, light in (dark | lights).items()}
    scene = Scene({"ball": ball(Phong(k_d=0.0), 0.5, Vec3(0.0, 0.0, 2.0)), "floor": plane(paint)}, all_lights)
    eye = np.resize([(x, y, 1.0) for x, y in points], (8, 3))  # below the ball
    out = trace(scene, Ray(vec(eye), vec(np.tile([0.0, 0.0, -1.0], (8, 1)))), 0, account=False)
    return np.asarray(out.radiance)[: len(points)]


@pytest.mark.parametrize(
    "light",
    [
        {"sun_a": Directional(DOWN, diffuse=[0.5, 2.0, 7.0])},
        {"bulb_b": PointLight(Vec3(*BESIDE, 3.0), diffuse=[0.5, 2.0, 7.0])},
        {"lamp_a": Spot(Vec3(*BESIDE, 3.0), DOWN, 20.0, 0.1, diffuse=[0.5, 2.0, 7.0])},
        {"ghost": Directional(DOWN, diffuse=[0.5, 2.0, 7.0], shadows=False)},
    ],
)
def test_a_white_lambert_floor_that_faces_a_light_shows_its_intensity(light):
    np.testing.assert_allclose(floor_shows(WHITE, BESIDE, **light), [[0.5, 2, 7]], rtol=1e-14)


def test_global_ambient_light_is_intensity_times_coefficient_everywhere():
    paint = Phong(k_d=0.3, k_s=0.9, k_a=[0.1, 0.2, 0.4], emission=[0.0, 0.0, 1.0])
    shown = floor_shows(paint, UNDER, BESIDE, ambient=Ambient([2.0, 3.0, 5.0]))
    np.testing.assert_allclose(shown, [[0.2, 0.6, 3]] * 2, rtol=1e-15)


def test_the_ambient_intensity_of_a_light_is_attenuated_by_distance_and_cone_but_not_shadowed():
    paint, fall = Phong(k_d=1.0, k_a=0.5), {"constant": 0.5, "linear": 0.25, "quadratic": 0.125}
    attenuated = 1 / (0.5 + 0.25 * 5 + 0.125 * 25)
    above, at_side = Vec3(0.0, 0.0, 5.0), (5.0 * 0.75, 0.0)  # distance 5 and 6.25, cosines 1 and 0.8
    bulb = PointLight(above, diffuse=2.0, ambient=[1.0, 2.0, 3.0], **fall)
    in_shadow = floor_shows(paint, (0.0, 0.0), bulb_a=bulb)
    np.testing.assert_allclose(in_shadow, [0.5 * attenuated * np.array([1, 2, 3])], rtol=1e-14)
    lamp = Spot(above, DOWN, 3.0, 0.7, diffuse=0.0, ambient=1.0, **fall)
    shown = floor_shows(paint, (0.0, 0.0), at_side, (6.0, 0.0), lamp_b=lamp)[:, 0]
    aside = 0.5 * 0.8**3 / (0.5 + 0.25 * 6.25 + 0.125 * 6.25**2)
    np.testing.assert_allclose(shown, [0.5 * attenuated, aside, 0], rtol=1e-14)
    sun = Directional(DOWN, diffuse=1.0, ambient=0.5)
    np.testing.assert_allclose(floor_shows(paint, UNDER, BESIDE, sun_b=sun)[:, 0], [0.25, 1.25], rtol=1e-15)


def test_a_light_below_the_floor_gives_its_ambient_part_alone():
    paint, below = Phong(k_d=1.0, k_s=1.0, k_a=0.5), Vec3(2.0, 0.0, -1.0)
    lights = {"bulb_a": PointLight(below, ambient=0.6), "sun_a": Directional(UP, ambient=0.2)}
    np.testing.assert_allclose(floor_shows(paint, BESIDE, **lights)[0], 0.4, rtol=1e-15)


def test_diffuse_and_specular_intensities_are_separate():
    """The light falls at 60 degrees; H is 30 degrees from the normal, and the viewer straight above."""
    slanting = Vec3(0.0, -math.sqrt(3), -1.0)
    for k_d, k_s, expected in [(RED, 0.0, RED * 0.5), (0.0, GREEN, 4 * GREEN * 0.75**2), (RED, GREEN, None)]:
        sun = Directional(slanting, diffuse=[1.0, 9.0, 9.0], specular=[9.0, 4.0, 9.0])
        shown = floor_shows(Phong(k_d=k_d, k_s=k_s, shininess=4.0), BESIDE, sun_a=sun)[0]
        np.testing.assert_allclose(shown, RED * 0.5 + 4 * GREEN * 0.75**2 if expected is None else expected, atol=1e-14)


def test_a_ball_shades_the_floor_from_what_is_behind_it_and_not_from_what_is_before():
    down, through = Directional(DOWN), Directional(DOWN, shadows=False)
    np.testing.assert_array_equal(floor_shows(WHITE, UNDER, BESIDE, sun_a=down)[:, 0], [0, 1])
    np.testing.assert_array_equal(floor_shows(WHITE, UNDER, BESIDE, ghost=through)[:, 0], [1, 1])
    for height, seen in [(1.2, 1.0), (3.5, 0.0)]:
        bulb, lamp = PointLight(Vec3(0.0, 0.0, height)), Spot(Vec3(0.0, 0.0, height), DOWN)
        assert floor_shows(WHITE, (0.0, 0.0), bulb_a=bulb)[0, 0] == seen
        assert floor_shows(WHITE, (0.0, 0.0), lamp_a=lamp)[0, 0] == seen


def test_in_the_light_itself_a_floor_shows_a_finite_radiance():
    for fall in ({}, {"constant": 0.0, "quadratic": 1.0}):
        light = PointLight(Vec3(*BESIDE, 0.0), ambient=1.0, **fall)
        shown = floor_shows(Phong(k_d=1.0, k_s=1.0, k_a=0.5), BESIDE, bulb_a=light)
        np.testing.assert_array_equal(shown, 0.0 if fall else 0.5)


def test_lights_of_every_kind_add_up():
    paint = Phong(k_d=[0.5, 0.4, 0.3], k_s=[0.2, 0.3, 0.1], k_a=0.2, shininess=7.0)
    lights = {
        "ambient": Ambient([0.1, 0.2, 0.3]),
        "sun_a": Directional(Vec3(0.3, 0.1, -1.0), ambient=0.1),
        "sun_b": Directional(Vec3(-0.5, 0.2, -1.0), [0.2, 0.4, 0.1], 0.7),
        "bulb_a": PointLight(Vec3(1.0, 1.0, 2.0), 0.8, [0.1, 0.9, 0.4], 0.2, 0.2, 0.1, 0.3),
        "bulb_b": PointLight(Vec3(3.0, -1.0, 1.0), 0.3, 0.2, 0.0, 0.5),
        "lamp_a": Spot(Vec3(2.0, 0.0, 3.0), DOWN, 2.0, 0.9, [0.5, 0.1, 0.2], 0.4, 0.1, 0.3),
        "lamp_b": Spot(Vec3(1.0, -1.0, 2.0), Vec3(0.5, 0.5, -1.0), 1.5, 1.2, 0.4, 0.4),
        "ghost": Directional(Vec3(0.2, -0.4, -1.0), 0.1, 0.6, shadows=False),
    }
    places = (UNDER, BESIDE, (1.3, 0.4))
    alone = sum(floor_shows(paint, *places, **{name: light}) for name, light in lights.items())
    np.testing.assert_allclose(floor_shows(paint, *places, **lights), alone, rtol=1e-13)


def test_there_may_be_any_number_of_each_light():
    rng, paint = np.random.default_rng(3), Phong(k_d=[0.5, 0.4, 0.3], k_s=0.3, shininess=6.0, k_a=0.2)
    many = {f"bulb {i}": PointLight(Vec3(*rng.uniform(-2, 2, 2), 3.0), rng.random(), ambient=0.1) for i in range(35)}
    many |= {f"spot {i}": Spot(Vec3(*rng.uniform(-1, 1, 2), 4.0), DOWN, 3.0, 0.6, rng.random(3)) for i in range(3)}
    many |= {f"sky {i}": Ambient(rng.random(3)) for i in range(2)}
    objects = {"ball": ball(paint, 0.4, UP), "floor": plane(paint)}
    for lights in ({}, many):
        scene = Scene(objects, lights)
        shown = trace(scene, rays_of(ABOVE, 6, 6), 0, account=False).radiance
        expected = reference(scene, ABOVE, 6, 6, 0).reshape(36, -1)
        np.testing.assert_allclose(shown, np.broadcast_to(expected, shown.shape), rtol=1e-12, atol=1e-15)
        assert (shown > 0).all() == bool(lights)
