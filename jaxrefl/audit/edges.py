"""Edges: NaN and infinity in the value and the gradient, at the directions where formulas break.

The lattice pairs every direction with every other: the normal, 1e-7 beside it, 45 degrees, 1e-7 above the horizon, on
it, and the same below it, at several azimuths. Equal directions, opposite ones, the mirror direction and the
retro-reflection are among the pairs.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..albedo import delta_parts
from ..params import foreign_classes
from ..vec import Vec3
from .evaluate import deltas, values
from .report import Row
from .search import unit
from .subject import Subject, leaves_with_names

_NEAR = 1e-7  # radians
_ELEVATIONS = (0.5 * np.pi, 0.5 * np.pi - _NEAR, 0.25 * np.pi, _NEAR, 0.0, -_NEAR, -0.25 * np.pi, -0.5 * np.pi)
_AZIMUTHS = (0.0, 0.5 * np.pi, np.pi, 4.0)


def lattice(above: bool = False) -> tuple[Vec3, Vec3]:
    """Pairs wi and wo, each (N,), N about 600; or only those ``above`` the surface."""
    elevation, phi = (x.ravel() for x in np.meshgrid(_ELEVATIONS, _AZIMUTHS, indexing="ij"))
    once = ((abs(elevation) < 0.5 * np.pi) | (phi == 0)) & ((elevation >= 0) | (not above))
    found = unit(elevation[once], phi[once]).to_array()
    exact = jnp.where(abs(found) < 1e-15, 0.0, found)  # the cosine of 90 degrees
    first, second = np.indices((len(exact), len(exact))).reshape(2, -1)
    return Vec3.from_array(exact[first]), Vec3.from_array(exact[second])


@functools.partial(jax.jit, static_argnames="classes")
def _gradients(model: Any, wi: Vec3, wo: Vec3, classes: Any) -> tuple[Any, Vec3, Vec3]:
    """Derivatives of the sum over the channels, delta parts of the view included."""

    def total(model: Any, wi: Vec3, wo: Vec3) -> Array:
        return jnp.sum(model(wi, wo)) + jnp.sum(delta_parts(model, jnp.abs(wo.z), "both"))

    return jax.vmap(jax.grad(total, argnums=(0, 1, 2)), in_axes=(None, 0, 0))(model, wi, wo)


def _words(wi: Vec3, wo: Vec3, k: int) -> str:
    def one(w: Vec3) -> str:
        return f"({', '.join(f'{float(x[k]):.3g}' for x in (w.x, w.y, w.z))})"

    return f"wi = {one(wi)}, wo = {one(wo)}"


def finite_values(subject: Subject) -> Row:
    """Row of the pairs at which the value, or a delta part, is NaN or infinite."""
    wi, wo = lattice(subject.reflects_only)
    f = values(subject.model, wi, wo)
    delta = deltas(subject.model, np.abs(np.asarray(wo.z))).sum(axis=-1)
    bad = ~(np.isfinite(f).all(axis=-1) & np.isfinite(delta))
    if not bad.any():
        return Row("finite_values", "ok", 0.0, "", f"finite at all {bad.size} pairs of the edge lattice")
    k = int(np.argmax(bad))
    text = f"f = {f[k]}, delta parts {delta[k]:.3g}: not finite at {bad.sum()} of {bad.size} pairs of the edge lattice"
    return Row("finite_values", "fails", float(bad.sum()), _words(wi, wo, k), text)


def finite_gradients(subject: Subject) -> Row:
    """Row of the pairs at which a derivative by a direction or a parameter is NaN or infinite."""
    name = "finite_gradients"
    if not subject.has_gradient:
        return Row(name, "skipped", None, "", "a numpy function has no derivatives")
    wi, wo = lattice(subject.reflects_only)
    by_model, by_wi, by_wo = _gradients(subject.model, wi, wo, foreign_classes(subject.model))
    names, leaves = leaves_with_names(by_model)
    names += [f"{side}.{axis}" for side in ("wi", "wo") for axis in "xyz"]
    leaves += [getattr(by, axis) for by in (by_wi, by_wo) for axis in "xyz"]
    broken = np.stack([~np.isfinite(np.asarray(x)).reshape(len(np.asarray(x)), -1).all(axis=1) for x in leaves])
    bad = broken.any(axis=0)
    asked = f"{len(names) - 6} parameter{'s' if len(names) != 7 else ''} and both directions"
    if not bad.any():
        return Row(name, "ok", 0.0, "", f"finite in {asked}, at all {bad.size} pairs of the edge lattice")
    which = ", ".join(n for n, row in zip(names, broken, strict=True) if row.any())
    text = f"NaN or infinity in d f / d ({which}) at {bad.sum()} of {bad.size} pairs of the edge lattice"
    return Row(name, "fails", float(bad.sum()), _words(wi, wo, int(np.argmax(bad))), text)
