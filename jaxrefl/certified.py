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

from .albedo import Sums, check_arguments, delta_parts, rounding, rule_for, stated_error, sums
from .brdf.function import as_model
from .brdf.protocol import BRDF, chart_of
from .chart import CHARTS, LEVELS, AlbedoRule, spread_rule
from .params import Interval, foreign_classes, require, validate

_CHUNK = 8192  # nodes handed over at a time: one size, one compilation per model and chart
_FIRST = 3  # level to begin with; on the one before, a coincidence of rules that are all wrong is not rare
_SPREAD = 65536  # directions that look for what the rules miss
_SIGMAS = 6  # that the mean over these may be off, by the variance that the rule knows of
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
    """Chart of the second rule, with other nodes, that agrees within the errors of both, as do directions that are
    spread evenly; "" if they were not asked or do not."""
    evaluations: int
    """Evaluations of the model, of all rules together."""


class _Smooth(NamedTuple):
    """Smooth part of an albedo by one rule, each (C,) or scalar."""

    value: np.ndarray
    error: np.ndarray
    spread: np.ndarray
    """Standard deviation of one random direction."""
    level: int


def _gap(a: _Smooth, b: _Smooth) -> np.ndarray:
    """Disagreement of two rules, 0 where it is within the errors of both."""
    gap = abs(a.value - b.value)
    return np.where(gap <= a.error + b.error, 0.0, gap)


@functools.partial(jax.jit, static_argnames=("part", "fixed", "classes"))
def _partial_sums(
    brdf: Any, cos_theta: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str, classes: Any
) -> Any:
    return sums(brdf, cos_theta, phi, rule, part, fixed)


def _whole(brdf: Any, cos_theta: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str) -> _Smooth:
    """Smooth part by a rule, chunk by chunk, added exactly."""
    n = rule.evaluations
    filled = jax.tree.map(lambda x: np.resize(np.asarray(x), math.ceil(n / _CHUNK) * _CHUNK), rule)
    weightless = np.arange(filled.weight.size) >= n
    filled = dataclasses.replace(
        filled,
        level=0,
        **{name: np.where(weightless, 0, getattr(filled, name)) for name in ("weight", "coarse", "coarsest")},
    )
    parts, classes = [], foreign_classes(brdf)
    for first in range(0, n, _CHUNK):
        chunk = jax.tree.map(lambda x, first=first: jnp.asarray(x[first : first + _CHUNK]), filled)
        parts.append([np.asarray(x) for x in _partial_sums(brdf, cos_theta, phi, chunk, part, fixed, classes)])
    totals: Any = [np.apply_along_axis(math.fsum, 0, np.stack(column)) for column in zip(*parts, strict=True)]
    found = Sums(*totals)
    spread = np.sqrt(np.maximum(2 * np.pi * found.square - found.fine**2, 0.0))
    return _Smooth(totals[0], np.asarray(stated_error(found, rule.weight.dtype, rule.level)), spread, rule.level)


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
    """Directional albedo to a relative tolerance: the rule grows until it is met, and others must agree.

    Args:
        brdf, cos_theta_o, part, fixed, phi_o: as in `jaxrefl.albedo.directional_albedo`.
        rtol: tolerance of every channel, relative; at least 64 eps of the default float dtype.
        budget: largest number of evaluations of the model, >= 1000.
        chart: of the first rule; the model's own if None.

    Returns:
        Certified: value, error, and how they came about. If the budget ends first ``converged`` is False, and the error
        is what was reached, or the disagreement of the rules if that is larger.

    Raises:
        ValueError: an argument or a parameter of the model out of its range; an rtol that the dtype cannot hold.

    Runs on the host; not differentiable (use `directional_albedo` with the rule that it names). What can hide from all
    rules is a glint of less than 1 % of the albedo and a degree across, away from where the charts have their edges.
    """
    dtype = jax.dtypes.canonicalize_dtype(float)
    eps = float(jnp.finfo(dtype).eps)
    require("budget", budget, Interval.parse("[1000, inf)"))
    if not 64 * eps <= rtol <= 1:
        raise ValueError(f"rtol = {rtol} is outside [{64 * eps:.1e}, 1], what {dtype} can hold")
    check_arguments(part, fixed, cos_theta_o)
    validate(brdf)
    brdf = as_model(brdf)
    mu, phi = jnp.asarray(cos_theta_o, float), jnp.asarray(phi_o, float)
    first = chart or chart_of(brdf)
    if first not in CHARTS:
        raise ValueError(f"chart = {first!r} must be one of {', '.join(CHARTS)}")
    delta = np.asarray(delta_parts(brdf, mu, part))
    delta_error = rounding(mu.dtype) * abs(delta)
    spent, second = 0, _SECOND[first]
    best: _Smooth | None = None
    gap: np.ndarray | None = None  # None: the others were not asked

    @functools.cache
    def evaluated(name: str, level: int) -> _Smooth | None:
        nonlocal spent
        rule = rule_for(brdf, level, chart=name) if name else spread_rule(_SPREAD)
        cost = rule.evaluations * (2 if part == "both" else 1)
        if spent + cost > budget:
            return None
        spent += cost
        return _whole(brdf, mu, phi, rule, part, fixed)

    def is_met(error: np.ndarray, value: np.ndarray) -> bool:
        return bool(np.all(error <= rtol * abs(value)))

    for level in range(_FIRST, LEVELS[1] + 1):
        finer = evaluated(first, level)
        if finer is None:
            break
        best, gap = finer, None
        if is_met(best.error + delta_error, best.value + delta):
            other, spread = evaluated(second, min(level, 4)), evaluated("", 0)
            if other is None or spread is None:
                break
            known = spread._replace(error=_SIGMAS * best.spread / math.sqrt(_SPREAD))
            gap = np.maximum(_gap(best, other), _gap(best, known))
            if not np.any(gap):
                break
    if best is None:
        raise ValueError(f"budget = {budget} is less than one rule takes; the smallest has 10000 nodes or so")
    value, error = best.value + delta, best.error + delta_error
    if gap is not None:
        error = np.maximum(error, gap)
    confirmed = gap is not None and not np.any(gap)
    return Certified(value, error, is_met(error, value), first, best.level, second if confirmed else "", spent)
