r"""Rays, spheres and planes: where a ray hits, in forms that do not cancel, and what keeps it from hitting twice.

A shape is one primitive; every method is written for ONE ray and ONE primitive. It offers

    roots(ray, own, inside, t_min)   the nearest acceptable distance, inf for none, and which root it is: the search
    point(ray, own, far)             the same distance again with the point and its normal, differentiable
    legal_ray()                      a ray that hits it head on, put in the place of one that misses

The search runs over numbers without derivatives and is carried, never decided twice; value and gradient of the hit
come from `point` alone. For a sphere of centre c the foot of the perpendicular l = oc - (oc . d) d decides, with
r^2 - |l|^2 in place of the textbook discriminant, and the point is c + r n with a unit n: it lies on the sphere to
rounding, however far the ray came from.
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array
from jaxtyping import Bool, Float

from .params import param
from .safe import safe_divide, safe_sqrt
from .vec import Vec3, cross, dot, normalize, where

Scalar = Float[Array, ""]
Flag = Bool[Array, ""]


class Ray(NamedTuple):
    """Half line o + t d, t > 0."""

    origin: Vec3
    """o."""
    direction: Vec3
    """d, unit length; not checked."""

    def at(self, t: Any) -> Vec3:
        """Point at distance t."""
        return self.origin + self.direction * t


class Root(NamedTuple):
    """Answer of a search: the distance, inf for none, and whether it is the far root of a sphere."""

    t: Array
    far: Array


class Point(NamedTuple):
    """Where a ray meets a primitive."""

    t: Array
    """() distance along the ray."""
    p: Vec3
    """Point, on the primitive to rounding."""
    n: Vec3
    """Unit normal to the outside of the primitive."""
    tangent: Vec3
    """Unit tangent, along increasing u."""
    uv: tuple[Array, Array]
    """Surface coordinates: of a sphere azimuth / 2 pi and polar angle / pi, both in [0, 1]; of a plane lengths."""


class Hit(NamedTuple):
    """What a surface is told of a hit: everything is finite, and legal even where there was no hit."""

    p: Vec3
    """Point of the scene."""
    n: Vec3
    """Unit normal, on the side of ``wo``."""
    tangent: Vec3
    """Unit tangent, along increasing u."""
    wo: Vec3
    """Unit direction to the viewer."""
    t: Array
    """() distance that the ray came, (0, inf)."""
    uv: tuple[Array, Array]
    """Surface coordinates, see `Point`."""
    entering: Array
    """() bool: the ray came from the outside."""

    @property
    def cos_theta_o(self) -> Scalar:
        """Cosine of the angle between the normal and the viewer, [0, 1]."""
        return cosine(self.n, self.wo)


def cosine(a: Vec3, b: Vec3) -> Scalar:
    """Cosine between two unit vectors, held in [0, 1]; at either end the derivative is that of the inside."""
    c = dot(a, b)
    return jnp.where(c < 0, 0.0, jnp.where(c > 1, 1.0, c))


class Remedy(NamedTuple):
    """What keeps a ray from hitting the surface it starts on (JHU, "Floating Point Imprecision and Self Shadowing").

    Four numbers in the unit of the scene; all zero, and ``skip`` False, is no remedy at all: the picture shows acne.
    """

    t_min: Any = 0.0
    """Hits nearer than this are not believed: "t < EPSILON implies the ray is on the surface"."""
    along_ray: Any = 0.0
    """The origin is moved this far along the new ray: "nudge"."""
    along_normal: Any = 0.0
    """The origin is moved this far along the normal, to the side where the new ray goes."""
    skip: Any = True
    """The primitive just left is not tested; from inside a sphere its far root is taken (the document's third remedy
    leaves the object out altogether, which loses every ray that was refracted into it)."""


SKIP = Remedy()


def no_remedy() -> Remedy:
    """No remedy, to show what it is for."""
    return Remedy(skip=False)


def tolerance(epsilon: Any) -> Remedy:
    """Smallest distance that counts as a hit."""
    return Remedy(t_min=epsilon, skip=False)


def nudge(epsilon: Any) -> Remedy:
    """Origin moved along the new ray."""
    return Remedy(along_ray=epsilon, skip=False)


def offset(epsilon: Any) -> Remedy:
    """Origin moved along the normal."""
    return Remedy(along_normal=epsilon, skip=False)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Sphere:
    """Sphere, hit from the outside and from the inside; its polar axis is z."""

    center: Any = param("(-inf, inf)", vector=True, doc="centre")
    radius: Any = param("(0, inf)", default=1.0, doc="radius")

    def roots(self, ray: Ray, own: Flag, inside: Flag, t_min: Scalar) -> Root:
        """Nearest distance above t_min; of the sphere that the ray leaves (``own``), the chord if it runs inside."""
        b, foot = self._foot(ray)
        discriminant = self.radius**2 - dot(foot, foot)
        half_chord = jnp.sqrt(jnp.maximum(discriminant, 0.0))
        near, far = -b - half_chord, -b + half_chord
        first = near > t_min
        t = jnp.where(first, near, far)
        t = jnp.where((discriminant > 0) & (t > t_min), t, jnp.inf)
        chord = jnp.where(inside, 2 * jnp.abs(b), jnp.inf)
        return Root(jnp.where(own, chord, t), own | ~first)

    def point(self, ray: Ray, own: Flag, far: Flag) -> Point:
        """Point of the chosen root, with derivatives (at grazing, where the true one is infinite, finite)."""
        b, foot = self._foot(ray)
        half_chord = safe_sqrt(self.radius**2 - dot(foot, foot))
        half_chord = jnp.where(own, -b, half_chord)  # the chord of a ray that starts on the sphere: no root is taken
        along = jnp.where(far, half_chord, -half_chord)
        n = normalize(foot + ray.direction * along)
        return Point(along - b, self.center + n * self.radius, n, *_sphere_map(n))

    def legal_ray(self) -> Ray:
        """Ray that hits the sphere head on, from above the equator."""
        d = Vec3(*(jnp.full_like(self.radius, x) for x in (-0.6, 0.0, -0.8)))
        return Ray(self.center - d * (2 * self.radius), d)

    def _foot(self, ray: Ray) -> tuple[Scalar, Vec3]:
        """oc . d, and the foot of the perpendicular from the centre on the ray, seen from the centre."""
        oc = ray.origin - self.center
        b = dot(oc, ray.direction)
        foot = oc - ray.direction * b
        again = dot(foot, ray.direction)  # what rounding left of d in the foot
        return b + again, foot - ray.direction * again


def _sphere_map(n: Vec3) -> tuple[Vec3, tuple[Array, Array]]:
    """Tangent and surface coordinates; at the poles, where neither exists, those of azimuth 0."""
    rho2 = n.x * n.x + n.y * n.y
    pole = rho2 < 1e-12
    x, y = jnp.where(pole, 1.0, n.x), jnp.where(pole, 0.0, n.y)
    scale = 1 / jnp.sqrt(jnp.where(pole, 1.0, rho2))
    u = jnp.arctan2(y, x) / (2 * jnp.pi)
    v = jnp.arctan2(safe_sqrt(rho2), n.z) / jnp.pi
    return Vec3(-y * scale, x * scale, jnp.zeros_like(x)), (jnp.where(u < 0, u + 1, u), v)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Plane:
    """Infinite plane; the side of its normal is outside."""

    point_on: Any = param("(-inf, inf)", vector=True, doc="any point of the plane, where u = v = 0")
    normal: Any = param("(-inf, inf)", vector=True, doc="normal, of any length but 0")

    def roots(self, ray: Ray, own: Flag, inside: Flag, t_min: Scalar) -> Root:
        """Distance above t_min; a ray that leaves the plane (``own``) never meets it again."""
        height, slope = self._height(ray, self._unit())
        toward = height * slope < 0
        t = -height / jnp.where(toward, slope, 1.0)
        t = jnp.where(toward & (t > t_min) & ~own, t, jnp.inf)
        return Root(t, jnp.zeros_like(own))

    def point(self, ray: Ray, own: Flag, far: Flag) -> Point:
        """Point of the plane, put back on it after rounding."""
        n = self._unit()
        height, slope = self._height(ray, n)
        t = -safe_divide(height, slope)
        p = ray.at(t)
        p = p - n * dot(p - self.point_on, n)
        tangent = _any_tangent(n)
        away = p - self.point_on
        return Point(t, p, n, tangent, (dot(away, tangent), dot(away, cross(n, tangent))))

    def legal_ray(self) -> Ray:
        """Ray that falls on the plane obliquely from its outer side, one unit away."""
        n = self._unit()
        d = _any_tangent(n) * 0.6 - n * 0.8
        return Ray(self.point_on - d, d)

    def _unit(self) -> Vec3:
        return normalize(self.normal)

    def _height(self, ray: Ray, n: Vec3) -> tuple[Scalar, Scalar]:
        return dot(ray.origin - self.point_on, n), dot(ray.direction, n)


def _any_tangent(n: Vec3) -> Vec3:
    """Unit tangent: x projected on the plane, y where the normal is nearer to x than 18 degrees."""
    steep = jnp.abs(n.x) > 0.95
    axis = Vec3(*(jnp.where(steep, a, b).astype(n.x.dtype) for a, b in ((0.0, 1.0), (1.0, 0.0), (0.0, 0.0))))
    return normalize(axis - n * dot(axis, n))


def hit_of(ray: Ray, point: Point, far: Flag) -> Hit:
    """Hit of a ray at a point: the normal turned to the viewer."""
    entering = (dot(ray.direction, point.n) < 0) & ~far
    return Hit(point.p, where(entering, point.n, -point.n), point.tangent, -ray.direction, point.t, point.uv, entering)


def spawn(hit: Hit, direction: Vec3, remedy: Remedy) -> Ray:
    """Ray that starts at a hit, moved as the remedy has it."""
    side = jnp.where(dot(direction, hit.n) < 0, -1.0, 1.0).astype(hit.t.dtype)
    origin = hit.p + direction * remedy.along_ray + hit.n * (side * remedy.along_normal)
    return Ray(origin, direction)


def refract(wo: Vec3, n: Vec3, eta: Any) -> tuple[Vec3, Flag]:
    """Refracted direction, and whether there is none: total reflection, where the tangent direction is returned.

    Args:
        wo: unit direction against the ray, on the side of n.
        n: unit normal.
        eta: n_t / n_i, (0, inf).

    Differentiable where there is refraction; at the critical angle the infinite derivative is replaced by 0.
    """
    cos_i, inverse = dot(wo, n), 1 / eta
    sin2_t = inverse * inverse * (1 - cos_i) * (1 + cos_i)
    cos_t = safe_sqrt(1 - sin2_t)
    return normalize(n * (inverse * cos_i - cos_t) - wo * inverse), sin2_t > 1


__all__ = [
    "SKIP",
    "Hit",
    "Plane",
    "Point",
    "Ray",
    "Remedy",
    "Root",
    "Sphere",
    "cosine",
    "hit_of",
    "no_remedy",
    "nudge",
    "offset",
    "refract",
    "spawn",
    "tolerance",
]
