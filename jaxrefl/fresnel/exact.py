r"""Fresnel's equations for a smooth interface, exactly.

Every function is a scalar formula that broadcasts. ``eta`` = n_t / n_i and ``k`` (relative to n_i too) make the complex
index N = eta + i k, time factor exp(-i w t); cos theta_i is measured in the medium of incidence. With
c = cos theta_i, q = N cos theta_t = sqrt(N^2 - sin^2 theta_i), Im q >= 0, the amplitudes of LAMBERT-FRESNEL are

    r_s = (c - q) / (c + q)         =  (1 - N^2) / (c + q)^2
    r_p = (N^2 c - q)/(N^2 c + q)   =  (N^2 - 1) (q^2 - N^2 sin^2 theta_i) / (N^2 c + q)^2

The right-hand forms are the ones computed: nothing cancels in them at N -> 1, and where R is large it is 1 - T,
so that a small R, a small 1 - R and their slopes all have the relative accuracy of the arithmetic. The real and
imaginary parts of q come from the larger of the two, |N^2 - s^2| never from a difference, which is what keeps value
and slope finite at k = 0 inside total reflection. At the critical angle itself, k = 0, the true derivative is
infinite; the one returned there is finite.

In float32 value and slope are finite and accurate for eta in [1e-4, 1e4] and k up to 1e4: beyond, powers of |N| leave
the range of the type. The source prints Fresnel with two l (S35), and "a^2 + b^2 = sqrt(...)", which holds only for
indices divided by n_i (S39), as here.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax
from jaxtyping import Complex

from ..params import Real, Result, checked, floats
from ..safe import safe_divide, safe_sqrt


class Amplitudes(NamedTuple):
    """Complex amplitude coefficients of the electric field, in reflection (r) and transmission (t)."""

    r_s: Complex[Array, "..."]
    r_p: Complex[Array, "..."]
    t_s: Complex[Array, "..."]
    t_p: Complex[Array, "..."]


def _root(re: Array, im: Array) -> tuple[Array, Array]:
    """Principal square root a + i b of re + i im, for im >= 0: the larger part first, the other from a b = im / 2."""
    magnitude = jnp.where(re < 0, -re, re)
    large = safe_sqrt(0.5 * (safe_sqrt(re * re + im * im) + magnitude))
    small = safe_divide(0.5 * im, large)
    return jnp.where(re < 0, small, large), jnp.where(re < 0, large, small)


def _q_squared(mu: Array, eta: Array) -> Array:
    """eta^2 - sin^2 theta_i, in the arrangement that loses least on either side of eta^2 = 1/2."""
    return jnp.where(eta < 0.7, eta * eta - (1 - mu) * (1 + mu), (eta - 1) * (eta + 1) + mu * mu)


def _brewster(mu: Array, q2: Array, n2: Array, small: Array) -> Array:
    """N^2 cos^2 theta_i - sin^2 theta_i, the factor of r_p that vanishes at Brewster's angle.

    For |N| < 0.7 it is q^2 - N^2 sin^2 theta_i, with the same q^2 as in the denominators: near the critical angle their
    roundings then cancel as the slopes of R_s and R_p do.
    """
    sin2 = (1 - mu) * (1 + mu)
    return jnp.where(small, q2 - n2 * sin2, n2 * mu * mu - sin2)


def _refracted(mu: Array, eta: Array, k: Array) -> tuple[Array, Array]:
    """Real and imaginary part of q = sqrt(N^2 - sin^2 theta_i)."""
    return _root(_q_squared(mu, eta) - k * k, 2 * eta * k)


def _smaller_first(r: Array, t: Array) -> Array:
    """Reflectance from r or from 1 - t, whichever is small: R, 1 - R and their slopes keep their relative accuracy."""
    return jnp.where(t > 0.5, r, 1 - t)


@checked(cos_theta_i="[0, 1]", eta="(0, inf)")
def dielectric_sp(cos_theta_i: Real, eta: Real) -> tuple[Result, Result]:
    """Reflectances (R_s, R_p) of a smooth interface between two dielectrics, R = r^2.

    Args:
        cos_theta_i: cosine of the angle of incidence, [0, 1].
        eta: relative index n_t / n_i, (0, inf).

    Returns:
        (R_s, R_p), broadcast shape; both 1 under total reflection (sin theta_i >= eta); both 0 for eta = 1.

    Raises:
        ValueError: an argument outside its range (outside jit only).

    Differentiable everywhere but at the critical angle, where the one-sided derivative below it is infinite and the
    finite 0 from above is returned. Source: LAMBERT-FRESNEL, dielectric; the printed eta = eta_t / eta_i means
    n_t / n_i (S38), total reflection is not mentioned there (S40).
    """
    mu, eta = floats(cos_theta_i, eta)
    total = (_q_squared(mu, eta) <= 0) & (eta < 1)
    mu = jnp.where(total, 1.0, mu)  # a harmless angle, so that the branch not taken has a finite slope
    contrast, eta2, q2 = (eta - 1) * (eta + 1), eta * eta, _q_squared(mu, eta)
    # reached at eta = 1 and grazing incidence alone, where the slope of q would leave the dtype
    q = safe_sqrt(jnp.where(q2 < jnp.sqrt(jnp.finfo(q2.dtype).tiny), lax.stop_gradient(q2), q2))
    over_s, over_p = safe_divide(1.0, mu + q), safe_divide(1.0, eta2 * mu + q)
    r_s = contrast * over_s * over_s
    r_p = contrast * over_p * _brewster(mu, q2, eta2, eta < 0.7) * over_p
    big_r_s = _smaller_first(r_s * r_s, safe_divide(4 * mu * q, (mu + q) ** 2, fill=1.0))
    big_r_p = _smaller_first(r_p * r_p, safe_divide(4 * eta2 * mu * q, (eta2 * mu + q) ** 2, fill=1.0))
    return jnp.where(total, 1.0, big_r_s), jnp.where(total, 1.0, big_r_p)


@checked(cos_theta_i="[0, 1]", eta="(0, inf)")
def dielectric(cos_theta_i: Real, eta: Real) -> Result:
    """Reflectance (R_s + R_p) / 2 of a smooth dielectric interface in unpolarised light; see `dielectric_sp`.

    Source: LAMBERT-FRESNEL, Fr = (r_s^2 + r_p^2) / 2.
    """
    r_s, r_p = dielectric_sp(cos_theta_i, eta)
    return 0.5 * (r_s + r_p)


def _conductor_powers(c: Array, eta: Array, k: Array, a: Array, b: Array) -> tuple[Array, ...]:
    """N^2 (real, imaginary), |c + q|^2, |N^2 c + q|^2 and the transmitted powers T_s, T_p, for q = a + i b."""
    n2_re, n2_im = eta * eta - k * k, 2 * eta * k  # not a product: its slope in k would cancel at k -> 0
    den_s, den_p = (c + a) ** 2 + b * b, (n2_re * c + a) ** 2 + (n2_im * c + b) ** 2
    t_s = safe_divide(4 * c * a, den_s, fill=1.0)
    t_p = safe_divide(4 * c * (n2_re * a + n2_im * b), den_p, fill=1.0)
    return n2_re, n2_im, den_s, den_p, t_s, t_p


@checked(cos_theta_i="[0, 1]", eta="(0, inf)", k="[0, inf)")
def conductor_sp(cos_theta_i: Real, eta: Real, k: Real) -> tuple[Result, Result]:
    """Reflectances (R_s, R_p) of a smooth conductor seen from a dielectric, R = |r|^2.

    Args:
        cos_theta_i: cosine of the angle of incidence, [0, 1].
        eta: real part of the relative index, (0, inf).
        k: extinction coefficient over n_i, [0, inf); k = 0 gives the dielectric, total reflection included.

    Returns:
        (R_s, R_p), broadcast shape.

    Raises:
        ValueError: an argument outside its range (outside jit only).

    Differentiable everywhere but at the one point sin theta_i = eta, k = 0, where it is finite. Inside total reflection
    dR/dk at k = 0 is the analytic slope (attenuated total reflection). Source: LAMBERT-FRESNEL, conductor. Printed
    there: (r_s^2 + r_p^2) / 2 with complex r, which must be |r|^2 (S36); `theta tan^2 theta` as the denominator of the
    first R_p, which must be a^2 + b^2 + 2 a sin tan + sin^2 tan^2 (S37); n - i k (S41), the other time convention.
    """
    c, eta, k = floats(cos_theta_i, eta, k)
    a, b = _refracted(c, eta, k)
    n2_re, n2_im, den_s, den_p, t_s, t_p = _conductor_powers(c, eta, k, a, b)
    over_s, over_p = safe_divide(1.0, den_s), safe_divide(1.0, den_p)
    minus, plus = (eta - 1) ** 2 + k * k, (eta + 1) ** 2 + k * k  # |N - 1|^2, |N + 1|^2
    real = _brewster(c, _q_squared(c, eta) - k * k, n2_re, eta * eta + k * k < 0.5)
    bracket = real * real + (n2_im * c * c) ** 2
    r_s = (minus * over_s) * (plus * over_s)
    r_p = (minus * plus * over_p) * (bracket * over_p)
    return _smaller_first(r_s, t_s), _smaller_first(r_p, t_p)


@checked(cos_theta_i="[0, 1]", eta="(0, inf)", k="[0, inf)")
def conductor(cos_theta_i: Real, eta: Real, k: Real) -> Result:
    """Reflectance (R_s + R_p) / 2 of a smooth conductor in unpolarised light; see `conductor_sp`.

    Source: LAMBERT-FRESNEL, Fr = (R_s + R_p) / 2.
    """
    r_s, r_p = conductor_sp(cos_theta_i, eta, k)
    return 0.5 * (r_s + r_p)


@checked(cos_theta_i="[0, 1]", eta="(0, inf)", k="[0, inf)")
def amplitudes(cos_theta_i: Real, eta: Real, k: Real = 0.0) -> Amplitudes:
    """Complex amplitude coefficients of the electric field.

    r_s = (c - q)/(c + q), t_s = 1 + r_s, r_p = (N^2 c - q)/(N^2 c + q), t_p = (1 + r_p)/N; at normal incidence
    r_p = -r_s. Under total reflection |r| = 1 and arg r_s = -2 atan(sqrt(s^2 - eta^2) / c), arg r_p =
    -2 atan(sqrt(s^2 - eta^2) / (eta^2 c)), negative because fields go as exp(-i w t).

    Args:
        cos_theta_i, eta, k: as in `conductor_sp`.

    Returns:
        Amplitudes(r_s, r_p, t_s, t_p), complex, broadcast shape.

    Differentiable but at the critical angle (k = 0), where it is finite. Source: LAMBERT-FRESNEL; Born & Wolf,
    Principles of Optics, section 1.5.
    """
    c, eta, k = floats(cos_theta_i, eta, k)
    q, n = lax.complex(*_refracted(c, eta, k)), lax.complex(*jnp.broadcast_arrays(eta, k))
    n2_re, n2_im = eta * eta - k * k, 2 * eta * k  # not a product: its slope in k would cancel at k -> 0
    real = _brewster(c, _q_squared(c, eta) - k * k, n2_re, eta * eta + k * k < 0.5)
    over_s, over_p = safe_divide(1.0, c + q), safe_divide(1.0, n * n * c + q)
    r_s = (1 - n) * over_s * (1 + n) * over_s
    r_p = (n - 1) * (n + 1) * over_p * lax.complex(*jnp.broadcast_arrays(real, n2_im * c * c)) * over_p
    t_s, t_p = safe_divide(2 * c, c + q, fill=1.0), safe_divide(2 * n * c, n * n * c + q, fill=1.0)
    return Amplitudes(*jnp.broadcast_arrays(r_s, r_p, t_s, t_p))


@checked(cos_theta_i="[0, 1]", eta="(0, inf)", k="[0, inf)")
def transmittance_sp(cos_theta_i: Real, eta: Real, k: Real = 0.0) -> tuple[Result, Result]:
    """Transmitted fraction of the power (T_s, T_p): T = Re(n_t cos theta_t) / (n_i cos theta_i) |t|^2 for s.

    T_s = 4 c Re q / |c + q|^2, T_p = 4 c Re(N^2 q*) / |N^2 c + q|^2, with the index and cosine factors in. R + T = 1,
    and T is accurate where R is close to 1. For k > 0 it is the power that enters the metal, all of which it absorbs.
    (Radiance crossing a dielectric interface scales by T eta^2; power does not.)

    Args, Raises: as in `conductor_sp`. Returns (T_s, T_p), broadcast shape; 0 under total reflection.

    Differentiable where the reflectances are. Source: LAMBERT-FRESNEL with Born & Wolf, section 1.5.
    """
    c, eta, k = floats(cos_theta_i, eta, k)
    *_, t_s, t_p = _conductor_powers(c, eta, k, *_refracted(c, eta, k))
    return t_s, t_p


@checked(cos_theta_i="[0, 1]", eta="(0, inf)")
def cos_theta_t(cos_theta_i: Real, eta: Real) -> Result:
    """Cosine of the angle of refraction, sqrt(1 - sin^2 theta_i / eta^2); 0 under total reflection.

    Args: as in `dielectric_sp`. Differentiable but at the critical angle, where the slope is set to 0.
    Source: LAMBERT-FRESNEL, Snell's law n_i sin theta_i = n_t sin theta_t.
    """
    mu, eta = floats(cos_theta_i, eta)
    return safe_sqrt(_q_squared(mu, eta)) / eta


@checked(eta="(0, inf)")
def f0_dielectric(eta: Real) -> Result:
    """Reflectance of a dielectric at normal incidence, ((eta - 1) / (eta + 1))^2.

    Source: D3D9 (2), printed as [(1 - n)/(1 + n)]^2; LAMBERT-FRESNEL, R(0) of a dielectric.
    """
    (eta,) = floats(eta)
    return ((eta - 1) / (eta + 1)) ** 2


@checked(eta="(0, inf)", k="[0, inf)")
def f0_conductor(eta: Real, k: Real) -> Result:
    """Reflectance of a conductor at normal incidence, ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2).

    Source: LAMBERT-FRESNEL, R(0) of a conductor.
    """
    eta, k = floats(eta, k)
    return ((eta - 1) ** 2 + k * k) / ((eta + 1) ** 2 + k * k)


@checked(eta="(0, inf)")
def brewster_angle(eta: Real) -> Result:
    """Angle of incidence in radians at which R_p = 0: arctan(eta). Born & Wolf, section 1.5."""
    (eta,) = floats(eta)
    return jnp.arctan(eta)


@checked(eta="(0, 1]")
def critical_angle(eta: Real) -> Result:
    """Angle of incidence in radians beyond which reflection is total: arcsin(eta), for eta = n_t / n_i in (0, 1].

    From glass of index n into air, eta = 1 / n. At eta = 1 the value is pi / 2 and the slope, infinite there, is set
    to 0; under jit the same is returned for eta > 1 (no total reflection). Source: LAMBERT-FRESNEL, Snell's law.
    """
    (eta,) = floats(eta)
    return jnp.arctan2(eta, safe_sqrt((1 - eta) * (1 + eta)))
