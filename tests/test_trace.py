"""The tracer: against a second implementation, its series, its budget, its derivatives, its transformations."""

import dataclasses
import functools
import logging
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import (
    BLACK,
    DOWN,
    ORIGIN,
    UP,
    VIEW,
    ball,
    lamp,
    plane,
    quick_jit,
    quick_trace,
    rays_of,
    vec,
    zoo,
)

from jaxrefl import Vec3
from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.geometry import Plane, Ray, Sphere
from jaxrefl.light import Ambient, Directional, PointLight
from jaxrefl.scene import Object, Scene, Sky, canonical, canonical_model, primitive_names
from jaxrefl.scene_file import example, examples, load
from jaxrefl.series import Layers, iterative
from jaxrefl.surface import D3D9, Blend, Coat, Dielectric, Phong, Whitted
from jaxrefl.texture import Checker
from jaxrefl.trace import follow, radiance, trace

pytestmark = pytest.mark.usefixtures("quick_compilation")


def along(tree, rng, part="") -> object:
    """Random direction in the space of all leaves whose path contains a word, each by its own size; 0 in the others."""

    def step(path, x):
        size = np.abs(x) + 0.1 * (part in jax.tree_util.keystr(path) and np.abs(x).max() > 0)
        wanted = part in jax.tree_util.keystr(path)
        return jnp.asarray(rng.uniform(-1, 1, x.shape) * size * wanted, x.dtype)

    return jax.tree_util.tree_map_with_path(step, tree)


def moved(tree, direction, h):
    return jax.tree.map(lambda x, d: x + jnp.asarray(h, x.dtype) * d, tree, direction)


def dot_of(a, b):
    return sum(float(jnp.vdot(x, y)) for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True))


def all_finite(tree) -> bool:
    return all(bool(jnp.isfinite(x).all()) for x in jax.tree.leaves(tree))


# ---------------------------------------------------------------- every model at once

WIDE, HIGH = 18, 12


@functools.cache
def look_at_zoo():
    return quick_trace(zoo(), rays_of(VIEW, WIDE, HIGH), 2, terms=True)


def test_a_scene_with_every_model_has_the_radiance_of_the_reference_tracer():
    out = look_at_zoo()
    expected = reference(zoo(), VIEW, WIDE, HIGH, 2).reshape(-1, 3)
    np.testing.assert_allclose(out.radiance, expected, rtol=1e-12, atol=1e-12)
    names = primitive_names(zoo())
    assert len({names[i] for i in np.unique(out.primitive) if i >= 0}) == len(zoo().objects)  # each is seen


def test_the_terms_of_a_tree_add_up_to_the_radiance_and_its_budget_is_nowhere_negative():
    out = look_at_zoo()
    total = (out.terms.weight * out.terms.local * out.terms.color).sum(axis=1)
    np.testing.assert_allclose(total, out.radiance, rtol=1e-13, atol=1e-14)
    shown = (out.terms.weight * out.terms.local).sum(axis=1)
    np.testing.assert_allclose(out.account.budget.shaded + out.account.budget.escaped, shown, rtol=1e-13, atol=1e-14)
    assert min(float(x.min()) for x in out.account.budget) >= 0
    assert (out.account.hits <= out.account.rays).all()
    assert (out.account.rays <= 7).all()  # of a full tree of depth 2


# ---------------------------------------------------------------- the shipped scenes


@pytest.mark.parametrize("name", sorted(examples()))
def test_a_shipped_scene_is_that_of_the_reference_tracer_with_every_derivative_finite_and_right(name):
    file, w, h = load(example(name)), 10, 6
    world = canonical(file.scene), canonical_model(file.camera, float)

    @quick_jit
    def values_and_slopes(world, weights):
        def weighted(world):
            out = trace(world[0], rays_of(world[1], w, h), 2)
            return jnp.vdot(out.radiance, weights[:, None] * jnp.ones(file.channels)), out

        return jax.value_and_grad(weighted, has_aux=True)(world)

    (_, out), slopes = values_and_slopes(world, jnp.ones(w * h))
    expected = reference(file.scene, file.camera, w, h, 2).reshape(w * h, -1)
    np.testing.assert_allclose(out.radiance, expected, rtol=1e-11, atol=1e-12)
    assert all_finite((out.radiance, slopes))
    direction, step = along(world, np.random.default_rng(1)), 1e-7  # a texture has edges that no path_id tells
    up, down = (values_and_slopes(moved(world, direction, s), jnp.ones(w * h))[0][1] for s in (step, -step))
    same = (up.account.path_id == down.account.path_id) & (up.account.path_id == out.account.path_id)
    assert same.mean() > 0.9
    slope = dot_of(values_and_slopes(world, jnp.asarray(same, float))[1], direction)
    quotient = float(((up.radiance - down.radiance) * same[:, None]).sum()) / (2 * step)
    assert math.isclose(slope, quotient, rel_tol=1e-6)


# ---------------------------------------------------------------- a ball of glass: one structure, many numbers


def lens(k_rg=0.2, k_tg=0.6, eta=1.4, sigma=0.2, light=1.0, height=0.9):
    """A ball of coloured glass that shines, in the light of a bulb and the sky."""
    glass = Whitted(Phong([0.5, 0.4, 0.3], 0.2, 9.0, 0.0, 0.25), k_rg, k_tg, eta, sigma, sigma)
    bulb, sky = PointLight(Vec3(1.0, -2.0, 3.0), light, light), Sky([0.2, 0.5, 0.9], [0.2, 0.4, 0.6], [0.1, 0.3, 0.2])
    return Scene({"ball": ball(glass, 0.8, UP * height)}, {"bulb": bulb}, sky)


def room(alpha=0.3, **numbers):
    """The same on a mirror floor that shines."""
    scene = lens(**numbers)
    return dataclasses.replace(scene, objects=scene.objects | {"floor": plane(Blend(lamp(0.125), alpha))})


NEAR = Pinhole(Vec3(0.2, -3.0, 1.5), Vec3(0.0, 0.0, 0.8), field_of_view=0.9)
SKYWARDS = Pinhole(Vec3(0.2, -3.0, 1.5), Vec3(0.0, 3.0, 4.5), field_of_view=1.05)  # the ball looks in at the lower edge


@quick_jit
def look_at_lens(world, direction, weights):
    """Trace of 64 rays; derivative of the radiance along a direction; derivative of a weighted sum, backwards."""

    def shoot(world):
        out = trace(*world, 3, terms=True)
        return out.radiance, out

    _, forward, out = jax.jvp(shoot, (world,), (direction,), has_aux=True)
    return out, forward, jax.grad(lambda world: jnp.vdot(shoot(world)[0], weights))(world)


def lens_world(camera=NEAR, dtype=float, **numbers):
    """Scene and rays; every number of both is a leaf."""
    return jax.tree.map(lambda x: jnp.asarray(x, dtype), (canonical(lens(**numbers)), rays_of(camera, 8, 8)))


def seen(world, direction=None, weights=None):
    dtype = world[0].background.zenith.dtype
    direction = jax.tree.map(jnp.zeros_like, world) if direction is None else direction
    return look_at_lens(world, direction, jnp.ones((64, 3), dtype) if weights is None else weights)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_forward_and_reverse_derivatives_agree(dtype, tolerance):
    world, rng = lens_world(dtype=dtype), np.random.default_rng(0)
    parts = ("radius", "center", "k_tg", "eta", "sigma_tg", "emission", "bulb", "zenith", "origin", "")
    for part in parts:
        direction, weights = along(world, rng, part), jnp.asarray(rng.random((64, 3)), dtype)
        out, forward, backward = seen(world, direction, weights)
        terms = np.asarray(forward, float) * np.asarray(weights, float)
        assert abs(terms.sum() - dot_of(backward, direction)) <= tolerance * np.abs(terms).sum()
        assert all_finite((out.radiance, forward, backward))
        assert {x.dtype for x in jax.tree.leaves((forward, backward))} == {np.dtype(dtype)}


def test_a_scene_in_float32_is_traced_in_float32_with_64_bits_at_hand():
    shapes = jax.eval_shape(lambda world: trace(*world, 1, terms=True), lens_world(dtype=np.float32))
    others = {jax.tree_util.keystr(k): str(x.dtype) for k, x in jax.tree_util.tree_leaves_with_path(shapes)}
    assert {k: dtype for k, dtype in others.items() if dtype not in ("float32", "int32", "uint32")} == {}


@pytest.mark.parametrize("part", ["shape", "surface", "lights", "background", "origin", "direction", ""])
def test_the_derivative_of_each_ray_is_the_difference_quotient_where_no_edge_lies_between(part):
    world, h = lens_world(), 1e-6
    direction = along(world, np.random.default_rng(len(part)), part)
    (out, slope, _), (up, *_), (down, *_) = (seen(moved(world, direction, s), direction) for s in (0, h, -h))
    same = (up.account.path_id == down.account.path_id) & (up.account.path_id == out.account.path_id)
    assert same.mean() > 0.97
    quotient, size = (up.radiance - down.radiance) / (2 * h), float(jnp.abs(slope).max())
    np.testing.assert_allclose(slope[same], quotient[same], rtol=1e-5, atol=1e-6 * size)
    assert size > 1e-3


def test_every_derivative_of_an_image_that_is_mostly_sky_is_finite():
    out, forward, backward = seen(lens_world(SKYWARDS), along(lens_world(SKYWARDS), np.random.default_rng(2)))
    assert 0 < (out.primitive >= 0).mean() < 0.2
    assert all_finite((forward, backward))
    assert float(jnp.abs(backward[0].objects["ball"].surface.eta).sum()) > 0
    empty = lens_world(dataclasses.replace(SKYWARDS, target=Vec3(0.0, 3.0, 40.0)))
    out, forward, backward = seen(empty, along(empty, np.random.default_rng(3)))
    assert (out.primitive < 0).all()
    assert all_finite((forward, backward))
    assert float(jnp.abs(backward[0].background.zenith).sum()) > 0


def test_the_derivative_in_a_reflectivity_of_zero_is_what_the_mirror_would_show_less_what_is_seen():
    """c = (1 - alpha) c_0 + alpha c_1 at alpha = 0: a floor that shows 0.125 under a lamp of 0.25 and a sky of 0.5."""
    lamps = ball(lamp(0.25), 1.2, Vec3(0.0, 1.5, 2.0))

    def shown(alpha):
        scene = Scene({"floor": plane(Blend(lamp(0.125), alpha)), "lamp": lamps}, background=0.5)
        out = trace(scene, rays_of(NEAR, 8, 8), 1, terms=True)
        return out.radiance[:, 0], out

    _, slope, out = quick_jit(lambda alpha: jax.jvp(shown, (alpha,), (1.0,), has_aux=True))(0.0)
    floor, behind = np.asarray(out.primitive) == 0, np.asarray(out.terms.color)[:, 1, 0]
    assert {*behind[floor]} == {0.25, 0.5}
    np.testing.assert_allclose(slope, np.where(floor, behind - 0.125, 0), rtol=1e-14)


def test_the_derivative_in_a_transmission_of_zero_is_what_the_glass_would_show():
    """The ray ends where it would leave: d c / d k_tg = E exp(-sigma chord) / eta^2."""
    eta, sigma, camera = 1.4, 0.7, Orthographic(Vec3(0.0, -5.0, 0.9), UP * 0.9, height=1.5)
    world = lens_world(camera, k_rg=0.0, k_tg=0.0, light=0.0, eta=eta, sigma=sigma)
    direction = jax.tree.map(jnp.zeros_like, world)
    surface = dataclasses.replace(direction[0].objects["ball"].surface, k_tg=jnp.ones((1, 1)))
    direction[0].objects["ball"] = dataclasses.replace(direction[0].objects["ball"], surface=surface)
    out, forward, _ = seen(world, direction)
    x = (np.arange(8) + 0.5) / 8 * 1.5 - 0.75
    impact = np.hypot(x, x[:, None]).ravel() / 0.8
    hit = np.asarray(out.primitive) == 0
    np.testing.assert_array_equal(hit, impact < 1)
    chord = 1.6 * np.sqrt(1 - (impact[hit] / eta) ** 2)
    expected = 0.25 * np.exp(-sigma * chord) / eta**2
    np.testing.assert_allclose(forward[hit], np.repeat(expected[:, None], 3, axis=1), rtol=1e-12)


def test_at_zero_bounces_there_is_one_term_and_what_lies_behind_is_truncated():
    out = quick_trace(room(k_rg=0.0, k_tg=0.0), rays_of(NEAR, 8, 8), 0, terms=True)
    shown = out.terms.weight[:, 0] * out.terms.local[:, 0] * out.terms.color[:, 0]
    np.testing.assert_allclose(shown, out.radiance, rtol=1e-15)
    np.testing.assert_array_equal(out.terms.weight[:, 1:], 0)
    assert (out.account.rays == 1).all()
    floor = np.asarray(out.primitive) == 1
    np.testing.assert_allclose(out.account.budget.truncated[floor], 0.3, rtol=1e-15)
    np.testing.assert_allclose(out.account.budget.shaded[floor], 0.7, rtol=1e-15)


def test_sixteen_scenes_at_once_are_equal_to_each_alone_and_one_of_them_may_be_empty():
    worlds = [
        lens_world(SKYWARDS if i == 5 else NEAR, k_rg=i / 16, eta=1 + i / 10, height=0.8 + 0.1 * i) for i in range(16)
    ]
    worlds[7] = lens_world(dataclasses.replace(SKYWARDS, target=Vec3(0.0, 3.0, 40.0)))
    many = jax.tree.map(lambda *x: jnp.stack(x), *worlds)

    @quick_jit
    def together(many):
        def shoot(world):
            out = trace(*world, 3)
            return out.radiance.sum(), out

        (_, out), slopes = jax.vmap(jax.value_and_grad(shoot, has_aux=True))(many)
        return out, slopes

    out, slopes = together(many)
    for i, world in enumerate(worlds):
        alone, _, backward = seen(world)
        np.testing.assert_allclose(out.radiance[i], alone.radiance, rtol=1e-13, atol=1e-15)
        np.testing.assert_array_equal(out.account.path_id[i], alone.account.path_id)
        for a, b in zip(jax.tree.leaves(slopes), jax.tree.leaves(backward), strict=True):
            np.testing.assert_allclose(a[i], b, rtol=1e-9, atol=1e-11 * float(jnp.abs(b).max() + 1))


def test_other_numbers_are_not_compiled_again(caplog):
    def run(k_d, weight, x):
        rays = Ray(vec([[x, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]]))
        scene = Scene({"ball": ball(Phong(k_d, emission=0.25))}, {"sun": Directional(DOWN, diffuse=x)})
        return float(trace(scene, rays, 0, min_weight=weight).radiance[0, 0])

    first = run(0.5, 0.0, 0.0)
    with jax.log_compiles(), caplog.at_level(logging.WARNING):
        second = run(0.25, 0.01, 0.6)
        jnp.sinh(np.ones(7)).block_until_ready()  # this one is new
    compiled = [r.getMessage() for r in caplog.records if r.getMessage().startswith("Compiling")]
    assert compiled
    assert not [x for x in compiled if "sinh" not in x]
    assert (first, second) == (0.25, 0.25 + 0.25 * 0.6 * 0.8)


def test_min_weight_cuts_the_branches_below_it_into_the_budget():
    scene, rays = room(k_rg=0.2, k_tg=0.6, light=0.0), rays_of(NEAR, 8, 8)
    whole = quick_trace(scene, rays, 2)
    for weight in (0.05, 0.25, 0.5, 0.7):
        out = quick_trace(scene, rays, 2, min_weight=weight)
        missing = whole.radiance - out.radiance
        assert (missing >= -1e-15).all()
        assert (missing <= out.account.budget.cut * 1.5).all()  # nothing here is brighter than a chain of 0.9 and 0.25s
        budget = out.account.budget
        assert (out.account.rays <= whole.account.rays).all()
        assert min(float(x.min()) for x in budget) >= 0
    assert (out.account.rays == 1).all()
    np.testing.assert_array_equal(whole.account.budget.cut, 0)
    with_floor = np.asarray(out.primitive) == 1
    np.testing.assert_allclose(out.account.budget.cut[with_floor], 0.3, rtol=1e-15)


# ---------------------------------------------------------------- chains


def mirrors(n=20):
    """Opaque: a floor, a ball of its own and twenty of one object, whose names interleave the models."""
    rng = np.random.default_rng(0)
    where = np.concatenate([rng.uniform(-2, 2, (n, 2)), rng.uniform(0.2, 1.5, (n, 1))], axis=1)
    objects = {
        "a": plane(Blend(Phong(Checker(0.8, 0.3, 2.0, 2.0)), 0.4)),
        "b": ball(Coat(Phong(np.array([0.6, 0.3, 0.1]), 0.4)), 0.7, Vec3(0.0, 0.5, 2.0)),
        "c": ball(Blend(Phong(rng.random((n, 3)), 0.3), rng.random((n, 3))), rng.uniform(0.1, 0.3, n), where),
        "d": ball(D3D9(Phong(0.2, k_a=0.5), np.array([0.8, 0.5, 0.2])), 0.4, Vec3(-1.0, -2.0, 0.4)),
        "e": ball(Blend(Phong(0.9), 0.7), 0.5, Vec3(1.0, -2.0, 0.5)),
    }
    lights = {"sun": Directional(Vec3(0.5, 0.3, -1.0)), "sky": Ambient(0.3)}
    return Scene(objects, lights, Sky(np.array([0.3, 0.5, 0.9])))


@functools.cache
def mirrored():
    return quick_trace(mirrors(), rays_of(VIEW, WIDE, HIGH), 5, terms=True)


def test_a_chain_over_many_primitives_has_the_radiance_of_the_reference_tracer():
    np.testing.assert_allclose(
        mirrored().radiance, reference(mirrors(), VIEW, WIDE, HIGH, 5).reshape(-1, 3), rtol=1e-11
    )
    assert len(np.unique(mirrored().primitive)) > 12
    assert mirrored().account.rays.max() == 6


def test_the_terms_of_a_chain_are_layers_whose_bounce_series_is_the_radiance():
    out = mirrored()
    layers = Layers(*(jnp.moveaxis(x, 1, 0) for x in out.terms[:3]))
    series = iterative(layers)
    np.testing.assert_allclose(series.radiance, out.radiance, rtol=1e-13)
    np.testing.assert_allclose(series.remainder, out.account.budget.truncated, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(series.weights, jnp.moveaxis(out.terms.weight * out.terms.local, 1, 0), rtol=1e-13)


def test_what_a_blend_shows_escapes_or_leaves_out_is_one():
    scene = mirrors()
    del scene.objects["d"]  # D3D9 adds light
    total = quick_trace(scene, rays_of(VIEW, WIDE, HIGH), 5).account.budget.total
    np.testing.assert_allclose(total, 1, rtol=1e-12)
    assert (mirrored().account.budget.total > 1 + 1e-3).any()


@pytest.mark.parametrize("limits", [{}, {"max_nodes": 4}, {"max_waiting": 1}, {"max_nodes": 1, "max_waiting": 1}])
def test_what_lossless_glass_shows_escapes_or_leaves_out_is_one_however_few_branches_are_followed(limits):
    objects = {"glass": ball(Dielectric(1.5), 0.8, UP), "floor": plane(Blend(Phong(0.5), 0.6))}
    scene = Scene(objects, {"sun": Directional(DOWN)}, 1.0)
    out = quick_trace(scene, rays_of(NEAR, 8, 8), 4, **limits)
    budget = out.account.budget
    np.testing.assert_allclose(budget.total, 1, atol=1e-12)
    assert min(float(x.min()) for x in budget) >= 0
    assert (out.account.rays <= limits.get("max_nodes", 20)).all()
    assert (budget.truncated[np.asarray(out.primitive) == 1] > 0).all()


def test_a_full_tree_with_room_for_every_branch_loses_none():
    sheets = Object(Plane(np.stack([0 * np.arange(9.0), 0 * np.arange(9.0), np.arange(-4.0, 5.0)], -1), UP), None)
    sheets = dataclasses.replace(sheets, surface=Whitted(lamp(0.1), 0.3, 0.5))
    ray = Ray(vec([[0.0, 0.0, 0.5]]), vec([[0.0, 0.0, -1.0]]))
    out = quick_trace(Scene({"sheets": sheets}), ray, 3, max_nodes=15, max_waiting=8)
    assert int(out.account.rays[0]) == 15
    assert math.isclose(float(out.radiance[0, 0]), 0.1 * (1 + 0.8 + 0.64 + 0.512), rel_tol=1e-13)


# ---------------------------------------------------------------- transformations of one ray


BALL = Scene({"ball": ball(Phong(0.5, emission=0.25))}, {"sun": Directional(DOWN)})


def test_the_radiance_of_one_ray_is_the_same_jitted_mapped_and_differentiated():
    x = jnp.array([0.0, 0.3, 0.6, 2.0])

    def at(x, k_d=0.5):
        scene = dataclasses.replace(BALL, objects={"ball": ball(Phong(k_d, emission=0.25))})
        return radiance(scene, Ray(Vec3(x, 0.0, 3.0), Vec3(0.0, 0.0, -1.0)), 0)[0]

    cos = np.sqrt(np.maximum(1 - x**2, 0))
    assert math.isclose(at(0.3), 0.25 + 0.5 * cos[1], rel_tol=1e-14)
    value, (by_x, by_k_d) = quick_jit(jax.vmap(jax.value_and_grad(at, (0, 1)), (0, None)))(x, 0.5)
    np.testing.assert_allclose(value, np.where(x < 1, 0.25 + 0.5 * cos, 0), rtol=1e-14)
    np.testing.assert_allclose(by_k_d, cos, atol=1e-15)
    np.testing.assert_allclose(by_x[:3], -0.5 * x[:3] / cos[:3], atol=1e-14)


def test_a_trace_knows_distance_normal_and_number_of_the_first_hit_and_a_miss_has_none():
    rays = Ray(vec([[0.6, 0.0, 3.0], [2.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]] * 2))
    out = quick_trace(BALL, rays, 0)
    np.testing.assert_allclose(out.depth, [2.2, np.inf], rtol=1e-15)
    np.testing.assert_allclose(out.normal.to_array(), [[0.6, 0, 0.8], [0, 0, 0]], atol=1e-15)
    assert out.primitive.tolist() == [0, -1]
    assert out.account.rays.tolist() == [1, 1]
    assert out.account.hits.tolist() == [1, 0]


def test_a_batch_without_rays_is_empty():
    none = jnp.zeros(0)
    assert trace(BALL, Ray(Vec3(none, none, none), Vec3(none, none, none)), 0).radiance.shape == (0, 1)


# ---------------------------------------------------------------- a prescribed path


def test_a_prescribed_path_through_a_glass_ball_has_the_documented_deviation():
    glass = Scene({"ball": ball(Dielectric(1.5))})
    start = Ray(Vec3(-3.0, 0.0, 0.5), Vec3(1.0, 0.0, 0.0))
    out = follow(glass, start, "TT")
    deviation = math.degrees(math.atan2(-out.direction.z, out.direction.x))
    assert math.isclose(deviation, 21.057558731018617, rel_tol=1e-12)
    crossing = out.origin.x - out.origin.z * out.direction.x / out.direction.z
    assert math.isclose(crossing, 1.3915729488893104, rel_tol=1e-12)
    mirrored = follow(glass, start, "R")
    normal = np.array([-math.sqrt(0.75), 0, 0.5])
    np.testing.assert_allclose(mirrored.origin.to_array(), normal, atol=1e-15)
    np.testing.assert_allclose(mirrored.direction.to_array(), [1 - 2 * 0.75, 0, math.sqrt(0.75)], rtol=1e-13)
    assert follow(glass, start, "").direction.to_array().tolist() == [1, 0, 0]


def test_the_primary_rainbow_is_where_its_derivative_vanishes():
    n, k = 1.333, 1
    glass = Scene({"ball": ball(Dielectric(n))})

    def angle(h):
        out = follow(glass, Ray(Vec3(-3.0, 0.0, h), Vec3(1.0, 0.0, 0.0)), "TRT").direction
        return jnp.degrees(jnp.arctan2(-out.z, -out.x))

    h = math.sqrt(1 - (n * n - 1) / (k * (k + 2)))
    value, slope = jax.value_and_grad(angle)(h)
    assert math.isclose(value, 42.078107380243553, rel_tol=1e-12)
    assert abs(slope) < 1e-10


def test_a_path_that_cannot_be_followed_has_direction_zero():
    glass = Scene({"ball": ball(Dielectric(1.5))})
    inside = Ray(ORIGIN + Vec3(0.0, 0.0, 0.9), Vec3(1.0, 0.0, 0.0))  # meets the surface beyond the critical angle
    cases = [(Ray(Vec3(-3.0, 0.0, 2.0), Vec3(1.0, 0.0, 0.0)), "R"), (inside, "T"), (inside, "RT"), (inside, "TT")]
    away = Ray(Vec3(-3.0, 0.0, 0.5), Vec3(1.0, 0.0, 0.0))
    for ray, branches in [*cases, (away, "RR"), (away, "TTT"), (away, "TTTR")]:
        assert follow(glass, ray, branches).direction.to_array().tolist() == [0, 0, 0]
    assert float(follow(glass, inside, "R").direction.x) != 0


@pytest.mark.parametrize("branches", ["X", "TRt", "T R"])
def test_a_path_of_other_letters_is_refused(branches):
    with pytest.raises(ValueError, match="R and T") as refusal:
        follow(BALL, Ray(ORIGIN, UP), branches)
    assert repr(branches) in str(refusal.value)


# ---------------------------------------------------------------- what is refused


def test_what_is_out_of_its_range_is_named_with_its_path_its_value_and_its_range():
    ray = Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]]))
    for scene, message in [
        (Scene({"glass": ball(Dielectric(-1.5))}), r"^objects\.glass\.surface\.eta = -1\.5 is outside \(0, inf\)"),
        (Scene({"a": ball(BLACK, radius=0.0)}), r"^objects\.a\.shape\.radius = 0\.0 is outside \(0, inf\)"),
        (Scene({"a": ball(BLACK, center=Vec3(0.0, math.nan, 0.0))}), r"^objects\.a\.shape\.center = nan is outside"),
        (Scene({"a": ball(Blend(lamp([0.5, -1.0, 0.5])))}), r"^objects\.a\.surface\.base\.emission = -1\.0 is outside"),
        (Scene({"a": ball(Blend(reflectivity=1.5))}), r"^objects\.a\.surface\.reflectivity = 1\.5 is outside \[0, 1\]"),
        (Scene({"a": ball(Phong(Checker(odd=-1.0)))}), r"^objects\.a\.surface\.k_d\.odd = -1\.0 is outside \[0, inf\)"),
        (
            Scene({"a": ball(BLACK)}, {"sun": Directional(DOWN, diffuse=-1.0)}),
            r"^lights\.sun\.diffuse = -1\.0 is outside",
        ),
        (Scene({"a": ball(BLACK)}, {}, Sky(horizon=-0.5)), r"^background\.horizon = -0\.5 is outside \[0, inf\)"),
        (Scene({"a": ball(BLACK, center=[0.0, 1.0])}), r"^objects\.a\.shape\.center = .* is not a vector of 3 numbers"),
        (Scene({}), "no primitive"),
    ]:
        with pytest.raises(ValueError, match=message):
            trace(scene, ray, 0)


@pytest.mark.parametrize(
    ("n_bounces", "options", "message"),
    [
        (-1, {}, r"^n_bounces = -1 is outside \[0, inf\)"),
        (1, {"max_nodes": 0}, r"^max_nodes = 0 is outside \[1, inf\)"),
        (1, {"max_waiting": -1}, r"^max_waiting = -1 is outside \[1, inf\)"),
        (1, {"min_weight": -0.1}, r"^min_weight = -0\.1 is outside \[0, inf\)"),
        (1, {"min_weight": math.nan}, r"^min_weight = nan is outside \[0, inf\)"),
    ],
)
def test_a_setting_of_the_loop_out_of_its_range_is_refused(n_bounces, options, message):
    with pytest.raises(ValueError, match=message):
        trace(BALL, Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]])), n_bounces, **options)


def test_numbers_of_two_dtypes_are_refused_and_both_are_named():
    shape = Sphere(Vec3(*(jnp.zeros((), jnp.float32) for _ in range(3))), 1.0)
    scene = Scene({"a": Object(shape, Phong(k_d=jnp.ones(3, jnp.float64)))})
    with pytest.raises(ValueError, match=r"objects\.a\.shape\.center is float32.*objects\.a\.surface\.k_d is float64"):
        trace(scene, Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]])), 0)


def test_shapes_that_do_not_fit_are_refused_by_name():
    ray = Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]]))
    for item, message in [
        (ball(BLACK, [1.0, 2.0], np.zeros((3, 3))), r"objects\.a\.shape\.(center|radius) has \d primitives.*has \d"),
        (ball(Phong(np.zeros((2, 2, 3)))), r"^objects\.a\.surface\.k_d has shape \(2, 2, 3\)"),
        (ball(BLACK, np.ones((2, 2))), r"^objects\.a\.shape\.radius has shape \(2, 2\)"),
    ]:
        with pytest.raises(ValueError, match=message):
            trace(Scene({"a": item}), ray, 0)
