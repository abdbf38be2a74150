"""The beam of a batch of rays: what it leaves out no ray meets, and the tracer brings back the same without it."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracer_scenes import plane, quick_jit, units, vec

from jaxrefl import beam as beams
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import SKIP, Ray, Sphere
from jaxrefl.light import Directional, PointLight
from jaxrefl.loop import trace_batch
from jaxrefl.params import param, pytree
from jaxrefl.path import Options
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky, canonical
from jaxrefl.stage import stage
from jaxrefl.surface import Blend, Dielectric, Phong
from jaxrefl.vec import Vec3

pytestmark = pytest.mark.usefixtures("quick_compilation")
N = 96  # rays


def bundle(rng, width, spread) -> tuple[np.ndarray, np.ndarray]:
    """Origins within a distance, directions within about an angle of a random axis."""
    origins = rng.normal(size=3) * 10 + units(rng, N) * spread * rng.random((N, 1))
    directions = units(rng, 1) + units(rng, N) * np.tan(width) * rng.random((N, 1))
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def a_perpendicular(rng, directions) -> np.ndarray:
    v = np.cross(directions, units(rng, len(directions)))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def as_ray(origins, directions, dtype) -> Ray:
    return Ray(vec(origins.astype(dtype)), vec(directions.astype(dtype)))


touches = quick_jit(lambda ray, alive, centers, radii: beams.beam(ray, alive).touches(centers, radii))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@settings(max_examples=300, deadline=None)
@given(
    seed=st.integers(0, 10**9),
    width=st.sampled_from([0.0, 1e-4, 1e-2, 0.3, 1.0, 1.5]),
    spread=st.sampled_from([0.0, 1e-3, 1.0, 30.0]),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
    dead=st.sampled_from([0.0, 0.5, 0.95]),
)
def test_a_ball_that_a_ray_meets_touches_the_beam(dtype, seed, width, spread, scale, dead):
    rng = np.random.default_rng(seed)
    origins, directions = bundle(rng, width, spread)
    lengths = 1 + rng.choice([0.0, 3e-4]) * rng.uniform(-1, 1, (N, 1))  # what hundreds of bounces make of 1 in float32
    alive = rng.random(N) >= dead
    # for each ray a ball it just meets, far or near, large or small, on a side of it, most of them outside the bundle
    t, r = (10 ** rng.uniform(-3, 3, (N, 1)) for _ in range(2))
    centers = origins + directions * t + a_perpendicular(rng, directions) * r * (1 - 1e-9)
    touched = touches(
        as_ray(origins * scale, directions * lengths, dtype),
        jnp.asarray(alive),
        vec((centers * scale).astype(dtype)),
        jnp.asarray(r[:, 0] * scale, dtype),
    )
    assert np.asarray(touched)[alive].all()


def grid(n) -> tuple[Vec3, np.ndarray]:
    x, y = np.meshgrid(np.linspace(-4, 4, n), np.linspace(-3, 6, n))
    return Vec3(x.ravel(), y.ravel(), np.full(n * n, 0.3)), np.full(n * n, 0.3)


def test_of_a_hundred_balls_few_touch_the_beam_of_a_patch_and_those_stand_in_front():
    scene = stage(Scene({"balls": Object(Sphere(*grid(10)), Phong(0.5))}, {}, Sky(1.0)))
    aim = np.random.default_rng(0).uniform([0.25, 0.85, 0.15], [0.55, 1.15, 0.45], (N, 3))
    d = aim - np.array([0.0, -8.0, 3.0])
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    ray = as_ray(np.tile([0.0, -8.0, 3.0], (N, 1)), d, np.float64)
    near = beams.reached(scene, ray, jnp.ones(N, bool)).kinds[0].near
    front = np.asarray(near.order)[: int(near.number)]
    distances = jax.vmap(lambda ball: jax.vmap(lambda ray: ball.roots(ray, 0.0).t)(ray))(scene.kinds[0].shape)
    met = set(np.flatnonzero(np.isfinite(distances).any(axis=1)).tolist())
    assert met
    assert met <= set(front.tolist())
    assert len(front) < 20
    assert (np.diff(front) > 0).all()
    assert sorted(near.order.tolist()) == list(range(100))


@pytree
class Shell:
    """A shape of a user: a sphere whose radius is the sum of a spectrum, with a ball or with none."""

    center: Any = param("(-inf, inf)", vector=True)
    radii: Any = param("(0, inf)", spectral=True)

    def _sphere(self) -> Sphere:
        return Sphere(self.center, jnp.sum(self.radii))

    def roots(self, ray, t_min):
        return self._sphere().roots(ray, t_min)

    def blocks(self, ray, t_min, distance):
        return self._sphere().blocks(ray, t_min, distance)

    def point(self, ray, own, far, here):
        return self._sphere().point(ray, own, far, here)

    def chord(self, n, direction):
        return self._sphere().chord(n, direction)


@pytree
class Balled(Shell):
    def ball(self):
        return self.center, jnp.sum(self.radii)


@pytree
class Enclosed(Shell):
    def ball(self):
        return Vec3(0.0, 0.0, 0.0), 30.0


def test_the_ball_of_a_shape_is_asked_for_one_shape_at_a_time():
    center, _ = grid(6)
    radii = np.linspace(0.01, 0.6, 36)[:, None] * np.array([[0.2, 0.3, 0.5]])

    def scene(shape) -> Scene:
        objects = {"shells": Object(shape(center, radii), Phong(0.5)), "floor": plane(Phong(0.3))}
        return Scene(objects, {"sun": Directional(Vec3(0.5, 0.3, -1.0))}, Sky([0.2, 0.5, 0.9]))

    camera = Pinhole(Vec3(0.0, -12.0, 5.0), Vec3(0.0, 1.0, 0.3), field_of_view=0.5)
    plain, balled = (render(scene(shape), camera, 24, 20, 0) for shape in (Shell, Balled))
    assert len(np.unique(plain.primitive)) > 20
    np.testing.assert_array_equal(balled.primitive, plain.primitive)
    np.testing.assert_array_equal(balled.path_id, plain.path_id)
    narrow = as_ray(*bundle(np.random.default_rng(5), 0.01, 0.0), np.float64)
    shells = {
        shape: beams.reached(stage(scene(shape)), narrow, jnp.ones(N, bool)).kinds[-1].near
        for shape in (Balled, Enclosed)
    }
    assert int(shells[Balled].number) < 36
    assert int(shells[Enclosed].number) == 36


def test_a_beam_of_which_nothing_is_known_touches_everything():
    rng = np.random.default_rng(1)
    origins, directions = bundle(rng, 0.01, 0.0)
    everywhere = vec(rng.normal(size=(50, 3)) * 100)
    radius, alive = jnp.full(50, 0.1), jnp.ones(N, bool)

    def touched(o, d, alive) -> np.ndarray:
        return np.asarray(touches(as_ray(o, d, np.float64), alive, everywhere, radius))

    narrow = touched(origins, directions, alive)
    assert not narrow.all()
    opposite = np.where(np.arange(N)[:, None] % 2 == 1, -directions, directions)  # first and last cancel
    assert touched(origins, opposite, alive).all()
    lost = directions.copy()
    lost[17] = np.nan
    assert touched(origins, lost, alive).all()
    np.testing.assert_array_equal(touched(origins, lost, alive.at[17].set(False)), narrow)  # unless it is dead


# ---------------------------------------------------------------- the tracer


def crowd(rng, surface) -> Scene:
    """Balls in two objects, a floor between them in number, and lights of both kinds among the balls."""
    some, more = ((rng.uniform([-3, -3, 0.2], [3, 3, 2.5], (n, 3)), rng.uniform(0.05, 0.5, n)) for n in (5, 6))
    objects = {
        "a": Object(Sphere(vec(some[0]), jnp.asarray(some[1])), surface),
        "b": plane(Blend(Phong(0.6), 0.4)),
        "c": Object(Sphere(vec(more[0]), jnp.asarray(more[1])), Blend(Phong([0.2, 0.5, 0.7], 0.3, 9.0), 0.6)),
    }
    lights = {
        "sun": Directional(Vec3(*rng.normal(size=2) * 0.3, -1.0), ambient=0.1),
        "lamp": PointLight(Vec3(*rng.uniform(-2, 2, 2), 1.5), diffuse=0.5),
    }
    return canonical(Scene(objects, lights, Sky([0.2, 0.5, 0.9])))


def look(rng) -> Ray:
    """A patch from a camera."""
    aim = rng.uniform(-2, 2, 3) * [1, 1, 0.2] + [0, 0, 1.0]
    eye = np.array([0.0, -9.0, 3.0])
    d = aim + rng.uniform(-1, 1, (N, 3)) * 0.7 - eye
    return as_ray(np.tile(eye, (N, 1)), d / np.linalg.norm(d, axis=1, keepdims=True), np.float64)


@pytest.mark.parametrize(
    ("surface", "blocks"), [(Blend(Phong([0.7, 0.3, 0.1]), 0.5), 2), (Dielectric(1.4), 1)], ids=["chain", "tree"]
)
def test_scenes_bring_back_the_same_as_without_beams(monkeypatch, surface, blocks):
    rng = np.random.default_rng(2)
    scenes = jax.tree.map(lambda *x: jnp.stack(x), *(crowd(rng, surface) for _ in range(16)))
    rays = jax.tree.map(lambda *x: jnp.stack(x), *(look(rng) for _ in range(16)))

    def traced(scene, rays):
        return trace_batch(stage(scene), rays, Options(SKIP, 0.0, 3), n_bounces=3, blocks=blocks)

    known = []
    reached = beams._reached

    def watched(*args):
        kind = reached(*args)
        known.append(kind.near is not None)
        return kind

    monkeypatch.setattr(beams, "_reached", watched)
    results = []
    for many in (1000, 4):
        monkeypatch.setattr(beams, "MANY", many)
        known.clear()
        results.append(quick_jit(jax.vmap(traced))(scenes, rays))
        assert any(known) == (many == 4)
    without, within = results
    assert len(np.unique(without.account.path_id)) > 50
    np.testing.assert_array_equal(without.account.path_id, within.account.path_id)
    for a, b in zip(jax.tree.leaves(without), jax.tree.leaves(within), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-14)


def test_gradients_pass_by_the_search(monkeypatch):
    rng = np.random.default_rng(3)
    scene, rays = crowd(rng, Blend(Phong([0.7, 0.3, 0.1]), 0.5)), look(rng)

    def loss(scene):
        return jnp.mean(
            trace_batch(stage(scene), rays, Options(SKIP, 0.0, 1), n_bounces=1, account=False).radiance ** 2
        )

    gradients = []
    for many in (1000, 4):
        monkeypatch.setattr(beams, "MANY", many)
        gradients.append(quick_jit(lambda scene: jax.grad(loss)(scene))(scene))
    assert max(float(jnp.abs(x).max()) for x in jax.tree.leaves(gradients[0])) > 1e-3
    for a, b in zip(*map(jax.tree.leaves, gradients), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-13)
