"""Reflection, transmission, absorption and phases of coherent layers."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array
from jaxtyping import Complex, Float

from ..params import Real, Result
from ..safe import safe_sqrt
from .given import Half, Layers, given
from .layers import fields, fields_everywhere, inverse, respond, square


class Film(NamedTuple):
    """Amplitude coefficients of the electric field, and the reflected and transmitted fractions of the power."""

    r_s: Complex[Array, "..."]
    r_p: Complex[Array, "..."]
    t_s: Complex[Array, "..."]
    t_p: Complex[Array, "..."]
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


class Phases(NamedTuple):
    """Phases of the four amplitudes in radians, (-pi, pi]; fields go as exp(-i w t), a longer way adds to them."""

    r_s: Result
    r_p: Result
    t_s: Result
    t_p: Result


class Ellipsometry(NamedTuple):
    """Ellipsometric angles in radians: psi in [0, pi / 2], delta in (-pi, pi]."""

    psi: Result
    delta: Result


def film(
    cos_theta: Real,
    wavelength_nm: Real,
    n: Layers,
    k: Layers,
    thickness_nm: Layers,
    outside: Real = 1.0,
    inside: Half = 1.5,
) -> Film:
    """Coherent layers between two half-spaces, by the characteristic matrices of `jaxrefl.films.layers`.

    Args:
        cos_theta: cosine of the angle of incidence in the outer medium, [0, 1].
        wavelength_nm: in vacuum, (0, inf).
        n, k, thickness_nm: (layers, ...) from the outside in: index (0, inf), extinction [0, inf), nm [0, inf); the
            axes after the first broadcast with the other arguments; a number is common to all layers.
        outside: real index of the medium of incidence, (0, inf).
        inside: index behind the layers: n, or a pair (n, k).

    Returns:
        Film(r_s, r_p, t_s, t_p, R_s, R_p, T_s, T_p), of the broadcast shape, with the unpolarised R, T and A;
        without layers it is `fresnel.amplitudes`. Phases refer to the outermost and the innermost interface.

    Raises:
        ValueError: an argument outside its range, or layers that differ in number (outside jit only).

    Differentiable in every argument, also where a layer is at its critical angle; where the inner medium is, k = 0,
    the true slope is infinite and a finite one is returned. Any depth of metal or of evanescent wave.
    Source: Abeles, Ann. Phys. (Paris) 5, 596 (1950); Born & Wolf, Principles of Optics, section 1.6.
    """
    at = given(cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside)
    found = respond(at.outside, fields(at.c, at.layers, at.inside), at.inside)
    (r_s, r_p), (t_s, t_p), back, on = found.r, found.t, found.reflected, found.transmitted
    return Film(r_s, r_p, t_s, t_p * inverse(at.index_inside), back[0], back[1], on[0], on[1])


def absorbed(
    cos_theta: Real,
    wavelength_nm: Real,
    n: Layers,
    k: Layers,
    thickness_nm: Layers,
    outside: Real = 1.0,
    inside: Half = 1.5,
) -> tuple[Float[Array, "layers ..."], Float[Array, "layers ..."]]:
    """Fractions of the power that each layer absorbs (s, p): the flux through its upper face minus that below it.

    Args, Raises: as of `film`.

    Returns:
        (A_s, A_p), each (layers, ...); 1 - R - T is their sum.

    Differentiable where `film` is. Source: Poynting's vector, Born & Wolf, section 1.1.4.
    """
    at = given(cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside)
    top, layer = fields_everywhere(at.c, at.layers, at.inside)
    passed = jnp.cumprod(square(layer.through), axis=0)
    at_top = jnp.concatenate([jnp.ones_like(passed[:1]), passed[:-1]]) * (layer.a * layer.b.conj()).real
    below = jnp.concatenate([at_top[1:], passed[-1:] * at.inside.y.real])
    y, over = at.outside.y, inverse(at.outside.y * top.a + top.b)
    share = 4 * (y.real * square(over)) * (at_top - below)
    return share[:, 0], share[:, 1]


def _angle(y: Array, x: Array) -> Result:
    """atan2(y, x) in (-pi, pi], 0 with slope 0 where both vanish."""
    nothing = x * x + y * y < jnp.finfo(x.dtype).tiny
    angle = jnp.where(nothing, 0.0, jnp.arctan2(y, jnp.where(nothing, 1.0, x)))
    return jnp.where(angle <= -jnp.pi, angle + 2 * jnp.pi, angle)  # of a y that is -0, or rounds to it


def _phase(z: Array) -> Result:
    return _angle(z.imag, z.real)


def phases(film: Film) -> Phases:
    """Phases of r_s, r_p, t_s, t_p in radians, (-pi, pi]; 0 with slope 0 where an amplitude vanishes.

    Source: the argument of the amplitudes of `film`; at normal incidence r_p = -r_s, so that their phases differ by pi.
    """
    return Phases(_phase(film.r_s), _phase(film.r_p), _phase(film.t_s), _phase(film.t_p))


def ellipsometry(film: Film) -> Ellipsometry:
    """Ellipsometric angles, tan(psi) exp(i delta) = r_p / r_s as instruments state it, for fields exp(+i w t).

    Our fields go as exp(-i w t), so delta = -arg(r_p / r_s). It is pi at normal incidence (r_p = -r_s) and falls to 0
    at grazing incidence on a bulk metal, through pi / 2 at its principal angle; a thin transparent film lowers it.

    Args:
        film: what `jaxrefl.films.film` returns.

    Returns:
        Ellipsometry(psi, delta) in radians, psi in [0, pi / 2], delta in (-pi, pi].

    Differentiable where neither amplitude vanishes; at such a point, Brewster's angle, the slopes are finite.
    Source: Azzam & Bashara, Ellipsometry and Polarized Light, section 4.2 (the Nebraska convention).
    """
    psi = _angle(safe_sqrt(square(film.r_p)), safe_sqrt(square(film.r_s)))
    return Ellipsometry(psi, _phase(film.r_s * film.r_p.conj()))
