"""Evaluators of section I, paths of rays: slab, ball lens, rainbow, curved mirrors and closed furnaces.

Displacements and deflections are read off the ray that `follow` brings out, slopes off its derivatives: along one
direction, which is an argument, so that one compilation serves the search of a minimum and the slope in the index.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..geometry import Plane, Ray, Sphere
from ..scene import Object, Scene
from ..surface import Blend, Dielectric, Phong, Whitted
from ..trace import follow, trace
from ..vec import Vec3, cross, norm
from .numerics import boundary
from .table import HostColumns, evaluates

ORIGIN, UP = Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)


def _directional(f: Callable[..., Array], n: int) -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """f of n numbers for rows of them, and its derivative along the n rows after these."""
    kernel = jax.jit(lambda *args: jax.jvp(f, args[:n], args[n:]))

    def rows_of(*args: Any) -> tuple[np.ndarray, np.ndarray]:
        rows = zip(*(x.ravel() for x in np.broadcast_arrays(*(np.asarray(x, float) for x in args))), strict=True)
        value, slope = zip(*(kernel(*row) for row in rows), strict=True)
        return np.stack(value), np.stack(slope)

    return rows_of


# --- refraction ---


def _through_slab(n: Array, sine: Array, cosine: Array) -> Array:
    """Way along the far face, and distance between the entering and the leaving ray, for a slab of unit thickness."""
    glass, zero = Dielectric(n), 0.0 * n
    slab = Scene({"front": Object(Plane(ORIGIN, UP), glass), "rear": Object(Plane(-UP, -UP), glass)})
    direction = Vec3(sine, zero, -cosine)
    ray = follow(slab, Ray(-direction, direction), "TT")
    return jnp.stack([ray.origin.x, cross(direction, ray.origin).y])


_slab = _directional(_through_slab, 3)


@evaluates("I.slab_shift", "n theta_deg", jit=False)
def _slab_shift(c: HostColumns) -> HostColumns:
    way, distance = _slab(c["n"], c["sin_theta"], c["cos_theta"], 0, 0, 0)[0].T
    return {
        "shift_perp": distance,
        "shift_along_face": c["sin_theta"] / c["cos_theta"] - way,
        "theta_t_deg": np.rad2deg(np.arctan(way)),
    }


def _through_ball(height: Array, n: Array) -> Array:
    """Lateral and axial component of point and direction in which a ray parallel to the axis leaves a glass ball."""
    zero = 0.0 * height
    ball = Scene({"ball": Object(Sphere(ORIGIN), Dielectric(n))})
    ray = follow(ball, Ray(Vec3(height, zero, zero - 3), Vec3(zero, zero, zero + 1)), "TT")
    return jnp.stack([ray.origin.x, ray.origin.z, ray.direction.x, ray.direction.z])


_ball = _directional(_through_ball, 2)


@evaluates("I.ball_lens", "n", jit=False)
def _ball_lens(c: HostColumns) -> HostColumns:
    columns: HostColumns = {}
    for height in ("0.1", "0.5", "0.9"):
        x, z, dx, dz = _ball(float(height), c["n"], 0, 0)[0].T
        columns |= {f"dev_{height}": np.rad2deg(np.arctan2(-dx, dz)), f"z_{height}": z - x * dz / dx}
    x, _, dx, _ = _ball(0, c["n"], 1, 0)[1].T  # per unit of height, on the axis
    return {"EFL": -1 / dx, "BFL": -x / dx, **columns}


def _deflection(incidence: Array, n: Array, branches: str) -> Array:
    """Angle, in [0, 2 pi), by which a ray turns in a sphere of water."""
    zero = 0.0 * n
    drop = Scene({"drop": Object(Sphere(ORIGIN), Dielectric(n))})
    ray = follow(drop, Ray(Vec3(jnp.sin(incidence), zero, zero + 3), Vec3(zero, zero, zero - 1)), branches)
    turned = jnp.arctan2(-ray.direction.x, -ray.direction.z)
    return jnp.where(turned < 0, turned + 2 * jnp.pi, turned)


_bows = [_directional(functools.partial(_deflection, branches=branches), 2) for branches in ("TRT", "TRRT")]


def _least(order: int, n: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Incidence and deflection of the bow of an order, radians, and the slope of the deflection in the index."""
    bow = _bows[order - 1]
    incidence = boundary(lambda i: bow(i, n, 1, 0)[1] < 0, 0.1 + 0 * n, 1.5 + 0 * n)
    return incidence, *bow(incidence, n, 0, 1)  # at the minimum the incidence does not matter


@evaluates("I.rainbow", "tag n", jit=False)
def _rainbow(c: HostColumns) -> HostColumns:
    columns: HostColumns = {}
    for order in (1, 2):
        incidence, deflection, _ = map(np.rad2deg, _least(order, c["n"]))
        columns |= {f"i{order}_deg": incidence, f"D{order}_deg": deflection}
        columns[f"radius{order}_deg"] = np.abs(180 - deflection)
    return columns


@evaluates(
    "I.derivatives",
    given="rainbow n=1.333, ball and slab n=1.5",
    derivatives="drainbow1_dn drainbow2_dn dEFL_dn dshift_dn",
    skipped={"drainbow1_check": "drainbow1_dn again, by finite difference"},
    jit=False,
)
def _derivatives(_: HostColumns) -> HostColumns:
    near = 1e-7  # the deviation at this height over the height is 1 / EFL to 1e-14
    bent, bends = (x[0, 2] / near for x in _ball(near, 1.5, 0, 1))
    return {
        "drainbow1_dn": -_least(1, np.array([1.333]))[2][0],
        "drainbow2_dn": _least(2, np.array([1.333]))[2][0],
        "dEFL_dn": bends / bent**2,
        "dshift_dn": _slab(1.5, np.sqrt(0.75), 0.5, 1, 0, 0)[1][0, 1],
    }


# --- reflection ---


def _off_ball(x: Array, z: Array, aim_x: Array, aim_z: Array, radius: Array) -> Array:
    """Point and direction (x, z, dx, dz) of a ray from (x, z) towards (x + aim_x, z + aim_z), reflected in a ball."""
    zero, aim = 0.0 * x, Vec3(aim_x, 0.0 * x, aim_z)
    ball = Scene({"ball": Object(Sphere(ORIGIN, radius), Blend(Phong(0.0), 1.0))})
    ray = follow(ball, Ray(Vec3(x, zero, z), aim / norm(aim)), "R")
    return jnp.stack([ray.origin.x, ray.origin.z, ray.direction.x, ray.direction.z])


_mirror = _directional(_off_ball, 5)


@evaluates("I.alhazen", "a b beta_deg", skipped={"outside_visible": "a verdict on the table, not a number"}, jit=False)
def _alhazen(c: HostColumns) -> HostColumns:
    a, b, beta = c["a"], c["b"], np.deg2rad(c["beta_deg"])
    source = b * c["cos_beta"], b * c["sin_beta"]

    def reflected(angle: np.ndarray) -> np.ndarray:
        return _mirror(a, 0, np.cos(angle) - a, np.sin(angle), 1, *[0] * 5)[0].T

    def short_of_it(angle: np.ndarray) -> np.ndarray:  # the reflected ray passes the source on the side of the eye
        x, y, dx, dy = reflected(angle)
        return dx * (source[1] - y) - dy * (source[0] - x) > 0

    angle = boundary(short_of_it, np.maximum(0, beta - np.arccos(1 / b)), np.minimum(beta, np.arccos(1 / a)))
    x, y, dx, dy = reflected(angle)
    return {
        "phi_deg": np.rad2deg(np.arctan2(y, x)),
        "Px": x,
        "Py": y,
        "incidence_deg": np.rad2deg(np.arctan2(np.abs(x * dy - y * dx), x * dx + y * dy)),
        "path": np.hypot(x - a, y) + np.hypot(x - source[0], y - source[1]),
    }


@evaluates("I.convex_mirror", "u R", jit=False)
def _convex_mirror(c: HostColumns) -> HostColumns:
    u, radius = c["u"], c["R"]

    def per_height(of_object: float, of_mirror: float) -> np.ndarray:
        """Slopes of the reflected ray in the height of the object or in that at which its ray meets the mirror."""
        fall = (of_mirror - of_object) / u
        # the ray starts one unit before the mirror: from the object, far away, half of the digits would be lost
        return _mirror(0, radius + 1, 0, -1, radius, of_mirror - fall, 0, fall, 0, 0)[1].T

    point, _, direction, _ = per_height(0, 1)
    depth = point / direction  # where the rays from one point meet
    return {"image_depth": depth, "magnification": -depth * per_height(1, 0)[2]}


# --- furnaces ---


@functools.partial(jax.jit, static_argnames="n_bounces")
def _from_within(rho: Array, emission: Array, n_bounces: int) -> Array:
    """Partial sums (n_bounces + 1, C) of what a ray gathers in a sphere that shines and reflects rho at every hit."""
    wall = Whitted(Phong(0.0, emission=emission), k_rg=rho)
    ray = Ray(Vec3(*jnp.array([[0.1], [-0.3], [0.2]])), Vec3(*jnp.array([[0.48], [0.6], [0.64]])))
    terms = trace(Scene({"wall": Object(Sphere(ORIGIN), wall)}), ray, n_bounces, terms=True).terms
    assert terms is not None
    return jnp.cumsum((terms.weight * terms.local * terms.color)[0], axis=0)


BOUNCES = 2000  # 0.98^2000 = 3e-18


@evaluates("I.furnace_box", given="emission=1, rho=0.5", jit=False)
def _furnace_box(_: HostColumns) -> HostColumns:
    radiance = np.asarray(_from_within(np.full(6, 0.5), np.ones(6), BOUNCES))[:, 0]
    return {"rho05": radiance[-1], "rho05_N4": radiance[4]}


@evaluates("I.integrating_sphere", "rho", given="Phi/A=1, port f=0.02", jit=False)
def _integrating_sphere(c: HostColumns) -> HostColumns:
    # in a sphere every patch sees every other one with the same form factor: each hit stands for a mean over the wall
    rho, one = c["rho"], np.ones_like(c["rho"])
    closed, ported = np.split(
        np.asarray(_from_within(np.concatenate([rho, rho * 0.98]), np.concatenate([one, rho]), BOUNCES)), 2, axis=1
    )
    return {
        "E_indirect": closed[-1] - closed[0],
        "E_total": closed[-1],
        "E_5_bounces": closed[5],
        "M_port_0.02": ported[-1],
    }
