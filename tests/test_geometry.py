"""Where rays hit spheres and planes, against 40 digits, and what keeps a ray from hitting the surface it leaves.

A surface of the test's own shows everything that it is told of a hit, one number per channel of the radiance.
"""

import dataclasses
import itertools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from tracer_scenes import DOWN, ORIGIN, UP, ball, lamp, plane, quick_jit, quick_trace, units, vec

from jaxrefl import Vec3
from jaxrefl.geometry import SKIP, Hit, Plane, Ray, Sphere, cosine, no_remedy, nudge, offset, refract, spawn, tolerance
from jaxrefl.light import PointLight
from jaxrefl.params import param, pytree
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Local, Weights
from jaxrefl.trace import trace
from jaxrefl.vec import normalize

pytestmark = pytest.mark.usefixtures("quick_compilation")
DTYPES = [np.float32, np.float64]
N = 4000  # rays of a batch: one size, one compilation
MANY = 20_000  # where a million are asked for


@pytree
class Probe:
    """Surface that shows its hits; ``outside`` and ``inside`` are what glass transmits to rays from there, 0 or 1."""

    outside: Any = param("[0, 1]", default=0.0)
    inside: Any = param("[0, 1]", default=0.0)
    eta: Any = param("(0, inf)", default=1.0)
    glass: bool = dataclasses.field(default=True, metadata={"static": True})

    def local(self, hit, wi):
        return Local(jnp.zeros(14, hit.t.dtype).at[13].set(self._scale(hit)), 0.0)

    def weights(self, hit):
        through, one = jnp.where(hit.entering, self.outside, self.inside), jnp.ones_like(hit.t)
        seen = (hit.t, *jax.tree.leaves((hit.p, hit.n, hit.tangent)), *hit.uv, hit.entering * one, 0 * one)
        shown = Weights(reflected=1.0, emitted=jnp.stack(seen) * self._scale(hit))
        return shown._replace(reflected=1 - through, transmitted=through, eta=self.eta) if self.glass else shown

    def _scale(self, hit):
        return jnp.where(hit.entering, 1.0, self.eta * self.eta)  # the tracer divides by n^2 inside


MIRROR = Probe(glass=False)


class Seen(NamedTuple):
    """Hits that a picture of probes shows; where nothing was hit, t is 0."""

    t: np.ndarray
    p: np.ndarray
    n: np.ndarray
    tangent: np.ndarray
    uv: np.ndarray
    entering: np.ndarray
    lit: np.ndarray


def read(shown) -> Seen:
    t, *v, entering, lit = np.moveaxis(np.asarray(shown, np.float64), -1, 0)
    p, n, tangent = (np.stack(v[i : i + 3], axis=-1) for i in (0, 3, 6))
    return Seen(t, p, n, tangent, np.stack(v[9:11], axis=-1), entering == 1, lit == 1)


def hits(shape, ray, probe=None, light=ORIGIN, remedy=SKIP) -> list[Seen]:
    """Up to four hits of the path of each ray with one primitive; the batch is filled up to a common size."""
    n, dtype = ray.origin.x.size, ray.origin.x.dtype
    probe = probe or (Probe() if isinstance(shape, Sphere) else MIRROR)
    size = max(n, N)
    ray = jax.tree.map(lambda x: jnp.broadcast_to(x, (size,)) if n == 1 else jnp.resize(x, (size,)), ray)
    shape, probe, light = arrays((shape, probe, PointLight(light, ambient=0.0)), dtype)
    scene = Scene({"one": Object(shape, probe)}, {"lamp": light})
    terms = quick_trace(scene, ray, 3, max_nodes=4, min_weight=1e-9, remedy=remedy, account=False, terms=True).terms
    assert terms.color.dtype == dtype
    return [read(jnp.where(terms.weight[:n, i] > 0, terms.color[:n, i], 0.0)) for i in range(4)]


def arrays(tree, dtype):
    return jax.tree.map(lambda x: jnp.asarray(x, dtype), tree)


def array(v) -> np.ndarray:
    return np.stack([np.asarray(x, np.float64) for x in (v.x, v.y, v.z)], axis=-1)


def toward_sphere(rng, far, offsets, dtype, away=0.0):
    """Rays from ``far`` radii that pass the centre ``away`` of a unit sphere at given offsets, rounded to a dtype."""
    d = units(rng, len(offsets))
    side = np.cross(d, units(rng, len(offsets)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    d = d.astype(dtype)
    return Ray(vec((away + side * offsets[:, None] - far * d).astype(dtype)), vec(d))


def exact_roots(o, d, c, r):
    """Distances at which |o + t d - c| = r, with 40 digits, of numbers that are taken as they are."""
    with mpmath.workdps(40):
        o, d, c = ([mpmath.mpf(float(x)) for x in v] for v in (o, d, c))
        oc = [a - b for a, b in zip(o, c, strict=True)]
        a, b, q = (mpmath.fdot(x, y) for x, y in ((d, d), (oc, d), (oc, oc)))
        disc = b * b - a * (q - mpmath.mpf(float(r)) ** 2)
        return [(-b - mpmath.sqrt(disc)) / a, (-b + mpmath.sqrt(disc)) / a]


# ---------------------------------------------------------------- spheres


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("far", [1.5, 1e2, 1e4])
def test_distance_point_and_normal_of_a_sphere_are_those_of_forty_digits(far, dtype):
    rng, n = np.random.default_rng(0), 60
    eps, center = float(jnp.finfo(dtype).eps), np.array([0.25, -0.5, 0.75], dtype)
    ray = toward_sphere(rng, far, rng.uniform(0, 0.9, n), dtype, center.astype(float))
    hit = hits(Sphere(vec(center), dtype(1)), ray)[0]
    assert hit.entering.all()
    for i, (o, d) in enumerate(zip(array(ray.origin), array(ray.direction), strict=True)):
        near = exact_roots(o, d, center, 1)[0]
        normal = np.array([float(a + near * b) for a, b in zip(o, d, strict=True)]) - center
        assert abs(hit.t[i] - float(near)) < 8 * eps * far
        np.testing.assert_allclose(hit.n[i], normal, atol=8 * eps * far)
        np.testing.assert_allclose(hit.p[i], normal + center, atol=8 * eps * far)


def test_no_sure_hit_is_lost_where_the_textbook_form_loses_a_quarter():
    rng, far = np.random.default_rng(1), 1e4
    ray = toward_sphere(rng, far, np.sqrt(rng.uniform(0, 0.81, N)), np.float32)
    o, d = (np.stack([np.asarray(x) for x in (v.x, v.y, v.z)]) for v in ray)
    b, q = (o * d).sum(0), (o * o).sum(0)
    assert q.dtype == np.float32
    assert 0.15 < (b * b - (q - np.float32(1)) <= 0).mean() < 0.85
    assert (hits(Sphere(ORIGIN, 1.0), ray)[0].t > 0).all()


def test_a_sphere_is_hit_within_its_radius_and_missed_beyond():
    rng = np.random.default_rng(2)
    for within, margin in itertools.product((True, False), (1e-12, 1e-6)):
        offsets = np.full(60, 1 - margin if within else 1 + margin)
        hit = hits(Sphere(ORIGIN, 1.0), toward_sphere(rng, 3.0, offsets, np.float64))[0]
        assert ((hit.t > 0) == within).all()


def test_from_inside_the_far_root_is_hit_and_the_ray_is_leaving():
    rng, n = np.random.default_rng(3), 60
    origin, d = 0.999 * rng.uniform(0, 1, (n, 1)) ** (1 / 3) * units(rng, n), units(rng, n)
    hit = hits(Sphere(ORIGIN, 1.0), Ray(vec(origin), vec(d)))[0]
    assert not hit.entering.any()
    expected = [float(exact_roots(o, v, (0, 0, 0), 1)[1]) for o, v in zip(origin, d, strict=True)]
    np.testing.assert_allclose(hit.t, expected, rtol=1e-13)
    np.testing.assert_allclose(hit.n, -(origin + d * np.array(expected)[:, None]), atol=1e-14)  # to the viewer


def test_a_sphere_behind_the_ray_is_not_hit():
    rng = np.random.default_rng(4)
    ray = toward_sphere(rng, 2.0, rng.uniform(0, 0.99, 60), np.float64)
    assert (hits(Sphere(ORIGIN, 1.0), Ray(ray.origin, -ray.direction))[0].t == 0).all()


def test_a_root_nearer_than_the_tolerance_gives_way_to_the_far_one():
    ray = Ray(vec([[0.0, 0.0, 3.0]]), vec([[0.0, 0.0, -1.0]]))
    for t_min, t, entering in [(0.0, 2, True), (2.5, 4, False), (3.5, 4, False), (4.5, 0, False)]:
        hit = hits(Sphere(ORIGIN, 1.0), ray, remedy=tolerance(t_min))[0]
        assert (hit.t[0], hit.entering[0]) == (t, entering)


def test_what_the_search_compares_by_squares_is_what_the_roots_say():
    """Spheres before, around and behind the ray; a shadow ray that ends in one, passes it or stays inside."""
    rng, n = np.random.default_rng(6), 400
    ray = toward_sphere(rng, 1.0, rng.uniform(0, 1.3, n), np.float64)
    ray = Ray(ray.origin + ray.direction * rng.uniform(-3, 3, n), ray.direction)
    ball, kinds = Sphere(ORIGIN, 1.0), set()
    for t_min, length in itertools.product((0.0, 0.7, 2.5), (0.4, 1.5, 4.0, np.inf)):
        found = jax.jit(jax.vmap(lambda ray, t_min=t_min: ball.roots(ray, t_min)))(ray)
        distance = np.full(n, t_min + length)
        blocked = jax.jit(jax.vmap(lambda ray, d, t_min=t_min: ball.blocks(ray, t_min, d)))(ray, distance)
        for i, (o, d) in enumerate(zip(array(ray.origin), array(ray.direction), strict=True)):
            b, q = float(np.dot(o, d)), float(np.dot(o, o))
            roots = np.sort(np.roots([1.0, 2 * b, q - 1]).real) if b * b - q + 1 > 0 else np.array([])
            after = roots[roots > t_min]
            assert found.t[i] == (pytest.approx(after[0], abs=1e-7) if after.size else np.inf)
            assert not after.size or found.far[i] == (after.size == 1)
            assert blocked[i] == bool((after < distance[i]).any())
            kinds.add((roots.size, after.size, bool(blocked[i])))
    assert kinds == {(0, 0, False), *((2, m, blocked) for m in (1, 2) for blocked in (False, True)), (2, 0, False)}


# ---------------------------------------------------------------- planes


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_plane_is_hit_from_both_sides_where_forty_digits_say(dtype):
    rng, n, eps = np.random.default_rng(5), 60, float(jnp.finfo(dtype).eps)
    normal, point = np.array([0.5, -2.0, 1.0], dtype), np.array([1.0, 2.0, -1.0], dtype)
    aim = point + np.cross(normal, rng.normal(size=(n, 3)))
    eye = (aim + np.where(rng.random((n, 1)) < 0.5, -1, 1) * (normal + rng.uniform(-1, 1, (n, 3)))).astype(dtype)
    ray = Ray(vec(eye), jax.jit(normalize)(vec((aim - eye).astype(dtype))))
    hit, height = hits(Plane(vec(point), vec(normal)), ray)[0], np.zeros(n)
    for i, (o, d) in enumerate(zip(array(ray.origin), array(ray.direction), strict=True)):
        with mpmath.workdps(40):
            height[i] = mpmath.fdot(o - point, normal)
            t = float(-mpmath.fdot(o - point, normal) / mpmath.fdot(d, normal))
        assert abs(hit.t[i] - t) < 60 * eps
        np.testing.assert_allclose(hit.p[i], o + t * d, atol=60 * eps)
    unit = normal.astype(float) / np.linalg.norm(normal.astype(float))
    np.testing.assert_array_equal(hit.entering, height > 0)
    np.testing.assert_allclose(hit.n, np.sign(height)[:, None] * unit, atol=2 * eps)
    assert (np.abs((hit.p - point) @ unit) < 4 * eps * np.abs(hit.p).max()).all()  # put back on it


def test_a_plane_that_is_parallel_or_behind_is_not_hit():
    eye = vec([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    d = vec([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.6, 0.0, -0.8], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])
    np.testing.assert_array_equal(hits(Plane(ORIGIN, UP), Ray(eye, d))[0].t, [0, 0, 0, 0, 1.25])


def test_the_length_of_a_normal_does_not_matter():
    ray = Ray(vec([[0.3, 0.2, 5.0]]), vec([[0.0, 0.0, -1.0]]))
    for scale in (1e-6, 1e6):
        hit = hits(Plane(ORIGIN, UP * scale), ray)[0]
        np.testing.assert_allclose(hit.t, 5, rtol=1e-15)
        np.testing.assert_allclose(hit.n, [[0, 0, 1]], atol=1e-15)


# ---------------------------------------------------------------- rays that start on a surface


def chord_error(t, offsets, eta):
    """Error of t^2, for the chord of a unit sphere that a ray with an impact parameter is refracted into."""
    return np.abs(t**2 - 4 * (1 - (offsets / eta) ** 2))


def off(hit, center):
    return np.abs(np.linalg.norm(hit.p - center.astype(float), axis=1) - 1)


LEVELS = {np.float32: (1.5, 1e1, 1e2, 1e3, 1e4, 1e5), np.float64: (1.5, 1e2, 1e4, 1e6, 1e8)}


def from_afar(dtype, far):
    """A unit sphere, rays toward it, half of them grazing, and their offsets; far is the eye, or both of them are."""
    rng = np.random.default_rng(7)
    offsets = np.where(rng.random(MANY) < 0.5, np.sqrt(rng.random(MANY)), 1 - 10 ** rng.uniform(-7, 0, MANY))
    for away in (np.zeros(3), far * np.array([0.6, -0.48, 0.64])):
        center = away.astype(dtype)
        yield Sphere(vec(center), dtype(1)), center, toward_sphere(rng, far, offsets, dtype, away), offsets


@pytest.mark.parametrize("dtype", DTYPES)
def test_no_ray_of_a_million_hits_again_the_sphere_that_it_leaves(dtype):
    eps, rays = np.finfo(dtype).eps, 0
    for far in LEVELS[dtype]:
        error = 4 * eps * far
        for sphere, center, ray, offsets in from_afar(dtype, far):
            light, sure = (center + np.array([0, 0, 3])).astype(dtype), offsets < 1 - error
            first, escaped, *_ = hits(sphere, ray, Probe(), vec(light))
            assert (first.t > 0)[sure].all()
            assert first.entering[sure].all()
            assert off(first, center)[sure].max() <= max(error, 4 * eps)
            assert (escaped.t == 0)[sure].all()
            cos_light = ((light - first.p) * first.n).sum(1)
            assert (first.lit == (cos_light > 0))[sure & (np.abs(cos_light) > error)].all()  # it does not shade itself
            rays += 2 * sure.sum()
            for eta in (1.5, 1 / 1.5):
                _, *inside = hits(sphere, ray, Probe(1.0, 0.0, eta))
                _, leaving, gone, _ = hits(sphere, ray, Probe(1.0, 1.0, eta))
                entered = (inside[0].t > 0) & sure
                assert (entered == (offsets < eta))[sure & (np.abs(offsets - eta) > error)].all()
                for hit in (*inside, leaving):
                    assert (hit.t > 0)[entered].all()
                    assert not hit.entering[entered].any()
                    assert off(hit, center)[entered].max() <= max(error, 4 * eps)
                    assert chord_error(hit.t, offsets, eta)[entered].max() < 64 * eps * far
                assert not (gone.entering & (gone.t > 0))[entered].any()  # what was totally reflected is still inside
                rays += 4 * entered.sum()
    assert rays > 1e6


@pytest.mark.parametrize("dtype", DTYPES)
def test_nor_does_a_ray_that_grazes_it_within_the_rounding(dtype):
    again = 0
    for far in LEVELS[dtype]:
        for sphere, _, ray, _ in from_afar(dtype, far):
            first, escaped, *_ = hits(sphere, ray, Probe())
            again += int(((first.t > 0) & (~first.entering | (escaped.t > 0))).sum())
    assert again == 0


@pytest.mark.parametrize(("dtype", "far"), [(np.float32, 1e7), (np.float64, 1e15)])
def test_beyond_its_range_a_sphere_is_still_finite(dtype, far):
    for sphere, _, ray, _ in from_afar(dtype, far):
        for probe in (Probe(0.0, 0.0, 1.5), Probe(1.0, 0.0, 1.5), Probe(1.0, 1.0, 1 / 1.5)):
            assert all(np.isfinite(x).all() for x in jax.tree.leaves(hits(sphere, ray, probe)))


def test_the_remedies_move_the_origin_as_they_say():
    up, down, one = Vec3(0.6, 0.0, 0.8), Vec3(0.6, 0.0, -0.8), jnp.asarray(1.0)
    hit = Hit(Vec3(0.3, 0.0, 0.0), UP, Vec3(1.0, 0.0, 0.0), UP, one, (one, one), one > 0)
    for direction, side in [(up, 1), (down, -1)]:
        for remedy, moved in [
            (SKIP, [0, 0, 0]),
            (no_remedy(), [0, 0, 0]),
            (tolerance(0.1), [0, 0, 0]),
            (nudge(0.1), [0.06, 0, side * 0.08]),
            (offset(0.1), [0, 0, side * 0.1]),
        ]:
            new = spawn(hit, direction, remedy)
            np.testing.assert_allclose(array(new.origin), np.array([0.3, 0, 0]) + moved, atol=1e-16)
            np.testing.assert_array_equal(array(new.direction), array(direction))
    assert [bool(r.skip) for r in (SKIP, no_remedy(), tolerance(1), nudge(1), offset(1))] == [True] + 4 * [False]


def test_each_remedy_of_the_lecture_stops_the_acne_that_no_remedy_shows():
    rng, e = np.random.default_rng(8), 1e-4
    offsets, center = rng.uniform(0, 0.9, N), np.array([0.3, 0.2, -0.1])
    ray = toward_sphere(rng, 3.0, offsets, np.float32, center)
    sphere, floor = Sphere(vec(center), 1.0), Plane(vec(center), Vec3(1.0, 0.3, 0.2))
    cos_theta = np.abs(array(ray.direction) @ [1.0, 0.3, 0.2]) / np.sqrt(1.13)
    for remedy in (no_remedy(), tolerance(e), nudge(e), offset(e)):
        wrong = [(hits(sphere, ray, Probe(), remedy=remedy)[1].t > 0).mean()]
        again = hits(floor, ray, remedy=remedy)[1].t > 0
        wrong.append((again & (cos_theta > 0.05)).mean())  # at grazing a remedy needs a larger epsilon
        inside = hits(sphere, ray, Probe(1.0, 0.0, 1.5), remedy=remedy)[1]
        wrong.append((chord_error(inside.t, offsets, 1.5) > 20 * e).mean())
        assert min(wrong) > 0.02 if remedy == no_remedy() else wrong == [0, 0, 0]


# ---------------------------------------------------------------- ties


def test_of_equal_distances_the_lower_number_wins_whatever_the_shape_and_whoever_came_first_into_the_dict():
    """The balls touch the planes from below: all of a; b, b; c; d, in the order of the alphabet, are met at t = 5."""
    straight = Ray(vec([[0.0, 0.0, 5.0]]), vec([[0.0, 0.0, -1.0]]))
    for gone in range(5):  # so many of the first ones lie deeper
        z = np.where(np.arange(5) < gone, -50.0, 0.0)
        made = {
            "d": ball(lamp(0.5), 1.0, Vec3(0.0, 0.0, z[4] - 1)),
            "b": ball(lamp(np.array([[0.2], [0.3]])), 1.0, np.array([[0.0, 0.0, z[1] - 1], [0.0, 0.0, z[2] - 1]])),
            "c": plane(lamp(0.4), Vec3(0.0, 0.0, z[3])),
            "a": plane(lamp(0.1), Vec3(0.0, 0.0, z[0])),
        }
        for names in ("dbca", "abcd"):
            out = quick_trace(Scene({name: made[name] for name in names}), straight, 0, account=False)
            assert out.primitive.tolist() == [gone]
            assert float(out.radiance[0, 0]) == [0.1, 0.2, 0.3, 0.4, 0.5][gone]
            assert float(out.depth[0]) == 5


# ---------------------------------------------------------------- refraction


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("eta", [1.5, 2.4, 1 / 1.33, 0.5])
def test_refraction_obeys_the_law_of_snell_in_the_plane_of_incidence(eta, dtype):
    rng, n, eps = np.random.default_rng(9), 400, float(jnp.finfo(dtype).eps)
    normal, side = units(rng, n), units(rng, n)
    wo = normal * rng.uniform(0.05, 1, (n, 1)) + np.cross(normal, side)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    d, total = jax.jit(refract)(vec(wo.astype(dtype)), vec(normal.astype(dtype)), dtype(eta))
    sin_i, d = np.linalg.norm(np.cross(normal, wo), axis=1), array(d)
    sure = np.abs(sin_i / eta - 1) > 1e-3
    np.testing.assert_array_equal(np.asarray(total)[sure], (sin_i > eta)[sure])
    ok = sure & ~np.asarray(total)
    tolerance = 200 * eps  # sin theta_t at the critical angle has an infinite slope
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=4 * eps)
    np.testing.assert_allclose(np.linalg.norm(np.cross(normal, d), axis=1)[ok], (sin_i / eta)[ok], atol=tolerance)
    np.testing.assert_allclose(np.einsum("ij,ij->i", d, np.cross(normal, wo))[ok], 0, atol=tolerance)
    assert (np.einsum("ij,ij->i", d, normal)[ok] < 0).all()
    assert (np.einsum("ij,ij->i", d, wo)[ok] < 0).all()


def test_refraction_back_along_the_refracted_ray_returns_the_incident_one():
    wo = normalize(Vec3(0.6, -0.3, 0.5))
    inside, _ = refract(wo, UP, 1.5)
    back, total = refract(inside, DOWN, 1 / 1.5)
    assert not total
    np.testing.assert_allclose(array(back), array(wo), rtol=1e-14)
    np.testing.assert_allclose(array(refract(UP, UP, 1.5)[0]), [0, 0, -1], atol=1e-16)
    np.testing.assert_allclose(array(refract(wo, UP, 1.0)[0]), -array(wo), rtol=1e-14)


def test_total_reflection_begins_at_the_critical_angle_and_returns_the_tangent():
    critical = np.arcsin(1 / 1.5)
    for angle, expected in [(critical - 1e-9, False), (critical + 1e-9, True), (1.5, True)]:
        wo = Vec3(np.sin(angle), 0.0, np.cos(angle))
        d, total = refract(wo, UP, 1 / 1.5)
        assert bool(total) == expected
        if expected:
            np.testing.assert_allclose(array(d), [-1, 0, 0], atol=1e-12)


def test_the_derivative_of_a_refracted_direction_is_that_of_snells_law_and_finite_at_the_critical_angle():
    def sin_t(theta, eta):
        return -refract(Vec3(jnp.sin(theta), 0.0, jnp.cos(theta)), UP, eta)[0].x

    both = jax.vmap(jax.grad(sin_t, (0, 1)))
    theta, eta = jnp.array([0.0, 0.3, 1.2, 0.5]), jnp.array([1.5, 1.5, 2.4, 0.6])
    by_theta, by_eta = both(theta, eta)
    np.testing.assert_allclose(by_theta, np.cos(theta) / eta, rtol=1e-12)
    np.testing.assert_allclose(by_eta, -np.sin(theta) / eta**2, rtol=1e-12, atol=1e-16)
    edge = both(jnp.array([np.arcsin(0.5), np.arcsin(0.5) + 1e-15, np.pi / 2, 1.2]), jnp.array([0.5, 0.5, 1.0, 0.5]))
    assert all(jnp.isfinite(x).all() for x in edge)


# ---------------------------------------------------------------- coordinates


def test_the_coordinates_of_a_sphere_are_azimuth_and_polar_angle_in_turns_and_half_turns():
    theta, phi = (x.ravel() for x in np.meshgrid(np.linspace(0.1, 3.0, 6), np.linspace(0.05, 6.2, 10)))
    n = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    center, radius = np.array([1.0, -2.0, 0.5]), 2.5
    hit = hits(Sphere(vec(center), radius), Ray(vec(center + 3 * radius * n), vec(-n)))[0]
    np.testing.assert_allclose(hit.uv, np.stack([phi / (2 * np.pi), theta / np.pi], axis=-1), atol=1e-14)
    np.testing.assert_allclose(hit.tangent, np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=-1), atol=1e-13)


def test_at_the_poles_a_sphere_has_the_coordinates_of_azimuth_zero():
    d = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    hit = hits(Sphere(ORIGIN, 1.0), Ray(vec(-3 * d), vec(d)))[0]
    np.testing.assert_array_equal(hit.uv, [[0, 0], [0, 1]])
    np.testing.assert_array_equal(hit.tangent, [[0, 1, 0]] * 2)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (-0.96, 0.2, 0.1), (1.0, 2.0, -3.0)])
def test_the_coordinates_of_a_plane_are_lengths_along_two_perpendicular_tangents(normal):
    rng, base = np.random.default_rng(10), np.array([0.5, 1.0, -2.0])
    unit = np.array(normal) / np.linalg.norm(normal)
    aim = base + np.cross(unit, rng.normal(size=(30, 3)))
    aim[0] = base
    hit = hits(Plane(vec(base), vec(np.array(normal))), Ray(vec(aim + 2 * unit), vec(np.tile(-unit, (30, 1)))))[0]
    tangent = hit.tangent[0]
    assert np.ptp(hit.tangent, axis=0).max() < 1e-15
    np.testing.assert_allclose([tangent @ unit, np.linalg.norm(tangent)], [0, 1], atol=1e-15)
    np.testing.assert_allclose(hit.uv @ np.stack([tangent, np.cross(unit, tangent)]), aim - base, atol=1e-13)
    np.testing.assert_allclose(hit.uv[0], 0, atol=1e-14)


def test_a_horizontal_plane_measures_u_along_x_and_v_along_y():
    hit = hits(Plane(ORIGIN, UP), Ray(vec([[0.3, -0.7, 2.0]]), vec([[0.0, 0.0, -1.0]])))[0]
    np.testing.assert_allclose(hit.uv[0], [0.3, -0.7], atol=1e-15)


def test_the_cosine_of_unit_vectors_stays_between_zero_and_one_with_the_slope_of_the_inside():
    for x, value, slope in [(1 + 1e-12, 1, 1), (-0.5, 0, 0), (0.25, 0.25, 1)]:
        got = jax.value_and_grad(lambda x: cosine(Vec3(x, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)))(x)
        assert got == (value, slope)


# ---------------------------------------------------------------- derivatives


@quick_jit
def slopes(shape, probe, ray, along):
    """Numbers of a path of two hits, their derivatives along one direction, and backwards of one weighted sum."""

    def shown(shape, ray):
        return trace(Scene({"one": Object(shape, probe)}), ray, 1, account=False).radiance

    value, forward = jax.jvp(shown, (shape, ray), along)
    weights = jnp.linspace(1, 2, value.size, dtype=value.dtype).reshape(value.shape)
    return value, forward, jax.grad(lambda *x: jnp.vdot(shown(*x), weights), (0, 1))(shape, ray)


def test_the_derivatives_of_a_distance_are_those_of_the_implicit_function():
    """d t = n . (d c - d o - t d d) / (n . d), and for a sphere + d r / (n . d)."""
    rng, n = np.random.default_rng(11), 64
    ray, mirror = toward_sphere(rng, 3.0, rng.uniform(0, 0.9, n), np.float64), arrays(MIRROR, float)
    zero = jax.tree.map(jnp.zeros_like, ray)
    by_origin = [zero._replace(origin=Vec3(*(jnp.full(n, i == j, float) for j in range(3)))) for i in range(3)]
    for shape in (Sphere(ORIGIN, 1.0), Plane(Vec3(0.1, 0.0, 0.2), Vec3(0.2, 0.1, 1.0))):
        shape = arrays(shape, float)
        still = jax.tree.map(jnp.zeros_like, shape)
        seen = read(slopes(shape, mirror, ray, (still, zero))[0])
        hit = seen.t > 0
        slope = np.where(hit, (seen.n * array(ray.direction)).sum(1), 1)
        assert hit.sum() > 20

        def derivative(shape_along, ray_along, shape=shape, hit=hit):
            return np.asarray(slopes(shape, mirror, ray, (shape_along, ray_along))[1])[hit, 0]

        name = "center" if isinstance(shape, Sphere) else "point_on"
        for i in range(3):
            moved = dataclasses.replace(still, **{name: vec(np.eye(3)[i])})
            expected = (seen.n[:, i] / slope)[hit]
            np.testing.assert_allclose(derivative(moved, zero), expected, rtol=1e-11, atol=1e-12)
            np.testing.assert_allclose(derivative(still, by_origin[i]), -expected, rtol=1e-11, atol=1e-12)
            # a unit direction moves across itself
            across = np.eye(3)[i] - array(ray.direction) * array(ray.direction)[:, i, None]
            turned = (-(across * seen.n).sum(1) * seen.t / slope)[hit]
            got = derivative(still, zero._replace(direction=vec(across)))
            np.testing.assert_allclose(got, turned, rtol=1e-10, atol=1e-11)
        if isinstance(shape, Sphere):
            grown = derivative(dataclasses.replace(still, radius=jnp.asarray(1.0, float)), zero)
            np.testing.assert_allclose(grown, (1 / slope)[hit], rtol=1e-11)


EDGES = [(Sphere(ORIGIN, 1.0), np.float32), (Sphere(ORIGIN, 1.0), np.float64), (Plane(ORIGIN, UP), np.float64)]


@pytest.mark.nan_debug
@pytest.mark.parametrize(("shape", "dtype"), EDGES)
def test_every_derivative_of_a_path_is_finite_at_every_edge(shape, dtype):
    eps = float(jnp.finfo(dtype).eps)
    cases = [  # origin, direction
        ([0, 0, 3], [0, 0, -1]),  # the pole, head on, and a diameter; perpendicular to the plane
        ([0, 0, -3], [0, 0, 1]),  # the other pole
        ([1, 0, 3], [0, 0, -1]),  # tangent
        ([1 - eps, 0, 3], [0, 0, -1]),  # grazing
        ([1 + eps, 0, 3], [0, 0, -1]),
        ([2, 0, 3], [0, 0, -1]),  # a miss of the sphere
        ([3, 0, 0], [-1, 0, 0]),  # the equator, the seam, and in the plane
        ([3, 0, 0.5], [-1, 0, 0]),  # parallel to the plane
        ([3, 0, 0.5], [-1, 0, -eps]),
        ([0, 0, 0], [0, 0.6, 0.8]),  # from the centre, and back
        ([0, 0, 1], [0, 0, -1]),  # from the surface
        ([0, 0, 1], [1, 0, 0]),  # along the tangent
    ]
    cases = [cases[i % len(cases)] for i in range(64)]
    ray = Ray(*(vec(np.array(x, dtype)) for x in zip(*cases, strict=True)))
    shape, probe = arrays((shape, MIRROR), dtype)
    along = jax.tree.map(jnp.ones_like, (shape, ray))
    assert all(jnp.isfinite(x).all() for x in jax.tree.leaves(slopes(shape, probe, ray, along)))
