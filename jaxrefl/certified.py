"""Albedos to a tolerance: the loop over rules, which stands outside of `jit`."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from .albedo import chart_of, check_arguments, delta_parts, rounding, rule_for, sums
from .brdf.protocol import BRDF
from .chart import LEVELS, AlbedoRule
from .params import Interval, foreign_classes, require

_CHUNK = 8192  # nodes handed over at a time: one size, one compilation per model and chart
_FIRST = 2  # level to begin with
_SECOND = {"normal": "half", "mirror": "normal", "half": "normal", "product": "normal"}


class Certified(NamedTuple):
    """Directional albedo to a tolerance."""

    value: np.ndarray
    """(C,) or scalar."""
    error: np.ndarray
    """Bound on its error; likewise."""
    converged: bool
    """Whether the error is within rtol; False: the budget ended first."""
    chart: str
    """Rule that gave the value."""
    level: int
    confirmed_by: str
    """Chart of the second rule, with other nodes, that agrees within the errors of both; "" if it was not asked."""
    evaluations: int
    """Evaluations of the model, of all rules together."""


@functools.partial(jax.jit, static_argnames=("part", "fixed", "classes"))
def _partial_sums(
    brdf: Any, cos_theta: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str, classes: Any
) -> Any:
    return sums(brdf, cos_theta, phi, rule, part, fixed)


def _whole(brdf: Any, cos_theta: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str) -> tuple[Any, Any]:
    """Value of the smooth part by a rule and its error, chunk by chunk, added exactly."""
    n = rule.evaluations
    filled = jax.tree.map(lambda x: np.resize(np.asarray(x), math.ceil(n / _CHUNK) * _CHUNK), rule)
    weightless = np.arange(filled.weight.size) >= n
    filled = dataclasses.replace(
        filled, weight=np.where(weightless, 0, filled.weight), coarse=np.where(weightless, 0, filled.coarse), level=0
    )
    parts, classes = [], foreign_classes(brdf)
    for first in range(0, n, _CHUNK):
        chunk = jax.tree.map(lambda x, first=first: jnp.asarray(x[first : first + _CHUNK]), filled)
        parts.append([np.asarray(x) for x in _partial_sums(brdf, cos_theta, phi, chunk, part, fixed, classes)])
    fine, coarse, magnitude = (
        np.apply_along_axis(math.fsum, 0, np.stack(column)) for column in zip(*parts, strict=True)
    )
    return fine, abs(fine - coarse) + rounding(rule.weight.dtype) * magnitude


def albedo_to(
    brdf: BRDF,
    cos_theta_o: float,
    rtol: float = 1e-10,
    budget: int = 4_000_000,
    *,
    part: str = "reflected",
    fixed: str = "view",
    phi_o: float = 0.0,
    chart: str | None = None,
) -> Certified:
    """Directional albedo to a relative tolerance: the rule grows until it is met, and a second one must agree.

    Args:
        brdf, cos_theta_o, part, fixed, phi_o: as in `jaxrefl.albedo.directional_albedo`.
        rtol: tolerance of every channel, relative; at least 64 eps of the default float dtype.
        budget: largest number of evaluations of the model, >= 1000.
        chart: of the first rule; the model's own if None.

    Returns:
        Certified: value, error, and how they came about. If the budget ends first ``converged`` is False, and the error
        is what was reached, or the disagreement of the two rules if that is larger.

    Raises:
        ValueError: an argument out of its range; an rtol that the dtype cannot hold.

    Runs on the host; not differentiable (use `directional_albedo` with the rule that it names).
    """
    eps = float(jnp.finfo(float).eps)
    require("budget", budget, Interval.parse("[1000, inf)"))
    if not 64 * eps <= rtol <= 1:
        dtype = jnp.zeros(0).dtype
        raise ValueError(f"rtol = {rtol} is outside [{64 * eps:.1e}, 1], what {dtype} can hold")
    check_arguments(part, fixed, cos_theta_o)
    mu, phi = jnp.asarray(cos_theta_o, float), jnp.asarray(phi_o, float)
    first = chart or chart_of(brdf)
    delta = np.asarray(delta_parts(brdf, mu, part))
    delta_error = rounding(mu.dtype) * abs(delta)
    spent, found = 0, {}

    def refine(name: str, level: int) -> bool:
        nonlocal spent
        rule = rule_for(brdf, level, chart=name)
        cost = rule.evaluations * (2 if part == "both" else 1)
        if spent + cost > budget:
            return False
        value, error = _whole(brdf, mu, phi, rule, part, fixed)
        spent += cost
        found[name] = (value + delta, error + delta_error, level)
        return True

    def is_met(name: str) -> bool:
        value, error, _ = found[name]
        return bool(np.all(error <= rtol * abs(value)))

    other, agrees = _SECOND[first], False
    for level in range(_FIRST, LEVELS[1] + 1):
        if not refine(first, level):
            break
        if is_met(first) and refine(other, min(level, 4)):
            gap = abs(found[first][0] - found[other][0])
            agrees = bool(np.all(gap <= found[first][1] + found[other][1]))
            if agrees:
                break
    if first not in found:
        raise ValueError(f"budget = {budget} is less than one rule takes; the smallest has 1000 nodes or so")
    value, error, level = found[first]
    if other in found and not agrees:
        error = np.maximum(error, abs(value - found[other][0]))
    converged = bool(np.all(error <= rtol * abs(value)))
    return Certified(value, error, converged, first, level, other if agrees else "", spent)
