"""Spaces of a colour: linear sRGB, XYZ and CIE Lab, and what a screen can show. Formulas only, without tables."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from .params import Interval, floats, require
from .safe import safe_divide

GAMUTS = ("desaturate", "clip")

# IEC 61966-2-1: chromaticities of the primaries and of the white
_PRIMARIES = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]]).T
WHITE = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
"""XYZ of the white of sRGB, D65, with Y = 1."""
RGB_TO_XYZ = _PRIMARIES * np.linalg.solve(_PRIMARIES, WHITE)
"""XYZ of linear sRGB as a column: from the chromaticities at full precision, so that (1, 1, 1) is `WHITE`."""
XYZ_TO_RGB = np.linalg.inv(RGB_TO_XYZ)
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
"""Cones of Bradford's chromatic adaptation, of XYZ as a column. Source: ICC.1:2022, annex E."""


def times(values: Float[ArrayLike, "... n"], matrix: Float[ArrayLike, "n m"]) -> Float[Array, "... m"]:
    """values @ matrix in the dtype of the values, at its full precision even where a device has a faster one."""
    (values,) = floats(values)
    return jnp.matmul(values, jnp.asarray(matrix, values.dtype), precision="highest")


def xyz_to_rgb(xyz: Float[ArrayLike, "... 3"], white: Float[ArrayLike, "3"] | None = None) -> Float[Array, "... 3"]:
    """Linear sRGB of XYZ, unclipped.

    Args:
        xyz: (..., 3), Y = 1 for white.
        white: XYZ of a perfect reflector under the light of ``xyz``, which becomes (1, 1, 1) by Bradford's adaptation;
            without it there is no adaptation, and D65, `WHITE`, is (1, 1, 1).

    Differentiable in both. Source: IEC 61966-2-1, its matrix not rounded; ICC.1:2022, annex E.
    """
    if white is None:
        return times(xyz, XYZ_TO_RGB.T)
    xyz, white = floats(xyz, white)
    target = jnp.asarray(BRADFORD @ WHITE, xyz.dtype)
    adapted = times(xyz, BRADFORD.T) * safe_divide(target, times(white, BRADFORD.T))
    return times(adapted, (XYZ_TO_RGB @ np.linalg.inv(BRADFORD)).T)


def rgb_to_xyz(rgb: Float[ArrayLike, "... 3"]) -> Float[Array, "... 3"]:
    """XYZ of linear sRGB (..., 3), the inverse of `xyz_to_rgb`; (1, 1, 1) is `WHITE`. Source: IEC 61966-2-1."""
    return times(rgb, RGB_TO_XYZ.T)


def xyz_to_lab(xyz: Float[ArrayLike, "... 3"], white: Float[ArrayLike, "3"] | None = None) -> Float[Array, "... 3"]:
    """CIE 1976 L*, a*, b* of XYZ: L = 116 f(Y/Yn) - 16, a = 500 (f(X/Xn) - f(Y/Yn)), b = 200 (f(Y/Yn) - f(Z/Zn)).

    f(t) = t^(1/3), below t = (6/29)^3 the line with the same value and slope there; colours out of the gamut, t < 0,
    are on it.

    Args:
        xyz: (..., 3).
        white: XYZ of the white (3,), (0, inf); without it that of sRGB, `WHITE`.

    Raises:
        ValueError: a white outside its range (outside jit only).

    Differentiable everywhere. Source: CIE 15:2004, 8.2.1.
    """
    if white is None:
        (xyz,) = floats(xyz)
        white = jnp.asarray(WHITE, xyz.dtype)
    require("white", white, Interval.parse("(0, inf)"))
    xyz, white = floats(xyz, white)
    t, bend = xyz / white, 6 / 29
    small = t <= bend**3
    f = jnp.where(small, t / (3 * bend**2) + 4 / 29, jnp.cbrt(jnp.where(small, 1.0, t)))
    x, y, z = f[..., 0], f[..., 1], f[..., 2]
    return jnp.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def rgb_to_lab(rgb: Float[ArrayLike, "... 3"]) -> Float[Array, "... 3"]:
    """CIE 1976 L*, a*, b* of linear sRGB (..., 3), white D65; see `xyz_to_lab`."""
    return xyz_to_lab(rgb_to_xyz(rgb))


def to_gamut(rgb: Float[ArrayLike, "... 3"], method: str = "desaturate") -> Float[np.ndarray, "... 3"]:
    """Linear sRGB that a screen can show, each channel in [0, 1]; a colour that is there already is left as it is.

    Args:
        rgb: (..., 3), linear, finite.
        method: "desaturate": on the straight line to the grey of the same luminance Y, as far as needed: luminance and
            dominant wavelength are kept; Y >= 1 is white, Y <= 0 black;
            "clip": each channel held to [0, 1], which keeps neither.

    Raises:
        ValueError: another method; channels that are not three.
    """
    rgb = np.asarray(rgb)
    rgb = rgb if rgb.dtype.kind == "f" else rgb.astype(np.float64)
    if rgb.shape[-1:] != (3,):
        raise ValueError(f"rgb has shape {rgb.shape}; the last axis must be the 3 channels of linear sRGB")
    if method not in GAMUTS:
        raise ValueError(f"method = {method!r} must be one of {', '.join(GAMUTS)}")
    if method == "clip":
        return np.clip(rgb, 0.0, 1.0)
    grey = np.clip(rgb @ RGB_TO_XYZ[1].astype(rgb.dtype), 0.0, 1.0)[..., None]
    away = rgb - grey
    room = np.where(away > 0, 1 - grey, grey)
    over = np.abs(away) > room
    share = np.where(over, room / np.where(over, np.abs(away), 1.0), 1.0).min(axis=-1, keepdims=True)
    return np.where(share < 1, np.clip(grey + share * np.where(share > 0, away, 0.0), 0.0, 1.0), rgb)
