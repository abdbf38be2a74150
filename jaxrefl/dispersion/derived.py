"""Numbers derived from a dispersion model."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from .limits import check_wavelength, limits

LINES_NM = {"F": 486.1327, "d": 587.5618, "D": 589.2938, "C": 656.2725}
"""Fraunhofer lines of catalogues of glass: hydrogen, helium, the mean of sodium's two, hydrogen."""


def abbe_number(model: Any) -> Float[Array, ""]:
    """Abbe number V_d = (n_d - 1) / (n_F - n_C): the smaller, the stronger the dispersion.

    Args:
        model: dispersion model whose range holds the lines F (486.1327 nm), d (587.5618 nm) and C (656.2725 nm).

    Raises:
        ValueError: the range does not hold them, naming the range (outside jit only).

    Differentiable in the coefficients of the model; infinite where n_F = n_C, for a model without dispersion.
    Source: ISO 7944.
    """
    n = model(jnp.array([LINES_NM[line] for line in "FdC"])).n
    dispersion = n[0] - n[2]
    none = dispersion == 0
    return jnp.where(none, jnp.inf, (n[1] - 1) / jnp.where(none, 1.0, dispersion))


def group_index(model: Any, wavelength_nm: Float[ArrayLike, "..."]) -> Float[Array, "..."]:
    """Group index n - L dn/dL: the speed of light over that of a pulse.

    The slope is the derivative of the model, exact for closed forms; of a table with linear interpolation it jumps at
    the rows, so take ``method="cubic"`` there.

    Args:
        model: dispersion model, applied to each wavelength by itself.
        wavelength_nm: nm, any shape.

    Raises:
        ValueError: outside the range of the model (outside jit only).

    Differentiable where the slope of the model is. Source: Born & Wolf, section 1.3.4, (47).
    """
    check_wavelength(wavelength_nm, *limits(model))
    wavelength = jnp.asarray(wavelength_nm)
    wavelength = wavelength.astype(jnp.result_type(wavelength, 0.0))
    n, slope = jax.jvp(lambda at: model(at).n, (wavelength,), (jnp.ones_like(wavelength),))
    return n - wavelength * slope


def normal_reflectance(model: Any, wavelength_nm: Float[ArrayLike, "..."]) -> Float[Array, "..."]:
    """Reflectance at normal incidence from vacuum, ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).

    Unlike `fresnel.f0_conductor` it takes n = 0, where nothing is transmitted and R = 1.

    Args, Raises: as in `group_index`. Differentiable where the model is.
    """
    n, k = model(wavelength_nm)
    return ((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k)
