"""Pictures: which ray a pixel is, samples, tiles, devices; cameras."""

import dataclasses
import functools
import math
import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tracer_scenes import UP, ball, plane, quick_jit, quick_trace, rays_of, vec

import jaxrefl.render
from jaxrefl import Vec3
from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.geometry import Ray
from jaxrefl.light import Directional
from jaxrefl.params import pytree
from jaxrefl.render import Image, render
from jaxrefl.sampling import sample_position
from jaxrefl.scene import Scene, Sky, canonical, canonical_model
from jaxrefl.surface import Blend, Local, Phong, Weights
from jaxrefl.texture import Checker

pytestmark = pytest.mark.usefixtures("quick_compilation")
WIDTH, HEIGHT = 9, 7
EYE = Pinhole(Vec3(0.3, -4.0, 2.0), Vec3(0.0, 0.0, 0.7), field_of_view=0.8)


def hall() -> Scene:
    """A ball on a floor, both mirrors, in the sun."""
    objects = {
        "ball": ball(Blend(Phong([0.2, 0.5, 0.7], 0.5, 20.0), 0.4), 0.7, UP * 0.7),
        "floor": plane(Blend(Phong(Checker(0.8, 0.3, 2.3, 2.3)), 0.2)),
    }
    return Scene(objects, {"sun": Directional(Vec3(0.5, 0.4, -1.0), ambient=0.2)}, Sky([0.2, 0.5, 0.9]))


picture = quick_jit(render, static_argnames=("width", "height", "n_bounces", "spp", "alpha", "account"))


@functools.cache
def plain() -> Image:
    return picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2)


@functools.cache
def sampled() -> Image:
    return picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, spp=4, seed=3)


def same(a, b) -> bool:
    return all(bool((np.asarray(x) == np.asarray(y)).all()) for x, y in zip(*map(jax.tree.leaves, (a, b)), strict=True))


# ---------------------------------------------------------------- pixels


def test_a_pixel_is_the_ray_through_its_centre_and_row_zero_is_at_the_top():
    image, out = plain(), quick_trace(hall(), rays_of(EYE, WIDTH, HEIGHT), 2)
    flat = jax.tree.map(lambda x: x.reshape(WIDTH * HEIGHT, *x.shape[2:]), image)
    np.testing.assert_allclose(flat.radiance, out.radiance, rtol=1e-13)
    np.testing.assert_allclose(flat.depth, out.depth, rtol=1e-13)
    np.testing.assert_allclose(flat.normal, out.normal.to_array(), atol=1e-13)
    np.testing.assert_array_equal(flat.primitive, out.primitive)
    np.testing.assert_array_equal(flat.bounces, out.account.rays - 1)
    np.testing.assert_array_equal(flat.hits, out.account.hits)
    np.testing.assert_array_equal(flat.path_id, out.account.path_id)
    np.testing.assert_allclose(np.stack(flat.budget), np.stack(out.account.budget), rtol=1e-13)
    assert (image.primitive[0] == -1).any()  # the sky is above
    assert (image.primitive[-1] == 1).all()  # and the floor below


def test_alpha_depth_and_normal_of_a_miss_are_zero_infinity_and_zero():
    missed = np.asarray(plain().primitive) < 0
    np.testing.assert_array_equal(plain().alpha, ~missed)  # opaque surfaces
    assert (np.asarray(plain().depth)[missed] == np.inf).all()
    assert (np.asarray(plain().normal)[missed] == 0).all()
    np.testing.assert_allclose(np.linalg.norm(np.asarray(plain().normal)[~missed], axis=-1), 1, rtol=1e-14)


def test_without_an_account_the_picture_is_the_same_and_the_rest_is_absent():
    image = picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, account=False)
    np.testing.assert_allclose(image.radiance, plain().radiance, rtol=1e-14)
    assert image[:1] + image[5:] == (image.radiance, None, None, None, None)


def test_the_same_call_gives_the_same_bits_and_one_sample_needs_no_seed():
    again = picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, seed=9)
    assert same(again, plain())
    assert same(picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, spp=4, seed=3), sampled())
    other = picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, spp=4, seed=4)
    assert float(jnp.abs(other.radiance - sampled().radiance).max()) > 1e-3


def test_the_derivative_of_a_picture_in_the_sunlight_is_what_the_sun_adds_to_it():
    @quick_jit
    def mean_and_slope(light):
        scene = hall()
        sun = dataclasses.replace(scene.lights["sun"], diffuse=light, specular=light, ambient=light)
        scene = dataclasses.replace(scene, lights={"sun": sun})
        return jax.value_and_grad(lambda s: render(s, EYE, 4, 3, 2).radiance.mean())(canonical(scene))

    (dark, slope), (bright, _) = mean_and_slope(0.0), mean_and_slope(1.0)
    sun = slope.lights["sun"]
    added = sum(float(x.sum()) for x in (sun.diffuse, sun.specular, sun.ambient))
    assert math.isclose(added, float(bright - dark), rel_tol=1e-12)


# ---------------------------------------------------------------- samples


@pytest.mark.parametrize("pixel", [(0, 0), (5, 2), (1919, 1079)])
def test_of_the_first_samples_one_lies_in_each_elementary_interval(pixel):
    x, y = (np.asarray(v) for v in jax.jit(jax.vmap(lambda i: sample_position(7, *pixel, i)))(jnp.arange(256)))
    assert x.dtype == np.float32
    assert min(x.min(), y.min()) >= 0
    assert max(x.max(), y.max()) < 1
    for k in range(9):
        for columns in (2**j for j in range(k + 1)):
            rows = 2**k // columns
            box = np.floor(x[: 2**k] * columns) * rows + np.floor(y[: 2**k] * rows)
            assert len(np.unique(box)) == 2**k
        later = np.floor(x[2**k :][: 2**k] * 2**k)  # and so do those that follow
        assert len(np.unique(later)) == len(later)


def test_samples_depend_on_seed_and_pixel_alone():
    first = jax.jit(jax.vmap(lambda i: sample_position(i // 1600, i % 40, i // 40 % 40, 0)))(jnp.arange(3200))
    many = np.array(first)
    assert len(np.unique(many, axis=1).T) > 3190
    assert np.abs(many.mean(axis=1) - 0.5).max() < 0.03  # 4 sigma
    assert abs(np.corrcoef(many)[0, 1]) < 0.1


def test_a_pixel_is_the_mean_over_its_samples_and_its_first_hit_that_of_the_first():
    i = np.arange(WIDTH * HEIGHT)
    column, row = jnp.asarray(i % WIDTH), jnp.asarray(i // WIDTH)
    camera, total = canonical_model(EYE, float), 0.0
    for s in range(4):
        dx, dy = jax.vmap(lambda c, r, s=s: sample_position(3, c, r, s))(column, row)
        x, y = (2 * (column + dx) - WIDTH) / HEIGHT, 1 - 2 * (row + dy) / HEIGHT
        out = quick_trace(hall(), jax.vmap(camera.ray)(x.astype(float), y.astype(float)), 2)
        total = total + out.radiance / 4
        if s == 0:
            np.testing.assert_array_equal(sampled().primitive.ravel(), out.primitive)
            np.testing.assert_array_equal(sampled().path_id.ravel(), out.account.path_id)
            np.testing.assert_allclose(sampled().depth.ravel(), out.depth, rtol=1e-6)
    np.testing.assert_allclose(sampled().radiance.reshape(-1, 3), total, rtol=1e-5)  # dx is a float32
    budget = sampled().budget
    np.testing.assert_allclose(budget.total, 1, rtol=1e-12)


# ---------------------------------------------------------------- tiles, bands, devices


def test_tiles_bands_and_reports_do_not_change_the_picture(monkeypatch):
    """63 pixels in 13 tiles of 5, with two pixels too many; bands of 7 tiles, with one too many."""
    expected = picture(hall(), EYE, width=WIDTH, height=HEIGHT, n_bounces=2, spp=2)
    for name, value in {"TILE": 5, "BLOCKS": 1, "PARTS": 1, "LANES": 1, "BANDS": 2}.items():
        monkeypatch.setattr(jaxrefl.render, name, value)
    whole = quick_jit(lambda scene: render(scene, EYE, WIDTH, HEIGHT, 2, spp=2))(hall())
    assert same(whole[4:], expected[4:])
    np.testing.assert_allclose(whole.radiance, expected.radiance, rtol=1e-14)
    reports = []
    banded = render(hall(), EYE, WIDTH, HEIGHT, 2, spp=2, progress=lambda *numbers: reports.append(numbers))
    assert same(banded[4:-1], whole[4:-1])
    np.testing.assert_allclose(banded.radiance, whole.radiance, rtol=1e-14)
    done, total, rays = np.array(reports).T
    assert done.tolist() == [35, 63, 98, 126]
    assert set(total) == {126}
    assert (np.diff(rays) > 0).all()
    assert rays[-1] == float((whole.bounces + 1).sum() * 2)


def test_a_report_may_stop_the_work(monkeypatch):
    for name, value in {"TILE": 5, "BLOCKS": 1, "PARTS": 1, "LANES": 1, "BANDS": 2}.items():
        monkeypatch.setattr(jaxrefl.render, name, value)
    reports = []

    def stop(*numbers):
        reports.append(numbers)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render(hall(), EYE, WIDTH, HEIGHT, 2, spp=2, progress=stop)
    assert len(reports) == 1


TWO_DEVICES = """
import sys
import jax
import numpy as np
jax.config.update("jax_disable_most_optimizations", True)
sys.path.insert(0, sys.argv[1])
import jaxrefl.render
from test_render import EYE, hall
vars(jaxrefl.render).update(TILE=16, BLOCKS=3, PARTS=3, LANES=1)
assert len(jax.devices()) == 2, jax.devices()
images = [
    jaxrefl.render.render(hall(), EYE, 9, 8, 2, spp=2, devices=devices, progress=progress)
    for devices in (jax.devices()[:1], jax.devices())
    for progress in (None, lambda *done: None)
]
for image in images:
    for a, b in zip(jax.tree.leaves(image), jax.tree.leaves(images[0]), strict=True):
        assert np.asarray(a).tobytes() == np.asarray(b).tobytes()
assert images[0].radiance.dtype == np.float32
print("equal")
"""


def test_two_devices_give_the_same_bits_as_one():
    """5 tiles of 15 pixels: one device has 3 of them, the other 2 and one to spare."""
    here = Path(__file__).resolve().parent
    environment = os.environ | {
        "XLA_FLAGS": "--xla_force_host_platform_device_count=2",
        "JAX_PLATFORMS": "cpu",
        "PYTHONPATH": os.pathsep.join([str(here.parent), *filter(None, [os.environ.get("PYTHONPATH")])]),
    }
    command = [sys.executable, "-c", TWO_DEVICES, str(here)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout == "equal\n", done.stderr


# ---------------------------------------------------------------- dtype and refusals


def test_a_picture_of_a_float32_scene_is_float32_with_64_bits_at_hand():
    scene = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), canonical(hall()))
    image = jax.eval_shape(lambda scene: render(scene, EYE, 4, 3, 1, spp=2), scene)
    assert {str(x.dtype) for x in jax.tree.leaves(image)} == {"float32", "int32", "uint32"}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"width": 0}, r"^width = 0 is outside \[1, inf\)"),
        ({"height": -3}, r"^height = -3 is outside \[1, inf\)"),
        ({"spp": 0}, r"^spp = 0 is outside \[1, inf\)"),
        ({"n_bounces": -1}, r"^n_bounces = -1 is outside \[0, inf\)"),
        ({"alpha": "straight"}, r"^alpha = 'straight' must be one of premultiplied, printed"),
        (
            {"camera": dataclasses.replace(EYE, field_of_view=4.0)},
            r"^camera\.field_of_view = 4\.0 is outside \(0, 3\.14",
        ),
        ({"camera": dataclasses.replace(EYE, position=[0.0, 1.0])}, r"^camera\.position = .* is not a vector"),
        ({"scene": Scene({"a": ball(Phong(k_d=-1.0))})}, r"^objects\.a\.surface\.k_d = -1\.0 is outside \[0, inf\)"),
    ],
)
def test_what_is_out_of_its_range_is_refused_by_name(changed, message):
    settings = {"scene": hall(), "camera": EYE, "width": 4, "height": 3, "n_bounces": 1} | changed
    with pytest.raises(ValueError, match=message):
        render(**settings)


# ---------------------------------------------------------------- cameras


def array(v) -> np.ndarray:
    return np.stack([np.asarray(x) for x in (v.x, v.y, v.z)], axis=-1)


def test_a_pinhole_looks_at_its_target_and_sees_its_field_of_view_from_bottom_to_top():
    for fov in (0.1, 0.8, 2.0):
        camera = Pinhole(Vec3(1.0, 2.0, 3.0), Vec3(4.0, 2.0, -1.0), field_of_view=fov)
        middle, top, bottom, left, right = (camera.ray(*at) for at in ((0, 0), (0, 1), (0, -1), (-1, 0), (1, 0)))
        np.testing.assert_allclose(array(middle.direction), [0.6, 0, -0.8], atol=1e-15)
        rays = [array(r.direction) for r in (top, bottom, left, right)]
        np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1, rtol=1e-15)
        assert math.isclose(math.acos(rays[0] @ rays[1]), fov, rel_tol=1e-12)
        assert math.isclose(math.acos(rays[2] @ rays[3]), fov, rel_tol=1e-12)
        assert rays[0][2] > rays[1][2]  # up is up
        assert rays[2][1] > rays[3][1]  # looking along x, y is to the left
        np.testing.assert_array_equal(array(top.origin), [1, 2, 3])


def test_an_orthographic_camera_has_one_direction_and_a_height_in_the_unit_of_the_scene():
    camera = Orthographic(Vec3(0.0, -5.0, 1.0), Vec3(0.0, 0.0, 1.0), height=3.0)
    at = np.array([(-1.0, 1.0), (1.0, 1.0), (0.0, -1.0), (2.0, 0.0)])
    rays = jax.vmap(camera.ray)(*map(jnp.asarray, at.T))
    np.testing.assert_allclose(array(rays.direction), np.tile([0, 1, 0], (4, 1)), atol=1e-15)
    np.testing.assert_allclose(array(rays.origin), np.stack([1.5 * at[:, 0], 0 * at[:, 0] - 5, 1 + 1.5 * at[:, 1]], -1))


@pytest.mark.parametrize("camera", [EYE, Orthographic(Vec3(0.3, -4.0, 2.0), Vec3(0.0, 0.0, 0.7))])
def test_a_ray_can_be_differentiated_in_every_number_of_its_camera(camera):
    camera, rng, h = canonical_model(camera, float), np.random.default_rng(0), 1e-6
    direction = jax.tree.map(lambda x: jnp.asarray(rng.uniform(-1, 1)), camera)
    moved = [jax.tree.map(lambda x, d, s=s: x + s * d, camera, direction) for s in (h, -h)]
    ray = jax.jit(lambda camera: camera.ray(0.7, -0.4))
    _, slope = jax.jvp(ray, (camera,), (direction,))
    for s, up, down in zip(*map(jax.tree.leaves, (slope, *map(ray, moved))), strict=True):
        assert math.isclose(s, (up - down) / (2 * h), rel_tol=1e-6, abs_tol=1e-9)


def test_the_sky_goes_from_the_horizon_to_zenith_and_nadir_with_the_height_of_the_ray():
    sky = Sky(np.array([1.0, 0.0]), np.array([0.5, 0.5]), np.array([0.0, 2.0]))
    for z, expected in [(1.0, [1, 0]), (0.0, [0.5, 0.5]), (-1.0, [0, 2]), (0.5, [0.75, 0.25]), (-0.5, [0.25, 1.25])]:
        np.testing.assert_allclose(sky(Vec3(math.sqrt(1 - z * z), 0.0, z)), expected, rtol=1e-15)
    up = Ray(vec([[0.0, 0.0, 9.0]]), vec([[0.0, 0.6, 0.8]]))
    out = quick_trace(Scene({"ball": ball(Phong())}, {}, sky), up, 0)
    np.testing.assert_allclose(out.radiance, [[0.9, 0.1]], rtol=1e-15)


def test_a_camera_without_a_view_is_refused():
    scene = Scene({"ball": ball(Phong(), 1.0, Vec3(0.0, 0.0, 0.0))})
    with pytest.raises(ValueError, match=r"camera.target = \[0.0, 0.0, 5.0\] is the position of the camera"):
        render(scene, Pinhole(Vec3(0.0, 0.0, 5.0), Vec3(0.0, 0.0, 5.0)), 4, 4, 0)
    with pytest.raises(ValueError, match=r"camera.up = \[0.0, 0.0, 1.0\] is parallel to the view \[0.0, 0.0, -5.0\]"):
        render(scene, Pinhole(Vec3(0.0, 0.0, 5.0)), 4, 4, 0)
    render(scene, Pinhole(Vec3(0.0, 0.0, 5.0), up=Vec3(0.0, 1.0, 0.0)), 4, 4, 0)


def test_the_colours_of_a_texture_keep_the_range_of_the_parameter_in_whose_place_it_stands():
    objects = {"floor": plane(Blend(Phong(), Checker(0.5, 1.5)))}
    with pytest.raises(ValueError, match=r"^objects.floor.surface.reflectivity.odd = 1.5 is outside \[0, 1\]"):
        render(Scene(objects), EYE, 4, 4, 0)
    jax.eval_shape(lambda: render(Scene({"floor": plane(Phong(Checker(0.5, 1.5)))}), EYE, 4, 4, 0))


@pytree
class Prism:
    def local(self, hit, wi):
        return Local(0.0, 0.0)

    def weights(self, hit):
        return Weights(0.0, 0.1, 0.9, eta=jnp.array([1.5, 1.52, 1.54]))


def test_a_surface_with_an_index_per_channel_is_refused():
    with pytest.raises(ValueError, match=r"^Prism.weights: eta has shape \(3,\); a ray is bent by one index"):
        render(Scene({"glass": ball(Prism(), 1.0, Vec3(0.0, 0.0, 0.0))}), EYE, 4, 4, 1)
