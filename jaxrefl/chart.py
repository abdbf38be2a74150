"""Charts of the hemisphere: coordinates in which the integrand of an albedo is tame, and the rules that go with them.

A rule is a grid on panels (0, 1)^2; a chart says which direction belongs to a point of a panel. Every place where a
reflection model is peaked or kinked is an edge of a panel, and the rule is the double exponential one, whose nodes
crowd exponentially at the edges: it does not mind an infinite slope there and finds a lobe of any width.

    normal    theta from the normal, split at theta_o and at the kinks that the model names; phi from the view, in
              quarters: Oren-Nayar's kinks are edges, the mirror and the retro direction are corners
    mirror    the polar angle from the mirror direction, up to the horizon, split at 90 degrees: Phong's lobe
    half      the polar angle of the half vector from the normal, up to the horizon: Blinn's lobe
    product   Gauss-Legendre in cos theta times the periodic trapezoid in phi: exact for polynomials

The distance to the horizon is known to full relative accuracy in each of them: wi.z is computed from it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from .params import pytree
from .quadrature import double_exponential_nodes, gauss_legendre, spread_points
from .safe import safe_sqrt
from .vec import Vec3

CHARTS = ("normal", "mirror", "half", "product")
LEVELS = (0, 7)
_COLUMNS = ("u", "u_rest", "v", "v_rest", "panel_u", "panel_v", "weight", "coarse", "coarsest")


@pytree
class AlbedoRule:
    """Nodes of a chart and three nested rules on them; the finest is the answer, the others tell its error.

    All arrays are (M,).
    """

    u: Array
    """First coordinate of the panel, (0, 1)."""
    u_rest: Array
    """1 - u, to full relative accuracy."""
    v: Array
    v_rest: Array
    panel_u: Array
    """int32: which panel."""
    panel_v: Array
    weight: Array
    """Weight in the finest rule."""
    coarse: Array
    """Weight in the coarser one, 0 where it has no node."""
    coarsest: Array
    """Weight in the one before that."""
    chart: str = dataclasses.field(metadata={"static": True})
    level: int = dataclasses.field(metadata={"static": True})
    kinks: int = dataclasses.field(default=0, metadata={"static": True})
    """How many kinks of the model have panels."""

    @property
    def evaluations(self) -> int:
        """Evaluations of the model that it takes."""
        return int(self.weight.shape[0])


class Direction(NamedTuple):
    """Direction of a node."""

    wi: Vec3
    solid_angle: Array
    """sr per unit of du dv."""


def albedo_rule(chart: str = "normal", level: int = 3, kinks: int = 0, dtype: Any = None) -> AlbedoRule:
    """Rule for `jaxrefl.albedo.directional_albedo`.

    Args:
        chart: "normal", "mirror", "half" or "product".
        level: 0 to 7; every level has twice the nodes per axis of the one before, and twice as many digits.
        kinks: how many cosines the model names at which it has a kink (chart "normal").
        dtype: of the rule; the default float dtype if None.

    Raises:
        ValueError: another chart, or a level out of its range.
    """
    if chart not in CHARTS:
        raise ValueError(f"chart = {chart!r} must be one of {', '.join(CHARTS)}")
    if not isinstance(level, (int, np.integer)) or not LEVELS[0] <= level <= LEVELS[1]:
        raise ValueError(f"level = {level!r} must be an integer in [{LEVELS[0]}, {LEVELS[1]}]")
    if chart == "product":
        rules = [_product(level - i) for i in range(3)]
        mu, mu_rest, phi, weight = (np.concatenate(columns) for columns in zip(*rules, strict=True))
        which = np.repeat(np.arange(3), [len(columns[0]) for columns in rules])
        zero = np.zeros(len(mu), np.int32)
        table = (mu, mu_rest, phi, 1 - phi, zero, zero, *(np.where(which == i, weight, 0.0) for i in range(3)))
    else:
        x, rest, *weights = double_exponential_nodes(level, dtype)
        panels = ({"normal": 2 + kinks, "mirror": 2, "half": 1}[chart], 4)
        i, j, a, b = (g.ravel() for g in np.indices((*panels, len(x), len(x))))
        table = (x[a], rest[a], x[b], rest[b], i, j, *(w[a] * w[b] for w in weights))
    return _rule(table, dtype, chart, int(level), kinks)


def spread_rule(n: int, dtype: Any = None) -> AlbedoRule:
    """n directions spread evenly over the hemisphere, every one of the same weight: a look at what other rules miss."""
    u, v = spread_points(n)
    k, zero = np.arange(n), np.zeros(n, np.int32)
    weights = (np.where(k < n // part, part / n, 0.0) for part in (1, 2, 4))
    return _rule((u, 1 - u, v, 1 - v, zero, zero, *weights), dtype, "product", 0, 0)


def _rule(table: Sequence[np.ndarray], dtype: Any, chart: str, level: int, kinks: int) -> AlbedoRule:
    types = {name: jnp.int32 if name.startswith("panel") else dtype or float for name in _COLUMNS}
    columns = {name: jnp.asarray(x, types[name]) for name, x in zip(_COLUMNS, table, strict=True)}
    return AlbedoRule(**columns, chart=chart, level=level, kinks=kinks)


def _product(level: int) -> tuple[np.ndarray, ...]:
    """cos theta, 1 - cos theta, phi / 2 pi and weight of a product rule with 4 * 2^level cosines."""
    n = max(1, int(4 * 2**level))
    mu, w = (np.asarray(x, np.float64) for x in gauss_legendre(n))
    i, j = (g.ravel() for g in np.indices((n, 2 * n)))
    return mu[i], mu[::-1][i], (j + 0.5) / (2 * n), w[i] / (2 * n)


def _quarter(v: Array, rest: Array, number: Array) -> tuple[Array, Array]:
    """Cosine and sine of (number + v) 90 degrees, exact at the quarters."""
    c, s = jnp.sin(0.5 * jnp.pi * rest), jnp.sin(0.5 * jnp.pi * v)
    odd, far = number % 2 == 1, number >= 2
    c, s = jnp.where(odd, -s, c), jnp.where(odd, c, s)
    return jnp.where(far, -c, c), jnp.where(far, -s, s)


def direction(rule: AlbedoRule, cos_theta_o: Array, kinks: Array) -> Direction:
    """Direction of ONE node (the leaves of the rule are scalars), for a view in the x-z plane.

    ``kinks`` (k,) are cosines of theta_i.
    """
    chart = {"normal": _normal, "mirror": _mirror, "half": _half, "product": _even}[rule.chart]
    sin_theta_o = safe_sqrt((1 - cos_theta_o) * (1 + cos_theta_o))
    return chart(rule, cos_theta_o, sin_theta_o, kinks)


def _even(rule: AlbedoRule, mu_o: Array, sin_o: Array, kinks: Array) -> Direction:
    phi, sine = 2 * jnp.pi * rule.v, jnp.sqrt(rule.u_rest * (1 + rule.u))
    return Direction(Vec3(sine * jnp.cos(phi), sine * jnp.sin(phi), rule.u), jnp.full_like(rule.u, 2 * jnp.pi))


def _normal(rule: AlbedoRule, mu_o: Array, sin_o: Array, kinks: Array) -> Direction:
    right = jnp.asarray(0.5 * jnp.pi, mu_o.dtype)
    inner = jnp.sort(jnp.append(jnp.arctan2(safe_sqrt((1 - kinks) * (1 + kinks)), kinks), jnp.arctan2(sin_o, mu_o)))
    edges = jnp.concatenate([jnp.zeros(1, mu_o.dtype), inner, right[None]])
    low, high = edges[rule.panel_u], edges[rule.panel_u + 1]
    cosine = jnp.sin((right - high) + (high - low) * rule.u_rest)
    sine = jnp.sin(low + (high - low) * rule.u)
    c, s = _quarter(rule.v, rule.v_rest, rule.panel_v)
    return Direction(Vec3(sine * c, sine * s, cosine), sine * (high - low) * right)


def _mirror(rule: AlbedoRule, mu_o: Array, sin_o: Array, kinks: Array) -> Direction:
    right = jnp.asarray(0.5 * jnp.pi, mu_o.dtype)
    c, s = _quarter(rule.v, rule.v_rest, rule.panel_v)  # c = 1 is toward the normal
    near = jnp.where(c > 0, right, jnp.arctan2(mu_o, -sin_o * c))  # as far as 90 degrees or the horizon
    beyond = jnp.where(c > 0, jnp.arctan2(sin_o * c, mu_o), 0.0)
    first = rule.panel_u == 0
    width = jnp.where(first, near, beyond)
    beta, height = jnp.where(first, 0.0, near) + width * rule.u, jnp.where(first, beyond, 0.0) + width * rule.u_rest
    sine, cosine = jnp.sin(beta), jnp.cos(beta)
    z = jnp.sqrt(mu_o * mu_o + (sin_o * c) ** 2) * jnp.sin(height)
    wi = Vec3(mu_o * c * sine - sin_o * cosine, s * sine, z)
    return Direction(wi, sine * width * right)


def _half(rule: AlbedoRule, mu_o: Array, sin_o: Array, kinks: Array) -> Direction:
    c, s = _quarter(rule.v, rule.v_rest, rule.panel_v)
    horizon = 0.5 * jnp.arctan2(mu_o, -sin_o * c)
    theta = horizon * rule.u
    sine, cosine = jnp.sin(theta), jnp.cos(theta)
    along = sin_o * c * sine + mu_o * cosine  # wo . h
    z = jnp.sqrt(mu_o * mu_o + (sin_o * c) ** 2) * jnp.sin(2 * horizon * rule.u_rest)
    wi = Vec3(2 * along * sine * c - sin_o, 2 * along * sine * s, z)
    return Direction(wi, 4 * along * sine * horizon * (0.5 * jnp.pi))
