"""Thick layers between coherent ones: powers are added in them, not amplitudes."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from ..params import Real, Result
from ..safe import safe_divide
from .given import Given, Half, Layers, given
from .layers import Medium, fields, medium, respond


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


def _group(at: Given, above: Medium, layers: tuple[Array, Array, Array], below: Medium) -> _Part:
    """Coherent layers between two media, lit from above."""
    found = respond(above, fields(at.c, layers, below), below)
    return _Part(found.reflected, found.kept, found.transmitted)


def _bounded(part: _Part) -> _Part:
    """What is lit from a thick layer: its two waves interfere if it absorbs, and r and t alone may make light."""
    kept = jnp.maximum(part.kept, 0.0)
    return _Part(jnp.minimum(part.reflected, 1.0), kept, jnp.minimum(part.transmitted, kept))


class _Thick(NamedTuple):
    """A thick layer: as what lies below coherent layers, as what a wave comes from, and how open it is."""

    below: Medium
    above: Medium
    open: Array


def _thick(below: Medium) -> _Thick:
    """Thick layer: open by 1 - (Im q / Re q)^2, 0 where its waves decay faster than they go on.

    There nothing comes from it, and a harmless medium stands for it.
    """
    shut = below.q.imag > below.q.real
    ratio = safe_divide(jnp.where(shut, 0.0, below.q.imag), jnp.where(shut, 1.0, below.q.real))
    above = Medium(jnp.where(shut, 1.0, below.q), jnp.where(shut, 1.0, below.y))
    return _Thick(below, above, jnp.where(shut, 0.0, 1 - ratio * ratio))


def _join(front: _Part, back: _Part, opened: Array, once: Array, lost: Array, rest: _Part) -> _Part:
    """Coherent layers, a thick one, and the rest: all reflections inside the thick layer summed.

    ``once`` is the power that is left after going through it once, ``lost`` what is lost in going twice, 1 - once^2.
    """
    round_trip = once * once
    returned = round_trip * rest.reflected
    left = lost + round_trip * rest.kept + returned * back.kept  # 1 - returned * back.reflected
    entering = front.transmitted * opened
    again = safe_divide(entering * returned * back.transmitted, left)
    through = safe_divide(entering * once * rest.transmitted, left)
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
    T is taken times 1 - (Im q / Re q)^2, T' as 1 - R' at most: R + T <= 1, and nothing passes where Im q > Re q.

    Args:
        cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside: as of `film`.
        thick: numbers of the thick layers, 0 the outermost; static.

    Returns:
        Powers(R_s, R_p, T_s, T_p), of the broadcast shape, with the unpolarised R, T and A.

    Raises:
        ValueError: as of `film`, or ``thick`` with a number that is no layer or comes twice.

    Differentiable as `film`; a thick layer at its critical angle counts as a half-space does. At exactly grazing
    incidence the slope of a lossless pane leaves out the light that has been inside. For k << n of the thick layers:
    the two waves in a strongly absorbing one do not carry power independently.
    Source: Byrnes, arXiv:1603.02720, section 5; Harbecke, Appl. Phys. B 39, 165 (1986).
    """
    at = given(cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside)
    count = at.layers[0].shape[0]
    numbers = _numbers(thick, count)
    eta, kappa, x = at.layers
    between = [_thick(medium(at.c, eta[number], kappa[number])) for number in numbers]
    above, below = [at.outside, *(t.above for t in between)], [*(t.below for t in between), at.inside]
    edges = itertools.pairwise([-1, *numbers, count])
    groups = [(eta[i + 1 : j], kappa[i + 1 : j], x[i + 1 : j]) for i, j in edges]
    rest = _group(at, above[-1], groups[-1], below[-1])
    rest = _bounded(rest) if numbers else rest
    for i in reversed(range(len(numbers))):
        depth = 2 * x[numbers[i]] * between[i].below.q.imag
        once, lost = jnp.exp(-depth), -jnp.expm1(-2 * depth)
        front = _group(at, above[i], groups[i], below[i])
        front = _bounded(front) if i else front
        turned = groups[i][0][::-1], groups[i][1][::-1], groups[i][2][::-1]
        back = _group(at, between[i].above, turned, at.outside if i == 0 else between[i - 1].below)
        rest = _join(front, _bounded(back), between[i].open, once, lost, rest)
    return Powers(*rest.reflected, *rest.transmitted)


def _numbers(thick: Any, count: int) -> list[int]:
    """Numbers of the thick layers in ascending order."""
    whole = isinstance(thick, (tuple, list)) and all(isinstance(i, (int, np.integer)) for i in thick)
    if not whole or any(isinstance(i, bool) or not 0 <= i < count for i in thick) or len(set(thick)) != len(thick):
        raise ValueError(f"thick = {thick!r} must be a tuple of different numbers of layers, 0 to {count - 1}")
    return sorted(int(i) for i in thick)
