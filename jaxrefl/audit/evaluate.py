"""A model at many directions at once: compiled once per class of model, whatever its parameters are."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..albedo import directional_albedo, rule_for
from ..brdf.protocol import DELTA_PARTS
from ..chart import AlbedoRule
from ..params import foreign_classes
from ..vec import Vec3

ANGLES = 16
"""Angles that are integrated at a time."""
_LEVELS = 4, 5, 6  # of the rule: at the first one the stated error of most models is 1e-11 or less
_SLACK = 4.0
_REFINED = 32  # angles at most that are integrated at the higher levels


class Albedos(NamedTuple):
    """Directional albedos, each (M, C)."""

    value: np.ndarray
    error: np.ndarray


@functools.partial(jax.jit, static_argnames="classes")
def _values(model: Any, wi: Vec3, wo: Vec3, classes: Any) -> Array:
    return jax.vmap(lambda wi, wo: jnp.ravel(model(wi, wo)))(wi, wo)


def values(model: Any, wi: Vec3, wo: Vec3) -> np.ndarray:
    """f at pairs of directions, (N, C)."""
    return np.asarray(_values(model, wi, wo, foreign_classes(model)))


@functools.partial(jax.jit, static_argnames="classes")
def _deltas(model: Any, mu: Array, classes: Any) -> Array:
    def both(mu: Array) -> Array:
        found = [jnp.ravel(getattr(model, name)(mu)) for name in DELTA_PARTS if hasattr(model, name)]
        return jnp.concatenate(found) if found else jnp.zeros(1, mu.dtype)

    return jax.vmap(both)(mu)


def deltas(model: Any, mu: np.ndarray) -> np.ndarray:
    """Delta parts at cosines, one after the other (N, 2 C); zeros (N, 1) if there are none."""
    return np.asarray(_deltas(model, jnp.asarray(mu, float), foreign_classes(model)))


@functools.partial(jax.jit, static_argnames=("part", "fixed", "classes"))
def _albedos(model: Any, mu: Array, phi: Array, rule: AlbedoRule, part: str, fixed: str, classes: Any) -> Any:
    def one(pair: tuple[Array, Array]) -> Any:
        found = directional_albedo(model, pair[0], rule, part=part, fixed=fixed, phi_o=pair[1])
        return jnp.ravel(found.value), jnp.ravel(found.error)

    return lax.map(one, (mu, phi))


def epsilon() -> float:
    """Unit of rounding of the default float dtype."""
    return float(jnp.finfo(jnp.zeros(0).dtype).eps)


def margin(error: np.ndarray) -> np.ndarray:
    """Distance at which a verdict is sure: the error of a rule that converges slowly, at a jump, is no strict bound."""
    return np.where(error < epsilon() ** 0.5, error, _SLACK * error)


def albedos(
    model: Any, mu: np.ndarray, phi: np.ndarray, *, part: str = "both", fixed: str = "view", level: int = _LEVELS[0]
) -> Albedos:
    """Directional albedos at M cosines and azimuths, by the model's own rule, delta parts included."""
    rule, classes = rule_for(model, level), foreign_classes(model)
    n = -(-mu.size // ANGLES) * ANGLES
    batches = np.stack([np.resize(x, n).reshape(-1, ANGLES) for x in (mu, phi)], axis=1)
    found = [_albedos(model, *jnp.asarray(pair, float), rule, part, fixed, classes) for pair in batches]
    return Albedos(*(np.concatenate(column)[: mu.size] for column in zip(*found, strict=True)))


def refined(
    model: Any, mu: np.ndarray, phi: np.ndarray, found: Albedos, poor: Callable[[Albedos], np.ndarray], **options: str
) -> Albedos:
    """The same with those that are poor (M, C), the largest first, by finer rules.

    Args:
        model, mu, phi, options: as for `albedos`, which has found them.
        poor: which ones are not known well enough, from value and error.
    """
    found = Albedos(found.value.copy(), found.error.copy())
    for level in _LEVELS[1:]:
        bad = np.nonzero(poor(found).any(axis=-1))[0]
        if not bad.size:
            break
        worst = bad[np.argsort(-(found.value + found.error)[bad].max(axis=-1))][:_REFINED]
        better = albedos(model, mu[worst], phi[worst], level=level, **options)
        found.value[worst], found.error[worst] = better
    return found
