"""Rays that change places: the order, and that nothing but the time depends on it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tracer_scenes import ball, lamp, plane, quick_jit, units, vec

from jaxrefl import blocks
from jaxrefl.geometry import SKIP, Ray
from jaxrefl.light import Directional
from jaxrefl.loop import trace_batch
from jaxrefl.path import Options
from jaxrefl.scene import Scene, Sky, canonical
from jaxrefl.stage import stage
from jaxrefl.surface import Blend, Phong
from jaxrefl.vec import Vec3

pytestmark = pytest.mark.usefixtures("quick_compilation")
N = 60  # rays


def flags(rng, shape, share) -> jax.Array:
    return jnp.asarray(rng.random(shape) < share)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (4, 64), (3, 100), (7, 129)])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_those_with_a_flag_come_first_and_nobody_overtakes(shape, share):
    flag = flags(np.random.default_rng(0), shape, share)
    order = np.asarray(blocks.first(flag)).reshape(-1)
    flat = np.asarray(flag).reshape(-1)
    assert order.tolist() == [*np.flatnonzero(flat), *np.flatnonzero(~flat)]


def test_what_was_taken_in_an_order_is_put_back_by_its_inverse_to_the_bit():
    rng = np.random.default_rng(1)
    tree = {
        "scalar": jnp.asarray(rng.normal(size=30), np.float32),
        "color": jnp.asarray(rng.normal(size=(4, 30))),
        "record": jnp.asarray(rng.integers(0, 99, (2, 3, 30)), jnp.int32),
    }
    order = jnp.asarray(rng.permutation(30), jnp.int32)
    divided = blocks.divided(tree, 5)
    assert {name: x.shape for name, x in divided.items()} == {
        "scalar": (5, 6),
        "color": (5, 4, 6),
        "record": (5, 2, 3, 6),
    }
    moved = blocks.taken(divided, order.reshape(5, 6))
    for a, b in zip(jax.tree.leaves(blocks.joined(moved, 5)), jax.tree.leaves(tree), strict=True):
        np.testing.assert_array_equal(a, b[..., order])
    back = blocks.joined(blocks.taken(moved, blocks.inverse(order.reshape(5, 6))), 5)
    for a, b in zip(jax.tree.leaves(back), jax.tree.leaves(tree), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (["....", "...."], False),
        (["####", "####"], False),
        (["#...", "...."], False),  # one block has work, and one is needed
        (["#...", "..#."], True),
        (["##..", ".###"], False),
        (["###.", "#..."], True),
        (["#.#.", "##..", "..#."], True),
    ],
)
def test_a_move_pays_where_it_empties_a_block(rows, expected):
    assert bool(blocks.pays(jnp.array([[c == "#" for c in row] for row in rows]))) == expected


# ---------------------------------------------------------------- a batch of rays


def field() -> Scene:
    """Mirror balls and a lamp on a floor of mirror: rays leave at every number of bounces."""
    balls = [(-1.2, 0.0, 0.8), (0.7, -0.3, 0.7), (0.1, 1.3, 1.0), (1.9, 0.6, 0.5)]
    objects = {
        f"ball{i}": ball(Blend(Phong([0.2, 0.5, 0.7], 0.3, 9.0), 0.6), r, Vec3(x, y, r))
        for i, (x, y, r) in enumerate(balls)
    }
    objects |= {"floor": plane(Blend(Phong(0.7), 0.5)), "lamp": ball(lamp(2.0), 0.3, Vec3(-0.2, -0.9, 0.4))}
    return canonical(Scene(objects, {"sun": Directional(Vec3(0.3, 0.2, -1.0), ambient=0.1)}, Sky([0.2, 0.5, 0.9])))


def rays() -> Ray:
    rng = np.random.default_rng(2)
    aim = np.array([0.0, 0.0, 0.9]) + rng.normal(size=(N, 3)) * [1.5, 0.3, 0.8]
    eye = aim + np.array([0.0, -5.0, 2.0]) + units(rng, N)
    d = aim - eye
    return Ray(vec(eye), vec(d / np.linalg.norm(d, axis=1, keepdims=True)))


def traced(scene, count):
    return trace_batch(stage(scene), rays(), Options(SKIP, 0.0, 4), n_bounces=4, blocks=count)


def test_in_blocks_whose_rays_change_places_every_ray_brings_back_the_same(monkeypatch):
    decided = []
    pays = blocks.pays

    def watched(flag):
        jax.debug.callback(lambda x: decided.append(bool(x)), pays(flag))
        return pays(flag)

    monkeypatch.setattr("jaxrefl.loop.pays", watched)
    whole, parts = (quick_jit(traced, static_argnums=1)(field(), count) for count in (1, 6))
    jax.effects_barrier()
    assert {True, False} == set(decided)
    assert len(set(np.asarray(whole.account.hits).tolist())) > 3
    for a, b in zip(jax.tree.leaves(whole), jax.tree.leaves(parts), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-13, atol=1e-14)
    for a, b in zip(jax.tree.leaves(whole.account[1:]), jax.tree.leaves(parts.account[1:]), strict=True):
        np.testing.assert_array_equal(a, b)


def test_so_are_its_derivatives_forward_and_reverse():
    weight = jnp.asarray(np.random.default_rng(3).normal(size=(N, 3)))

    def loss(scene, count):
        return jnp.sum(weight * traced(scene, count).radiance)

    scene = field()
    gradient = quick_jit(jax.grad(loss), static_argnums=1)
    whole, parts = gradient(scene, 1), gradient(scene, 6)
    size = max(float(jnp.abs(x).max()) for x in jax.tree.leaves(whole))
    for a, b in zip(jax.tree.leaves(whole), jax.tree.leaves(parts), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-13 * size)
    rng = np.random.default_rng(4)
    along = jax.tree.map(lambda x: jnp.asarray(rng.normal(size=x.shape), x.dtype), scene)
    slope = quick_jit(lambda scene, along: jax.jvp(lambda scene: loss(scene, 6), (scene,), (along,))[1])(scene, along)
    both = sum(float(jnp.vdot(a, b)) for a, b in zip(jax.tree.leaves(parts), jax.tree.leaves(along), strict=True))
    assert slope == pytest.approx(both, rel=1e-11)


def test_scenes_mapped_together_each_have_their_own_order():
    scenes = [field(), jax.tree.map(lambda x: x, field())]
    scenes[1].objects["lamp"] = ball(lamp(2.0), 0.6, Vec3(0.9, -1.2, 0.6))
    scenes = [canonical(scene) for scene in scenes]
    stacked = jax.tree.map(lambda *x: jnp.stack(x), *scenes)
    together = quick_jit(jax.vmap(lambda scene: traced(scene, 6)))(stacked)
    for i, scene in enumerate(scenes):
        alone = quick_jit(lambda scene: traced(scene, 6))(scene)
        np.testing.assert_allclose(together.radiance[i], alone.radiance, rtol=1e-13, atol=1e-14)
        np.testing.assert_array_equal(together.account.path_id[i], alone.account.path_id)
    assert (together.account.path_id[0] != together.account.path_id[1]).any()
