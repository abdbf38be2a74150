"""What there is to draw of a reflection model: albedos over the angle, values over a lobe and over a slice."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..albedo import directional_albedo, rule_for
from ..brdf.function import as_model
from ..brdf.protocol import chart_of, kinks_of
from ..params import foreign_classes
from ..quadrature import Estimate
from ..vec import Vec3


def _rule_key(model: Any) -> str:
    return f"{chart_of(model)} {len(kinks_of(model))}"


@functools.partial(jax.jit, static_argnames=("part", "fixed", "classes"))
def _over_angles(
    models: list[Any], mu: Array, rules: dict[str, Any], part: str, fixed: str, classes: Any
) -> list[Estimate]:
    def all_of_them(mu: Array) -> list[Estimate]:
        return [directional_albedo(model, mu, rules[_rule_key(model)], part=part, fixed=fixed) for model in models]

    return lax.map(all_of_them, mu)


@functools.partial(jax.jit, static_argnames="classes")
def _over_pairs(model: Any, wi: Vec3, wo: Vec3, classes: Any) -> Array:
    return jax.vmap(model)(wi, wo)


def albedos(
    model: Any | Mapping[str, Any],
    theta_deg: Any = None,
    *,
    level: int = 3,
    part: str = "reflected",
    fixed: str = "view",
) -> Any:
    """Directional albedos of models over the angle, with their errors; several are compiled at once, which is faster.

    Args:
        model: f(wi, wo) in 1/sr, or a dict label -> model.
        theta_deg: (M,) angles in degrees; 0, 1, ... 90 if None.
        level: of the rule, `jaxrefl.albedo.rule_for`; 3 is good to 8 digits, to 5 for narrow lobes.
        part, fixed: as in `jaxrefl.albedo.directional_albedo`.

    Returns:
        Estimate(value, error), each (M,) or (M, C); or a dict label -> Estimate.
    """
    given = model if isinstance(model, Mapping) else {"": model}
    models = {name: as_model(one) for name, one in given.items()}
    theta = np.linspace(0.0, 90.0, 91) if theta_deg is None else np.asarray(theta_deg, float)
    mu = jnp.asarray(np.sin(np.deg2rad(90.0 - theta)))  # exactly 0 at 90 degrees
    rules = {_rule_key(one): rule_for(one, level) for one in models.values()}
    found = _over_angles(list(models.values()), mu, rules, part, fixed, foreign_classes(models))
    named = dict(zip(models, jax.tree.map(np.asarray, found), strict=True))
    return named if isinstance(model, Mapping) else named[""]


def lobe_values(model: Any, incident_deg: float = 40.0, samples: int = 61) -> np.ndarray:
    """f(wi, wo), (samples, 2 samples - 1) or with channels, over polar angle and azimuth of wo; the light is at -x."""
    theta = np.linspace(0, 0.5 * np.pi, samples)[:, None]
    phi = np.linspace(0, 2 * np.pi, 2 * samples - 1)
    x, y, z = np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta))
    angle = np.deg2rad(incident_deg)
    light = [np.full(x.shape, part) for part in (-np.sin(angle), 0.0, np.cos(angle))]
    return _over_grid(model, light, [x, y, z])


def slice_values(model: Any, samples: int = 90, phi_d_deg: float = 90.0) -> np.ndarray:
    """f, (samples, samples) or with channels, over theta_d (rows) and theta_h, in the middle of equal cells.

    theta_h is the angle of the half vector from the normal, theta_d that of the light from the half vector, phi_d its
    azimuth there, 0 where light, half vector and normal are in one plane. Directions below the surface are NaN; with
    phi_d = 90 degrees there are none.
    """
    middle = (np.arange(samples) + 0.5) * (0.5 * np.pi / samples)
    d, h = np.meshgrid(middle, middle, indexing="ij")
    across, along = np.sin(d) * np.cos(np.deg2rad(phi_d_deg)), np.cos(d)
    y = np.sin(d) * np.sin(np.deg2rad(phi_d_deg))
    wi, wo = (
        [np.cos(h) * a + np.sin(h) * along, b, np.cos(h) * along - np.sin(h) * a]
        for a, b in ((across, y), (-across, -y))
    )
    values = _over_grid(model, wi, wo)
    below = (wi[2] < 0) | (wo[2] < 0)
    return np.where(below.reshape(below.shape + (1,) * (values.ndim - 2)), np.nan, values)


def _over_grid(model: Any, wi: list[np.ndarray], wo: list[np.ndarray]) -> np.ndarray:
    flat = [Vec3(*(jnp.asarray(part.ravel(), float) for part in w)) for w in (wi, wo)]
    values = np.asarray(_over_pairs(as_model(model), *flat, foreign_classes(model)))
    return values.reshape(wi[0].shape + values.shape[1:])
