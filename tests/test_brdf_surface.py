"""A reflection model in a scene: what the tracer shows of it is what the analysis says of it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tracer_scenes import ABOVE, plane, quick_jit, quick_trace, rays_of

from jaxrefl import catalog, fresnel
from jaxrefl.brdf import D3D9, Lambert, LommelSeeliger, Mix, ModifiedPhong, Slab
from jaxrefl.geometry import Hit
from jaxrefl.params import param, pytree
from jaxrefl.scene import Scene
from jaxrefl.surface import D3D9 as D3D9Surface
from jaxrefl.surface import BRDFSurface, Phong
from jaxrefl.surface.protocol import is_absent
from jaxrefl.vec import Vec3, cross, normalize

RNG = np.random.default_rng(3)


def hit(n, tangent, wo, one=1.0):
    one = jnp.asarray(one)
    return Hit(n * 0.0, n, tangent, wo, one, (one, one), one > 0)


def frame():
    n = normalize(Vec3(0.3, -0.5, 0.8))
    tangent = normalize(cross(n, Vec3(0.1, 1.0, 0.2)))
    return n, tangent, cross(n, tangent)


def out_of(local, basis):
    n, x, y = basis
    return x * local.x + y * local.y + n * local.z


def pairs(count=40):
    u = RNG.uniform(0.02, 1, (2, count)), RNG.uniform(0, 2 * np.pi, (2, count))
    return [Vec3.from_spherical(jnp.asarray(u[0][i]), jnp.asarray(u[1][i])) for i in range(2)]


@pytree
class Brushed:
    """Not symmetric about the normal, nor in x and y."""

    strength: object = param("[0, 1]", default=0.7)

    def __call__(self, wi, wo):
        return self.strength * (1 + wi.x * wo.x - 0.5 * wi.y + 0.2 * wi.x * wo.z) / jnp.pi


@pytest.mark.parametrize("brdf", [Brushed(), ModifiedPhong(0.8, 7.0), Lambert(0.3)], ids=lambda b: type(b).__name__)
def test_the_response_is_pi_f_cos_in_the_frame_of_the_hit(brdf):
    basis = frame()
    wi, wo = pairs()

    @jax.jit
    @jax.vmap
    def both(wi, wo):
        local = BRDFSurface(brdf).local(hit(basis[0], basis[1], out_of(wo, basis)), out_of(wi, basis))
        return local.diffuse, jnp.pi * brdf(wi, wo) * wi.z, local.specular

    shown, expected, specular = both(wi, wo)
    np.testing.assert_allclose(shown, expected, rtol=1e-12, atol=1e-15)
    assert not specular.any()


def test_light_from_below_shows_nothing_and_has_no_derivative():
    n, tangent, _ = frame()

    def shown(surface, wi):
        return BRDFSurface(surface).local(hit(n, tangent, n), wi).diffuse

    for brdf in (Lambert(0.5), LommelSeeliger(0.5)):
        value, slopes = jax.value_and_grad(shown, (0, 1))(brdf, -n)
        assert value == 0
        assert not any(np.any(x) for x in jax.tree.leaves(slopes))


def test_what_a_model_has_not_is_absent_and_what_it_has_is_a_weight():
    n, tangent, side = frame()
    view = normalize(n * 0.5 + side * np.sqrt(0.75))
    lambert = BRDFSurface(Lambert()).weights(hit(n, tangent, view))
    assert is_absent(lambert.reflected)
    assert is_absent(lambert.transmitted)
    slab = BRDFSurface(Slab(1.5)).weights(hit(n, tangent, view))
    r = np.mean([2 * f / (1 + f) for f in np.asarray(fresnel.dielectric_sp(0.5, 1.5))])
    np.testing.assert_allclose([slab.reflected, slab.transmitted, slab.local], [r, 1 - r, 1], rtol=1e-13)


@pytest.mark.parametrize("sun_fresnel", [False, True])
def test_the_model_d3d9_shows_what_its_surface_does(sun_fresnel):
    basis = frame()
    wi, wo = pairs()
    colour, metal = jnp.array([0.7, 0.4, 0.2]), jnp.array([0.5, 0.3, 0.1])
    model = BRDFSurface(D3D9(colour, metal, 0.05, 0.9, 4.0, 0.8, sun_fresnel=sun_fresnel))
    surface = D3D9Surface(Phong(k_d=colour), metal, 0.05, 0.9, 4.0, 0.8, sun_fresnel=sun_fresnel)

    @jax.jit
    @jax.vmap
    def seen(wi, wo):
        here, light = hit(basis[0], basis[1], out_of(wo, basis)), out_of(wi, basis)
        a, b = model.weights(here), surface.weights(here)
        return (a.local * model.local(here, light).diffuse, a.reflected), (
            b.local * surface.local(here, light).diffuse,
            b.reflected,
        )

    for got, expected in zip(*seen(wi, wo), strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-13)


def test_every_model_of_the_catalog_is_finite_in_value_and_derivative_whatever_the_light():
    """All of them at once, in a chain of mixtures; the directions are those of light from everywhere, the edges too."""
    mixed = Lambert(0.4)
    for model in catalog.MODELS.values():
        mixed = Mix(mixed, model(), 0.3)
    n, tangent, side = frame()
    lights = [n, -n, tangent, -tangent, normalize(n + tangent), normalize(tangent - n), normalize(n * 1e-7 + side)]
    views = [n, tangent, normalize(n + tangent), normalize(n * 1e-7 - side)]
    wi = Vec3(*(jnp.stack([jnp.stack([getattr(w, c) for w in lights])] * len(views)).T.ravel() for c in "xyz"))
    wo = Vec3(*(jnp.tile(jnp.stack([getattr(w, c) for w in views]), len(lights)) for c in "xyz"))

    def shown(brdf, wi, wo):
        def one(wi, wo):
            here, surface = hit(n, tangent, wo), BRDFSurface(brdf)
            return surface.local(here, wi).diffuse + surface.weights(here).reflected

        return jnp.mean(jax.vmap(one)(wi, wo) ** 2)

    value, slopes = quick_jit(jax.value_and_grad(shown, (0, 1, 2)))(mixed, wi, wo)
    assert np.isfinite(value)
    assert value > 0
    assert all(np.isfinite(x).all() for x in jax.tree.leaves(slopes))


def test_a_slab_in_a_scene_shows_what_is_behind_it_and_what_is_before_it():
    """Reflected and transmitted ray both leave the scene: sky above, ground below."""

    @pytree
    class Halves:
        def __call__(self, direction):
            return jnp.where(direction.z > 0, jnp.array([1.0, 0.0]), jnp.array([0.0, 1.0]))

    scene = Scene({"pane": plane(BRDFSurface(Slab(1.5, [0.2, 0.2])))}, {}, Halves())
    eye = ABOVE.__class__(Vec3(0.0, -3.0, 3.0))
    seen = quick_trace(scene, rays_of(eye, 2, 2), 1).radiance
    mu = 3 / np.hypot(3, 3)
    model = Slab(1.5, 0.2)
    np.testing.assert_allclose(seen, [[float(model.mirror(mu)), float(model.through(mu))]] * 4, rtol=1e-12)


def test_white_lambert_facing_the_light_shows_its_intensity():
    here = hit(Vec3(0.0, 0.0, 1.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.6, 0.8))
    local = BRDFSurface(Lambert(1.0)).local(here, Vec3(0.0, 0.0, 1.0))
    np.testing.assert_allclose(local.diffuse, 1.0, rtol=1e-15)
