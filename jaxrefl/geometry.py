r"""Rays, spheres and planes: where a ray hits, in forms that do not cancel, and what keeps it from hitting twice.

A shape is one primitive; every method is written for ONE ray and ONE primitive. It offers

    roots(ray, t_min)             the nearest acceptable distance, inf for none, and which root it is: the search
    blocks(ray, t_min, distance)  whether it stands in between: the shadow
    point(ray, own, far, here)    the same distance again with the point and its normal, differentiable
    chord(n, direction)           how far it is through the inside, from a point of normal n: inf where there is none;
                                  the tracer asks along n and takes it times |n . d|, as it is for a sphere
    ball()                        center and radius of a ball around it, by which a search passes over it; may be absent

The search runs over numbers without derivatives and is carried, never decided twice; value and gradient of the hit
come from `point` alone, which gives a legal point also where the ray does not hit (``here`` False). For a sphere of
centre c the foot of the perpendicular l = oc - (oc . d) d decides, with r^2 - |l|^2 in place of the textbook
discriminant, and the point is c + r n with a unit n: it lies on the sphere to rounding, however far the ray came from.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array, lax
from jaxtyping import Bool, Float

from .params import param, pytree
from .safe import safe_sqrt
from .vec import Vec3, cross, dot, normalize

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
    entering: Array
    """() bool: the ray comes from the outside; of a sphere this is the near root, whatever rounding makes of n . d."""
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
    """() distance that the ray came, (0, inf); 0 to rounding where a ray may hit what it starts on."""
    uv: tuple[Array, Array]
    """Surface coordinates, see `Point`."""
    entering: Array
    """() bool: the ray came from the outside."""
    diameter: Any = jnp.inf
    """() longest way through the primitive, inf for a plane."""

    @property
    def cos_theta_o(self) -> Scalar:
        """Cosine of the angle between the normal and the viewer, [0, 1]."""
        return cosine(self.n, self.wo)


def cosine(a: Vec3, b: Vec3) -> Scalar:
    """Cosine between two unit vectors, held in [0, 1]; at and above 1 with its derivative, below 0 with none."""
    c = dot(a, b)
    c = c - lax.stop_gradient(jnp.where(c > 1, c - 1, 0.0))  # 1, still with its derivative
    return jnp.where(c < 0, 0.0, c)


class Remedy(NamedTuple):
    """What keeps a ray from hitting the surface it starts on (JHU, "Floating Point Imprecision and Self Shadowing").

    Lengths in the unit of the scene; all zero, and ``skip`` False, is no remedy at all: the picture shows acne.
    """

    t_min: Any = 0.0
    """Hits nearer than this are not believed: "t < EPSILON implies the ray is on the surface"."""
    along_ray: Any = 0.0
    """The origin is moved this far along the new ray: "nudge"."""
    along_normal: Any = 0.0
    """The origin is moved this far along the normal, to the side where the new ray goes."""
    skip: Any = True
    """The primitive just left is not tested; from inside a sphere its chord is taken, which needs no root (the
    document's third remedy leaves the object out altogether, which loses every ray that was refracted into it)."""


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


@pytree
class Sphere:
    """Sphere, hit from the outside and from the inside; its polar axis is z."""

    center: Any = param("(-inf, inf)", vector=True, doc="centre")
    radius: Any = param("(0, inf)", default=1.0, doc="radius")

    def roots(self, ray: Ray, t_min: Scalar) -> Root:
        """Nearest root -b -+ h above t_min; one that rounding cannot tell from t_min may come out as t_min.

        Which one is settled by squares: a square root with one user is computed in the same pass as the rest.
        """
        oc = ray.origin - self.center
        b = dot(oc, ray.direction)
        foot = oc - ray.direction * b
        h2 = self.radius * self.radius - dot(foot, foot)
        low = t_min + b
        toward, low2 = low < 0, low * low
        near = toward & (low2 > h2)
        t = jnp.where(near, -1.0, 1.0).astype(b.dtype) * jnp.sqrt(jnp.maximum(h2, 0.0)) - b
        return Root(jnp.where((h2 > 0) & (toward | (low2 < h2)), t, jnp.inf), ~near)

    def blocks(self, ray: Ray, t_min: Scalar, distance: Scalar) -> Flag:
        """Whether a root -b -+ h lies between t_min and a greater distance: whether of the way between them the nearest
        point to the center is inside, and the farthest is not. Compared by squares, without a square root."""
        oc = ray.origin - self.center
        b = dot(oc, ray.direction)
        foot = oc - ray.direction * b
        h2 = self.radius * self.radius - dot(foot, foot)
        low, high = t_min + b, distance + b
        nearest, farthest = jnp.maximum(low, jnp.minimum(high, 0.0)), jnp.maximum(-low, high)
        return (nearest * nearest < h2) & (farthest * farthest >= h2)

    def point(self, ray: Ray, own: Flag, far: Flag, here: Flag) -> Point:
        """Point of the chosen root, with derivatives (at grazing, where the true one is infinite, finite)."""
        oc = ray.origin - self.center
        b = dot(oc, ray.direction)
        foot = oc - ray.direction * b
        again = dot(foot, ray.direction)  # what rounding left of d in the foot
        b, foot = b + again, foot - ray.direction * again
        r2 = self.radius * self.radius
        half_chord = safe_sqrt(jnp.where(here, r2 - dot(foot, foot), r2))
        # a ray that starts on the sphere and runs inside: the chord, no root is taken
        along = jnp.where(own, -b, jnp.where(far, half_chord, -half_chord))
        n = normalize(foot + ray.direction * along)
        return Point(along - b, self.center + n * self.radius, n, ~far, *_sphere_map(n))

    def ball(self) -> tuple[Vec3, Scalar]:
        """Center and radius."""
        return self.center, self.radius

    def chord(self, n: Vec3, direction: Vec3) -> Scalar:
        """Length 2 r |n . d| of the chord from a point of normal n."""
        return 2 * self.radius * jnp.abs(dot(n, direction))


def _sphere_map(n: Vec3) -> tuple[Vec3, tuple[Array, Array]]:
    """Tangent and surface coordinates; at the poles, where neither exists, those of azimuth 0."""
    rho2 = n.x * n.x + n.y * n.y
    pole = rho2 < 1e-12
    x, y = jnp.where(pole, 1.0, n.x), jnp.where(pole, 0.0, n.y)
    scale = 1 / jnp.sqrt(jnp.where(pole, 1.0, rho2))
    u = jnp.arctan2(y, x) / (2 * jnp.pi)
    v = jnp.arctan2(safe_sqrt(rho2), n.z) / jnp.pi
    return Vec3(-y * scale, x * scale, jnp.zeros_like(x)), (jnp.where(u < 0, u + 1, u), v)


@pytree
class Plane:
    """Infinite plane; the side of its normal is outside."""

    point_on: Any = param("(-inf, inf)", vector=True, doc="any point of the plane, where u = v = 0")
    normal: Any = param("(-inf, inf)", vector=True, nonzero=True, doc="normal, of any length but 0")

    def roots(self, ray: Ray, t_min: Scalar) -> Root:
        """Distance above t_min."""
        height, slope = self._height(ray, self._unit())
        horizon = jnp.finfo(height.dtype).max ** 0.4  # farther away, squares of the distance overflow
        toward = (height * slope < 0) & (jnp.abs(height) < horizon * jnp.abs(slope))
        t = -height / jnp.where(toward, slope, 1.0)
        return Root(jnp.where(toward & (t > t_min), t, jnp.inf), jnp.zeros_like(toward))

    def blocks(self, ray: Ray, t_min: Scalar, distance: Scalar) -> Flag:
        """Whether the plane is met between t_min and a distance."""
        height, slope = self._height(ray, self._unit())
        reach, size = jnp.abs(slope), jnp.abs(height)
        return (height * slope < 0) & (size > t_min * reach) & (size < distance * reach)

    def point(self, ray: Ray, own: Flag, far: Flag, here: Flag) -> Point:
        """Point of the plane, put back on it after rounding."""
        n = self._unit()
        height, slope = self._height(ray, n)
        t = -height / jnp.where(here & (slope != 0), slope, 1.0)
        p = ray.at(t)
        p = p - n * dot(p - self.point_on, n)
        tangent = _any_tangent(n)
        away = p - self.point_on
        return Point(t, p, n, slope < 0, tangent, (dot(away, tangent), dot(away, cross(n, tangent))))

    def chord(self, n: Vec3, direction: Vec3) -> Scalar:
        """None: what goes below a plane does not meet it again."""
        return jnp.full_like(direction.x, jnp.inf)

    def _unit(self) -> Vec3:
        return normalize(self.normal)

    def _height(self, ray: Ray, n: Vec3) -> tuple[Scalar, Scalar]:
        return dot(ray.origin - self.point_on, n), dot(ray.direction, n)


def _any_tangent(n: Vec3) -> Vec3:
    """Unit tangent: x projected on the plane, y where the normal is nearer to x than 18 degrees."""
    steep = jnp.abs(n.x) > 0.95
    axis = Vec3(*(jnp.where(steep, a, b).astype(n.x.dtype) for a, b in ((0.0, 1.0), (1.0, 0.0), (0.0, 0.0))))
    return normalize(axis - n * dot(axis, n))


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
    "no_remedy",
    "nudge",
    "offset",
    "refract",
    "spawn",
    "tolerance",
]
