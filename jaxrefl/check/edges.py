"""Evaluators of section I, silhouettes and shadows: where hits begin and end, and integrals between these places.

Every edge is found by bisection on what `trace` hits or lights, without the formula for it, and form factors are
integrals over the directions that hit, between edges so found. The horizon of a patch is bisected too, on N . w.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..camera import Pinhole
from ..geometry import Plane, Ray, Sphere
from ..light import Directional, PointLight
from ..scene import Object, Scene
from ..surface import Phong
from ..trace import trace
from ..vec import Vec3, dot, norm
from .numerics import boundary
from .pictures import BLACK, FRESNEL, LAMBERT, ORIGIN, SHINING, UP, batched, frontal, rule
from .table import HostColumns, evaluates

ZENITH = Vec3(0.0, 0.0, 1.0)


def _first(scene: Scene, start: Vec3, aim: Vec3) -> tuple[Array, Array]:
    """Distance of the first hit of rays, inf for none, and the cosine of incidence there."""
    rays = Ray(start, aim / norm(aim))
    hits = trace(scene, rays, 0, account=False)
    return hits.depth, -dot(hits.normal, rays.direction)


@jax.jit
def _balls(x: Array, z: Array, aim_x: Array, aim_y: Array, aim_z: Array, along: Array, dradius: Array) -> Any:
    def first(aim_x: Array, radius: Array) -> tuple[Array, Array]:
        ball = Scene({"ball": Object(Sphere(ORIGIN, radius), BLACK)})
        return _first(ball, Vec3(x, 0 * x, z), Vec3(aim_x, aim_y, aim_z))

    return jax.jvp(first, (aim_x, jnp.ones_like(dradius)), (along, dradius))


def _ball(start: tuple[Any, Any], aim: tuple[Any, Any, Any], along: float = 0.0, dradius: float = 0.0) -> Any:
    """Distance and cosine with which rays from (x, z) meet the unit ball; derivatives, as aim_x and the ball grow."""
    return batched(lambda *rows: _balls(*rows, np.float64(dradius)), *start, *aim, along)


def _hits(start: tuple[Any, Any], aim: tuple[Any, Any, Any]) -> np.ndarray:
    return np.isfinite(_ball(start, aim)[0][0])


# --- form factors ---


def _patch_to_sphere(distance: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> np.ndarray:
    """Form factor of a patch whose normal makes an angle with the direction to a unit sphere; arrays of one axis.

    In angles about that direction: a polar one up to the silhouette or the horizon of the patch, and an azimuth, in
    two pieces, between which the silhouette goes below the horizon.
    """
    h, c, s = (x[:, None, None] for x in (distance, cosine, sine))  # patches, azimuths, polar angles

    def height(polar: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        return c * np.cos(polar) + s * np.sin(polar) * np.cos(azimuth)

    def hits(polar: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        aim = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
        return _hits((0, -h), aim)

    zero = np.zeros_like(h)
    rim = boundary(lambda polar: hits(polar, zero), zero, zero + np.pi / 2)
    corner = boundary(lambda azimuth: height(rim, azimuth) > 0, zero, zero + np.pi)
    (u, w), (p, q) = rule(24, 0.0, 1.0), rule(12, 0.0, 1.0)
    span = np.concatenate([-corner, np.pi - corner], axis=1)
    azimuth = (corner + span * u**4).reshape(len(h), -1, 1)  # crowded at the corner
    weight = (4 * np.abs(span) * u**3 * w).reshape(len(h), -1, 1)
    rim = boundary(lambda polar: hits(polar, azimuth), 0 * azimuth, 0 * azimuth + np.pi / 2)
    above = c >= 0
    horizon = boundary(lambda polar: (height(polar, azimuth) > 0) == above, 0 * rim, rim)
    low, high = np.where(above, 0, horizon), np.where(above, horizon, rim)
    polar, w = low + (high - low) * p, (high - low) * q
    return 2 / np.pi * np.sum(weight * w * hits(polar, azimuth) * height(polar, azimuth) * np.sin(polar), axis=(1, 2))


@evaluates(
    "I.patch_sphere",
    "H theta_deg",
    skipped={"check_abs_diff": "closed form against quadrature at 40 digits, a check of the table itself"},
    jit=False,
)
def _patch_sphere(c: HostColumns) -> HostColumns:
    factor = _patch_to_sphere(c["H"], c["cos_theta"], c["sin_theta"])
    return {"F": factor, "E_over_L": np.pi * factor}


@evaluates("I.sphere_sphere", "r1 r2 d", jit=False)
def _sphere_sphere(c: HostColumns) -> HostColumns:
    r1, r2, d = (c[name][:, None] for name in ("r1", "r2", "d"))

    def patch(polar: np.ndarray) -> tuple[np.ndarray, ...]:
        """Distance in radii r2, cosine and sine for the patch of sphere 1 at an angle from the line of centres."""
        across, along = r1 * np.sin(polar), d - r1 * np.cos(polar)
        distance = np.sqrt(across * across + along * along)
        return distance / r2, (d * np.cos(polar) - r1) / distance, d * np.sin(polar) / distance

    def horizon_hits(polar: np.ndarray) -> np.ndarray:  # the ray along the patch, in the plane of the centres
        distance, cosine, sine = patch(polar)
        return _hits((0, -distance), (-cosine, 0, sine))

    middle = np.arccos(r1 / d)
    whole = boundary(lambda polar: ~horizon_hits(polar), 0 * middle, middle)
    last = boundary(horizon_hits, middle, 0 * middle + np.pi)
    (u, v), (a, b) = rule(12, 0.0, 1.0), rule(28, 0.0, np.pi / 2)
    polar = np.concatenate([whole * u, whole + (last - whole) * np.sin(a) ** 2], axis=1)
    weight = np.concatenate([whole * v, (last - whole) * np.sin(2 * a) * b], axis=1)
    factor = _patch_to_sphere(*(x.ravel() for x in patch(polar))).reshape(polar.shape)
    mean = np.sum(weight * factor * np.sin(polar), axis=1) / 2
    return {"F12": mean, "F21": mean * (c["r1"] / c["r2"]) ** 2}


@jax.jit
def _floor(start: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Length of rays from (start, 0, 1) to (x, y, 0), and their cosine with the normal of the floor they fall on."""
    floor = Scene({"floor": Object(Plane(ORIGIN, ZENITH), BLACK)})
    return _first(floor, Vec3(start, 0 * x, 0 * x + 1), Vec3(x - start, y, 0 * x - 1))


@evaluates("I.misc_ff", given="a=h=r1=r2=1", jit=False)
def _discs(_: HostColumns) -> HostColumns:
    r, w = rule(20, 0.0, 1.0)
    t, cosine = batched(_floor, 0.0, r, 0.0)
    area = 2 * np.pi * r * w
    angle, v = rule(20, 0.0, np.pi / 2)
    far, below = batched(_floor, 0.0, np.tan(angle), 0.0)
    everywhere = 2 * np.pi * np.tan(angle) * v / np.cos(angle) ** 2
    azimuth = np.pi * (np.arange(20) + 0.5) / 20
    x, y = r[:, None] * np.cos(azimuth), r[:, None] * np.sin(azimuth)
    length, slant = batched(_floor, r[:, None, None], x, y)
    return {
        "sphere_plane": np.sum(everywhere * below / far**2) / (4 * np.pi),
        "sphere_disc": np.sum(area * cosine / t**2) / (4 * np.pi),
        "patch_disc": np.sum(area * cosine**2 / t**2) / np.pi,
        "disc_disc": np.einsum("i,j,ijk->", area, area, (slant / length) ** 2) / 20 / np.pi**2,
    }


# --- shadows ---


@jax.jit
def _lit(x: Array, y: Array) -> Array:
    """Radiance (n, 2) of a floor under a ball: in sunlight at 60 degrees, and under a lamp over the ball."""
    objects = {
        "ball": Object(Sphere(Vec3(0.0, 0.0, 3.0)), BLACK),
        "floor": Object(Plane(ORIGIN, ZENITH), Phong(1.0)),
    }
    lights = {
        "sun": Directional(Vec3(jnp.sqrt(3.0), 0.0, -1.0), diffuse=[1.0, 0.0]),
        "lamp": PointLight(Vec3(0.0, 0.0, 10.0), diffuse=[0.0, 1.0]),
    }
    rays = Ray(Vec3(x, y, 0 * x + 0.5), Vec3(0 * x, 0 * x, 0 * x - 1))
    return trace(Scene(objects, lights), rays, 0, account=False).radiance


def _shadow_edges() -> tuple[float, float, float, float]:
    """Ends in x of the shadow in sunlight, half its width, and the radius of the shadow under the lamp."""

    def dark(light: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(_lit(x, y))[:, light] == 0

    zero = np.zeros(2)
    x = boundary(lambda x: dark(0, x, zero), zero + 5, [9.0, 1.0])
    y = boundary(lambda y: dark(0, zero + x.mean(), y), zero, zero + 3)
    radius = boundary(lambda x: dark(1, x, zero), zero, zero + 3)
    return x[0], x[1], y[0], radius[0]


@evaluates("I.shadow", jit=False)
def _shadow(_: HostColumns) -> HostColumns:
    right, left, half_width, radius = _shadow_edges()
    return {
        "offset": (right + left) / 2,
        "semi_major": (right - left) / 2,
        "semi_minor": half_width,
        "point_radius": radius,
    }


@evaluates("I.penumbra", jit=False)
def _penumbra(_: HostColumns) -> HostColumns:
    side = np.array([1.0, -1.0])  # the upper rim of the lamp bounds the umbra, the lower one the penumbra

    def hits(angle: np.ndarray, x: np.ndarray, distance: float, size: float) -> np.ndarray:
        return _hits((x / size, -distance / size), (np.sin(angle), 0, np.cos(angle)))

    def rim(x: np.ndarray) -> np.ndarray:
        return boundary(lambda angle: hits(angle, x, 15, 2), np.arctan2(-x, 15.0), np.arctan2(3 * side - x, 15.0))

    radius = boundary(lambda x: hits(rim(x), x, 5, 1), [0.0, 2.0], [2.0, 5.0])
    angle = np.abs(rim(radius))
    apex = radius / np.tan(angle)  # as seen from the plane
    return {
        "umbra_half_deg": np.rad2deg(angle[0]),
        "umbra_apex": apex[0] + 5,
        "penumbra_half_deg": np.rad2deg(angle[1]),
        "penumbra_apex": apex[1] - 5,
        "umbra_radius_at_5": radius[0],
        "penumbra_radius_at_5": radius[1],
    }


# --- silhouettes ---


@evaluates("I.perspective_sphere", looser={"cap_fraction": 1e-12}, jit=False)
def _perspective_sphere(_: HostColumns) -> HostColumns:
    camera = Pinhole(Vec3(0.0, 0.0, 5.0), up=UP, field_of_view=np.pi / 2)  # its picture is one unit away
    shoot = jax.jit(jax.vmap(camera.ray))

    def seen(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        d = batched(shoot, x, 0.0).direction
        return np.arctan2(d.x, -d.z), *_ball((0, 5), (d.x, d.y, d.z))[0]

    radius = boundary(lambda x: np.isfinite(seen(x)[1]), [0.0], [1.0])
    (rim,), (v, w) = seen(radius)[0], rule(6, 0.0, 1.0)
    sine = np.sin(rim) * np.sqrt((1 - v) * (1 + v))  # nodes, denser towards the rim: the cosine there is about v
    angle, t, cosine = seen(np.tan(np.arcsin(sine)))
    # the visible area; near the rim, where the cosine is small, it is as inaccurate as eps / cosine^2
    area = np.sum(w * v * t**2 * np.sin(rim) ** 2 / (np.cos(angle) * cosine)) / 2  # over 4 pi
    return {"half_angle_deg": np.rad2deg(rim), "image_radius": radius[0], "cap_fraction": area}


@evaluates("I.visibility_gradients", skipped={"c_interior_quad": "c_interior again, to twelve digits"}, jit=False)
def _visibility_gradients(_: HostColumns) -> HostColumns:
    # interior: the pixels stay where they are, which is all that differentiation sees; total: they move with the rim
    weight, value, interior = frontal(dradius=1.0)
    total = np.pi * weight @ (2 * value + frontal(dx=1.0, dradius=1.0)[2])
    interior = np.pi * weight @ interior
    columns: HostColumns = {}
    for name, channel in zip("abc", (SHINING, LAMBERT, FRESNEL), strict=True):
        columns |= {f"{name}_total": total[channel], f"{name}_interior": interior[channel]}
        columns[f"{name}_edge"] = total[channel] - interior[channel]
    # the edge of a shadow is no integral: where the ray from the lamp grazes the ball, the cosine of incidence is 0,
    # its slopes are infinite, and their ratio is the speed of the edge
    radius = _shadow_edges()[3]
    (_, slope_x), (_, slope_radius) = (
        _ball((0, 7), (radius * (1 - 1e-12), 0, -10), *along)[1] for along in ((1, 0), (0, 1))
    )
    speed = -slope_radius / slope_x
    return {**columns, "d_radius": radius, "d_dradius_dr": speed, "d_dArea_dr": 2 * np.pi * radius * speed}
