r"""Colour of a reflectance spectrum: XYZ, linear sRGB, Lab, and the difference of two colours.

A colour is the product of a spectrum (..., n) and a matrix (n, 3), which is taken once from the tables of
colour-science and is a constant for JAX: colours have derivatives by everything that the spectrum depends on.

The spectrum between the given wavelengths is linear, and outside them constant. With the tables at a step d (5 nm if
the wavelengths are the grid of the tables 5 nm apart, else 1 nm), S the illuminant, xyz the observer and h_i the hat
function of wavelength i,

    matrix_i = sum_l h_i(l) S(l) xyz(l) / sum_l S(l) y(l),    l = 360, 360 + d, ..., 780 nm

so that on a grid of 1 or 5 nm it is the plain sum of CIE 15, and a perfect reflector has Y = 1 on any grid. A colour
out of the sRGB gamut stays as it is, negative or above 1, until `to_gamut` is called for display.
"""

from __future__ import annotations

import difflib
import functools
from collections.abc import Iterable
from types import ModuleType
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from .colourspace import BRADFORD, WHITE, XYZ_TO_RGB, rgb_to_lab, times, xyz_to_rgb
from .colourspace import rgb_to_xyz as rgb_to_xyz
from .colourspace import to_gamut as to_gamut
from .colourspace import xyz_to_lab as xyz_to_lab
from .params import Interval, floats, is_concrete, require
from .safe import safe_divide

OBSERVER = "CIE 1931 2 Degree Standard Observer"
FIRST, LAST = 360, 780
"""Ends of the sums in nanometres; the tables of most illuminants end at 780."""
WHITES = ("exact", "light", "colour")


def illuminants() -> list[str]:
    """Names of the illuminants that colour-science has a spectrum of."""
    return sorted(_science().SDS_ILLUMINANTS)


def observers() -> list[str]:
    """Names of the standard observers of colour-science."""
    return sorted(_science().colorimetry.MSDS_CMFS_STANDARD_OBSERVER)


def illuminant_power(illuminant: str, wavelength_nm: Float[ArrayLike, "n"]) -> Float[np.ndarray, "n"]:
    """Relative spectral power of an illuminant at wavelengths, linear between its tabulated points, its ends outside.

    Raises:
        ValueError: an illuminant that is not among `illuminants`; wavelengths as in `xyz_matrix`.
    """
    table = _science().SDS_ILLUMINANTS[_known("illuminant", illuminant, illuminants())]
    return np.interp(_wavelengths(wavelength_nm), table.wavelengths, table.values)


def spectral_locus(wavelength_nm: Float[ArrayLike, "n"], observer: str = OBSERVER) -> Float[np.ndarray, "n 2"]:
    """Chromaticities (x, y) of single wavelengths: the rim of the chromaticity diagram. Raises: as `xyz_matrix`."""
    table = _science().MSDS_CMFS[_known("observer", observer, observers())]
    xyz = np.stack([np.interp(_wavelengths(wavelength_nm), table.wavelengths, row) for row in table.values.T], -1)
    return xyz[:, :2] / xyz.sum(axis=1, keepdims=True)


def xyz_matrix(
    wavelength_nm: Float[ArrayLike, "n"], illuminant: str = "D65", observer: str = OBSERVER
) -> Float[np.ndarray, "n 3"]:
    """Matrix that takes a reflectance spectrum to XYZ, with Y = 1 for a perfect reflector: ``spectrum @ matrix``.

    Args:
        wavelength_nm: (n,) ascending, any spacing, one at least within 360 to 780 nm; n = 1 gives a grey.
        illuminant: one of `illuminants`; its table, interpolated by colour-science, ends constant.
        observer: one of `observers`.

    Returns:
        (n, 3), float64, read-only, the same array at every call.

    Raises:
        ValueError: wavelengths that are traced, out of order or all invisible; an unknown name, with those closest.

    Source: CIE 15:2004, 7.1; tables of colour-science.
    """
    light, eye = _known("illuminant", illuminant, illuminants()), _known("observer", observer, observers())
    return _xyz_matrix(tuple(_wavelengths(wavelength_nm).tolist()), light, eye)


def rgb_matrix(
    wavelength_nm: Float[ArrayLike, "n"], illuminant: str = "D65", observer: str = OBSERVER, white: str = "exact"
) -> Float[np.ndarray, "n 3"]:
    """Matrix that takes a reflectance spectrum to linear sRGB: ``spectrum @ matrix``, unclipped.

    Args:
        wavelength_nm, illuminant, observer: as in `xyz_matrix`.
        white: what a perfect reflector is.
            "exact": (1, 1, 1) under any illuminant: Bradford's adaptation from the illuminant to D65, as an eye or a
            camera that is used to the light;
            "light": the colour of the illuminant with Y = 1, no adaptation, so orange under A;
            "colour": the same through colour-science's rounded matrix, which is within 2e-4 of white under D65.

    Returns:
        (n, 3), float64, read-only, the same array at every call.

    Raises:
        ValueError: as in `xyz_matrix`; another ``white``.

    Source: IEC 61966-2-1; ICC.1:2022, annex E (Bradford).
    """
    light, eye = _known("illuminant", illuminant, illuminants()), _known("observer", observer, observers())
    return _rgb_matrix(tuple(_wavelengths(wavelength_nm).tolist()), light, eye, _known("white", white, WHITES))


def spectrum_to_xyz(
    reflectance: Float[ArrayLike, "... n"],
    wavelength_nm: Float[ArrayLike, "n"],
    illuminant: str | Float[ArrayLike, "n"] = "D65",
    observer: str = OBSERVER,
) -> Float[Array, "... 3"]:
    """XYZ of reflectance spectra, Y = 1 for a perfect reflector, in the dtype of the spectra.

    Args:
        reflectance: (..., n); not checked, so that differences and slopes have a colour too.
        wavelength_nm: (n,), as in `xyz_matrix`; not traced.
        illuminant: name, or relative power at the wavelengths (n,), [0, inf), not all 0: any light, with a derivative.
        observer: one of `observers`.

    Raises:
        ValueError: as in `xyz_matrix`; lengths that differ; a negative power.

    Differentiable in the spectra and in the power.
    """
    return times(reflectance, _any_matrix(reflectance, wavelength_nm, illuminant, observer))


def spectrum_to_rgb(
    reflectance: Float[ArrayLike, "... n"],
    wavelength_nm: Float[ArrayLike, "n"],
    illuminant: str | Float[ArrayLike, "n"] = "D65",
    observer: str = OBSERVER,
    white: str = "exact",
) -> Float[Array, "... 3"]:
    """Linear sRGB of reflectance spectra, unclipped, in the dtype of the spectra.

    Args, Raises, differentiability: as in `spectrum_to_xyz`; ``white`` as in `rgb_matrix`, where "colour" wants the
    name of an illuminant.
    """
    if isinstance(illuminant, str):
        return times(reflectance, _fitting(reflectance, rgb_matrix(wavelength_nm, illuminant, observer, white)))
    _known("white", white, ("exact", "light"))
    matrix = _any_matrix(reflectance, wavelength_nm, illuminant, observer)
    to_rgb = xyz_to_rgb(matrix, matrix.sum(axis=0) if white == "exact" else None)
    return times(reflectance, to_rgb)


def ciede2000(lab_1: Float[ArrayLike, "... 3"], lab_2: Float[ArrayLike, "... 3"]) -> Float[np.ndarray, "..."]:
    """Difference CIEDE2000 of two colours, or of each pair, in CIE Lab: 1 is just seen side by side.

    Args:
        lab_1, lab_2: (..., 3), as of `rgb_to_lab`; they broadcast.

    Raises:
        ValueError: a last axis that is not 3.

    Computed by colour-science on the host, so without a derivative. Source: CIE 142:2001, all weights 1.
    """
    _three(lab_1=lab_1, lab_2=lab_2)
    first, second = np.broadcast_arrays(np.asarray(lab_1, np.float64), np.asarray(lab_2, np.float64))
    return np.asarray(_science().delta_E(first, second, method="CIE 2000"))


def colour_difference(rgb_1: Float[ArrayLike, "... 3"], rgb_2: Float[ArrayLike, "... 3"]) -> Float[np.ndarray, "..."]:
    """CIEDE2000 between two results in linear sRGB, colour by colour or pixel by pixel; see `ciede2000`."""
    _three(rgb_1=rgb_1, rgb_2=rgb_2)
    return ciede2000(rgb_to_lab(rgb_1), rgb_to_lab(rgb_2))


def _three(**colours: Any) -> None:
    for name, value in colours.items():
        if np.shape(value)[-1:] != (3,):
            raise ValueError(f"{name} has shape {np.shape(value)}; the last axis must be the 3 numbers of a colour")


def _science() -> ModuleType:
    with np.printoptions():  # its import sets those of numpy, which are not ours to change
        import colour

    return colour


def _known(argument: str, name: str, names: Iterable[str]) -> str:
    """The name, if it is one; else an error that has the closest first."""
    names = list(names)
    if not isinstance(name, str):
        raise ValueError(f"{argument} = {name!r} must be a name")
    if name in names:
        return name
    closest = difflib.get_close_matches(str(name), names, n=5, cutoff=0.0)
    rest = [other for other in names if other not in closest]
    raise ValueError(f"{argument} = {name!r} must be one of {', '.join(closest + rest)}")


def _wavelengths(wavelength_nm: Any) -> np.ndarray:
    if not is_concrete(wavelength_nm):
        raise ValueError("wavelength_nm is traced; the matrix of a colour is made of tables, for given wavelengths")
    w = np.atleast_1d(np.asarray(wavelength_nm, np.float64))
    require("wavelength_nm", w, Interval.parse("[100, 100000]"))
    if w.ndim != 1 or not w.size or not (np.diff(w) > 0).all():
        raise ValueError(f"wavelength_nm has shape {w.shape}; it must be one ascending axis, in nanometres")
    if not ((w >= FIRST) & (w <= LAST)).any():
        raise ValueError(f"wavelength_nm = {w[0]:g} to {w[-1]:g}: none is within [{FIRST}, {LAST}]")
    return w


@functools.cache
def _tables(illuminant: str, observer: str, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wavelengths, power and observer at a step, as colour-science interpolates them."""
    science = _science()
    seen = science.MSDS_CMFS[observer]
    light = science.SDS_ILLUMINANTS[illuminant]
    ends = max(FIRST, float(seen.wavelengths[0])), min(LAST, float(seen.wavelengths[-1]))
    shape = science.SpectralShape(*ends, step)
    return shape.wavelengths, light.copy().align(shape).values, seen.copy().align(shape).values


@functools.cache
def _xyz_matrix(wavelengths: tuple[float, ...], illuminant: str, observer: str) -> np.ndarray:
    w = np.array(wavelengths)
    on_grid = w.size > 1 and np.allclose(np.diff(w), 5, rtol=0, atol=1e-4) and abs(w[0] - 5 * round(w[0] / 5)) < 1e-4
    table, power, seen = _tables(illuminant, observer, 5 if on_grid else 1)
    hats = np.stack([np.interp(table, w, unit) for unit in np.eye(w.size)])
    matrix: np.ndarray = hats @ (power[:, None] * seen) / (power @ seen[:, 1])
    matrix.setflags(write=False)
    return matrix


@functools.cache
def _rgb_matrix(wavelengths: tuple[float, ...], illuminant: str, observer: str, white: str) -> np.ndarray:
    xyz, to_rgb = _xyz_matrix(wavelengths, illuminant, observer), XYZ_TO_RGB
    if white == "colour":
        to_rgb = _science().RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB
    if white == "exact":
        scale = (BRADFORD @ WHITE) / (BRADFORD @ xyz.sum(axis=0))
        to_rgb = XYZ_TO_RGB @ np.linalg.solve(BRADFORD, scale[:, None] * BRADFORD)
    matrix: np.ndarray = xyz @ to_rgb.T
    if white == "exact":
        matrix /= matrix.sum(axis=0)  # what rounding left
    matrix.setflags(write=False)
    return matrix


def _fitting(reflectance: Any, matrix: Any) -> Any:
    shape = np.shape(reflectance)
    if not shape or shape[-1] != matrix.shape[0]:
        raise ValueError(f"reflectance has shape {shape}; the last axis must be the {matrix.shape[0]} wavelengths")
    return matrix


def _any_matrix(reflectance: Any, wavelength_nm: Any, illuminant: Any, observer: str) -> Any:
    """`xyz_matrix` of a name, or of the power of a light at the wavelengths: then of the dtype of the power."""
    if isinstance(illuminant, str):
        return _fitting(reflectance, xyz_matrix(wavelength_nm, illuminant, observer))
    require("illuminant", illuminant, Interval.parse("[0, inf)"))
    seen = _fitting(reflectance, xyz_matrix(wavelength_nm, "E", observer))
    if np.shape(illuminant) != seen.shape[:1]:
        raise ValueError(
            f"illuminant has shape {np.shape(illuminant)}; it must be {seen.shape[:1]}, as the wavelengths"
        )
    (power,) = floats(illuminant)
    if is_concrete(power) and not np.any(power):
        raise ValueError("illuminant is 0 at every wavelength; a light has some power")
    power = power / lax.stop_gradient(jnp.where(power.max() > 0, power.max(), 1.0))  # sums of it stay in range
    weighted = power[:, None] * jnp.asarray(seen, power.dtype)
    return safe_divide(weighted, weighted[:, 1].sum())
