"""The complex index of a medium, from its permittivity, and of two media against each other."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax
from jaxtyping import Complex, Float

from ..params import Interval, Real, floats, require
from ..safe import safe_divide, safe_sqrt


class Index(NamedTuple):
    """Complex refractive index n + i k, time factor exp(-i w t), so that k >= 0 absorbs."""

    n: Float[Array, "..."]
    k: Float[Array, "..."]

    @property
    def complex(self) -> Complex[Array, "..."]:
        """As one complex array n + i k."""
        return lax.complex(*jnp.broadcast_arrays(*floats(self.n, self.k)))


def from_permittivity(real: Real, imaginary: Real = 0.0) -> Index:
    """Complex index sqrt(eps' + i eps''), the root with n >= 0.

    The larger of n and k is sqrt((|eps| + |eps'|) / 2), the other eps'' / 2 over it: nothing cancels, a small k beside
    n (or n beside k) and its slope keep the relative accuracy of the arithmetic.

    Args:
        real: eps' = n^2 - k^2; negative for a metal, and k = sqrt(-eps') then even without absorption.
        imaginary: eps'' = 2 n k >= 0, not checked.

    Returns:
        Index of the broadcast shape.

    Differentiable everywhere but at eps = 0, where the true derivative is infinite and the finite 0 is returned. |eps|
    up to 1e19 in float32, 1e150 in float64.
    Source: Born & Wolf, Principles of Optics, section 14.1, (15).
    """
    re, im = jnp.broadcast_arrays(*floats(real, imaginary))
    size = jnp.where(re < 0, -re, re)
    large = safe_sqrt(0.5 * (safe_sqrt(re * re + im * im) + size))
    small = safe_divide(0.5 * im, large)
    return Index(jnp.where(re < 0, small, large), jnp.where(re < 0, large, small))


def relative(inside: Index, outside: Index) -> Index:
    """Index of one medium against another, (n1 + i k1) / (n2 + i k2), wavelength by wavelength.

    Args:
        inside: of the medium behind the interface.
        outside: of the medium of incidence, n > 0; both of shapes that broadcast.

    Returns:
        Index whose parts are the ``eta`` and ``k`` of `jaxrefl.fresnel`: `fresnel.conductor(cos_theta_i, *relative(
        metal, glass))`. Its k is negative where the outside absorbs more than the inside, k1 n2 < n1 k2; the
        functions of `jaxrefl.fresnel` refuse that.

    Raises:
        ValueError: outside.n not positive (outside jit only).

    Differentiable everywhere. Source: LAMBERT-FRESNEL, Snell's law with complex indices.
    """
    require("outside.n", outside.n, Interval(0.0, jnp.inf, True, True))
    n1, k1, n2, k2 = floats(inside.n, inside.k, outside.n, outside.k)
    over = 1 / (n2 * n2 + k2 * k2)
    return Index((n1 * n2 + k1 * k2) * over, (k1 * n2 - n1 * k2) * over)
