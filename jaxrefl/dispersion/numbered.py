"""The nine numbered formulas in which catalogues and the refractiveindex.info database publish n."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import Interval, param, pytree, require
from ..safe import safe_divide
from .closed import REAL, Devore, Polynomial, Sellmeier, high_nm, low_nm, real_index
from .index import Index, from_permittivity
from .limits import Ranged, prepare


def _pairs(c: Array, first: int) -> tuple[Array, Array]:
    return c[first::2], c[first + 1 :: 2]


def _power(base: Array, p: Array) -> Array:
    """base^p, by a negative base (p then is whole) without a slope in p."""
    positive, negative = jnp.where(base < 0, 1.0, base), jnp.where(base < 0, base, -1.0)
    return jnp.where(base < 0, negative ** lax.stop_gradient(p), positive**p)


def _general(x: Array, c: Array) -> Array:
    terms = sum(
        c[i] * x ** c[i + 1] * safe_divide(1.0, x * x - _power(c[i + 2], c[i + 3]))
        for i in (1, 5)
        if i + 3 < c.shape[0]
    )
    b, p = _pairs(c, 9)
    return c[0] + terms + jnp.sum(b * x[..., None] ** p, axis=-1)


def _cauchy(x: Array, c: Array) -> Array:
    b, p = _pairs(c, 1)
    return c[0] + jnp.sum(b * x[..., None] ** p, axis=-1)


def _gas(x: Array, c: Array) -> Array:
    b, p = _pairs(c, 1)
    return 1 + c[0] + jnp.sum(b * safe_divide(1.0, p - (1 / (x * x))[..., None]), axis=-1)


def _herzberger(x: Array, c: Array) -> Array:
    s = x * x
    over = safe_divide(1.0, s - 0.028)
    rest = sum(c[i] * s ** (i - 2) for i in range(3, c.shape[0]))
    return c[0] + over * (c[1] + over * c[2]) + rest


def _retro(x: Array, c: Array) -> Array:
    s = x * x
    t = c[0] + c[1] * s * safe_divide(1.0, s - c[2]) + c[3] * s
    return (1 + 2 * t) * safe_divide(1.0, 1 - t)


def _exotic(x: Array, c: Array) -> Array:
    d = x - c[4]
    return c[0] + c[1] * safe_divide(1.0, x * x - c[2]) + c[3] * d * safe_divide(1.0, d * d + c[5])


_SQUARE: dict[int, Callable[[Array, Array], Array]] = {4: _general, 8: _retro, 9: _exotic}
_DIRECT: dict[int, Callable[[Array, Array], Array]] = {5: _cauchy, 6: _gas, 7: _herzberger}
_LENGTH = {4: 5, 5: 1, 6: 1, 7: 3, 8: 4, 9: 6}


@pytree
class NumberedFormula(Ranged):
    """One of the numbered formulas 4 to 9 of the database of refractive indices, x the wavelength in micrometres.

    4: n^2 = c0 + c1 x^c2 / (x^2 - c3^c4) + c5 x^c6 / (x^2 - c7^c8) + sum c_i x^c_(i+1); 5 (Cauchy): n = c0 + sum c_i
    x^c_(i+1); 6 (gases): n - 1 = c0 + sum c_i / (c_(i+1) - x^-2); 7 (Herzberger): n = c0 + c1 / (x^2 - 0.028) + c2 /
    (x^2 - 0.028)^2 + c3 x^2 + c4 x^4 + ...; 8 (retro): (n^2 - 1) / (n^2 + 2) = c0 + c1 x^2 / (x^2 - c2) + c3 x^2;
    9 (exotic): n^2 = c0 + c1 / (x^2 - c2) + c3 (x - c4) / ((x - c4)^2 + c5). Formulas 1 to 3 are `Sellmeier` and
    `Polynomial`, see `from_formula`.

    Source: M. N. Polyanskiy, Sci. Data 11, 94 (2024), "Dispersion formulas". Differentiable as `Sellmeier` is.
    """

    c: Any = param(REAL, spectral=True, doc="coefficients, in the database's order")
    number: int = dataclasses.field(metadata={"static": True})
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        wavelength, c = prepare(self, wavelength_nm, self.c)
        x = wavelength / 1000
        if self.number in _SQUARE:
            return from_permittivity(_SQUARE[self.number](x, c))
        return real_index(_DIRECT[self.number](x, c))


def from_formula(
    number: int, coefficients: Sequence[float], low_nm: float | None = None, high_nm: float | None = None
) -> Any:
    """Model of a numbered formula: `Sellmeier` (1, 2), `Polynomial` (3), `Devore` (4, if it is one), or the formula.

    Args:
        number: 1 to 9.
        coefficients: in the database's order, in micrometres; of 1, the resonances, of 2, their squares.
        low_nm, high_nm: range.

    Returns:
        A dispersion model.

    Raises:
        ValueError: another number, or too few coefficients for it.
    """
    require("number", number, Interval(1.0, 9.0))
    c = np.array(coefficients, float)
    if c.size < _LENGTH.get(number, 1) or (number in (1, 2, 3, 5, 6) and c.size % 2 == 0):
        raise ValueError(f"coefficients has {c.size} numbers, formula {number} cannot be read from them")
    ends = (low_nm, high_nm)
    if number in (1, 2):
        return Sellmeier(c[1::2], c[2::2] ** (2 if number == 1 else 1), 1 + c[0], *ends)
    if number == 3:
        return Polynomial(c[0], c[1::2], c[2::2], *ends)
    if number == 4 and c[2] == 0 and not np.any(c[5:6]) and not np.any(c[9:]):
        return Devore(c[0], c[1], c[3] ** c[4], *ends)
    if number == 4 and c.size > 8 and c[5] == 0:
        c[7:9] = 0.0, 1.0  # a term that is not there, with a derivative that is
    if number in (8, 9):
        c = c[: _LENGTH[number]]
    return NumberedFormula(c, number, *ends)
