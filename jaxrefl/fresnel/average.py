"""Cosine-weighted averages of reflectances: 2 int_0^1 R(mu) mu dmu, the reflectance in diffuse light."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array

from ..params import Real, Result, checked, floats

_SWITCH = 2.5  # above this index Walsh's closed form loses less than two digits
_NODES, _NODE_WEIGHTS = (0.5 * (x + s) for x, s in zip(np.polynomial.legendre.leggauss(16), (1.0, 0.0), strict=True))


def _average_small(x: Array) -> Array:
    """Average for 1 <= n <= 2.5 as a function of x = (n - 1)/(n + 1), without cancellation.

    With B = 2 x / (1 + x^2): F_s = x (2 + x) / 3 and F_p = x / (1 - x)^2 times the integral over t from x to 1 of
    ((t - B) / (1 - B t))^2 (1 / t^2 - 1), whose two terms singular at t = 0 are integrated by hand and whose remainder
    is analytic: 16 Gauss-Legendre nodes reach float64. The derivation is in docs/numerics.md.
    """
    b = 2 * x / (1 + x * x)
    b2 = b * b
    nodes, weights = (jnp.asarray(c, x.dtype).reshape((-1,) + (1,) * x.ndim) for c in (_NODES, _NODE_WEIGHTS))
    t = x + (1 - x) * nodes
    smooth = ((1 - 5 * b2 + 3 * b2 * b2) + 2 * b * (1 + b2 - b2 * b2) * t - t * t) / (1 - b * t) ** 2
    remainder = (1 - x) * jnp.sum(weights * smooth, axis=0)
    log_x = jnp.log(jnp.where(x > 0, x, 1.0))
    f_p = x / (1 - x) ** 2 * (4 * x * (1 - x) / (1 + x * x) ** 2 + 2 * b * (1 - b2) * log_x + remainder)
    return 0.5 * (x * (2 + x) / 3 + f_p)


def _average_walsh(m: Array) -> Array:
    """Walsh's closed form in m = 1 / n, in (0, 1)."""
    m2, m4 = m * m, m**4
    return (
        0.5
        + (1 - m) * (3 + m) / (6 * (1 + m) ** 2)
        + (1 - m2) ** 2 / (1 + m2) ** 3 * jnp.log((1 - m) / (1 + m))
        - 2 * m * (1 + 2 * m - m2) / ((1 + m2) * (1 - m4))
        - 8 * m2 * (1 + m4) / ((1 + m2) * (1 - m4) ** 2) * jnp.log(m)
    )


@checked(eta="(0, inf)")
def average_dielectric(eta: Real) -> Result:
    """Cosine-weighted average reflectance 2 int_0^1 R(mu) mu dmu of a dielectric (its albedo in diffuse light).

    External (eta > 1): Walsh's closed form, replaced below eta = 2.5, where that cancels, by an equal integral that
    does not. Internal (eta < 1): 1 - (1 - F(1/eta)) eta^2, by reversal. Full relative accuracy of the dtype up to eta
    -> 1.

    Args:
        eta: relative index n_t / n_i, (0, inf); any shape.

    Raises:
        ValueError: eta outside its range (outside jit only).

    Differentiable; at eta = 1 the average has a kink (slopes -7/3 and 1/3) and the right-hand slope is returned.
    Source: J. W. T. Walsh, 1926; S. Q. Duntley, J. Opt. Soc. Am. 32, 1942; Egan & Hilgeman, 1979.
    """
    (eta,) = floats(eta)
    inside = eta < 1
    m = jnp.where(inside, eta, 1 / jnp.where(inside, 1.0, eta))  # the smaller index over the larger
    small = m > 1 / _SWITCH
    x = jnp.where(inside, 1 - eta, eta - 1) / (1 + eta)
    external = jnp.where(small, _average_small(jnp.where(small, x, 0.0)), _average_walsh(jnp.where(small, 0.25, m)))
    return jnp.where(inside, (1 - eta) * (1 + eta) + external * eta * eta, external)


@checked(f0="[0, inf)", f90="[0, inf)", p="[0, inf)")
def average_schlick(f0: Real, f90: Real = 1.0, p: Real = 5) -> Result:
    """Cosine-weighted average of `schlick`: f0 + 2 (f90 - f0) / ((p + 1) (p + 2)), f0 + (1 - f0)/21 for p = 5."""
    f0, f90, p = floats(f0, f90, p)
    return f0 + 2 * (f90 - f0) / ((p + 1) * (p + 2))


@checked(r0="[0, inf)", m="(-inf, inf)", p="[0, inf)")
def average_d3d9(r0: Real, m: Real, p: Real) -> Result:
    """Cosine-weighted average of `d3d9`: r0 + 2 m / ((p + 1) (p + 2))."""
    r0, m, p = floats(r0, m, p)
    return r0 + 2 * m / ((p + 1) * (p + 2))
