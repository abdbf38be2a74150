"""Textures: a colour that depends on the place, in the place of any colour parameter of a surface.

A texture is any dataclass with ``__call__(uv) -> (C,)``. u and v are lengths on a plane and in [0, 1] on a sphere.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from .params import param, parameters, pytree
from .vec import Vec3

UV = tuple[Array, Array]


def is_texture(value: Any) -> bool:
    """True for a model that stands in the place of a number."""
    return dataclasses.is_dataclass(value) and not isinstance(value, type) and callable(value)


def resolve(model: Any, uv: UV) -> Any:
    """A surface with every texture replaced by its value at a place: models of surfaces never see a texture.

    A parameter that is not spectral takes the first channel. A model in a field that is no parameter, such as the BRDF
    of a user's surface, is no texture, even if it can be called.
    """
    spectral = {p.name: p.spectral for p in parameters(model)}
    fields = {}
    for field in dataclasses.fields(model):
        value = getattr(model, field.name)
        if is_texture(value) and field.name in spectral:
            color = value(uv)
            fields[field.name] = color if spectral[field.name] else color[0]
        elif dataclasses.is_dataclass(value) and not isinstance(value, Vec3):
            fields[field.name] = resolve(value, uv)
    return dataclasses.replace(model, **fields) if fields else model


@pytree
class Checker:
    """Checkerboard of two colours; nothing can be differentiated in its edges, everything in its colours."""

    even: Any = param("[0, inf)", spectral=True, default=0.8, doc="colour of the square at the origin")
    odd: Any = param("[0, inf)", spectral=True, default=0.2, doc="colour of its neighbours")
    squares_u: Any = param("(0, inf)", default=1.0, doc="squares per unit of u")
    squares_v: Any = param("(0, inf)", default=1.0, doc="squares per unit of v")

    def __call__(self, uv: UV) -> Float[Array, "*C"]:
        """Colour at (u, v)."""
        parity = jnp.floor(uv[0] * self.squares_u) + jnp.floor(uv[1] * self.squares_v)
        return jnp.where(parity == 2 * jnp.floor(parity / 2), self.even, self.odd)  # a remainder is a slow call


@pytree
class ImageTexture:
    """Picture (H, W, C) repeated over the plane of u and v, interpolated between the centres of its pixels.

    Row 0 begins at v = 0, the north pole of a sphere. Differentiable in the pixels and, between their centres, in u
    and v. It is shared by all primitives of an object.
    """

    shared: ClassVar[bool] = True

    pixels: Any = param("[0, inf)", spectral=True, doc="(H, W, C)")
    scale_u: Any = param("(0, inf)", default=1.0, doc="pictures per unit of u")
    scale_v: Any = param("(0, inf)", default=1.0, doc="pictures per unit of v")

    def __call__(self, uv: UV) -> Float[Array, "*C"]:
        """Colour at (u, v)."""
        height, width = self.pixels.shape[:2]
        x, y = uv[0] * self.scale_u * width - 0.5, uv[1] * self.scale_v * height - 0.5
        x0, y0 = jnp.floor(x), jnp.floor(y)
        fx, fy = x - x0, y - y0
        column, row = jnp.mod(x0, width).astype(int), jnp.mod(y0, height).astype(int)
        right, below = jnp.where(column + 1 < width, column + 1, 0), jnp.where(row + 1 < height, row + 1, 0)
        upper = self.pixels[row, column] * (1 - fx) + self.pixels[row, right] * fx
        lower = self.pixels[below, column] * (1 - fx) + self.pixels[below, right] * fx
        return upper * (1 - fy) + lower * fy
