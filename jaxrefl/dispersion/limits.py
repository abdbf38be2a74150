"""The wavelengths for which a model holds: an error for concrete ones outside, the nearer end for traced ones."""

from __future__ import annotations

from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Bool, Float

from ..params import Interval, floats, is_concrete, require, validate
from .index import Index

Limits = tuple[Any, Any]
"""Lowest and highest wavelength in nm; None is no limit."""


class Model(Protocol):
    """What a dispersion model is: a callable of the wavelength. ``range_nm`` is optional."""

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm, of their shape."""
        ...


class Ranged:
    """What the models with ends of their own share; they are their last two fields."""

    low_nm: Any
    high_nm: Any

    @property
    def range_nm(self) -> Limits:
        """Wavelengths for which it holds."""
        return self.low_nm, self.high_nm


def limits(model: Any) -> Limits:
    """Range of a model, (None, None) if it states none."""
    return getattr(model, "range_nm", (None, None))


def shape_of(numbers: Any) -> tuple[int, ...]:
    """Shape of an array, or of a list, whose numbers may be traced."""
    return (len(numbers),) if isinstance(numbers, (list, tuple)) else np.shape(numbers)


def same_length(**coefficients: Any) -> None:
    """Raise `ValueError` naming the lists of coefficients, of which one belongs to each term, if they do not match."""
    shapes = {name: shape_of(x) for name, x in coefficients.items()}
    if len({shape[-1:] or (1,) for shape in shapes.values()}) > 1:
        text = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"shapes {text} differ; each holds one number for every term")


def check_wavelength(wavelength_nm: Any, low: Any = None, high: Any = None) -> None:
    """Raise `ValueError` for a concrete wavelength outside a concrete range, or for a range that is empty."""
    if low is not None and high is not None and is_concrete(low) and is_concrete(high) and not low < high:
        raise ValueError(
            f"the range is empty: its lower end, {float(low):g} nm, is not below the upper one, {float(high):g} nm"
        )
    if all(is_concrete(x) for x in jax.tree.leaves((wavelength_nm, low, high))):
        interval = Interval(
            0.0 if low is None else float(low), np.inf if high is None else float(high), low is None, high is None
        )
        require("wavelength_nm", wavelength_nm, interval)


def prepare(model: Any, wavelength_nm: Any, *coefficients: Any) -> tuple[Array, ...]:
    """Wavelength held to the model's range, and the coefficients, as arrays of one dtype; all checked if concrete."""
    low, high = limits(model)
    check_wavelength(wavelength_nm, low, high)
    if all(is_concrete(x) for x in jax.tree.leaves(model)):
        validate(model)
    dtype = jnp.result_type(*jax.tree.leaves((wavelength_nm, coefficients)), 0.0)
    wavelength, *values = (jnp.asarray(x, dtype) for x in (wavelength_nm, *coefficients))
    if low is not None:
        low = lax.stop_gradient(jnp.asarray(low, dtype))
        wavelength = jnp.where(wavelength < low, low, wavelength)
    if high is not None:
        high = lax.stop_gradient(jnp.asarray(high, dtype))
        wavelength = jnp.where(wavelength > high, high, wavelength)
    return wavelength, *values


def in_range(model: Any, wavelength_nm: Float[ArrayLike, "..."]) -> Bool[Array, "..."]:
    """Mask of the wavelengths that lie in the range of a model: elsewhere, under jit, its value is that at the end.

    Args:
        model: any dispersion model; one without ``range_nm`` has no limits.
        wavelength_nm: nm, any shape, concrete or traced.

    Returns:
        Booleans of the same shape. Both ends belong to the range.
    """
    low, high = limits(model)
    (wavelength,) = floats(wavelength_nm)
    inside = wavelength > 0
    if low is not None:
        inside = inside & (wavelength >= jnp.asarray(low, wavelength.dtype))
    if high is not None:
        inside = inside & (wavelength <= jnp.asarray(high, wavelength.dtype))
    return inside
