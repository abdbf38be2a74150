"""Cameras: a place on the picture becomes a ray.

The picture has its centre at (0, 0); y runs from -1 at the bottom to 1 at the top, x from -aspect to aspect. Every
parameter is a leaf of the pytree: a picture can be differentiated in the position of the camera.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from .geometry import Ray
from .params import Interval, is_concrete, param, pytree, require
from .scene import check_model
from .vec import Vec3, cross, normalize


def basis(position: Vec3, target: Vec3, up: Vec3) -> tuple[Vec3, Vec3, Vec3]:
    """Right, true up and forward of a camera that looks at a target; ``up`` must not be parallel to the view."""
    forward = normalize(target - position)
    right = normalize(cross(forward, up))
    return right, cross(right, forward), forward


def check(camera: Any) -> None:
    """Raise `ValueError` for a camera that looks at its own place, or along its ``up``: its picture has no sides."""
    places = [getattr(camera, name, None) for name in ("position", "target", "up")]
    if any(place is None for place in places) or not all(map(is_concrete, jax.tree.leaves(places))):
        return
    rows = [(p.x, p.y, p.z) if isinstance(p, Vec3) else p for p in places]  # inside jit too these are numbers
    position, target, up = (np.asarray(row, np.float64) for row in rows)
    view = target - position
    if not np.any(view):
        raise ValueError(
            f"camera.target = {target.tolist()} is the position of the camera; it needs a direction of view"
        )
    sine = np.linalg.norm(np.cross(view, up))
    if sine <= 1e-7 * np.linalg.norm(view) * np.linalg.norm(up):
        raise ValueError(f"camera.up = {up.tolist()} is parallel to the view {view.tolist()}; it must not be")


def check_picture(camera: Any, **sizes: int) -> None:
    """Raise `ValueError` for a size that is no whole number from 1, or a camera that can take no picture."""
    for name, value in sizes.items():
        require(name, value, Interval.parse("[1, inf)"))
        if not isinstance(value, (int, np.integer)):
            raise ValueError(f"{name} = {value!r} is not a whole number")
    check_model(camera, "camera")
    check(camera)


@pytree
class Pinhole:
    """Perspective camera."""

    position: Any = param("(-inf, inf)", vector=True, doc="eye")
    target: Any = param("(-inf, inf)", vector=True, default=Vec3(0.0, 0.0, 0.0), doc="point it looks at")
    up: Any = param("(-inf, inf)", vector=True, default=Vec3(0.0, 0.0, 1.0), doc="direction that is up in the picture")
    field_of_view: Any = param("(0, 3.14159)", unit="rad", default=0.7, doc="vertical angle of the picture")

    def ray(self, x: Float[jax.Array, ""], y: Float[jax.Array, ""]) -> Ray:
        """Ray through a place on the picture."""
        right, up, forward = basis(self.position, self.target, self.up)
        scale = jnp.tan(0.5 * jnp.asarray(self.field_of_view))
        direction = normalize(forward + right * (x * scale) + up * (y * scale))
        return Ray(self.position + direction * 0.0, direction)


@pytree
class Orthographic:
    """Camera with parallel rays, an infinite viewer: V is the same everywhere."""

    position: Any = param("(-inf, inf)", vector=True, doc="centre of the plane from which the rays start")
    target: Any = param("(-inf, inf)", vector=True, default=Vec3(0.0, 0.0, 0.0), doc="point it looks at")
    up: Any = param("(-inf, inf)", vector=True, default=Vec3(0.0, 0.0, 1.0), doc="direction that is up in the picture")
    height: Any = param("(0, inf)", unit="length", default=2.0, doc="height of the picture in the scene")

    def ray(self, x: Float[jax.Array, ""], y: Float[jax.Array, ""]) -> Ray:
        """Ray through a place on the picture."""
        right, up, forward = basis(self.position, self.target, self.up)
        half = 0.5 * jnp.asarray(self.height)
        return Ray(self.position + right * (x * half) + up * (y * half), forward + right * (0.0 * x))
