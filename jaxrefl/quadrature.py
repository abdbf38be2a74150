r"""Nodes and weights: on an interval, in the cosine, on the hemisphere; and the Lambertian pi by each of them.

A rule is data (two arrays), built on the host in float64 and cast to the dtype asked for; an integral is
`integrate(f, rule)`, a weighted sum that can be jitted, differentiated and mapped. Which rule suits which integrand:

* `hemisphere_rule`: Gauss-Legendre in cos theta times the periodic trapezoid in phi; exact for polynomials.
* `cosine_rule`, `uniform_cosine_rule`, `uniform_theta_rule`: averages over cos theta with the density 2 mu dmu, dmu,
dtheta.
* `gauss_legendre`, `midpoint`, `trapezoid`, `simpson`: an interval.
* `double_exponential`: (0, 1), for any behaviour at the ends, nested; the hemisphere by it is `jaxrefl.chart`.
* `monte_carlo`, `quasi_monte_carlo`: random and well spread directions, with the standard error of the estimate.
"""

from __future__ import annotations

import decimal
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jaxtyping import Float

from .safe import safe_sqrt
from .vec import Vec3


class Rule(NamedTuple):
    """Nodes (n,) and weights (n,): the integral of f is the sum of weight * f(node)."""

    node: Array
    weight: Array


class HemisphereRule(NamedTuple):
    """Unit directions wi with wi.z >= 0, shape (n,), and solid-angle weights (n,) in steradians, summing to 2 pi."""

    wi: Vec3
    weight: Array


class NestedRule(NamedTuple):
    """Nodes in (0, 1) and the weights (n,) of three rules on them."""

    node: Array
    rest: Array
    """1 - node, to full relative accuracy."""
    weight: Array
    coarse: Array
    """Weights of the coarser rule, which has every other node; 0 at the others."""
    coarsest: Array
    """Weights of the one with every fourth node."""


class Estimate(NamedTuple):
    """Value of an integral and its error: a bound for a nested rule, a standard error (1 sigma) for Monte Carlo."""

    value: Array
    error: Array


def _positive(name: str, n: int, least: int = 1) -> int:
    if not isinstance(n, (int, np.integer)) or n < least:
        raise ValueError(f"{name} = {n!r} must be an integer in [{least}, inf)")
    return int(n)


def _rule(node: np.ndarray, weight: np.ndarray, dtype: Any) -> Rule:
    return Rule(jnp.asarray(node, dtype=dtype or float), jnp.asarray(weight, dtype=dtype or float))


@functools.cache
def _legendre_unit(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1], correctly rounded.

    NumPy's are off by a few units of 1e-15 in the weights, which a sum shows. One Newton step on P_n in 40-digit
    decimal arithmetic, from NumPy's nodes, takes them to 30 digits; the rule is symmetric, so half of them is enough.
    """
    node, weight = np.empty(n), np.empty(n)
    with decimal.localcontext() as context:
        context.prec = 40
        for i, start in enumerate(np.polynomial.legendre.leggauss(n)[0][: (n + 1) // 2]):
            x = decimal.Decimal(float(start)) if 2 * i + 1 < n else decimal.Decimal(0)
            for _ in range(2):  # the second pass only evaluates the slope at the corrected node
                before, here = decimal.Decimal(1), x
                for j in range(2, n + 1):
                    before, here = here, ((2 * j - 1) * x * here - (j - 1) * before) / j
                slope = n * (before - x * here) / (1 - x * x)
                x -= here / slope
            node[i], node[n - 1 - i] = float((1 + x) / 2), float((1 - x) / 2)
            weight[i] = weight[n - 1 - i] = float(1 / ((1 - x * x) * slope * slope))
    return node, weight


def _legendre(n: int, a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    node, weight = _legendre_unit(_positive("n", n))
    return a + (b - a) * node, (b - a) * weight


def gauss_legendre(n: int, a: float = 0.0, b: float = 1.0, dtype: Any = None) -> Rule:
    """Gauss-Legendre rule with n nodes on [a, b]: exact for polynomials up to degree 2 n - 1."""
    return _rule(*_legendre(n, a, b), dtype)


def midpoint(n: int, a: float = 0.0, b: float = 1.0, dtype: Any = None) -> Rule:
    """Midpoint rule with n panels on [a, b]; error O(n^-2)."""
    n = _positive("n", n)
    return _rule(a + (b - a) * (np.arange(n) + 0.5) / n, np.full(n, (b - a) / n), dtype)


def trapezoid(n: int, a: float = 0.0, b: float = 1.0, dtype: Any = None) -> Rule:
    """Trapezoid rule with n panels (n + 1 nodes) on [a, b]; error O(n^-2), spectral for a periodic integrand."""
    n = _positive("n", n)
    weight = np.full(n + 1, (b - a) / n)
    weight[[0, -1]] *= 0.5
    return _rule(np.linspace(a, b, n + 1), weight, dtype)


def simpson(n: int, a: float = 0.0, b: float = 1.0, dtype: Any = None) -> Rule:
    """Simpson's rule with n panels (n even, n + 1 nodes) on [a, b]; error O(n^-4)."""
    if _positive("n", n, 2) % 2:
        raise ValueError(f"n = {n!r} must be an even integer in [2, inf)")
    weight = np.where(np.arange(n + 1) % 2, 4.0, 2.0) * (b - a) / (3 * n)
    weight[[0, -1]] *= 0.5
    return _rule(np.linspace(a, b, n + 1), weight, dtype)


def outermost(dtype: Any = None) -> tuple[float, float]:
    """Place t of the outermost node of `double_exponential`, and its distance from the end: 3e-23, in float32 2e-14."""
    t = 3.5 if jnp.finfo(jax.dtypes.canonicalize_dtype(dtype or float)).bits == 64 else 3.0
    return t, math.exp(-math.pi * math.sinh(t))


def double_exponential_nodes(level: int, dtype: Any = None) -> tuple[np.ndarray, ...]:
    """Columns of `double_exponential`, on the host in float64."""
    step = 2.0 ** -_positive("level", level, 0)
    reach = math.floor(outermost(dtype)[0] / step)
    k = np.arange(-reach, reach + 1)
    node, rest = (1 / (1 + np.exp(sign * np.pi * np.sinh(k * step))) for sign in (-1, 1))
    weight = step * np.pi * np.cosh(k * step) * node * rest
    return node, rest, weight, *(np.where(k % every == 0, every * weight, 0.0) for every in (2, 4))


def double_exponential(level: int, dtype: Any = None) -> NestedRule:
    """Tanh-sinh rule on (0, 1) with step 2^-level, and those with two and four times the step on the same nodes.

    The nodes crowd exponentially at both ends: it converges exponentially for any integrand that is analytic inside,
    whatever power or logarithm it has at an end, but for what lies beyond the outermost node. Source: Takahasi and
    Mori 1974.
    """
    return NestedRule(*(jnp.asarray(column, dtype or float) for column in double_exponential_nodes(level, dtype)))


def cosine_rule(n: int, dtype: Any = None) -> Rule:
    """Average over the cosine-weighted hemisphere, density 2 mu dmu on [0, 1]; the weights sum to 1.

    Exact for polynomials in mu up to degree 2 n - 2. The average of a reflectance over it is its diffuse albedo.
    """
    mu, w = _legendre(n, 0.0, 1.0)
    return _rule(mu, 2 * mu * w, dtype)


def uniform_cosine_rule(n: int, dtype: Any = None) -> Rule:
    """Average over mu = cos theta uniform on [0, 1]; the weights sum to 1."""
    return gauss_legendre(n, dtype=dtype)


def uniform_theta_rule(n: int, dtype: Any = None) -> Rule:
    """Average over theta uniform on [0, pi/2], with nodes cos theta; the weights sum to 1."""
    theta, w = _legendre(n, 0.0, 0.5 * np.pi)
    return _rule(np.cos(theta), w / (0.5 * np.pi), dtype)


def hemisphere_rule(n_theta: int, n_phi: int, dtype: Any = None) -> HemisphereRule:
    """Product rule on the hemisphere: Gauss-Legendre in cos theta, periodic trapezoid in phi.

    Exact for f = mu^j cos(m phi), cos theta-polynomials up to degree 2 n_theta - 1 and |m| < n_phi.

    Args:
        n_theta, n_phi: number of nodes in each, >= 1.
        dtype: of the rule; the default float dtype if None.

    Returns:
        HemisphereRule of n_theta * n_phi directions.

    Raises:
        ValueError: a count below 1.
    """
    mu, w = _legendre(_positive("n_theta", n_theta), 0.0, 1.0)
    phi = 2 * np.pi * (np.arange(_positive("n_phi", n_phi)) + 0.5) / n_phi
    mu, phi = (x.ravel() for x in np.meshgrid(mu, phi, indexing="ij"))
    sin, weight = np.sqrt((1 - mu) * (1 + mu)), np.repeat(w * (2 * np.pi / n_phi), n_phi)
    columns = (sin * np.cos(phi), sin * np.sin(phi), mu, weight)
    *wi, weights = (jnp.asarray(column, dtype=dtype or float) for column in columns)
    return HemisphereRule(Vec3(*wi), weights)


def _two_sum(left: tuple[Array, Array], right: tuple[Array, Array]) -> tuple[Array, Array]:
    """Sum of two numbers, each with its error so far: the rounding error of the addition itself is exact."""
    (a, error_a), (b, error_b) = left, right
    total = a + b
    part_b = total - a
    return total, error_a + error_b + ((a - (total - part_b)) + (b - part_b))


@jax.custom_jvp
def accurate_sum(terms: Float[Array, "n ..."]) -> Float[Array, "..."]:
    """Sum over the first axis with the rounding error of every addition carried along and added at the end.

    As accurate as if summed in twice the precision and rounded once; the derivative is that of a plain sum. It is what
    lets an integral be right to the last digit however many nodes it has.
    """
    zero = jnp.zeros((), terms.dtype)
    total, error = lax.reduce((terms, jnp.zeros_like(terms)), (zero, zero), _two_sum, (0,))
    return jnp.where(jnp.isfinite(total), total + error, total)


@accurate_sum.defjvp
def _accurate_sum_jvp(primals: tuple[Array], tangents: tuple[Array]) -> tuple[Array, Array]:
    return accurate_sum(*primals), jnp.sum(tangents[0], axis=0)


def integrate(f: Callable[[Any], Array], rule: Rule | HemisphereRule) -> Array:
    """Weighted sum of f over the nodes of a rule, by `accurate_sum`; f maps ONE node (or direction) to any shape."""
    values = jax.vmap(f)(rule[0])
    return accurate_sum(rule.weight.reshape(rule.weight.shape + (1,) * (values.ndim - 1)) * values)


def monte_carlo(f: Callable[[Vec3], Array], key: Array, n: int) -> Estimate:
    """Integral of f over the hemisphere from n uniform random directions, with its standard error.

    Args:
        f: maps ONE unit direction (Vec3, z >= 0) to an array of any shape.
        key: JAX random key.
        n: number of samples, >= 2.

    Returns:
        Estimate(value, error): the mean of 2 pi f and its sigma, sqrt(sample variance / n).
    """
    u = jax.random.uniform(key, (2, _positive("n", n, 2)))
    wi = Vec3.from_spherical(u[0], 2 * jnp.pi * u[1])
    values = 2 * jnp.pi * jax.vmap(f)(wi)
    return Estimate(values.mean(axis=0), safe_sqrt(values.var(axis=0, ddof=1) / n))


def spread_points(n: int) -> np.ndarray:
    """Points (2, n) spread evenly over the unit square: multiples of (1/g, 1/g^2), g^3 = g + 1, modulo 1."""
    g = 1.324717957244746
    return np.outer([1 / g, 1 / g**2], np.arange(n)) % 1


def quasi_monte_carlo(f: Callable[[Vec3], Array], key: Array, n: int, shifts: int = 16) -> Estimate:
    """Integral of f over the hemisphere from n directions spread evenly, in ``shifts`` randomly displaced copies.

    The points are `spread_points`, each copy displaced at random, which makes the mean unbiased and its standard error
    known. Arguments as for `monte_carlo`; n is rounded down to a multiple of ``shifts``.
    """
    each = _positive("n", n, _positive("shifts", shifts, 2)) // shifts
    lattice = jnp.asarray(spread_points(each), float)
    u = (lattice[:, None] + jax.random.uniform(key, (2, shifts, 1))) % 1
    wi = Vec3.from_spherical(u[0].ravel(), 2 * jnp.pi * u[1].ravel())
    values = 2 * jnp.pi * jax.vmap(f)(wi)
    means = values.reshape(shifts, each, *values.shape[1:]).mean(axis=1)
    return Estimate(means.mean(axis=0), safe_sqrt(means.var(axis=0, ddof=1) / shifts))


def cosine_integral(rule: HemisphereRule | None = None) -> Float[Array, ""]:
    """Integral of cos theta over the hemisphere: the Lambertian pi, by a product rule (8 x 16 nodes if None).

    Source: LAMBERT-FRESNEL, the integral of |cos theta_i| over H^2.
    """
    return integrate(lambda wi: wi.z, hemisphere_rule(8, 16) if rule is None else rule)


def cosine_integral_1d(rule: Rule | None = None) -> Float[Array, ""]:
    """The Lambertian pi as pi int sin(2 theta) dtheta over [0, pi/2], by a rule on [0, 1] scaled to that interval.

    The rule is 16 Gauss-Legendre nodes if None.

    Source: LAMBERT-FRESNEL, the identity sin 2 theta = 2 sin theta cos theta.
    """
    rule = gauss_legendre(16) if rule is None else rule
    return jnp.pi * integrate(lambda t: 0.5 * jnp.pi * jnp.sin(jnp.pi * t), rule)


def cosine_integral_mc(key: Array, n: int) -> Estimate:
    """The Lambertian pi by Monte Carlo over n uniform directions; the exact sigma is pi / sqrt(3 n)."""
    return monte_carlo(lambda wi: wi.z, key, n)
