"""Evaluators of section C: Schlick's family against the exact equations, with its extrema and fits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from .. import d3d9, fresnel
from ..quadrature import Rule, cosine_rule, integrate, uniform_cosine_rule, uniform_theta_rule
from .numerics import NODES, extrema, minimum
from .table import Columns, evaluates

RULES = {"theta": uniform_theta_rule, "mu": uniform_cosine_rule, "cos": cosine_rule}


def _cos_deg(angle: Array) -> Array:
    return jnp.cos(jnp.deg2rad(angle))


def _rms(error: Callable[[Any], Array], rule: Rule | None = None) -> Array:
    """Root mean square of error(cos theta) over a rule, uniform in theta if None."""
    return jnp.sqrt(integrate(lambda mu: error(mu) ** 2, uniform_theta_rule(NODES) if rule is None else rule))


@evaluates("C.schlick_dielectric", "n")
def _schlick_dielectric(c: Columns) -> dict[str, Array]:
    n = c["n"]

    def error(mu: Any) -> Array:
        return fresnel.schlick_dielectric(mu, n) - fresnel.dielectric(mu, n)

    high, low = extrema(error)
    over, under = error(_cos_deg(high)), error(_cos_deg(low))
    return {
        "F0": fresnel.f0_dielectric(n),
        "err_max": over,
        "at_deg": high,
        "err_min": under,
        "at_deg2": low,
        "max_abs": jnp.maximum(jnp.abs(over), jnp.abs(under)),
        "rms_theta": _rms(error),
    }


@evaluates("C.schlick_conductor", "metal@nm eta k")
def _schlick_conductor(c: Columns) -> dict[str, Array]:
    eta, k = c["eta"], c["k"]
    f0, f82 = fresnel.f0_conductor(eta, k), fresnel.conductor(1 / 7, eta, k)
    tint = f82 / fresnel.schlick(1 / 7, f0)

    def exact(mu: Any) -> Array:
        return fresnel.conductor(mu, eta, k)

    def schlick(mu: Any) -> Array:
        return fresnel.schlick(mu, f0) - exact(mu)

    def tinted(mu: Any) -> Array:
        return fresnel.f82_tint(mu, f0, tint) - exact(mu)

    def dip(mu: Any, exponent: Any) -> Array:
        return fresnel.lazanyi(mu, f0, 0.0, exponent) - fresnel.lazanyi(mu, f0, 1.0, exponent)

    rule = uniform_theta_rule(NODES)

    def depth(exponent: Any) -> Array:  # the a of least squares, which is linear
        square = integrate(lambda mu: dip(mu, exponent) ** 2, rule)
        return integrate(lambda mu: schlick(mu) * dip(mu, exponent), rule) / square

    def lazanyi_rms(exponent: Any) -> Array:
        a = depth(exponent)
        return _rms(lambda mu: fresnel.lazanyi(mu, f0, a, exponent) - exact(mu))

    exponent = minimum(lazanyi_rms, jnp.linspace(1.0, 20.0, 39))
    high, low = extrema(schlick)
    high82, low82 = extrema(tinted)
    return {
        "F0": f0,
        "schlick_err_max": schlick(_cos_deg(high)),
        "at_deg": high,
        "schlick_err_min": schlick(_cos_deg(low)),
        "at_deg2": low,
        "schlick_rms": _rms(schlick),
        "F82": f82,
        "F82_tint": tint,
        "a_F82": (fresnel.schlick(0.5, f0) - fresnel.f82_tint(0.5, f0, tint)) * 2**7,
        "F82fit_err_max": tinted(_cos_deg(high82)),
        "F82fit_err_min": tinted(_cos_deg(low82)),
        "F82fit_rms": _rms(tinted),
        "LSK_a": depth(exponent),
        "LSK_alpha": exponent,
        "LSK_rms": lazanyi_rms(exponent),
    }


@evaluates("C.gulbrandsen", "r g")
def _gulbrandsen(c: Columns) -> dict[str, Array]:
    r, g = c["r"], c["g"]
    eta, k = fresnel.gulbrandsen(r, g)
    return {
        "n_min": fresnel.gulbrandsen(r, 1.0)[0],
        "n_max": fresnel.gulbrandsen(r, 0.0)[0],
        "n": eta,
        "k2": k * k,
        "k": k,
        "F0_check": fresnel.f0_conductor(eta, k),
        "R60": fresnel.conductor(0.5, eta, k),
        "R80": fresnel.conductor(np.sin(np.deg2rad(10.0)), eta, k),
    }


@evaluates("C.gulbrandsen_inverse", "metal@nm")
def _gulbrandsen_inverse(c: Columns) -> dict[str, Array]:
    r, g = fresnel.gulbrandsen_inverse(c["eta"], c["k"])
    return {"r": r, "g": g}


@evaluates(
    "C.d3d9_fit",
    "n metric",
    skipped={"max_abs_err_at_nodes": "a maximum over the nodes of one rule, of five digits"},
    jit=False,
)
def _d3d9_fit(c: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    @jax.jit
    def schlick5(n: Array, rule: Rule) -> Array:
        return _rms(lambda mu: fresnel.schlick_dielectric(mu, n) - fresnel.dielectric(mu, n), rule)

    rows = []
    for n, metric in zip(c["n"], c["metric"], strict=True):
        rule = RULES[metric](NODES)
        free, p_only = d3d9.best_fit(n, rule), d3d9.best_fit(n, rule, free_multiplier=False)
        rows.append((free.r0, free.p, free.m, free.rms, free.r0 + free.m, p_only.p, p_only.rms, schlick5(n, rule)))
    names = "R0", "p", "m", "rms", "R0+m", "p_only", "rms_p_only", "rms_schlick5"
    return dict(zip(names, np.asarray(rows).T, strict=True))


@evaluates("C.schlick_internal", "n theta_deg")
def _schlick_internal(c: Columns) -> dict[str, Array]:
    mu, eta = c["cos_theta"], 1 / c["n"]
    return {
        "R_exact": fresnel.dielectric(mu, eta),
        "schlick_theta_i": fresnel.schlick(mu, fresnel.f0_dielectric(eta)),
        "schlick_theta_t": fresnel.schlick_dielectric(mu, eta),
    }


@evaluates("C.d3d9_eq3", "n p theta_deg")
def _d3d9_equation_3(c: Columns) -> dict[str, Array]:
    r0 = fresnel.f0_dielectric(c["n"])
    return {"R": fresnel.d3d9(c["cos_theta"], r0, 1 - r0, c["p"])}
