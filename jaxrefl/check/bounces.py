"""Evaluators of section H: the bounce series, convex and additive, and the series inside a glass sphere."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from .. import fresnel, series
from .table import Columns, evaluates

ALPHA, COLOR = (0.5, 0.8, 0.3, 0.9, 0.6), (0.2, 0.9, 0.4, 0.7, 0.1)  # the example, of which the table holds three rows
EXAMPLE = f"alpha={ALPHA}, c={COLOR}"


def _pixel(color: Array, alpha: Array) -> Array:
    return series.iterative(series.convex(color, alpha)).radiance


@evaluates(
    "H.series",
    "i alpha c",
    given=EXAMPLE,
    derivatives="dcb_dalpha dcb_dc",
    skipped={"recursive_equals_iterative": "a verdict on the table, not a number"},
)
def _series(c: Columns) -> dict[str, Array]:
    color, alpha, i = jnp.array(COLOR), jnp.array(ALPHA), c["i"].astype(int)
    layers = series.convex(color, alpha)
    whole = series.iterative(layers)
    d_color, d_alpha = jax.grad(_pixel, (0, 1))(color, alpha)
    return {
        "w": series.iterative(series.additive(color, alpha)).weights[i],
        "weight": whole.weights[i],
        "tail_c^i": series.recursive(layers)[i],
        "dcb_dalpha": d_alpha[i],
        "dcb_dc": d_color[i],
        "c_b": whole.radiance,
        "remaining_weight": whole.remainder,
        "c_b_last_alpha_zero": series.iterative(series.convex(color, alpha, fold=True)).radiance,
    }


@evaluates("H.hessian", "j k", given=EXAMPLE, derivatives="value")
def _hessian(c: Columns) -> dict[str, Array]:
    second = jax.hessian(_pixel, 1)(jnp.array(COLOR), jnp.array(ALPHA))
    return {"value": second[c["j"].astype(int), c["k"].astype(int)]}


@evaluates("H.constant", "alpha c N", derivatives="dcb_dalpha_total")
def _constant(c: Columns) -> dict[str, Array]:
    n, row, layers = c["N"].astype(int), jnp.arange(c["N"].size), jnp.ones((101, 1))  # N is at most 100

    def truncated(alpha: Array) -> Array:
        return series.iterative(series.convex(layers * c["c"], layers * alpha)).partial[n, row]

    return {
        "c_b": truncated(c["alpha"]),
        "truncation": series.truncation_bound(n, c["alpha"], c["c"]),  # type: ignore[arg-type]  # one N per row
        "dcb_dalpha_total": jax.grad(lambda alpha: jnp.sum(truncated(alpha)))(c["alpha"]),
    }


@evaluates(
    "H.jhu",
    given="I_local=(0.6, 0.3, 0.8), k_rg=(0.5, 0.2, 0)",
    derivatives="dI_dkr1 dI_dkr2 dI_dIlocal1 dI_dIlocal2 dI_dIlocal3",
)
def _jhu(_: Columns) -> dict[str, Array]:
    local, k = jnp.array([0.6, 0.3, 0.8]), jnp.array([0.5, 0.2, 0.0])
    additive, convex = series.additive(local, k), series.convex(local, k)
    d_local, d_k = jax.grad(lambda *args: series.iterative(series.additive(*args)).radiance, (0, 1))(local, k)
    needed = additive.local * additive.color / convex.local
    return {
        "additive": series.iterative(additive).radiance,
        "convex": series.iterative(convex).radiance,
        "dI_dkr1": d_k[0],
        "dI_dkr2": d_k[1],
        "dI_dIlocal1": d_local[0],
        "dI_dIlocal2": d_local[1],
        "dI_dIlocal3": d_local[2],
        "convex_c1_needed_for_same_image": needed[0],
        "convex_c2_needed": needed[1],
    }


@evaluates("H.tree", "L k_r k_t depth", skipped={"nodes": "2^(depth + 1) - 1; the library sums whole levels"})
def _tree(c: Columns) -> dict[str, Array]:
    depth, row, k = c["depth"].astype(int), jnp.arange(c["depth"].size), c["k_r"] + c["k_t"]
    levels = series.tree(c["L"], c["k_r"], c["k_t"], 5)  # the depth is at most 5
    infinite = series.periodic_limit(series.additive(c["L"][None], k[None]))
    return {"I_D": levels.partial[depth, row], "remainder_to_inf": levels.weights[depth, row] * k * infinite}


@evaluates("H.corridor", "N", given="alpha=(0.9, 0.8), c=(0.3, 0.7)", derivatives="dconvex_dalpha_a dconvex_dalpha_b")
def _corridor(c: Columns) -> dict[str, Array]:
    alpha, color, last = jnp.array([0.9, 0.8]), jnp.array([0.3, 0.7]), jnp.isinf(c["N"])
    n = jnp.where(last, 0, c["N"]).astype(int)

    def radiance(layers: series.Layers) -> Array:
        long = series.Layers(*(jnp.tile(x, 26) for x in layers))  # N is at most 50
        return jnp.where(last, series.periodic_limit(layers), series.iterative(long).partial[n])

    slope = jax.grad(lambda alpha: series.periodic_limit(series.convex(color, alpha)))(alpha)
    return {
        "convex": radiance(series.convex(color, alpha)),
        "additive": radiance(series.additive(color, alpha)),
        "dconvex_dalpha_a": slope[0],
        "dconvex_dalpha_b": slope[1],
    }


@evaluates("H.glass_sphere_tree", "n b")
def _glass_sphere(c: Columns) -> dict[str, Array]:
    b, inner = c["b"], jnp.ones((5, 1, 1))
    r = jnp.stack(fresnel.dielectric_sp(jnp.sqrt((1 - b) * (1 + b)), c["n"]))  # by reversal the same inside
    inside = series.iterative(series.Layers(inner, inner * (1 - r), inner * r))  # what leaves at each inner hit
    orders = jnp.concatenate([r[None], (1 - r) * inside.weights]).mean(axis=1)
    return {**{f"p{i}": order for i, order in enumerate(orders)}, "deficit": ((1 - r) * inside.remainder).mean(axis=0)}
