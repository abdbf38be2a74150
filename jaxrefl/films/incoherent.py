"""Thick layers between coherent ones: powers are added in them, not amplitudes."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from ..params import Real, Result
from ..safe import safe_divide
from .given import Given, Half, Layers, given
from .layers import Medium, Response, fields, medium, respond


class Powers(NamedTuple):
    """Reflected and transmitted fractions of the power."""

    R_s: Result
    R_p: Result
    T_s: Result
    T_p: Result

    @property
    def R(self) -> Result:
        """Reflectance in unpolarised light, (R_s + R_p) / 2."""
        return 0.5 * (self.R_s + self.R_p)

    @property
    def T(self) -> Result:
        """Transmittance in unpolarised light, (T_s + T_p) / 2; into an absorbing medium, the power that enters it."""
        return 0.5 * (self.T_s + self.T_p)

    @property
    def A(self) -> Result:
        """Absorptance of the layers in unpolarised light, 1 - R - T."""
        return 1 - self.R - self.T


class _Part(NamedTuple):
    """What a part of the stack does: reflected, 1 - reflected, transmitted."""

    reflected: Array
    kept: Array
    transmitted: Array


def _group(at: Given, above: Medium, layers: tuple[Array, Array, Array], below: Medium) -> Response:
    """Coherent layers between two media, lit from above."""
    return respond(above, fields(at.c, layers, below), below)


def _join(front: Response, back: Response, once: Array, lost: Array, rest: _Part) -> _Part:
    """Coherent layers, a thick one, and the rest: all reflections inside the thick layer summed.

    ``once`` is the power that is left after going through it once, ``lost`` what is lost in going twice, 1 - once^2.
    """
    round_trip = once * once
    returned = round_trip * rest.reflected
    left = lost + round_trip * rest.kept + returned * back.kept  # 1 - returned * back.reflected
    again = safe_divide(front.transmitted * returned * back.transmitted, left)
    through = safe_divide(front.transmitted * once * rest.transmitted, left)
    return _Part(front.reflected + again, front.kept - again, through)


def incoherent(
    cos_theta: Real,
    wavelength_nm: Real,
    n: Layers,
    k: Layers,
    thickness_nm: Layers,
    thick: tuple[int, ...],
    outside: Real = 1.0,
    inside: Half = 1.0,
) -> Powers:
    """Coherent layers with thick ones between, in which powers add and nothing interferes (a pane, a wafer).

    Coherent layers with R, T from above and R', T' from below, over a thick layer with P = exp(-4 pi d Im q / lambda),
    over the rest with R_b, T_b: R_all = R + T T' P^2 R_b / (1 - R' P^2 R_b) and T_all = T P T_b / (1 - R' P^2 R_b).

    Args:
        cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside: as of `film`.
        thick: numbers of the thick layers, 0 the outermost; static.

    Returns:
        Powers(R_s, R_p, T_s, T_p), of the broadcast shape, with the unpolarised R, T and A.

    Raises:
        ValueError: as of `film`, or a number that is no layer or comes twice.

    Differentiable as `film`; a thick layer at its critical angle counts as a half-space does. At exactly grazing
    incidence the slope of a lossless pane leaves out the light that has been inside. For k << n of the thick layers:
    the two waves in a strongly absorbing one do not carry power independently.
    Source: Byrnes, arXiv:1603.02720, section 5; Harbecke, Appl. Phys. B 39, 165 (1986).
    """
    at = given(cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside)
    count = at.layers[0].shape[0]
    numbers = sorted(set(thick))
    if len(numbers) != len(thick) or any(not 0 <= number < count for number in numbers):
        raise ValueError(f"thick = {thick} must be different numbers of layers, 0 to {count - 1}")
    between = [medium(at.c, at.layers[0][number], at.layers[1][number]) for number in numbers]
    media, (eta, kappa, x) = [at.outside, *between, at.inside], at.layers
    edges = itertools.pairwise([-1, *numbers, count])
    groups = [(eta[i + 1 : j], kappa[i + 1 : j], x[i + 1 : j]) for i, j in edges]
    last = _group(at, media[-2], groups[-1], media[-1])
    rest = _Part(last.reflected, last.kept, last.transmitted)
    for i in reversed(range(len(numbers))):
        depth = 2 * x[numbers[i]] * between[i].q.imag
        once, lost = jnp.exp(-depth), -jnp.expm1(-2 * depth)
        front = _group(at, media[i], groups[i], media[i + 1])
        turned = groups[i][0][::-1], groups[i][1][::-1], groups[i][2][::-1]
        back = _group(at, media[i + 1], turned, media[i])
        rest = _join(front, back, once, lost, rest)
    return Powers(*rest.reflected, *rest.transmitted)
