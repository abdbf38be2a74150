"""Closed forms of n for transparent media, with coefficients in micrometres as they are published."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import param, pytree
from ..safe import safe_divide
from .index import Index, from_permittivity
from .limits import Limits, Ranged, limits, prepare, same_length

REAL = "(-inf, inf)"


def low_nm() -> Any:
    """Field of the lower end of a range."""
    return param("(0, inf)", unit="nm", default=None, doc="lower end of the range; none if absent")


def high_nm() -> Any:
    """Field of the upper end of a range."""
    return param("(0, inf)", unit="nm", default=None, doc="upper end of the range; none if absent")


def real_index(n: Array) -> Index:
    """Index without absorption."""
    return Index(n, jnp.zeros_like(n))


@pytree
class Constant:
    """Index n + i k that does not depend on the wavelength; n and k broadcast with it.

    Differentiable in both.
    """

    n: Any = param("[0, inf)", spectral=True, default=1.0, doc="refractive index")
    k: Any = param("[0, inf)", spectral=True, default=0.0, doc="extinction coefficient")

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        wavelength, n, k = prepare(self, wavelength_nm, self.n, self.k)
        _, n, k = jnp.broadcast_arrays(wavelength, n, k)
        return Index(n, k)


@pytree
class Cauchy(Ranged):
    """Cauchy's formula n = a + b / L^2 + c / L^4, L in micrometres; k = 0.

    A fit for the visible, not for more. Tables of it that give a = n_d (Wikipedia's, for all glasses but BK7) are
    too high by b / L^2, 0.01 to 0.04. Differentiable in the coefficients and the wavelength.
    """

    a: Any = param(REAL, doc="limit of n for long waves")
    b: Any = param(REAL, unit="um^2", default=0.0, doc="coefficient of 1 / L^2")
    c: Any = param(REAL, unit="um^4", default=0.0, doc="coefficient of 1 / L^4")
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        wavelength, a, b, c = prepare(self, wavelength_nm, self.a, self.b, self.c)
        per_square = (1000 / wavelength) ** 2
        return real_index(a + per_square * (b + per_square * c))


@pytree
class Sellmeier(Ranged):
    """Sellmeier's formula n^2 = constant + sum_i b_i L^2 / (L^2 - c_i), L in micrometres.

    c_i is the square of a wavelength of resonance. Where n^2 is negative (between a resonance and the zero above it)
    the medium reflects all: n = 0, k = sqrt(-n^2). At a resonance itself its term is left out. Differentiable in the
    coefficients and the wavelength but at n = 0 (there it is finite). Source: W. Sellmeier, Ann. Phys. 219, 272 (1871).
    """

    b: Any = param(REAL, spectral=True, doc="strengths (J,)")
    c: Any = param(REAL, unit="um^2", spectral=True, doc="squares of the resonances (J,)")
    constant: Any = param(REAL, default=1.0, doc="n^2 far below all resonances")
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        same_length(b=self.b, c=self.c)
        wavelength, b, c, constant = prepare(self, wavelength_nm, self.b, self.c, self.constant)
        square = ((wavelength / 1000) ** 2)[..., None]
        return from_permittivity(constant + jnp.sum(b * square * safe_divide(1.0, square - c), axis=-1))


@pytree
class Devore(Ranged):
    """Devore's form n^2 = a + sum_i b_i / (L^2 - c_i), L in micrometres; of rutile, with one term.

    Differentiable as `Sellmeier` is. Source: J. R. Devore, J. Opt. Soc. Am. 41, 416 (1951).
    """

    a: Any = param(REAL, doc="limit of n^2 for long waves")
    b: Any = param(REAL, unit="um^2", spectral=True, doc="strengths, a number or (J,)")
    c: Any = param(REAL, unit="um^2", spectral=True, doc="squares of the resonances, a number or (J,)")
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        same_length(b=self.b, c=self.c)
        wavelength, a, b, c = prepare(self, wavelength_nm, self.a, self.b, self.c)
        square = ((wavelength / 1000) ** 2)[..., None]
        return from_permittivity(a + jnp.sum(b * safe_divide(1.0, square - c), axis=-1))


@pytree
class Polynomial(Ranged):
    """Polynomial form n^2 = c0 + sum_i c_i L^p_i, L in micrometres, powers of either sign (Schott's, before 1992).

    Differentiable in the coefficients, the powers and the wavelength, but at n = 0 (there it is finite).
    """

    c0: Any = param(REAL, doc="constant of n^2")
    c: Any = param(REAL, spectral=True, doc="coefficients (J,), in um^-p")
    p: Any = param(REAL, spectral=True, doc="powers (J,)")
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        same_length(c=self.c, p=self.p)
        wavelength, c0, c, p = prepare(self, wavelength_nm, self.c0, self.c, self.p)
        powers = (wavelength / 1000)[..., None] ** p
        return from_permittivity(c0 + jnp.sum(c * powers, axis=-1))


@pytree
class WithExtinction:
    """Index whose n comes from one model and whose k from another: a glass with its measured absorption.

    Its range is what the two have in common.
    """

    index: Any
    extinction: Any

    @property
    def range_nm(self) -> Limits:
        """Wavelengths for which both hold."""
        ends = zip(limits(self.index), limits(self.extinction), strict=True)
        low, high = ([x for x in pair if x is not None] for pair in ends)
        return _extreme(jnp.maximum, low), _extreme(jnp.minimum, high)

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        (wavelength,) = prepare(self, wavelength_nm)
        return Index(self.index(wavelength).n, self.extinction(wavelength).k)


def _extreme(choose: Any, ends: list[Any]) -> Any:
    return choose(*ends) if len(ends) == 2 else (ends[0] if ends else None)
