"""From a scene to a picture: samples, tiles, bands, devices, alpha."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tracer_scenes import ABOVE, VIEW, ball, lamp, plane, rays_of

from jaxrefl.render import Image, render, sample_position
from jaxrefl.scene import Scene
from jaxrefl.surface import Blend, Phong
from jaxrefl.trace import trace


def scene() -> Scene:
    return Scene(
        {"ball": ball(Blend(lamp([0.2, 0.5, 0.9]), 0.5)), "floor": plane(Phong(k_d=0.0, emission=0.1))}, background=0.7
    )


def test_a_picture_is_what_its_rays_bring_back_row_by_row_from_the_top():
    image, found = render(scene(), VIEW, 14, 9, 2), trace(scene(), rays_of(VIEW, 14, 9), 2)
    np.testing.assert_allclose(image.radiance.reshape(-1, 3), found.radiance, rtol=1e-13)
    np.testing.assert_array_equal(image.primitive.ravel(), found.primitive)
    np.testing.assert_allclose(image.depth.ravel(), found.depth, rtol=1e-13)
    np.testing.assert_array_equal(image.path_id.ravel(), found.account.path_id)
    np.testing.assert_array_equal(image.bounces.ravel(), found.account.rays - 1)
    assert image.normal.shape == (9, 14, 3)
    assert (image.primitive[0] == -1).all()
    assert (image.primitive[-1] == 1).all()


@pytest.mark.parametrize("log2", range(7))
def test_of_the_first_samples_one_lies_in_each_equal_box_of_every_shape(log2):
    n = 2**log2
    x, y = jax.vmap(lambda i: sample_position(7, 12, 34, i))(jnp.arange(n))
    for a in range(log2 + 1):
        boxes = np.floor(x * 2**a) * 2 ** (log2 - a) + np.floor(y * 2 ** (log2 - a))
        assert len(set(boxes.tolist())) == n


def test_a_sample_depends_on_seed_pixel_and_number_alone():
    positions = {
        tuple(map(float, sample_position(*key))) for key in ((0, 1, 2, 3), (1, 1, 2, 3), (0, 2, 1, 3), (0, 1, 2, 4))
    }
    assert len(positions) == 4
    assert tuple(map(float, sample_position(0, 1, 2, 3))) in positions


def test_samples_are_averaged_and_the_first_hit_is_that_of_the_first_sample():
    image, again = (render(scene(), ABOVE, 6, 6, 1, spp=8, seed=s) for s in (3, 3))
    for a, b in zip(jax.tree.leaves(image), jax.tree.leaves(again), strict=True):
        np.testing.assert_array_equal(a, b)
    assert (render(scene(), ABOVE, 6, 6, 1, spp=8, seed=4).radiance != image.radiance).any()
    inside = np.asarray(image.primitive) == 0
    assert 0.5 < inside.mean() < 0.95
    pixels = [(r, c, *map(float, sample_position(3, c, r, 0))) for r in range(6) for c in range(6)]
    for r, c, dx, dy in pixels:
        x, y = (2 * (c + dx) - 6) / 6, 1 - 2 * (r + dy) / 6
        if abs(x * x + y * y - 1) > 1e-6:
            assert inside[r, c] == (x * x + y * y < 1)


def test_bands_with_a_report_are_the_same_picture_and_count_every_ray():
    reports = []
    whole = render(scene(), VIEW, 150, 101, 1, spp=2)
    banded = render(scene(), VIEW, 150, 101, 1, spp=2, progress=lambda *args: reports.append(args))
    for a, b in zip(jax.tree.leaves(whole), jax.tree.leaves(banded), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-14)
    assert [done for done, _, _ in reports] == sorted(done for done, _, _ in reports)
    assert reports[-1][:2] == (150 * 101 * 2, 150 * 101 * 2)
    assert reports[-1][2] >= 150 * 101 * 2


def test_a_report_may_stop_the_work():
    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render(scene(), VIEW, 8, 8, 1, progress=stop)


def test_two_devices_make_the_same_picture_bit_for_bit(tmp_path):
    script = """
import jax, numpy as np
from test_render import scene, VIEW, render
devices = jax.devices()
assert len(devices) == 2
one = render(scene(), VIEW, 150, 101, 2)
two = render(scene(), VIEW, 150, 101, 2, devices=devices)
assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(two)))
"""
    here = os.path.dirname(__file__)
    environment = {**os.environ, "XLA_FLAGS": "--xla_force_host_platform_device_count=2"}
    environment["PYTHONPATH"] = os.pathsep.join([here, os.path.dirname(here), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr


def test_a_picture_without_account_is_the_same_picture_and_keeps_no_count():
    full, lean = (render(scene(), VIEW, 14, 9, 2, account=account) for account in (True, False))
    np.testing.assert_array_equal(full.radiance, lean.radiance)
    assert lean.budget is None
    assert isinstance(full, Image)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"width": 0}, r"width = 0 is outside \[1, inf\)"),
        ({"spp": 0}, r"spp = 0 is outside \[1, inf\)"),
        ({"alpha": "straight"}, "alpha = 'straight' must be one of premultiplied, printed"),
    ],
)
def test_a_setting_out_of_range_is_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        render(**{"scene": scene(), "camera": VIEW, "width": 4, "height": 4, "n_bounces": 1} | wrong)
