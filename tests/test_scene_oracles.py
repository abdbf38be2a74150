"""Whole scenes through the tracer, against the bounce series of the table: glass sphere, corridor, three in a row."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from oracle_table import BLOCKS

from jaxrefl import fresnel
from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.geometry import Hit, Plane, Ray, Sphere
from jaxrefl.params import param, pytree
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Blend, Dielectric, Local, Phong, Weights, Whitted
from jaxrefl.trace import radiance, trace
from jaxrefl.vec import Vec3

ORIGIN, ZENITH = Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)


def lamp(color):
    return Phong(k_d=0.0, emission=color)


def table(block):
    """Rows of numbers by column."""
    members = BLOCKS[block]
    return [dict(zip(members["fields"], map(float, row), strict=True)) for row in members["rows"]]


def down(*x):
    """Vertical rays from z = 2 at offsets x."""
    x = jnp.asarray(x, float)
    return Ray(Vec3(x, 0 * x, 0 * x + 2), Vec3(0 * x, 0 * x, 0 * x - 1))


# --- the glass sphere ---


@pytree
class PolarizedGlass:
    """Two channels, the two polarisations: in a sphere the plane of incidence stays the same from hit to hit."""

    eta: float = param("(0, inf)")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        return Local(0.0 * hit.t, 0.0 * hit.t)

    def weights(self, hit: Hit) -> Weights:
        eta = jnp.where(hit.entering, self.eta, 1 / self.eta)
        reflected = jnp.stack(fresnel.dielectric_sp(hit.cos_theta_o, eta))
        return Weights(0.0, reflected, 1 - reflected, eta=self.eta)


GLASS = table("H.glass_sphere_tree")


@functools.cache
def glass_spheres():
    """The ray of each row, six bounces far; all rows in one compilation."""

    def one(n, b):
        ball = Scene({"ball": Object(Sphere(ORIGIN), PolarizedGlass(n))}, background=1.0)
        return trace(ball, down(b), 6, terms=True)

    return jax.vmap(one)(*(jnp.array([row[name] for row in GLASS]) for name in ("n", "b")))


@pytest.mark.parametrize("i", range(len(GLASS)), ids=lambda i: f"n={GLASS[i]['n']}, b={GLASS[i]['b']}")
def test_a_glass_sphere_sends_out_the_orders_of_the_table(i):
    traced = glass_spheres()
    orders = [GLASS[i][f"p{order}"] for order in range(6)]
    terms = jax.tree.map(lambda x: np.asarray(x)[i, 0], traced.terms)
    shown = (terms.weight * terms.local * terms.color).mean(axis=1)  # unpolarised light is the mean of both
    np.testing.assert_allclose(np.sort(shown[shown > 0]), np.sort(orders), rtol=1e-13)  # the strongest rays come first
    np.testing.assert_allclose(traced.radiance[i, 0].mean(), sum(orders), rtol=1e-14)


@pytest.mark.parametrize("i", range(len(GLASS)), ids=lambda i: f"n={GLASS[i]['n']}, b={GLASS[i]['b']}")
def test_what_a_glass_sphere_keeps_is_the_deficit_of_the_table_and_in_its_budget(i):
    traced = jax.tree.map(lambda x: x[i, 0], glass_spheres()._replace(terms=None))
    budget = traced.account.budget
    np.testing.assert_allclose(budget.truncated.mean(), GLASS[i]["deficit"], rtol=1e-12)
    np.testing.assert_allclose(budget.escaped, traced.radiance, rtol=1e-15)
    np.testing.assert_allclose(budget.total, 1, rtol=1e-14)


def test_a_glass_sphere_before_a_white_background_is_white_to_a_millionth_and_its_budget_is_one():
    glass = {"ball": Object(Sphere(ORIGIN), Dielectric(1.5))}
    image = render(Scene(glass, background=1.0), Orthographic(Vec3(0.0, 0.0, 5.0), up=Vec3(0.0, 1.0, 0.0)), 24, 24, 12)
    radiance, budget = (np.asarray(x) for x in (image.radiance, image.budget.total))
    np.testing.assert_allclose(budget, 1, rtol=1e-14)
    inside = np.asarray(image.primitive) == 0
    x = (np.arange(24) - 11.5) / 12
    cosine = np.sqrt(np.maximum(0, 1 - x**2 - x[:, None] ** 2))
    # after 12 bounces one ray is left, which has been reflected 11 times: F^11 (1 - F)
    f = np.asarray(fresnel.dielectric(cosine, 1.5))
    np.testing.assert_allclose(radiance[inside, 0], (1 - f**11 * (1 - f))[inside], rtol=1e-12)
    away_from_the_rim = f < 0.25
    assert away_from_the_rim.sum() > 350
    assert np.abs(radiance[away_from_the_rim] - 1).max() < 1e-6


# --- two facing mirrors ---

CORRIDOR = table("H.corridor")
MODELS = {"convex": Blend, "additive": Whitted}


def corridor(model, alpha_a=0.9, alpha_b=0.8):
    """Two facing planes, of which a ray that goes down hits the first one first."""
    first = Object(Plane(ORIGIN, ZENITH), model(lamp(0.3), alpha_a))
    second = Object(Plane(Vec3(0.0, 0.0, 9.0), -ZENITH), model(lamp(0.7), alpha_b))
    return Scene({"first": first, "second": second})


def oblique():
    return Ray(Vec3(*jnp.array([[0.0], [0.0], [5.0]])), Vec3(*jnp.array([[0.48], [0.36], [-0.8]])))


@pytest.mark.parametrize("name", MODELS)
def test_a_corridor_of_mirrors_has_the_partial_sums_and_the_limit_of_the_table(name):
    traced = trace(corridor(MODELS[name]), oblique(), 220, account=False, terms=True)  # 0.72^110 = 2e-16
    partial = np.cumsum((traced.terms.weight * traced.terms.local * traced.terms.color)[0, :, 0])
    for row in CORRIDOR:
        n = int(min(row["N"], 220))
        np.testing.assert_allclose(partial[n], row[name], rtol=1e-13)
    np.testing.assert_allclose(traced.radiance[0, 0], CORRIDOR[-1][name], rtol=1e-13)


@pytest.mark.parametrize(("name", "expected"), [("convex", 0.455145056256), ("additive", 2.73680702976)])
def test_after_ten_bounces_a_corridor_has_the_sum_of_eleven_terms_and_knows_what_is_left(name, expected):
    alpha, color = np.tile([0.9, 0.8], 6)[:11], np.tile([0.3, 0.7], 6)[:11]
    local = 1 - alpha if name == "convex" else np.ones(11)
    weight = np.concatenate([[1.0], np.cumprod(alpha)])
    traced = trace(corridor(MODELS[name]), oblique(), 10)
    np.testing.assert_allclose(traced.radiance[0, 0], expected, rtol=1e-14)
    np.testing.assert_allclose(traced.radiance[0, 0], np.sum(weight[:11] * local * color), rtol=1e-14)
    budget = jax.tree.map(lambda x: x[0, 0], traced.account.budget)
    np.testing.assert_allclose(budget.shaded, np.sum(weight[:11] * local), rtol=1e-14)
    np.testing.assert_allclose(budget.truncated, weight[11], rtol=1e-14)
    if name == "convex":
        np.testing.assert_allclose(budget.total, 1, rtol=1e-14)
    else:
        assert budget.total > 4  # coefficients that nothing bounds make light


def test_the_slopes_of_a_long_corridor_in_its_reflectivities_are_those_of_the_table():
    ray = jax.tree.map(lambda x: x[0], oblique())
    slopes = jax.grad(lambda alpha: radiance(corridor(Blend, alpha[0], alpha[1]), ray, 260)[0])(jnp.array([0.9, 0.8]))
    expected = [float(BLOCKS["H.corridor"][f"dconvex_dalpha_{which}"]) for which in "ab"]
    np.testing.assert_allclose(slopes, expected, rtol=1e-11)


# --- three surfaces in a row ---

JHU = {name: float(text) for name, text in BLOCKS["H.jhu"]["values"].items()}


def three(local, k, model=Whitted):
    """Down to the first, to the right to the second, up to the third."""
    tilted = Vec3(1.0, 0.0, 1.0), Vec3(-1.0, 0.0, 1.0), Vec3(0.0, 0.0, -1.0)
    places = ORIGIN, Vec3(3.0, 0.0, 0.0), Vec3(0.0, 0.0, 2.0)
    planes = zip(("first", "second", "third"), places, tilted, strict=True)
    surfaces = (model(lamp(local[i]), k[i]) for i in range(3))
    objects = {
        name: Object(Plane(place, n), surface) for (name, place, n), surface in zip(planes, surfaces, strict=True)
    }
    camera = Pinhole(Vec3(0.0, 0.0, 1.0), ORIGIN, Vec3(0.0, 1.0, 0.0), 0.01)
    return render(Scene(objects, background=9.0), camera, 1, 1, 2)


LOCAL, K = jnp.array([0.6, 0.3, 0.8]), jnp.array([0.5, 0.2, 0.0])


def test_a_picture_of_three_surfaces_in_a_row_has_the_value_and_the_gradients_of_the_document():
    value, (d_local, d_k) = jax.value_and_grad(lambda *args: three(*args).radiance[0, 0, 0], (0, 1))(LOCAL, K)
    np.testing.assert_allclose(value, JHU["additive"], rtol=1e-14)
    np.testing.assert_allclose(d_k[:2], [JHU["dI_dkr1"], JHU["dI_dkr2"]], rtol=1e-13)
    np.testing.assert_allclose(d_local, [JHU[f"dI_dIlocal{i}"] for i in (1, 2, 3)], rtol=1e-13)
    assert (JHU["additive"], JHU["dI_dkr1"], JHU["dI_dkr2"]) == (0.83, 0.46, 0.4)


def test_by_the_convex_rule_the_same_picture_is_darker_and_its_budget_is_one():
    image = three(LOCAL, K, Blend)
    np.testing.assert_allclose(image.radiance[0, 0, 0], JHU["convex"], rtol=1e-14)
    assert image.hits[0, 0] == 3
    for k in (K, jnp.array([0.5, 0.8, 0.3])):
        np.testing.assert_allclose(three(LOCAL, k, Blend).budget.total, 1, rtol=1e-15)
