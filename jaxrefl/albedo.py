r"""Albedos: integrals of a reflection model over the hemisphere, each with its error.

    hemispherical-directional     rho(wo) = int f(wi, wo) |cos theta_i| dwi + delta parts      ``fixed="view"``
    directional-hemispherical     rho(wi) = int f(wi, wo) |cos theta_o| dwo + delta parts      ``fixed="light"``
    bihemispherical               2 int_0^1 rho(mu) mu dmu

The first is the radiance seen in a uniform environment of radiance 1, the second what becomes of a beam; they are equal
where the model is reciprocal. Value and error come from three nested rules (`jaxrefl.chart`), see `stated_error`: it is
the error of the coarser rule, and by far bounds that of the finest. What no rule can know is a lobe narrower than its
nodes are apart, away from the places where models have theirs (the mirror and the retro direction, the normal, the
horizon, the kinks that a model names), and how many digits the model itself loses.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from .brdf.protocol import BRDF, DELTA_PARTS, chart_of, kinks_of
from .chart import AlbedoRule, albedo_rule, direction
from .params import Interval, checked, require
from .quadrature import Estimate, HemisphereRule, accurate_sum, double_exponential, integrate, outermost
from .safe import safe_divide, safe_sqrt
from .vec import Vec3

PARTS = ("reflected", "transmitted", "both")
FIXED = ("view", "light")
_ROUNDING = 16.0  # of every term, in units of eps
_SHARP = 2.0  # of a direction, in units of eps and of the angle in which the integrand changes


@checked(cos_theta_o="[0, 1]")
def hemispherical_directional_albedo(
    brdf: BRDF, cos_theta_o: Float[ArrayLike, ""], rule: HemisphereRule
) -> Float[Array, "*C"]:
    """Smooth part of rho_hd(wo) by any rule on the hemisphere: the definition, without an error.

    Args:
        brdf: reflection model, f(wi, wo) in 1/sr.
        cos_theta_o: cosine of the direction of view, [0, 1]; the view lies in the x-z plane.
        rule: from `jaxrefl.quadrature.hemisphere_rule`.

    Returns:
        (C,) or scalar: the radiance seen in a uniform environment of radiance 1; > 1 creates energy.

    Differentiable in the model's parameters and, through the model, in cos_theta_o.
    Source: LAMBERT-FRESNEL, rho_hd(omega_o).
    """
    wo = Vec3.from_spherical(cos_theta_o, 0.0)
    return integrate(lambda wi: brdf(wi, wo) * wi.z, rule)


def _cosines(kinks: tuple[Any, ...], dtype: Any) -> Float[Array, " k"]:
    return jnp.stack([jnp.asarray(x, dtype) for x in kinks]) if kinks else jnp.zeros(0, dtype)


def rule_for(brdf: Any, level: int = 3, dtype: Any = None, chart: str | None = None) -> AlbedoRule:
    """Rule that suits a model, by its own declaration."""
    return albedo_rule(chart or chart_of(brdf), level, len(kinks_of(brdf)), dtype)


def check_arguments(
    part: str, fixed: str, cos_theta: Any, brdf: Any = None, rule: AlbedoRule | None = None, many: bool = False
) -> None:
    """Raise `ValueError` for an argument out of its range, or a rule made for another number of kinks."""
    if part not in PARTS:
        raise ValueError(f"part = {part!r} must be one of {', '.join(PARTS)}")
    if fixed not in FIXED:
        raise ValueError(f"fixed = {fixed!r} must be one of {', '.join(FIXED)}")
    require("cos_theta_o", cos_theta, Interval.parse("[0, 1]"))
    if not many and np.ndim(cos_theta):
        raise ValueError(f"cos_theta_o has shape {np.shape(cos_theta)}; it is a scalar, map over it with jax.vmap")
    if rule is not None and rule.chart == "normal":
        panels, kinks = rule.kinks, len(kinks_of(brdf))
        if panels != kinks:
            raise ValueError(f"rule has panels for {panels} kinks, the model has {kinks}; take rule_for(brdf)")


def delta_parts(brdf: Any, cos_theta: Array, part: str) -> Any:
    """Delta parts at an angle."""
    names = {"reflected": DELTA_PARTS[:1], "transmitted": DELTA_PARTS[1:], "both": DELTA_PARTS}[part]
    return sum(getattr(brdf, name)(cos_theta) for name in names if hasattr(brdf, name))


class Sums(NamedTuple):
    """Sums over the nodes of a rule, each (C,) or scalar."""

    fine: Array
    coarse: Array
    coarsest: Array
    magnitude: Array
    """Of the magnitudes of the terms of the finest."""
    square: Array
    """Integral of the square, 1/sr times the square of the albedo."""
    edge: Array
    """Of the magnitudes at the outermost nodes, beyond which nothing is looked at."""


def sums(brdf: Any, cos_theta: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str) -> Sums:
    """Smooth part by the three rules, before anything is said about its error."""
    kinks = _cosines(kinks_of(brdf), cos_theta.dtype)
    sine = safe_sqrt((1 - cos_theta) * (1 + cos_theta))
    c, s = jnp.cos(phi), jnp.sin(phi)
    here = Vec3(sine * c, sine * s, cos_theta)
    sides = {"reflected": (1,), "transmitted": (-1,), "both": (1, -1)}[part]

    def term(node: AlbedoRule) -> tuple[Array, Array]:
        w, solid_angle = direction(node, cos_theta, kinks)
        x, y = w.x * c - w.y * s, w.x * s + w.y * c

        def value(side: int) -> Array:
            there = Vec3(x, y, side * w.z)
            return brdf(there, here) if fixed == "view" else brdf(here, there)

        sent = sum(value(side) for side in sides) * w.z
        return sent * solid_angle, sent * (sent * solid_angle)

    terms, squares = jax.vmap(term)(rule)
    shape = (-1,) + (1,) * (terms.ndim - 1)
    fine, coarse, coarsest = (w.reshape(shape) * terms for w in (rule.weight, rule.coarse, rule.coarsest))
    magnitude, square = jnp.sum(jnp.abs(fine), axis=0), jnp.sum(rule.weight.reshape(shape) * squares, axis=0)
    nearest = functools.reduce(jnp.minimum, (rule.u, rule.u_rest, rule.v, rule.v_rest))
    is_edge = (nearest < 2 * outermost(nearest.dtype)[1]) & (rule.chart != "product")
    edge = jnp.sum(jnp.where(is_edge.reshape(shape), jnp.abs(fine), 0.0), axis=0)
    return Sums(accurate_sum(fine), accurate_sum(coarse), jnp.sum(coarsest, axis=0), magnitude, square, edge)


def rounding(dtype: Any) -> float:
    """Bound on the rounding of a sum, relative to the sum of the magnitudes of its terms."""
    return _ROUNDING * float(jnp.finfo(dtype).eps)


def stated_error(found: Sums, dtype: Any, level: int) -> Array:
    """Error of the finest of three nested rules: what its refinement changed, and what rounding can do.

    A refinement may change little by chance. The one before then tells: a rule that converges exponentially has more
    than twice the digits with each, so that the error is at most (2 before)^2 before, relative to the whole. Rounding
    acts on every term, and on every direction: a lobe that fills a small part of the hemisphere (the square of the
    integral is small beside the integral of the square) changes by more than its direction does. Where two refinements
    change much the same, something jumps inside a panel, and nothing better than twice the larger is said. What lies
    beyond the outermost nodes of an integrand x^(p - 1), p >= 0.1, is less than 2^level / 5 times what they show.
    """
    last, before = abs(found.fine - found.coarse), abs(found.coarse - found.coarsest)
    relative = 2 * safe_divide(before, found.magnitude)
    sharp = _SHARP * float(jnp.finfo(dtype).eps) * safe_sqrt(2 * jnp.pi * found.square)
    rounded = rounding(dtype) * found.magnitude + sharp
    slow = jnp.where(8 * last > before, 2 * jnp.maximum(last, before), 0.0)
    return jnp.maximum(jnp.maximum(last, slow), relative * relative * before) + rounded + 0.2 * 2**level * found.edge


def _estimate(found: Sums, delta: Any, level: int) -> Estimate:
    dtype = found.fine.dtype
    return Estimate(found.fine + delta, stated_error(found, dtype, level) + rounding(dtype) * abs(delta))


def directional_albedo(
    brdf: BRDF,
    cos_theta_o: Float[ArrayLike, ""],
    rule: AlbedoRule,
    *,
    part: str = "reflected",
    fixed: str = "view",
    phi_o: Float[ArrayLike, ""] = 0.0,
) -> Estimate:
    """Directional albedo with its error, delta parts (``mirror``, ``through``) included.

    Args:
        brdf: reflection model, f(wi, wo) in 1/sr; the angle at which it is seen or lit:
        cos_theta_o: cosine of the fixed direction, [0, 1].
        rule: from `rule_for` or `jaxrefl.chart.albedo_rule`; its dtype rules.
        part: "reflected", "transmitted" (wi below the surface) or "both".
        fixed: which direction is held: the "view" (hemispherical-directional) or the "light"
            (directional-hemispherical).
        phi_o: azimuth of the fixed direction from the tangent, radians; of no effect for an isotropic model.

    Returns:
        Estimate(value, error), each (C,) or scalar.

    Raises:
        ValueError: an argument out of its range, or a rule made for another number of kinks.

    Pure: to be jitted, mapped and differentiated, in the model's parameters and, inside (0, 1), in cos_theta_o; at
    0 and at 1 the latter derivative is finite and means nothing.
    """
    check_arguments(part, fixed, cos_theta_o, brdf, rule)
    cos_theta, phi = (jnp.asarray(x, rule.weight.dtype) for x in (cos_theta_o, phi_o))
    return _estimate(sums(brdf, cos_theta, phi, rule, part, fixed), delta_parts(brdf, cos_theta, part), rule.level)


def bihemispherical_albedo(brdf: BRDF, rule: AlbedoRule, *, part: str = "reflected", phi_o: float = 0.0) -> Estimate:
    """Bihemispherical albedo 2 int rho(mu) mu dmu with its error: a double exponential rule over `directional_albedo`.

    Args as there. Of an anisotropic model it is the one of the azimuth phi_o.
    """
    check_arguments(part, "view", 0.5, brdf, rule)
    mu, _, *weights = double_exponential(rule.level, rule.weight.dtype)
    inner = lax.map(lambda mu: directional_albedo(brdf, mu, rule, part=part, phi_o=phi_o), mu)
    shape = (-1,) + (1,) * (inner.value.ndim - 1)
    weights = [(2 * mu * w).reshape(shape) for w in weights]
    fine, coarse, coarsest = (accurate_sum(w * inner.value) for w in weights)
    magnitude = jnp.sum(weights[0] * abs(inner.value), 0)
    whole = _estimate(Sums(fine, coarse, coarsest, magnitude, 0 * magnitude, 0 * magnitude), 0.0, rule.level)
    return Estimate(whole.value, whole.error + jnp.sum(weights[0] * inner.error, 0))
