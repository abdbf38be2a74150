"""The reference tracer against numbers that can be checked by hand: closed forms, and those of the documents."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
import reference_tracer
from reference_tracer import fresnel_conductor, fresnel_dielectric, reference

from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.light import Ambient, Directional, PointLight, Spot
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import D3D9, Blend, Coat, Conductor, Dielectric, Phong, Whitted
from jaxrefl.texture import Checker, ImageTexture
from jaxrefl.vec import Vec3

UP = Vec3(0.0, 0.0, 1.0)
ORIGIN = Vec3(0.0, 0.0, 0.0)
ABOVE = Orthographic(Vec3(0.0, 0.0, 5.0), up=Vec3(0.0, 1.0, 0.0))  # looks down, one unit is half a picture
BLACK = Phong(k_d=0.0)


def lamp(emission) -> Phong:
    return Phong(k_d=0.0, emission=emission)


def plane(surface, point=ORIGIN, normal=UP) -> Object:
    return Object(Plane(point, normal), surface)


def ball(surface, radius=1.0, center=ORIGIN) -> Object:
    return Object(Sphere(center, radius), surface)


def tilted(theta_deg) -> Orthographic:
    """Camera whose rays fall on the horizontal plane at an angle, the middle one at the origin."""
    theta = math.radians(theta_deg)
    return Orthographic(Vec3(-4 * math.sin(theta), 0.0, 4 * math.cos(theta)), up=Vec3(0.0, 1.0, 0.0))


def value(scene, camera, n_bounces=0):
    """Radiance of the middle of the picture, one channel."""
    (radiance,) = reference(scene, camera, 1, 1, n_bounces).ravel()
    return radiance


def offsets(size):
    """Distance from the middle of each pixel of a square picture."""
    x = (2 * np.arange(size) + 1) / size - 1
    return np.hypot(x, x[:, None])


def test_the_reference_imports_nothing_of_the_library():
    tree = ast.parse(Path(reference_tracer.__file__).read_text(encoding="utf-8"))
    names = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    assert names | {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)} == {"numpy", "types"}


# ---------------------------------------------------------------- one hit


def test_fresnel_has_the_documented_values():
    for eta, theta, expected in [
        (1.5, 60, 0.089186712802212783),
        (2.4, 60, 0.20935126077072882),
        (1 / 1.33, 45, 0.13418671521276993),
        (1 / 1.5, 45, 1),
    ]:
        assert math.isclose(fresnel_dielectric(math.cos(math.radians(theta)), eta), expected, rel_tol=1e-13)
    for eta, k, theta, expected in [
        (0.43, 2.455, 60, 0.78813190320326089),
        (1.0728, 6.7839, 85, 0.87353290037473085),
        (0.5, 1e-6, 60, 0.99999734299652837),
        (1.5, 0.1, 60, 0.091713548781009321),
    ]:
        assert math.isclose(fresnel_conductor(math.cos(math.radians(theta)), eta, k), expected, rel_tol=1e-13)


def test_a_frontal_lambert_sphere_shows_the_cosine_and_on_average_two_thirds():
    sun = Directional(Vec3(0.0, 0.0, -2.0), diffuse=[1.0, 2.0, 4.0])
    picture = reference(Scene({"ball": ball(Phong(k_d=0.9))}, {"sun": sun}), ABOVE, 32, 32, 0)
    inside = offsets(32) < 1
    assert picture.shape == (32, 32, 3)
    assert (picture[~inside] == 0).all()
    cosine = np.sqrt(1 - offsets(32)[inside] ** 2)
    np.testing.assert_allclose(picture[inside], 0.9 * cosine[:, None] * np.array([1, 2, 4]), rtol=1e-12)
    mean = picture.sum(axis=(0, 1)) / (math.pi * 16**2)  # over the area of the disc
    np.testing.assert_allclose(mean, 0.6 * np.array([1, 2, 4]), rtol=4e-3)  # the sum over pixels errs by 2e-3


@pytest.mark.parametrize("highlight", ["half_vector", "mirror"])
def test_a_frontal_highlight_is_a_power_of_its_own_cosine(highlight):
    surface = Phong(k_d=0.0, k_s=0.5, shininess=3.5, highlight=highlight)
    picture = reference(Scene({"ball": ball(surface)}, {"sun": Directional(Vec3(0.0, 0.0, -1.0))}), ABOVE, 8, 8, 0)
    mu = np.sqrt(np.maximum(1 - offsets(8) ** 2, 0))
    lobe = mu if highlight == "half_vector" else np.maximum(2 * mu * mu - 1, 0)
    np.testing.assert_allclose(picture[..., 0], 0.5 * lobe**3.5, rtol=1e-12, atol=1e-15)


def test_point_light_spot_and_ambient_terms_add_as_printed():
    paint = Phong(k_d=0.5, k_s=0.0, k_a=0.25, emission=0.125)
    fall = {"constant": 1.0, "linear": 0.5, "quadratic": 0.25}
    lights = {
        "everywhere": Ambient(0.4),
        "bulb": PointLight(Vec3(0.0, 0.0, 2.0), diffuse=3.0, ambient=0.8, **fall),  # 1 / (1 + 1 + 1)
        "hidden": PointLight(Vec3(0.0, 0.0, -2.0), ambient=0.8, **fall),  # behind the floor: ambient alone
        "lamp": Spot(Vec3(3.0, 0.0, 4.0), Vec3(0.0, 0.0, -1.0), exponent=2.0, cutoff=0.7, diffuse=2.0),
        "narrow": Spot(Vec3(3.0, 0.0, 4.0), Vec3(0.0, 0.0, -1.0), exponent=2.0, cutoff=0.6, diffuse=2.0),
    }  # the floor is seen by both spots at acos(4/5) = 0.6435
    by_hand = 0.125 + 0.4 * 0.25 + (0.8 * 0.25 + 3 * 0.5) / 3 + 0.8 * 0.25 / 3 + 0.8**2 * 2 * 0.5 * 0.8
    assert math.isclose(value(Scene({"floor": plane(paint)}, lights), ABOVE), by_hand, rel_tol=1e-14)


def test_a_shadow_takes_diffuse_light_and_leaves_ambient():
    objects = {"floor": plane(Phong(k_d=0.5, k_a=0.25)), "ball": ball(BLACK, 0.5, Vec3(0.0, 0.0, 1.0))}
    camera = tilted(60)
    for shadows, light in [(True, 0.0), (False, 1.0)]:
        sun = Directional(Vec3(0.0, 0.0, -1.0), diffuse=1.0, ambient=0.4, shadows=shadows)
        assert math.isclose(value(Scene(objects, {"sun": sun}), camera), 0.1 + 0.5 * light, rel_tol=1e-14)
    for height, light in [(0.25, 0.5), (1.75, 0.0)]:  # a bulb under the ball lights the floor, one above it does not
        bulb = PointLight(Vec3(0.0, 0.0, height))
        assert math.isclose(value(Scene(objects, {"bulb": bulb}), camera), light, abs_tol=1e-15)


def test_textures_follow_the_coordinates_of_the_shape():
    thirds = Checker(0.75, 0.25, 3.0, 2.0)  # of a sphere: azimuths of 120 degrees, two hemispheres
    picture = reference(Scene({"ball": ball(lamp(thirds))}), ABOVE, 4, 4, 0)
    np.testing.assert_array_equal(picture[1:3, 1:3, 0], [[0.25, 0.75], [0.25, 0.75]])  # 135, 45; 225, 315 degrees
    ramp = ImageTexture(np.array([[[0.0], [1.0]], [[2.0], [3.0]]]), 0.25, 0.25)  # pixels two units wide
    picture = reference(Scene({"floor": plane(lamp(ramp), Vec3(-2.0, -2.0, 0.0))}), ABOVE, 4, 4, 0)
    x = np.array([-0.75, -0.25, 0.25, 0.75])
    np.testing.assert_allclose(picture[..., 0], 0.5 * (x + 1) - x[:, None] + 1, rtol=1e-14)


def test_the_pinhole_looks_through_the_centres_of_its_pixels():
    level = Pinhole(ORIGIN, Vec3(1.0, 0.0, 0.0), UP, math.pi / 2)
    picture = reference(Scene(background=Sky([1.0, 0.0], [0.0, 0.0], [0.0, 1.0])), level, 4, 2, 0)
    slope = 0.5 / np.sqrt(1.25 + np.array([1.5, 0.5, 0.5, 1.5]) ** 2)
    np.testing.assert_allclose(picture, [[(s, 0) for s in slope], [(0, s) for s in slope]], rtol=1e-14)


# ---------------------------------------------------------------- the series and the tree


@pytest.mark.parametrize(("model", "expected"), [("additive", 0.83), ("convex", 0.5)])
def test_three_surfaces_in_a_row_have_the_value_of_the_document(model, expected):
    def mirror(color, k):
        return Whitted(lamp(color), k) if model == "additive" else Blend(lamp(color), k)

    objects = {  # down to the first, to the right to the second, up to the third
        "first": plane(mirror(0.6, 0.5), ORIGIN, Vec3(1.0, 0.0, 1.0)),
        "second": plane(mirror(0.3, 0.2), Vec3(3.0, 0.0, 0.0), Vec3(-1.0, 0.0, 1.0)),
        "third": plane(lamp(0.8), Vec3(0.0, 0.0, 2.0), Vec3(0.0, 0.0, -1.0)),
    }
    camera = Orthographic(Vec3(0.0, 0.0, 1.0), up=Vec3(0.0, 1.0, 0.0))
    assert math.isclose(value(Scene(objects, background=9.0), camera, 2), expected, rel_tol=1e-14)


@pytest.mark.parametrize(("model", "expected"), [(Blend, 0.455145056256), (Whitted, 2.73680702976)])
def test_two_facing_mirrors_have_the_sum_of_the_corridor(model, expected):
    objects = {
        "a": plane(model(lamp(0.3), 0.9)),
        "b": plane(model(lamp(0.7), 0.8), Vec3(0.0, 0.0, 9.0), Vec3(0.0, 0.0, -1.0)),
    }
    assert math.isclose(value(Scene(objects), ABOVE, 10), expected, rel_tol=1e-12)


def test_a_homogeneous_tree_has_the_sum_of_its_levels():
    sheets = Plane(Vec3(0.0, 0.0, np.arange(-6.0, 7.0)), UP)  # between them every ray hits, whichever way it goes
    tree = Scene({"sheets": Object(sheets, Whitted(lamp(0.1), 0.3, 0.5))})
    camera = Orthographic(Vec3(0.0, 0.0, 0.5), up=Vec3(0.0, 1.0, 0.0))
    assert math.isclose(value(tree, camera, 5), 0.368928, rel_tol=1e-13)


def test_reflected_rays_fade_with_their_own_extinction():
    mirror = Whitted(BLACK, k_rg=0.5, sigma_rg=[0.0, 0.25])
    lid = plane(lamp(0.8), Vec3(0.0, 0.0, 8.0), Vec3(0.0, 0.0, -1.0))
    faded = reference(Scene({"lid": lid, "mirror": plane(mirror)}), ABOVE, 1, 1, 1)[0, 0]
    np.testing.assert_allclose(faded, [0.4, 0.4 * math.exp(-2)], rtol=1e-14)
    escaped = reference(Scene({"mirror": plane(mirror)}, background=1.0), ABOVE, 1, 1, 1)[0, 0]
    np.testing.assert_array_equal(escaped, [0.5, 0.0])


# ---------------------------------------------------------------- the sources' surfaces, glass and metal


def test_d3d9_reflects_by_equation_five_and_dims_the_base_by_six_and_eight():
    camera, sun = tilted(60), Directional(Vec3(0.0, -math.sqrt(3), -1.0))  # both at 60 degrees, R = 0.07
    shiny = Scene({"floor": plane(D3D9(BLACK, metallic=0.7))}, background=1.0)
    assert math.isclose(value(shiny, camera, 1), 0.721, rel_tol=1e-13)
    for sun_fresnel, dim in [(False, 1.0), (True, 0.93)]:
        paint = D3D9(Phong(k_d=0.5, emission=0.2), metallic=[0.7, 0.1, 0.4], sun_fresnel=sun_fresnel)
        picture = reference(Scene({"floor": plane(paint)}, {"sun": sun}), camera, 1, 1, 0)
        np.testing.assert_allclose(picture[0, 0], 0.3 * (0.2 + 0.5 * 0.5 * dim), rtol=1e-13)


def test_metal_and_coat_reflect_the_exact_fraction():
    gold = Scene({"floor": plane(Conductor([0.43, 1.38], [2.455, 1.914]))}, background=1.0)
    picture = reference(gold, tilted(60), 1, 1, 1)[0, 0]
    np.testing.assert_allclose(picture, [0.78813190320326089, 0.43979866663659919], rtol=1e-13)
    coat = Scene({"floor": plane(Coat(lamp(0.5)))}, background=2.0)
    assert math.isclose(value(coat, tilted(60), 1), 0.5 + 1.5 * 0.089186712802212783, rel_tol=1e-13)


def test_a_lossless_glass_sphere_sends_on_what_its_truncated_series_says():
    glass = Scene({"ball": ball(Dielectric(1.5))}, background=1.0)
    inside = offsets(6) < 1
    fresnel = np.array([fresnel_dielectric(math.sqrt(1 - s * s), 1.5) for s in offsets(6)[inside]])
    for n_bounces in (1, 2, 4, 8):
        missing = 1 - reference(glass, ABOVE, 6, 6, n_bounces)[inside][:, 0]
        np.testing.assert_allclose(missing, (1 - fresnel) * fresnel ** (n_bounces - 1), rtol=1e-7, atol=2e-15)


def test_an_absorbing_sphere_is_a_slab_to_the_ray_through_its_centre():
    glass = Scene({"ball": ball(Dielectric(1.5, sigma=0.25))}, background=1.0)
    assert math.isclose(value(glass, ABOVE, 20), 0.05356949482041847 + 0.5593078685769788, rel_tol=1e-14)


def test_a_slab_of_glass_moves_the_ray_by_the_documented_length():
    ramp = ImageTexture(np.array([[[0.0], [1.0]]]), 0.1, 1.0)  # 0.2 u - 0.5 for u in [2.5, 7.5]
    floor = {"floor": plane(lamp(ramp), Vec3(-1.0, 0.0, -2.0))}
    glass = {
        "top": plane(Dielectric(1.5)),
        "under": plane(Dielectric(1.5), Vec3(0.0, 0.0, -1.0), Vec3(0.0, 0.0, -1.0)),
    }
    straight = value(Scene(floor), tilted(60))
    bent = value(Scene(floor | glass), tilted(60), 2) / (1 - 0.089186712802212783) ** 2
    assert math.isclose((straight - bent) / 0.2 * math.cos(math.radians(60)), 0.51247201319116488, rel_tol=1e-12)


def test_what_shines_in_water_is_divided_by_the_square_of_the_index():
    pool = {"water": plane(Dielectric(1.5)), "floor": plane(lamp(0.8), Vec3(0.0, 0.0, -3.0))}
    assert math.isclose(value(Scene(pool), ABOVE, 1), 0.96 * 0.8 / 2.25, rel_tol=1e-14)
    assert math.isclose(value(Scene({"water": pool["water"]}, background=1.0), ABOVE, 1), 0.04 + 0.96 / 2.25)
    milk = plane(Whitted(lamp(0.3), k_tg=1.0, eta=1.5))  # shines too, and is seen again in the floor
    floor = plane(Whitted(lamp(0.8), k_rg=0.5), Vec3(0.0, 0.0, -3.0))
    assert math.isclose(value(Scene({"milk": milk, "floor": floor}), ABOVE, 2), 0.3 + (0.8 + 0.5 * 0.3) / 2.25)


def test_total_reflection_joins_the_transmitted_ray_to_the_reflected_one():
    bubble = Scene({"ball": ball(Whitted(BLACK, 0.25, 0.5, eta=0.5))}, background=1.0)
    picture = reference(bubble, ABOVE, 4, 4, 1)[..., 0]
    np.testing.assert_allclose(picture[1, 1], 0.25, rtol=1e-15)  # at 0.35 the ray enters, and ends inside
    np.testing.assert_allclose(picture[0, 1], 0.75, rtol=1e-15)  # at 0.79 sin theta is beyond eta
    np.testing.assert_allclose(reference(bubble, ABOVE, 4, 4, 2)[1, 1, 0], 0.25 + 0.5 * 0.5, rtol=1e-15)


# ---------------------------------------------------------------- order


def test_of_equal_distances_the_first_name_wins_and_then_the_first_of_its_axis():
    shape = Plane(Vec3(0.0, 0.0, np.zeros(2)), UP)
    objects = {"b": plane(lamp(0.1)), "a": Object(shape, lamp(np.array([[0.2, 0.4], [0.6, 0.8]])))}
    np.testing.assert_array_equal(reference(Scene(objects), ABOVE, 1, 1, 0)[0, 0], [0.2, 0.4])
    above = Plane(Vec3(0.0, 0.0, np.array([0.0, 1.0])), UP)
    nearer = Scene(objects | {"a": Object(above, objects["a"].surface)})
    np.testing.assert_array_equal(reference(nearer, ABOVE, 1, 1, 0)[0, 0], [0.6, 0.8])
