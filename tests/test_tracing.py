"""What a review of the tracer found: layers over any base, rays that miss, many lights, what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import DOWN, VIEW, ball, lamp, plane, rays_of, vec

from jaxrefl.geometry import Ray
from jaxrefl.light import Directional
from jaxrefl.scene import Scene
from jaxrefl.surface import Blend, Coat, Conductor, Dielectric, Phong, Whitted
from jaxrefl.trace import radiance, trace
from jaxrefl.vec import Vec3

W, H = 16, 12


@pytest.fixture(scope="module")
def rays():
    return rays_of(VIEW, W, H)


def test_sixteen_scenes_with_glass_at_once_are_the_same_as_one_by_one(rays):
    some = jax.tree.map(lambda x: x[80:100], rays)

    def pixels(eta):
        scene = Scene({"glass": ball(Dielectric(eta)), "floor": plane(lamp(0.3), Vec3(0.0, 0.0, -1.5))}, background=1.0)
        return trace(scene, some, 3).radiance

    values = jnp.linspace(1.1, 2.0, 16)
    together = jax.jit(jax.vmap(pixels))(values)
    one = jax.jit(pixels)
    np.testing.assert_allclose(together, jnp.stack([one(v) for v in values]), rtol=1e-13)


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
