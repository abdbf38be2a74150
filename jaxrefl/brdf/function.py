"""A user's function as a reflection model: one of two `Vec3`, or a numpy function of arrays (..., 3)."""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jaxtyping import Float

from ..vec import Vec3


@jax.tree_util.register_static
class Opaque:
    """A model without parameters that JAX could see; equal to another one if it holds the same object."""

    def __init__(self, model: Any) -> None:
        self.model = model

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        return self.model(wi, wo)

    def __getattr__(self, name: str) -> Any:
        if name == "model":  # while it is being copied
            raise AttributeError(name)
        return getattr(self.model, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Opaque) and other.model is self.model

    def __hash__(self) -> int:
        return id(self.model)


def as_model(brdf: Any) -> Any:
    """A model as `jax.jit` takes it for an argument: one whose leaves are numbers as it is, integers made floats.

    Any other callable, such as a plain function or an object that is no pytree, becomes an `Opaque` model.

    Raises:
        ValueError: something that cannot be called, or a class.
    """
    if isinstance(brdf, type) or not callable(brdf):
        raise ValueError(f"brdf = {brdf!r} must be a model, called as f(wi, wo), such as Lambert(0.5)")
    leaves = jax.tree.leaves(brdf)
    if not all(isinstance(x, (numbers.Real, np.ndarray, np.generic, Array)) for x in leaves):
        return Opaque(brdf)
    return jax.tree.map(lambda x: x if np.asarray(x).dtype.kind not in "iu" else np.asarray(x, float), brdf)


class _OnHost:
    """A numpy function called from inside a JAX computation."""

    has_gradient = False

    def __init__(self, function: Callable[[np.ndarray, np.ndarray], Any]) -> None:
        self.function = function
        self.__name__ = getattr(function, "__name__", type(function).__name__)
        up = np.tile([0.0, 0.0, 1.0], (2, 1))
        shape = np.shape(function(up, up))
        if not 1 <= len(shape) <= 2 or shape[0] != 2:
            raise ValueError(f"function = {self.__name__} maps (2, 3) arrays to {shape}; it must be (2,) or (2, C)")
        self.channels = shape[1:]

    def __call__(self, wi: Vec3, wo: Vec3) -> Array:
        components = jnp.broadcast_arrays(wi.x, wi.y, wi.z, wo.x, wo.y, wo.z)
        shape = components[0].shape + self.channels
        result = jax.ShapeDtypeStruct(shape, components[0].dtype)
        return jax.pure_callback(self._values, result, *components, vmap_method="broadcast_all")

    def _values(self, *components: Any) -> np.ndarray:
        columns = [np.asarray(x) for x in components]
        batch = columns[0].shape
        wi, wo = (np.stack(part, axis=-1).reshape(math.prod(batch), 3) for part in (columns[:3], columns[3:]))
        with np.errstate(all="ignore"):  # whoever calls looks for NaN
            values = np.asarray(self.function(wi, wo), columns[0].dtype)
        return values.reshape(batch + self.channels)


def from_numpy(function: Callable[[np.ndarray, np.ndarray], Any]) -> Opaque:
    """Model of a plain numpy function f(wi, wo) of unit directions (N, 3), which returns (N,) or (N, C) in 1/sr.

    It can be compiled, mapped and integrated as any other, by a call back to numpy; it has no derivatives.

    Raises:
        ValueError: a function that returns another shape.
    """
    return Opaque(_OnHost(function))
