"""Approximations of Fresnel reflectance: Schlick's family, with what each leaves out said in its docstring."""

from __future__ import annotations

import jax.numpy as jnp

from ..params import Real, Result, checked, floats
from ..safe import safe_divide, safe_power, safe_sqrt
from .exact import cos_theta_t, f0_conductor, f0_dielectric


@checked(cos_theta="[0, 1]", f0="[0, inf)", f90="[0, inf)", p="[0, inf)")
def schlick(cos_theta: Real, f0: Real, f90: Real = 1.0, p: Real = 5) -> Result:
    """Schlick's approximation f0 + (f90 - f0) (1 - cos theta)^p.

    Args:
        cos_theta: cosine of the angle of incidence, or of refraction if that is larger: see `schlick_dielectric`.
        f0: reflectance at normal incidence. Any colour channel; not clamped to 1.
        f90: reflectance at grazing incidence, 1 in the sources.
        p: exponent, [0, inf); 5 is Schlick's, D3D9 leaves it free (S1). A Python int is faster than a float.

    Differentiable in all four; at cos theta = 1 the slope for 0 < p < 1 is set to 0.
    Source: D3D9 (1); LAMBERT-FRESNEL, Schlick; C. Schlick, Computer Graphics Forum 13(3), 1994.
    """
    cos_theta, f0, f90 = floats(cos_theta, f0, f90)
    return f0 + (f90 - f0) * safe_power(1 - cos_theta, p)


@checked(cos_theta_i="[0, 1]", eta="(0, inf)")
def schlick_dielectric(cos_theta_i: Real, eta: Real) -> Result:
    """Schlick's approximation of a dielectric, with the angle taken on the rarer side.

    cos theta is cos theta_i for eta >= 1 and cos theta_t for eta < 1, and the result is 1 under total reflection; the
    sources do not say so (S40), and with theta_i on the denser side the error reaches 0.96.

    Args, Raises: as in `dielectric_sp`. Differentiable but at the critical angle. Source: D3D9 (1), (2);
    LAMBERT-FRESNEL.
    """
    mu, eta = floats(cos_theta_i, eta)
    return schlick(jnp.where(eta < 1, cos_theta_t(mu, eta), mu), f0_dielectric(eta))


@checked(cos_theta="[0, 1]", r0="[0, inf)", m="(-inf, inf)", p="[0, inf)")
def d3d9(cos_theta: Real, r0: Real, m: Real, p: Real) -> Result:
    """Generalised Schlick reflectance R = R0 + m (1 - cos theta)^p of the D3D9Client.

    Args:
        cos_theta: cosine of the view (or sun) angle, [0, 1].
        r0: offset, the reflectance at normal incidence.
        m: multiplier, most often 1 - r0; r0 + m > 1 makes the transmitted fraction 1 - R negative (S7): not checked.
        p: exponent, [0, inf); the document plots 2 and 4.

    Differentiable in all four. Source: D3D9 (3).
    """
    cos_theta, r0, m = floats(cos_theta, r0, m)
    return r0 + m * safe_power(1 - cos_theta, p)


@checked(cos_theta="[0, 1]", f0="[0, inf)", tint="[0, inf)")
def f82_tint(cos_theta: Real, f0: Real, tint: Real) -> Result:
    """Schlick's approximation corrected to hit a given reflectance near 82 degrees: S(mu) - a mu (1 - mu)^6.

    a is such that at mu = 1/7 (81.79 degrees) the value is ``tint`` times Schlick's, a = S(1/7) (1 - tint) /
    ((1/7) (6/7)^6): metals dip there before they rise to 1. Not clamped: extreme tints leave [0, 1].

    Args:
        cos_theta: cosine of the angle of incidence, [0, 1].
        f0: reflectance at normal incidence.
        tint: reflectance at mu = 1/7 over Schlick's, 1 for no correction.

    Differentiable in all three. Source: N. Hoffman, Workshop on Material Appearance Modeling, 2019 (F82), in the tint
    form of the Adobe Standard Material.
    """
    cos_theta, f0, tint = floats(cos_theta, f0, tint)
    a = schlick(1 / 7, f0) * (1 - tint) / (6**6 / 7**7)
    return schlick(cos_theta, f0) - a * cos_theta * safe_power(1 - cos_theta, 6)


@checked(cos_theta="[0, 1]", f0="[0, inf)", a="(-inf, inf)", exponent="[0, inf)")
def lazanyi(cos_theta: Real, f0: Real, a: Real, exponent: Real) -> Result:
    """Schlick's approximation with a metal's dip, S(mu) - a mu (1 - mu)^exponent.

    Args:
        cos_theta: cosine of the angle of incidence, [0, 1].
        f0: reflectance at normal incidence, of a conductor: `f0_conductor`.
        a, exponent: depth and position of the dip, fitted per metal.

    Differentiable in all four. Source: Lazanyi & Szirmay-Kalos, WSCG 2005 short papers, 77-80.
    """
    cos_theta, f0, a = floats(cos_theta, f0, a)
    return schlick(cos_theta, f0) - a * cos_theta * safe_power(1 - cos_theta, exponent)


@checked(r="[0, 1)", g="[0, 1]")
def gulbrandsen(r: Real, g: Real) -> tuple[Result, Result]:
    """Index (eta, k) of the conductor with normal reflectance r and edge tint g.

    eta = g (1 - r)/(1 + r) + (1 - g) (1 + sqrt r)/(1 - sqrt r), k^2 = (r (eta + 1)^2 - (eta - 1)^2)/(1 - r).

    Args:
        r: reflectance at normal incidence, [0, 1); eta and k grow without bound towards 1.
        g: edge tint, [0, 1]; at g = 0 k = 0, where the slope, infinite there, is set to 0.

    Differentiable for 0 < r and 0 < g. Source: O. Gulbrandsen, JCGT 3(4), 2014.
    """
    r, g = floats(r, g)
    root = safe_sqrt(r)
    low, high = (1 - r) / (1 + r), (1 + root) / (1 - root)
    eta = g * low + (1 - g) * high
    k2 = g * (high - low) * (eta - 1 / high)  # (high - eta)(eta - 1/high), the printed numerator factored
    return eta, safe_sqrt(k2)


@checked(eta="(0, inf)", k="[0, inf)")
def gulbrandsen_inverse(eta: Real, k: Real) -> tuple[Result, Result]:
    """Normal reflectance r and edge tint g of a conductor, the inverse of `gulbrandsen`; (0, 0) for eta = 1, k = 0."""
    eta, k = floats(eta, k)
    r, lost = f0_conductor(eta, k), 4 * eta / ((eta + 1) ** 2 + k * k)  # lost = 1 - r, without the difference
    root = safe_sqrt(r)
    low, high = lost / (1 + r), (1 + root) ** 2 / lost
    return r, safe_divide(high - eta, high - low)
