"""The loop as a JAX function: jit, grad, jvp and vmap, its terms, its budget, prescribed branches, what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import DOWN, ORIGIN, VIEW, ball, lamp, plane, rays_of, vec, zoo

from jaxrefl import series
from jaxrefl.geometry import Ray, Sphere
from jaxrefl.light import Ambient, Directional
from jaxrefl.params import Interval
from jaxrefl.scene import Object, Scene, canonical, canonical_model
from jaxrefl.surface import Blend, Coat, Conductor, Dielectric, Phong, Whitted
from jaxrefl.trace import _traced, follow, radiance, trace
from jaxrefl.vec import Vec3

W, H = 16, 12


def corner(reflectivity=(0.5, 0.3), k_d=0.6) -> Scene:
    """Two mirror balls on a mirror floor: a chain."""
    return canonical(
        Scene(
            {
                "floor": plane(Blend(Phong(k_d=k_d, k_a=1.0), reflectivity[1])),
                "balls": ball(
                    Blend(Phong(k_d=[0.7, 0.2, 0.1], k_s=0.3, shininess=9.0), reflectivity[0]),
                    [0.8, 0.6],
                    [[-0.9, 0.0, 0.8], [0.8, -0.4, 0.6]],
                ),
            },
            {"sun": Directional(Vec3(0.3, 0.5, -1.0), 0.8, 0.6), "sky": Ambient(0.2)},
            jnp.array([0.3, 0.5, 0.9]),
        )
    )


@pytest.fixture(scope="module")
def rays():
    return rays_of(VIEW, W, H)


@pytest.fixture(scope="module")
def traced(rays):
    return trace(corner(), rays, 4, terms=True)


def test_every_model_agrees_with_a_tracer_that_shares_no_code():
    picture = reference(zoo(), VIEW, W, H, 3).reshape(-1, 3)
    found = trace(zoo(), rays_of(VIEW, W, H), 3, max_nodes=100, max_waiting=16)
    np.testing.assert_allclose(found.radiance, picture, rtol=1e-10, atol=1e-11)
    assert float(found.account.budget.truncated.max()) < 1


def test_a_chain_agrees_with_it_at_every_number_of_bounces(rays, traced):
    partial = jnp.cumsum(traced.terms.weight * traced.terms.local * traced.terms.color, axis=1)
    for n in range(5):
        picture = reference(corner(), VIEW, W, H, n).reshape(-1, 3)
        np.testing.assert_allclose(partial[:, n], picture, rtol=1e-11, atol=1e-13)


def test_the_series_of_the_terms_is_the_picture(traced):
    terms = traced.terms
    for i in range(0, W * H, 7):
        layers = series.Layers(terms.color[i], terms.local[i], terms.reflected[i])
        whole = series.iterative(layers)
        np.testing.assert_allclose(whole.radiance, traced.radiance[i], rtol=1e-13)
        np.testing.assert_allclose(whole.weights, terms.weight[i] * terms.local[i], rtol=1e-13)


def test_every_term_of_a_budget_is_there_and_the_convex_rule_spends_exactly_one(traced):
    budget = traced.account.budget
    assert all(float(x.min()) >= 0 for x in budget)
    np.testing.assert_allclose(budget.total, 1.0, atol=1e-14)
    np.testing.assert_allclose(budget.cut, 0.0)
    hits, ray_count = np.asarray(traced.account.hits), np.asarray(traced.account.rays)
    escaped = np.asarray(budget.escaped).max(1) > 0
    assert (escaped == (ray_count == hits + 1)).all()
    assert ((hits == 5) == (np.asarray(budget.truncated).max(1) > 0)).all()


def test_weak_branches_are_cut_and_what_finds_no_turn_is_truncated(rays):
    cut = trace(corner(), rays, 4, min_weight=0.1).account
    np.testing.assert_allclose(cut.budget.total, 1.0, atol=1e-14)
    assert float(cut.budget.cut.max()) > 0.01
    assert float(cut.budget.cut.max()) < 0.1
    glass = Scene({"glass": ball(Dielectric(1.5)), "floor": plane(lamp(0.3), Vec3(0.0, 0.0, -1.5))}, background=1.0)
    for nodes, waiting in ((1, 6), (3, 6), (40, 1)):
        budget = trace(glass, rays, 4, max_nodes=nodes, max_waiting=waiting).account.budget
        np.testing.assert_allclose(budget.total, 1.0, atol=1e-12)
        assert float(budget.truncated.max()) > 0


def test_sixteen_scenes_at_once_are_the_same_as_one_by_one(rays):
    some = jax.tree.map(lambda x: x[90], rays)
    values = jnp.linspace(0.0, 1.0, 16)

    def pixel(value):
        return radiance(corner((value, 0.3)), some, 3)

    together, tangents = jax.jit(jax.vmap(lambda v: jax.jvp(pixel, (v,), (jnp.ones_like(v),))))(values)
    one = jax.jit(pixel)
    np.testing.assert_allclose(together, jnp.stack([one(v) for v in values]), rtol=1e-14)
    step = 1e-6
    differences = [(one(v + step) - one(v - step)) / (2 * step) for v in (values[3], values[9])]
    np.testing.assert_allclose(tangents[jnp.array([3, 9])], jnp.stack(differences), rtol=1e-8, atol=1e-9)


def test_sixteen_scenes_with_glass_at_once_are_the_same_as_one_by_one(rays):
    some = jax.tree.map(lambda x: x[80:100], rays)

    def pixels(eta):
        scene = Scene({"glass": ball(Dielectric(eta)), "floor": plane(lamp(0.3), Vec3(0.0, 0.0, -1.5))}, background=1.0)
        return trace(scene, some, 3).radiance

    values = jnp.linspace(1.1, 2.0, 16)
    together = jax.jit(jax.vmap(pixels))(values)
    one = jax.jit(pixels)
    np.testing.assert_allclose(together, jnp.stack([one(v) for v in values]), rtol=1e-13)


def test_forward_and_reverse_mode_agree_in_every_leaf_and_none_is_nan_in_a_picture_of_mostly_sky():
    up = rays_of(VIEW, W, H)
    up = Ray(up.origin, vec(np.stack([up.direction.x, up.direction.y, up.direction.z + 0.45], -1)))
    scene = corner()

    def loss(scene, rays):
        return jnp.mean(trace(scene, rays, 4, account=False).radiance ** 2)

    value, slopes = jax.jit(jax.value_and_grad(loss, (0, 1)))(scene, up)
    assert np.isfinite(value)
    assert all(np.isfinite(x).all() for x in jax.tree.leaves(slopes))
    keys = iter(jax.random.split(jax.random.key(0), 200))
    tangents = jax.tree.map(lambda x: jax.random.normal(next(keys), x.shape, x.dtype), (scene, up))
    forward = jax.jit(lambda *args: jax.jvp(loss, args, tangents)[1])(scene, up)
    reverse = sum(jnp.vdot(a, b) for a, b in zip(jax.tree.leaves(slopes), jax.tree.leaves(tangents), strict=True))
    assert abs(forward - reverse) < 1e-12 * sum(float(jnp.abs(x).sum()) for x in jax.tree.leaves(slopes))


def test_a_derivative_is_the_central_difference_where_no_edge_moves(rays):
    def picture(radius, k_d, reflectivity):
        scene = corner((reflectivity, 0.3), k_d)
        balls = scene.objects["balls"]
        larger = Object(Sphere(balls.shape.center, balls.shape.radius * radius), balls.surface)
        return trace(Scene({**scene.objects, "balls": larger}, scene.lights, scene.background), rays, 3)

    point, step = (1.0, 0.6, 0.5), 1e-5
    tangent = jax.jit(jax.jacfwd(lambda *x: picture(*x).radiance, (0, 1, 2)))(*point)
    at = jax.jit(picture)
    for i in range(3):
        low, high = (at(*(x + s * step * (j == i) for j, x in enumerate(point))) for s in (-1, 1))
        smooth = np.asarray(low.account.path_id == high.account.path_id)
        assert smooth.mean() > 0.9
        difference = (high.radiance - low.radiance) / (2 * step)
        np.testing.assert_allclose(tangent[i][smooth], difference[smooth], rtol=2e-4, atol=2e-5)


def test_the_slope_at_a_reflectivity_of_zero_is_the_true_one():
    """PERRIN: dc_b / dalpha_0 = c^1 - c_0; a weight that is absent has no slope at all."""
    down = Ray(Vec3(0.0, 0.0, 3.0), DOWN)

    def seen(alpha):
        return radiance(Scene({"mirror": plane(Blend(lamp(0.2), alpha))}, background=0.9), down, 2)[0]

    np.testing.assert_allclose(jax.value_and_grad(seen)(0.0), (0.2, 0.7), rtol=1e-14)

    def added(k_rg, k_tg):
        scene = Scene({"glass": plane(Whitted(lamp(0.2), k_rg, k_tg, 1.5))}, background=0.9)
        return radiance(scene, down, 2)[0]

    slopes = jax.grad(added, (0, 1))(0.0, 0.0)
    np.testing.assert_allclose(slopes, (0.9, 0.9 / 1.5**2), rtol=1e-14)


def test_a_path_of_prescribed_branches_is_the_ray_that_leaves_the_last_hit():
    water = Scene({"drop": ball(Dielectric(4 / 3))})
    height = np.sin(np.deg2rad(59.41))
    out = follow(water, Ray(Vec3(height, 0.0, 5.0), DOWN), "TRT")
    r = np.arcsin(height * 3 / 4)
    deviation = np.pi + 2 * np.deg2rad(59.41) - 4 * r
    assert float(out.direction.z) == pytest.approx(-np.cos(deviation), rel=1e-12)
    straight = follow(water, Ray(Vec3(0.0, 0.0, 5.0), DOWN), "TT")
    assert float(straight.origin.z) == pytest.approx(-1.0)
    missed = follow(water, Ray(Vec3(2.0, 0.0, 5.0), DOWN), "T")
    assert float(missed.direction.to_array() @ missed.direction.to_array()) == 0.0
    totally = follow(Scene({"bubble": ball(Dielectric(0.5))}), Ray(Vec3(0.9, 0.0, 5.0), DOWN), "T")
    assert float(abs(totally.direction.to_array()).max()) == 0.0
    with pytest.raises(ValueError, match="branches = 'TX'"):
        follow(water, Ray(Vec3(0.0, 0.0, 5.0), DOWN), "TX")


def test_a_float32_scene_stays_float32_and_mixed_leaves_are_named(rays):
    single = canonical_model(corner(), jnp.float32)
    found = trace(single, jax.tree.map(lambda x: x[:9], rays), 2)
    floats = [x for x in jax.tree.leaves(found) if jnp.issubdtype(x.dtype, jnp.floating)]
    assert {x.dtype for x in floats} == {jnp.dtype("float32")}
    mixed = Scene({"a": ball(lamp(jnp.float32(0.5)), jnp.float64(1.0))})
    with pytest.raises(ValueError, match=r"objects\.a\.s\w+\.\S+ is float\d\d and objects\.a\.\S+ is float\d\d"):
        trace(mixed, rays, 1)


def test_what_is_out_of_range_is_named_with_its_path_value_and_range(rays):
    for bad, message in (
        (Scene({"b": ball(Dielectric(-1.0))}), r"objects\.b\.surface\.eta = -1\.0 is outside \(0, inf\)"),
        (Scene({"b": ball(Blend(lamp(0.1), 1.5))}), r"objects\.b\.surface\.reflectivity = 1\.5 is outside \[0, 1\]"),
        (Scene({"b": ball(lamp(0.1), 0.0)}), r"objects\.b\.shape\.radius = 0\.0 is outside \(0, inf\)"),
        (Scene({"b": ball(lamp(0.1))}, {"sun": Directional((1.0, 2.0))}), r"lights\.sun\.direction = \(1\.0, 2\.0\)"),
        (Scene({}), "objects"),
    ):
        with pytest.raises(ValueError, match=message):
            trace(bad, rays, 1)
    for options in ({"n_bounces": -1}, {"n_bounces": 1, "max_nodes": 0}, {"n_bounces": 1, "min_weight": -0.1}):
        with pytest.raises(ValueError, match="is outside"):
            trace(Scene({"b": ball(lamp(0.1))}), rays, **options)
    assert Interval.parse("[0, 1]").contains(np.array(0.5))


def test_other_numbers_do_not_compile_again(rays):
    few = jax.tree.map(lambda x: x[:9], rays)
    trace(Scene({"b": ball(lamp(0.1), 1.0, ORIGIN)}), few, 1)
    size = _traced._cache_size()
    trace(Scene({"b": ball(lamp(0.7), 2.0, Vec3(1.0, 2.0, 3.0))}), few, 1)
    assert _traced._cache_size() == size


def test_a_layer_lies_over_everything_that_its_base_does():
    down = Ray(Vec3(0.0, 0.0, 3.0), DOWN)
    twice = Scene({"mirror": plane(Blend(Blend(lamp(1.0), 0.5), 0.25))})
    np.testing.assert_allclose(radiance(twice, down, 2), 0.75 * 0.5, rtol=1e-15)
    varnished = Scene({"metal": plane(Coat(Conductor(0.2, 3.0), 1.5))}, background=1.0)
    coat, metal = 0.04, (0.8**2 + 9) / (1.2**2 + 9)
    np.testing.assert_allclose(radiance(varnished, down, 2), coat + (1 - coat) * metal, rtol=1e-13)
    glass = Scene({"ball": ball(Blend(Dielectric(1.5), 0.25))}, background=1.0)
    one = jax.tree.map(lambda x: jnp.asarray(x)[None], down)
    np.testing.assert_allclose(trace(glass, one, 6).account.budget.total, 1.0, rtol=1e-13)


def test_extinction_of_a_ray_that_misses_has_a_finite_derivative(float32):
    def seen(sigma, height):
        high = ball(Whitted(Phong(0.2), 0.5, sigma_rg=sigma), 1.0, Vec3(0.0, 0.0, height))
        above = Ray(Vec3(0.0, 0.0, 200.0), DOWN)
        return radiance(Scene({"ball": high, "floor": plane(Phong(0.5))}, background=1.0), above, 2).sum()

    assert np.isfinite(jax.grad(seen, (0, 1))(3.0, 40.0)).all()


def test_as_many_branches_may_wait_as_are_asked_for():
    sheets = {f"s{i}": plane(Whitted(lamp(0.1 * i), 0.4, 0.5, 1.0), Vec3(0.0, 0.0, -1.0 * i)) for i in range(6)}
    scene = Scene(sheets, background=0.3)
    picture = reference(scene, VIEW, 3, 2, 5).reshape(-1, 1)
    found = trace(scene, rays_of(VIEW, 3, 2), 5, max_nodes=100, max_waiting=32)
    np.testing.assert_allclose(found.radiance, picture, rtol=1e-12)


def test_lights_are_told_apart_in_the_path_however_many_there_are():
    lights = {f"l{i:02d}": Directional(Vec3(0.02 * i, 0.0, -1.0), 0.03) for i in range(33)}
    under = Scene({"floor": plane(Phong(0.5)), "leaf": ball(Phong(0.5), 0.4, Vec3(0.0, 0.0, 8.0))}, lights)
    x = np.linspace(-1.0, 6.0, 200)
    rays = Ray(vec(np.stack([x, 0 * x, 0 * x + 1], -1)), vec(np.stack([0 * x, 0 * x, 0 * x - 1], -1)))
    found = trace(under, rays, 0)
    changed = np.diff(np.asarray(found.radiance)[:, 0]) != 0
    assert changed.sum() > 10
    assert (np.diff(np.asarray(found.account.path_id).astype(np.int64)) != 0)[changed].all()


@pytest.mark.parametrize("bad", [{"n_bounces": 2.5}, {"n_bounces": 1, "max_nodes": 3.0}])
def test_a_number_of_steps_is_a_whole_number(rays, bad):
    with pytest.raises(ValueError, match="is not a whole number"):
        trace(Scene({"b": ball(lamp(0.1))}), rays, **bad)


def test_directions_that_are_none_and_spectra_that_disagree_are_named(rays):
    for bad, message in (
        (Scene({"b": plane(lamp(0.1), normal=Vec3(0.0, 0.0, 0.0))}), r"objects\.b\.shape\.normal is the zero vector"),
        (Scene({"b": ball(lamp(0.1))}, background=-1.0), r"background = -1\.0 is outside \[0, inf\)"),
        (Scene({"b": ball(lamp([0.1, 0.2])), "c": plane(lamp([0.1, 0.2, 0.3]))}), "2 and 3 channels"),
    ):
        with pytest.raises(ValueError, match=message):
            trace(bad, rays, 1)
