"""A model tabulated at pairs of directions, its albedos with their errors."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..brdf.function import as_model
from ..brdf.protocol import DELTA_PARTS
from ..certified import albedo_to
from ..params import foreign_classes, validate
from ..vec import Vec3
from .directions import spread_directions


@dataclasses.dataclass(frozen=True, eq=False)
class Vectors:
    """Values of a model at N pairs of directions."""

    wi: np.ndarray
    """(N, 3)."""
    wo: np.ndarray
    """(N, 3)."""
    values: dict[str, np.ndarray]
    """Quantity to (N, C): ``f``, then ``pdf``, ``mirror`` and ``through`` where the model has them, ``albedo`` and
    ``albedo_error``."""
    model: str
    parameters: dict[str, Any]


def as_argument(brdf: Any) -> Any:
    """A model as jit takes it as an argument, its parameters arrays of float64, so that it is compiled once."""
    return jax.tree.map(lambda x: jnp.asarray(x, float), as_model(brdf))


@functools.partial(jax.jit, static_argnames="classes")
def _values(brdf: Any, wi: Vec3, wo: Vec3, classes: Any) -> dict[str, Any]:
    found = {"f": jax.vmap(brdf)(wi, wo)}
    if hasattr(brdf, "pdf"):
        found["pdf"] = jax.vmap(brdf.pdf)(wi, wo)
    return found | {name: jax.vmap(getattr(brdf, name))(wo.z) for name in DELTA_PARTS if hasattr(brdf, name)}


def evaluate(brdf: Any, wi: np.ndarray, wo: np.ndarray) -> dict[str, np.ndarray]:
    """Quantities of a model at pairs of directions, each (N, C): f, and pdf, mirror, through where there are such.

    Args:
        brdf: model, or function f(wi, wo).
        wi, wo: (N, 3).

    Raises:
        ValueError: 64-bit types are off; a parameter out of its range.
    """
    if not jax.config.read("jax_enable_x64"):
        raise ValueError("reference values are float64; call jax.config.update('jax_enable_x64', True) before")
    validate(brdf)
    light, view = (Vec3.from_array(np.asarray(w, np.float64)) for w in (wi, wo))
    found = _values(as_argument(brdf), light, view, foreign_classes(brdf))
    return {name: np.asarray(value, np.float64).reshape(len(wi), -1) for name, value in found.items()}


def parameters_of(model: Any, path: str = "") -> dict[str, Any]:
    """Parameters of a model, or of a nest of models, by their path; those of a function are none."""
    if not dataclasses.is_dataclass(model):
        return {}
    found: dict[str, Any] = {}
    for field in dataclasses.fields(model):
        value, name = getattr(model, field.name), f"{path}{field.name}"
        if dataclasses.is_dataclass(value):
            found |= {name: type(value).__name__} | parameters_of(value, f"{name}.")
        elif isinstance(value, (str, bool)):
            found[name] = value
        else:
            array = np.asarray(value)
            found[name] = array.tolist() if array.dtype.kind in "fiu" else str(value)
    return found


def reference_vectors(brdf: Any, n: int = 1000, seed: int = 0, *, name: str = "", rtol: float = 1e-10) -> Vectors:
    """Reference vectors of a model.

    Args:
        brdf: model, or function f(wi, wo).
        n: number of pairs of directions, >= 1.
        seed: of the directions.
        name: of the model, as the files will say it; the name of its type if empty.
        rtol: relative tolerance of the albedos; each has its own error beside it, met or not.

    Raises:
        ValueError: an argument out of its range, 64-bit types off, or a model that is not finite at some directions.
    """
    at = spread_directions(n, seed)
    values = evaluate(brdf, at.wi, at.wo)
    for quantity, table in values.items():
        bad = ~np.isfinite(table).all(axis=1)
        if bad.any():
            i = int(np.argmax(bad))
            raise ValueError(f"{quantity} = {table[i]} is not finite at wi = {at.wi[i]}, wo = {at.wo[i]}")
    model = as_argument(brdf)
    views = zip(at.cos_theta_o, at.phi_o, strict=True)
    found = [albedo_to(model, float(mu), rtol, 2_000_000, phi_o=float(phi)) for mu, phi in views]
    for quantity, column in (("albedo", [a.value for a in found]), ("albedo_error", [a.error for a in found])):
        values[quantity] = np.stack([np.ravel(x) for x in column])[at.view]
    return Vectors(at.wi, at.wo, values, name or type(brdf).__name__, parameters_of(brdf))
