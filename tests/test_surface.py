"""Surfaces: what the four documents claim, one row of the protocol each; textures; and a user's own models."""

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_tracer import reference
from tracer_scenes import ABOVE, UP, ball, lamp, plane, quick_jit, rays_of, vec
from tracer_scenes import quick_trace as trace

from jaxrefl import Vec3, brdf, fresnel
from jaxrefl.camera import Orthographic
from jaxrefl.geometry import Hit, Ray
from jaxrefl.light import Directional, Illumination, PointLight
from jaxrefl.params import param, pytree
from jaxrefl.render import render
from jaxrefl.scene import Scene, Sky
from jaxrefl.surface import D3D9, Blend, Coat, Conductor, Dielectric, Local, Phong, Surface, Weights, Whitted
from jaxrefl.surface.phong import blinn_lobe
from jaxrefl.texture import Checker, ImageTexture
from jaxrefl.vec import dot

pytestmark = pytest.mark.usefixtures("quick_compilation")


def toward(theta_deg, phi_deg=0.0, dtype=float) -> Vec3:
    theta, phi = math.radians(theta_deg), math.radians(phi_deg)
    x = (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
    return Vec3(*(jnp.asarray(round(c, 15), dtype) for c in x))


def seen_at(theta_deg, entering=True, uv=(0.0, 0.0), dtype=float) -> Hit:
    """Hit of a horizontal surface, seen from an angle."""
    one = jnp.asarray(1.0, dtype)
    p, n, tangent = (Vec3(*(jnp.asarray(x, dtype) for x in v)) for v in ((0, 0, 0), (0, 0, 1), (1, 0, 0)))
    return Hit(p, n, tangent, toward(theta_deg, 0, dtype), one, tuple(one * x for x in uv), jnp.asarray(entering))


# ---------------------------------------------------------------- Phong


def test_a_red_surface_in_white_light_has_a_red_diffuse_part_and_a_white_highlight():
    paint = Phong(k_d=np.array([0.8, 0.0, 0.0]), k_s=0.9, shininess=30.0)
    shown = paint.local(seen_at(40), toward(40, 180))  # the mirror direction
    np.testing.assert_allclose(shown.diffuse, [0.8 * math.cos(math.radians(40)), 0, 0], rtol=1e-14)
    np.testing.assert_allclose(np.broadcast_to(shown.specular, (3,)), 0.9, rtol=1e-13)
    away = paint.local(seen_at(40), toward(40, 0))
    assert np.max(away.specular) < 1e-3  # off the highlight it is as red as before
    np.testing.assert_array_equal(away.diffuse, shown.diffuse)


def planes_and_suns(rays, k_d, k_s, sun=0.0, bulb=0.0):
    """What rays see of a floor under a directional light, or a point light."""
    both = {"sun": Directional(Vec3(0.6, 0.0, -0.8), sun, sun), "bulb": PointLight(Vec3(0.0, 0.0, 2.0), bulb, bulb)}
    return np.asarray(
        trace(Scene({"floor": plane(Phong(k_d, k_s, 20.0))}, both), rays, 0, account=False).radiance[:, 0]
    )


def test_in_directional_light_the_diffuse_part_is_constant_over_a_plane_for_any_viewer_and_in_no_other():
    rng = np.random.default_rng(0)
    eye, aim = np.array([0, 0, 4]) + rng.uniform(-3, 3, (64, 3)), rng.uniform(-3, 3, (64, 3)) * [1, 1, 0]
    d = (aim - eye) / np.linalg.norm(aim - eye, axis=1, keepdims=True)
    np.testing.assert_allclose(planes_and_suns(Ray(vec(eye), vec(d)), 0.5, 0.0, sun=1.0), 0.4, rtol=1e-14)
    assert np.ptp(planes_and_suns(Ray(vec(eye), vec(d)), 0.5, 0.0, bulb=1.0)) > 0.1


def test_with_an_infinite_viewer_and_a_directional_light_the_half_vector_is_constant_over_a_plane():
    orthographic = rays_of(Orthographic(Vec3(3.0, 0.0, 4.0)), 8, 8)
    h = np.array([0.6 - 0.6, 0, 0.8 + 0.8])
    assert h[0] == 0  # the viewer is in the mirror direction
    np.testing.assert_allclose(planes_and_suns(orthographic, 0.0, 1.0, sun=1.0), 1, rtol=1e-13)
    tilted = rays_of(Orthographic(Vec3(3.0, 2.0, 4.0)), 8, 8)
    shown = planes_and_suns(tilted, 0.0, 1.0, sun=1.0)
    h = np.array([-0.6, 0, 0.8]) + np.array([3.0, 2.0, 4.0]) / math.sqrt(29)
    np.testing.assert_allclose(shown, (h[2] / np.linalg.norm(h)) ** 20, rtol=1e-13)
    near = jax.tree.map(lambda x: jnp.full_like(x, jnp.mean(x)), tilted.origin)
    d = np.stack([np.asarray(x) for x in (tilted.origin.x, tilted.origin.y, 0 * tilted.origin.z)], axis=-1)
    d = d - np.array([3.0, 2.0, 4.0])
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    assert np.ptp(planes_and_suns(Ray(near, vec(d)), 0.0, 1.0, sun=1.0)) > 0.1  # a near viewer sees a highlight


@pytest.mark.parametrize(("highlight", "share"), [("mirror", 1.0), ("half_vector", 0.5)])
def test_the_highlight_is_a_power_of_a_cosine_that_shrinks_to_the_mirror_direction(highlight, share):
    off = np.array([0.0, 0.5, 2.0, 10.0])  # degrees from the mirror direction of light at 30 degrees
    exponents, lobes = (1.0, 10.0, 1e2, 1e4, 1e6), []
    for n in exponents:
        paint = Phong(k_s=1.0, shininess=n, highlight=highlight)
        lobes.append([float(paint.local(seen_at(30 + x), toward(30, 180)).specular) for x in off])
    expected = np.cos(np.radians(share * off)) ** np.array(exponents)[:, None]
    np.testing.assert_allclose(lobes, expected, rtol=1e-9, atol=1e-300)
    assert (np.diff(lobes, axis=0)[:, 1:] < 0).all()  # "Large n produces a smaller highlight"
    np.testing.assert_allclose(lobes[-1], [1, 0, 0, 0], atol=1e-4)  # "Perfect mirror - n is infinity"


@pytest.mark.parametrize("highlight", ["mirror", "half_vector"])
def test_light_from_below_the_horizon_gives_neither_diffuse_light_nor_a_highlight(highlight):
    paint = Phong(k_d=1.0, k_s=1.0, shininess=2.0, highlight=highlight)
    for theta in (90.5, 95.0, 120.0, 180.0):
        wi, hit = toward(theta, 180), seen_at(60)
        lobe = dot(hit.n * (2 * dot(hit.n, wi)) - wi, hit.wo) if highlight == "mirror" else (wi + hit.wo).z
        assert lobe > 0 or theta > 100  # the formula as printed would show one
        assert paint.local(hit, wi) == (0, 0)
    assert min(paint.local(seen_at(60), toward(89.5, 180))) > 0


def test_where_light_and_viewer_are_opposite_and_there_is_no_half_vector_the_lobe_is_zero_with_finite_slopes():
    right, left = Vec3(1.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0)
    for shininess in (1.0, 2.5):
        value, slopes = jax.value_and_grad(blinn_lobe, (0, 1, 2, 3))(UP, right, left, shininess)
        assert value == 0
        assert all(jnp.isfinite(x) for x in jax.tree.leaves(slopes))


def test_emission_and_ambient_coefficient_are_weights_and_no_ray_goes_on():
    w = Phong(k_a=0.25, emission=2.0).weights(seen_at(0))
    assert w == Weights(local=1.0, reflected=0.0, transmitted=0.0, emitted=2.0, ambient=0.25)


# ---------------------------------------------------------------- PERRIN and JHU


def test_the_blend_weighs_its_base_with_one_minus_alpha():
    w = Blend(Phong(emission=0.5), np.array([0.0, 0.25, 1.0])).weights(seen_at(30))
    np.testing.assert_array_equal(w.local, [1, 0.75, 0])
    np.testing.assert_array_equal(w.reflected, [0, 0.25, 1])
    assert w.emitted == 0.5


def test_over_a_black_background_the_blend_is_what_equation_four_says_and_never_brighter_than_both():
    rays = Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.6, -0.8]]))
    for alpha, background in [(0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (0.3, 5.0), (1.0, 5.0)]:
        scene = Scene({"floor": plane(Blend(lamp(0.8), alpha))}, background=background)
        np.testing.assert_allclose(
            trace(scene, rays, 1, account=False).radiance, (1 - alpha) * 0.8 + alpha * background
        )
        assert trace(scene, rays, 0, account=False).radiance[0, 0] == pytest.approx((1 - alpha) * 0.8)


def test_whitted_adds_and_its_absent_rays_are_absent():
    w = Whitted(Phong(emission=0.5), k_rg=0.25).weights(seen_at(30))
    assert w == Weights(local=1.0, reflected=0.25, emitted=0.5)
    w = Whitted(Phong(), 0.25, 0.5, 1.5, 0.125, 2.0).weights(seen_at(30))
    assert (w.transmitted, w.eta, w.sigma_reflected, w.sigma) == (0.5, 1.5, 0.125, 2.0)


def test_both_rays_of_whitted_are_added_with_their_attenuation_and_total_reflection_joins_them():
    """Rays fall on a ball through a lid that shines downwards alone."""
    for eta, k_rg, k_tg, sigma_rg, sigma_tg in [(1.5, 0.25, 0.5, 0.125, 0.75), (0.5, 0.25, 0.5, 0.125, 0.75)]:
        x = np.array([0.0, 0.3, 0.7, 0.9])
        glass = Whitted(lamp([0.1, 0.2, 0.3]), k_rg, k_tg, eta, sigma_rg, sigma_tg)
        rays = Ray(vec(np.stack([x, 0 * x, 0 * x + 3], axis=-1)), vec(np.tile([0.0, 0.0, -1.0], (4, 1))))
        sky = Sky([1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0])
        shown = trace(Scene({"ball": ball(glass)}, background=sky), rays, 1, account=False).radiance
        total = x > eta
        # the reflected ray escapes, and weighs nothing as its sigma is above 0; the refracted one ends at n_bounces = 1
        inside = np.where(total, 0, k_tg * np.exp(-sigma_tg * 2 * np.sqrt(np.maximum(1 - (x / eta) ** 2, 0))) / eta**2)
        expected = np.array([0.1, 0.2, 0.3]) * (1 + inside[:, None])
        np.testing.assert_allclose(shown, expected, rtol=1e-13)
        clear = dataclasses.replace(glass, sigma_rg=0.0)
        shown = trace(Scene({"ball": ball(clear)}, background=sky), rays, 1, account=False).radiance
        joined = np.where(total, k_rg + k_tg, k_rg)[:, None] * np.array([1.0, 1.0, 0.0])
        np.testing.assert_allclose(shown, expected + joined, rtol=1e-13)


# ---------------------------------------------------------------- D3D9


@pytest.mark.parametrize("theta", [0, 60, 80])
def test_d3d9_reflects_by_equation_five_and_shows_its_base_by_equation_six(theta):
    metallic, specular = np.array([0.7, 0.2, 0.4]), np.array([1.0, 0.5, 0.0])
    for p in (2.0, 4.0, 5.0):
        r = 0.04 + 0.9 * (1 - math.cos(math.radians(theta))) ** p
        w = D3D9(Phong(), metallic, 0.04, 0.9, p, specular).weights(seen_at(theta))
        np.testing.assert_allclose(w.reflected, metallic * (1 - r) + specular * r, rtol=1e-12)
        np.testing.assert_allclose(w.local, 0.3, rtol=1e-14)
    assert D3D9(Phong(), metallic, metallic_norm=0.25).weights(seen_at(theta)).local == 0.75


def test_equation_eight_dims_the_diffuse_light_of_the_sun_by_its_own_angle_and_nothing_else():
    base, wi = Phong(0.5, 0.3, 4.0, k_a=0.2, emission=0.1), toward(60, 130)
    six, eight = D3D9(base), D3D9(base, sun_fresnel=True)
    plain, dimmed = (surface.local(seen_at(20), wi) for surface in (six, eight))
    np.testing.assert_allclose(dimmed.diffuse, plain.diffuse * (1 - (0.04 + 0.96 * 0.5**5)), rtol=1e-13)
    assert dimmed.specular == plain.specular
    assert eight.weights(seen_at(20))._replace(reflected=0) == six.weights(seen_at(20))._replace(reflected=0)


def test_the_alpha_of_the_image_is_equation_seven_as_printed_or_premultiplied():
    """A tinted pane seen at 0 degrees, R = 0.04, in front of bright and dark surroundings."""
    coverage = Checker(0.6, 0.1, 1.0, 1.0)
    picture = quick_jit(lambda scene, alpha: render(scene, ABOVE, 2, 2, 1, alpha=alpha), static_argnames="alpha")
    for light in (0.5, 30.0):
        pane = D3D9(lamp(0.2), np.array([0.3, 0.1, 0.0]), 0.04, 0.96, 5.0, 1.0, alpha=coverage)
        scene = Scene({"pane": plane(pane)}, background=light)
        rho = np.array([0.3, 0.1, 0.0]) * 0.96 + 0.04
        d_a = np.array([[0.1, 0.6], [0.6, 0.1]])  # x < 0, x > 0; the upper row first
        premultiplied = render(scene, ABOVE, 2, 2, 1)
        np.testing.assert_allclose(
            premultiplied.radiance, np.broadcast_to(0.7 * 0.2 + rho * light, (2, 2, 3)), rtol=1e-13
        )
        np.testing.assert_allclose(premultiplied.alpha, 1 - (1 - d_a) * (1 - rho.max()), rtol=1e-13)
        printed = picture(scene, alpha="printed")
        np.testing.assert_allclose(printed.alpha, np.maximum(d_a, (rho * light).max()), rtol=1e-12)
        np.testing.assert_array_equal(printed.radiance, premultiplied.radiance)


# ---------------------------------------------------------------- LAMBERT-FRESNEL


@pytest.mark.parametrize(
    ("eta", "theta", "expected"),
    [
        (1.5, 60, 0.089186712802212783),
        (2.4, 60, 0.20935126077072882),
        (1.33, 0, (0.33 / 2.33) ** 2),
        (1.5, 85, 0.61279964526482738),
    ],
)
def test_a_dielectric_reflects_the_exact_fraction_and_transmits_the_rest(eta, theta, expected):
    w = Dielectric(eta).weights(seen_at(theta))
    np.testing.assert_allclose([w.reflected, w.transmitted], [expected, 1 - expected], rtol=1e-13)
    assert (w.local, w.eta) == (0, eta)
    assert Coat(Phong(), eta).weights(seen_at(theta))[:2] == (w.transmitted, w.reflected)
    assert Dielectric(eta).local(seen_at(theta), UP) == (0, 0)


def test_from_inside_a_dielectric_reflects_by_the_inverse_index_and_totally_beyond_the_critical_angle():
    for eta, theta, expected in [(1.33, 45, 0.13418671521276993), (1.5, 30, 0.055190167295375919), (1.5, 45, 1)]:
        w = Dielectric(eta, 0.5).weights(seen_at(theta, entering=False))
        np.testing.assert_allclose([w.reflected, w.transmitted], [expected, 1 - expected], rtol=1e-13, atol=1e-15)
        assert w.sigma == 0.5


def test_a_conductor_reflects_the_exact_fraction_of_each_channel():
    gold = Conductor(np.array([0.43, 1.38, 1.0728]), np.array([2.455, 1.914, 6.7839])).weights(seen_at(60))
    np.testing.assert_allclose(
        gold.reflected, [0.78813190320326089, 0.43979866663659919, 0.8994487265021787], rtol=1e-13
    )
    assert (gold.local, gold.transmitted) == (0, 0)


def test_at_index_one_the_forward_derivative_of_a_dielectric_is_zero_like_the_reverse_one():
    at = jnp.float32(6.1e-17), jnp.float32(1.0)
    assert jax.jit(jax.grad(fresnel.dielectric, (0, 1)))(*at) == (0, 0)
    assert jax.jit(lambda *x: jax.jvp(fresnel.dielectric, x, x))(*at) == (0, 0)


# ---------------------------------------------------------------- every surface

SURFACES = [
    Phong(0.5, 0.5, 2.5),
    Phong(0.5, 0.5, 0.0, highlight="mirror"),
    Blend(reflectivity=0.0),
    Whitted(Phong(k_s=0.3), 0.0, 0.0, 1.5, 0.0, 0.0),
    D3D9(Phong(), 0.0, 0.0, 1.0, 0.5, sun_fresnel=True),
    Dielectric(1.0, 0.0),
    Dielectric(1.5),
    Conductor(0.2, 0.0),
    Coat(Phong(k_s=0.3), 1.0),
]


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: type(s).__name__)
def test_every_surface_keeps_the_protocol_and_is_finite_in_value_and_derivative_at_every_edge(surface):
    assert isinstance(surface, Surface)
    model = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), surface)
    views = [seen_at(t, entering, dtype=np.float32) for t in (0, 45, 89.9, 90) for entering in (True, False)]
    lights = [toward(t, f, np.float32) for t, f in ((0, 0), (45, 180), (90, 180), (120, 0), (180, 0))]
    hits = jax.tree.map(lambda *x: jnp.stack(x), *[hit for hit in views for _ in lights])
    wi = jax.tree.map(lambda *x: jnp.stack(x), *(lights * len(views)))

    def everything(model, wo, wi, hit):
        hit = hit._replace(wo=wo)
        return jnp.stack([jnp.asarray(x, jnp.float32) for x in (*model.weights(hit), *model.local(hit, wi))])

    @jax.jit
    def values_and_slopes(wi, hit):
        arguments = (model, hit.wo, wi)
        along = jax.tree.map(jnp.ones_like, arguments)
        value, forward = jax.jvp(lambda *x: everything(*x, hit), arguments, along)
        return value, forward, jax.grad(lambda *x: everything(*x, hit).sum(), (0, 1, 2))(*arguments)

    assert all(jnp.isfinite(x).all() for x in jax.tree.leaves(jax.vmap(values_and_slopes)(wi, hits)))


# ---------------------------------------------------------------- textures


def test_an_image_is_its_pixels_at_their_centres_and_linear_in_between_and_repeats():
    rng = np.random.default_rng(0)
    image = ImageTexture(jnp.asarray(rng.random((2, 4, 3))), 0.5, 0.25)  # two units wide, four high
    at = jax.jit(jax.vmap(image))
    column, row = (x.ravel() for x in np.meshgrid(np.arange(-4, 8), np.arange(-2, 4)))
    np.testing.assert_allclose(
        at(((column + 0.5) / 2, (row + 0.5) * 2.0)), image.pixels[row % 2, column % 4], atol=1e-15
    )
    between = (image.pixels[row % 2, column % 4] + image.pixels[row % 2, (column + 1) % 4]) / 2
    np.testing.assert_allclose(at(((column + 1) / 2, (row + 0.5) * 2.0)), between, atol=1e-15)


def test_the_derivative_in_the_pixels_is_the_weight_of_each():
    pixels = jnp.zeros((2, 2, 1))
    slope = jax.grad(lambda x: ImageTexture(x)((0.25 + 0.125, 0.25 + 0.375))[0])(pixels)
    np.testing.assert_allclose(slope[..., 0], [[0.75 * 0.25, 0.25 * 0.25], [0.75 * 0.75, 0.25 * 0.75]], rtol=1e-15)


def test_a_checker_alternates_on_both_sides_of_zero():
    u, v = np.meshgrid(np.arange(-3, 3), np.arange(-2, 2))
    squares = Checker(1.0, 0.0, 2.0, 4.0)(((u + 0.5) / 2, (v + 0.5) / 4))
    np.testing.assert_array_equal(squares, (u + v) % 2 == 0)
    assert jax.grad(lambda c: Checker(c, 0.0)((0.5, 1.5)))(1.0) == 0  # the other square


def test_a_texture_may_stand_for_any_color_of_any_surface_on_plane_and_sphere():
    rng = np.random.default_rng(5)

    def picture(low=0.0, high=1.0):
        return ImageTexture(rng.uniform(low, high, (3, 5, 3)), 0.7, 1.3)

    def checks(squares=3.0):
        return Checker(rng.random(3), rng.random(3), squares, 2.0)

    objects = {
        "floor": plane(Whitted(Phong(picture(), checks(), 5.0, k_a=picture()), checks(), sigma_rg=picture(0, 0.1))),
        "metal": ball(
            D3D9(Phong(checks(8.0), emission=picture()), picture(), specular=checks()), 0.8, Vec3(-1.0, 0.0, 1.0)
        ),
        "two": ball(
            Blend(Phong(picture(), k_s=checks(), k_a=np.array([[0.1], [0.4]])), checks(7.0)),
            np.array([0.4, 0.5]),
            np.array([[0.9, 0.2, 0.6], [0.3, -1.0, 0.7]]),
        ),
    }
    lights = {"sun": Directional(Vec3(0.3, 0.5, -1.0), 0.8, 0.6, 0.3), "bulb": PointLight(Vec3(0.0, 0.0, 4.0), 0.5)}
    scene, camera = Scene(objects, lights, Sky([0.2, 0.4, 0.8])), Orthographic(Vec3(1.0, -4.0, 3.0), height=3.0)
    shown = trace(scene, rays_of(camera, 12, 12), 2, account=False).radiance
    np.testing.assert_allclose(shown, reference(scene, camera, 12, 12, 2).reshape(-1, 3), rtol=1e-11, atol=1e-13)


# ---------------------------------------------------------------- a user's own models


@pytree
class Polaroid:
    """Mirror that reflects the s and the p part, in two channels, of a pane of glass."""

    eta: Any = param("(0, inf)", default=1.5)

    def local(self, hit, wi):
        return Local(0.0, 0.0)

    def weights(self, hit):
        c, s2 = hit.cos_theta_o, 1 - hit.cos_theta_o**2
        q = jnp.sqrt(self.eta**2 - s2)
        return Weights(0.0, jnp.stack([(c - q) / (c + q), (self.eta**2 * c - q) / (self.eta**2 * c + q)]) ** 2)


@pytree
class Curtain:
    """Texture of stripes with a smooth edge."""

    color: Any = param("[0, 1]", spectral=True, default=0.5)

    def __call__(self, uv):
        return self.color * jnp.sin(uv[0]) ** 2


@pytree
class Tube:
    """Light along the x axis at a height: what falls on a point comes from the nearest place of the tube."""

    height: Any = param("(0, inf)", default=2.0)
    diffuse: Any = param("[0, inf)", spectral=True, default=1.0)
    specular: Any = param("[0, inf)", spectral=True, default=0.0)
    ambient: Any = param("[0, inf)", spectral=True, default=0.0)
    shadows: bool = dataclasses.field(default=True, metadata={"static": True})

    def at(self, p):
        distance = jnp.hypot(p.y, self.height - p.z)
        return Illumination(Vec3(0 * p.x, -p.y, self.height - p.z) / distance, distance, 1 / distance)


@pytree
class Stars:
    """Background that is bright along one axis."""

    brightness: Any = param("[0, inf)", spectral=True, default=1.0)

    def __call__(self, direction):
        return self.brightness * direction.y**2


def test_surface_light_texture_and_background_of_a_user_render_without_touching_the_library():
    paint = Phong(k_d=Curtain(np.array([0.8, 0.4])))
    objects = {"floor": plane(paint), "mirror": plane(Polaroid(1.5), Vec3(0.0, 0.0, -50.0), Vec3(1.0, 0.0, 1.0))}
    scene = Scene(objects, {"tube": Tube(2.0, np.array([1.0, 3.0]))}, Stars(np.array([5.0, 7.0])))
    down = Ray(vec([[0.3, 1.5, 1.0], [1.2, -2.0, 1.5]]), vec([[0.0, 0.0, -1.0]] * 2))
    y, x = np.array([1.5, -2.0]), np.array([0.3, 1.2])
    expected = (np.sin(x) ** 2 * 2 / (y**2 + 4))[:, None] * np.array([0.8, 0.4]) * np.array([1.0, 3.0])
    np.testing.assert_allclose(trace(scene, down, 1, account=False).radiance, expected, rtol=1e-13)
    up = Ray(vec([[0.0, 0.0, 1.0]] * 2), vec([[0.0, 0.6, 0.8]] * 2))
    np.testing.assert_allclose(trace(scene, up, 1, account=False).radiance, [[1.8, 2.52]] * 2, rtol=1e-14)
    # below the floor a ray falls on the mirror, which changes the places and signs of x and z, and falls back down
    cos, eta = 0.8 / math.sqrt(2), 1.5
    q = math.sqrt(eta**2 - 1 + cos**2)
    fresnel = np.array([(cos - q) / (cos + q), (eta**2 * cos - q) / (eta**2 * cos + q)]) ** 2
    aside = Ray(vec([[9.0, 0.0, -60.0]] * 2), vec([[0.0, 0.6, -0.8]] * 2))
    np.testing.assert_allclose(trace(scene, aside, 1, account=False).radiance, [[1.8, 2.52]] * 2, rtol=1e-14)
    onto = Ray(vec([[-9.0, 0.0, -40.0]] * 2), vec([[0.0, 0.6, -0.8]] * 2))
    shown = trace(scene, onto, 1, account=False).radiance
    np.testing.assert_allclose(shown, [fresnel * 0.36 * np.array([5.0, 7.0])] * 2, rtol=1e-12)


@pytree
class Matt:
    """Surface of any BRDF."""

    brdf: Any

    def local(self, hit, wi):
        cos = jnp.maximum(dot(hit.n, wi), 0.0)
        return Local(jnp.pi * cos * self.brdf(Vec3(0.0, 0.0, cos), Vec3(0.0, 0.0, hit.cos_theta_o)), 0.0)

    def weights(self, hit):
        return Weights()


def test_a_users_surface_may_hold_any_brdf():
    scene = Scene({"floor": plane(Matt(brdf.Lambert(0.6)))}, {"sun": Directional(Vec3(0.0, 0.6, -0.8))})
    shown = trace(scene, Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]])), 0, account=False).radiance
    np.testing.assert_allclose(shown, 0.48, rtol=1e-14)
