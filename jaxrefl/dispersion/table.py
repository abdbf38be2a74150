"""Measured n and k, interpolated."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import is_concrete, param, pytree
from .index import Index
from .limits import Limits, prepare, shape_of

METHODS = ("linear", "cubic")


@pytree
class Tabulated:
    """Index interpolated in a table: linearly, or by the monotone cubic that does not overshoot.

    The range is that of the table. Differentiable in n, k and the wavelength: at a row the linear slope is that of the
    interval above (at the last row: below), the cubic is smooth. The cubic's slope at a row is the weighted harmonic
    mean of its neighbours', 0 at an extremum. Source of the cubic: F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal.
    17, 238 (1980); F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5, 300 (1984), (5).
    """

    wavelength_nm: Any = param("(0, inf)", unit="nm", spectral=True, doc="ascending, (N,), N >= 2")
    n: Any = param("[0, inf)", spectral=True, doc="refractive index (N,)")
    k: Any = param("[0, inf)", spectral=True, default=0.0, doc="extinction coefficient (N,), or 0")
    method: str = dataclasses.field(default="linear", metadata={"static": True, "choices": METHODS})

    @property
    def range_nm(self) -> Limits:
        """First and last wavelength."""
        return self.wavelength_nm[0], self.wavelength_nm[-1]

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        self._check()
        wavelength, x, n, k = prepare(self, wavelength_nm, self.wavelength_nm, self.n, self.k)
        x = lax.stop_gradient(x)
        left = jnp.clip(jnp.searchsorted(x, wavelength, side="right") - 1, 0, x.shape[0] - 2)
        interpolate = _linear if self.method == "linear" else _cubic
        return Index(*(interpolate(x, jnp.broadcast_to(y, x.shape), left, wavelength) for y in (n, k)))

    def _check(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method = {self.method!r} must be one of {', '.join(METHODS)}")
        shapes = [shape_of(y) for y in (self.wavelength_nm, self.n, self.k)]
        if len(shapes[0]) != 1 or shapes[0][0] < 2 or shapes[1] != shapes[0] or shapes[2] not in ((), shapes[0]):
            raise ValueError(f"wavelength_nm, n, k have shapes {shapes}; they are (N,) with N >= 2, k may be a number")
        if all(is_concrete(x) for x in jax.tree.leaves(self.wavelength_nm)):
            falls = np.flatnonzero(np.diff(np.asarray(self.wavelength_nm)) <= 0)
            if falls.size:
                raise ValueError(f"wavelength_nm[{falls[0] + 1}] = {self.wavelength_nm[falls[0] + 1]} does not ascend")


def _linear(x: Array, y: Array, left: Array, at: Array) -> Array:
    t = (at - x[left]) / (x[left + 1] - x[left])
    return y[left] * (1 - t) + y[left + 1] * t


def _cubic(x: Array, y: Array, left: Array, at: Array) -> Array:
    """Hermite's cubic between two rows."""
    slope = _slopes(jnp.diff(x), jnp.diff(y) / jnp.diff(x))
    h = x[left + 1] - x[left]
    t = (at - x[left]) / h
    ends = y[left] * (1 + 2 * t) * (1 - t) ** 2 + y[left + 1] * t * t * (3 - 2 * t)
    return ends + h * t * (1 - t) * (slope[left] * (1 - t) - slope[left + 1] * t)


def _slopes(h: Array, chord: Array) -> Array:
    """Slopes at the rows from the widths and the slopes of the intervals."""
    if h.shape[0] == 1:
        return jnp.concatenate([chord, chord])
    inner = _harmonic(2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1], chord[:-1], chord[1:])
    first, last = _end(h[0], h[1], chord[0], chord[1]), _end(h[-1], h[-2], chord[-1], chord[-2])
    return jnp.concatenate([first[None], inner, last[None]])


def _harmonic(w1: Array, w2: Array, a: Array, b: Array) -> Array:
    """Weighted harmonic mean of two slopes of one sign, else 0; scaled, so that small slopes have finite slopes."""
    same = ((a > 0) & (b > 0)) | ((a < 0) & (b < 0))
    a, b = jnp.where(same, a, 1.0), jnp.where(same, b, 1.0)
    scale = lax.stop_gradient(jnp.maximum(jnp.abs(a), jnp.abs(b)))
    p, q = a / scale, b / scale
    return jnp.where(same, scale * ((w1 + w2) * p * q / (w1 * q + w2 * p)), 0.0)


def _end(h0: Array, h1: Array, near: Array, far: Array) -> Array:
    """Slope at an end row: of the parabola through three rows, held to what keeps the cubic monotone."""
    slope = ((2 * h0 + h1) * near - h0 * far) / (h0 + h1)
    turns = (near * far <= 0) & (jnp.abs(slope) > 3 * jnp.abs(near))
    return jnp.where(jnp.sign(slope) != jnp.sign(near), 0.0, jnp.where(turns, 3 * near, slope))
