r"""The D3D9Client reflection model, equations (4)-(8), as formulas of colours.

    r     = lambda (1 - R) phi                                                   (4) metallic reflection
    R_tot = (lambda (1 - R) + s R) phi                                           (5) total reflection
    c     = d (1 - |lambda|) + R_tot                                             (6) pixel
    c_a   = max(d_a, |R_tot|)                                                    (7) alpha
    c     = d (1 - |lambda|) (1 - R0 - m (1 - cos sigma)^p) + R_tot              (8) pixel, with the sun angle

with R = R0 + m (1 - cos theta)^p from `jaxrefl.fresnel.d3d9`. A colour is an array (C,), one pixel; map over pixels
with `vmap`. |lambda| is not defined in the document (S3): the Euclidean norm makes 1 - |lambda| negative for a grey
above 1/sqrt(3), so the largest channel is taken, as the client's shaders do. What these formulas do to energy is in
`docs/sources.md` and in the figure d3d9_energy: (6) adds light, (8) conserves it but is not reciprocal. Later client
code dropped R0 and weighs lambda by a luminance whose weights sum to 1.4 (S10): implemented is what the document says.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax
from jax.typing import ArrayLike
from jaxtyping import Float

from .fresnel import average_dielectric, d3d9, dielectric, f0_dielectric
from .params import Interval, checked, floats, require
from .quadrature import Rule
from .safe import safe_power, safe_sqrt

Color = Float[ArrayLike, "*C"]
Scalar = Float[ArrayLike, ""]


def max_norm(color: Color) -> Float[Array, ""]:
    """Largest channel of a colour (C,), or the number itself; the document's |lambda| and |R_tot| (S3).

    At a tie the derivative is shared equally among the largest channels.
    """
    (color,) = floats(color)
    return jnp.max(jnp.atleast_1d(color), axis=-1)


def euclidean_norm(color: Color) -> Float[Array, ""]:
    """Length of a colour (C,): the other reading of |lambda|, kept for comparison (S3). Its slope at black is 0."""
    (color,) = floats(color)
    return safe_sqrt(jnp.sum(jnp.atleast_1d(color) ** 2, axis=-1))


@checked(metallic="[0, 1]", phi="[0, inf)")
def metallic_reflection(metallic: Color, reflectance: Scalar, phi: Color = 1.0) -> Float[Array, "*C"]:
    """Metallic reflection r = lambda (1 - R) phi under a Fresnel layer.

    Args:
        metallic: lambda, reflectivity colour (C,), [0, 1].
        reflectance: R, from `jaxrefl.fresnel.d3d9`; 1 - R counts one crossing of the layer only (S8).
        phi: colour of the incoming light (C,), [0, inf).

    Source: D3D9 (4).
    """
    metallic, reflectance, phi = floats(metallic, reflectance, phi)
    return metallic * (1 - reflectance) * phi


@checked(metallic="[0, 1]", phi="[0, inf)", specular="[0, 1]")
def total_reflection(
    metallic: Color, reflectance: Scalar, phi: Color = 1.0, specular: Color = 1.0
) -> Float[Array, "*C"]:
    """Total reflection R_tot = (lambda (1 - R) + s R) phi.

    With s = 1 and m = 1 - R0 this is Schlick with F0' = lambda + R0 (1 - lambda), per channel, same p: see
    `schlick_f0`. The text above (5) adds r + R without s and phi (S2).

    Args:
        metallic, reflectance, phi: as in `metallic_reflection`.
        specular: s, colour of the Fresnel reflection, white in the document.

    Source: D3D9 (5).
    """
    reflectance, phi, specular = floats(reflectance, phi, specular)
    return metallic_reflection(metallic, reflectance, phi) + specular * reflectance * phi


@checked(metallic="[0, 1]", r0="[0, 1]")
def schlick_f0(metallic: Color, r0: Scalar) -> Float[Array, "*C"]:
    """F0' = lambda + R0 (1 - lambda) for which (5), with s = 1 and m = 1 - R0, is Schlick's formula."""
    metallic, r0 = floats(metallic, r0)
    return metallic + r0 * (1 - metallic)


@checked(diffuse="[0, inf)", metallic_norm="[0, inf)")
def pixel(diffuse: Color, metallic_norm: Scalar, r_tot: Color, sun_reflectance: Scalar = 0.0) -> Float[Array, "*C"]:
    """Pixel colour d (1 - |lambda|) (1 - R(sigma)) + R_tot.

    With ``sun_reflectance`` = 0 this is (6), which does not take from the diffuse light what the surface reflects
    (S4: the total is 1 + R (1 - lambda)); with R(sigma) = R0 + m (1 - cos sigma)^p it is (8), where one Fresnel factor
    stands on the way in and none on the way out (S6).

    Args:
        diffuse: d, diffuse or texture colour (C,).
        metallic_norm: |lambda|, from `max_norm` (or `euclidean_norm`, to see what it does).
        r_tot: from `total_reflection`.
        sun_reflectance: R at the sun angle sigma.

    Source: D3D9 (6), (8). The printed c_rgb lacks the arrow of a vector (S9).
    """
    diffuse, metallic_norm, r_tot, sun_reflectance = floats(diffuse, metallic_norm, r_tot, sun_reflectance)
    return diffuse * (1 - metallic_norm) * (1 - sun_reflectance) + r_tot


@checked(diffuse_alpha="[0, 1]", r_tot="[0, inf)")
def alpha_printed(diffuse_alpha: Scalar, r_tot: Color) -> Float[Array, ""]:
    """Alpha as printed, max(d_a, |R_tot|).

    |R_tot| contains the light phi, so that alpha grows with exposure and may exceed 1; and the straight blend
    multiplies the reflection, which is already there in full, by alpha once more (S5). See `alpha_premultiplied`.

    Source: D3D9 (7), where the scalar c_a carries an arrow.
    """
    (diffuse_alpha,) = floats(diffuse_alpha)
    return jnp.maximum(diffuse_alpha, max_norm(r_tot))


@checked(diffuse_alpha="[0, 1]", reflectance="[0, 1]")
def alpha_premultiplied(diffuse_alpha: Scalar, reflectance: Color) -> Float[Array, ""]:
    """Alpha for the premultiplied blend: 1 - (1 - d_a) (1 - |rho|), rho = lambda (1 - R) + s R without the light.

    What is neither reflected nor covered shows the background. Equal to the maximum of (7) where d_a is 0 or 1; in
    between the maximum would let reflection, coverage and background sum to more than 1.

    Source: D3D9 (7), corrected (S5).
    """
    (diffuse_alpha,) = floats(diffuse_alpha)
    return 1 - (1 - diffuse_alpha) * (1 - max_norm(reflectance))


def blend(color: Color, alpha: Scalar, background: Color) -> Float[Array, "*C"]:
    """Straight alpha blend alpha c + (1 - alpha) background, the one (7) is printed for."""
    color, alpha, background = floats(color, alpha, background)
    return alpha * color + (1 - alpha) * background


def blend_premultiplied(color: Color, alpha: Scalar, background: Color) -> Float[Array, "*C"]:
    """Premultiplied blend c + (1 - alpha) background, for a colour that already holds its coverage."""
    color, alpha, background = floats(color, alpha, background)
    return color + (1 - alpha) * background


class Fit(NamedTuple):
    """Parameters of eq (3) and the root-mean-square error they leave, in reflectance."""

    r0: Array
    m: Array
    p: Array
    rms: Array


def best_fit(eta: Scalar, rule: Rule, free_multiplier: bool = True) -> Fit:
    """Least-squares (m, p) of R0 + m (1 - cos theta)^p to the exact dielectric, with the exact R0.

    What to type for a material of index eta. For each p the best m is linear, m = <b, y> / <b, b> with
    b = (1 - mu)^p; p minimises what is left: the best of a grid on [1/4, 400], golden section, Newton. A free m gives
    R(90 deg) < 1; without it m = 1 - R0.

    Args:
        eta: relative index, [1.001, 10]; towards 1 the best p, towards infinity the best m leave all sense.
        rule: where the fit should be good: `uniform_theta_rule`, `uniform_cosine_rule` or `cosine_rule`.
        free_multiplier: False for m = 1 - R0.

    Returns:
        Fit(r0, m, p, rms), in the dtype of the rule.

    Raises:
        ValueError: eta outside its range.
    """
    require("eta", eta, Interval.parse("[1.001, 10]"))
    return _best_fit(jnp.asarray(eta, rule.node.dtype), rule, free_multiplier)


@functools.partial(jax.jit, static_argnames="free_multiplier")
def _best_fit(eta: Array, rule: Rule, free_multiplier: bool) -> Fit:
    mu, weight = rule
    r0 = f0_dielectric(eta)
    target = dielectric(mu, eta) - r0

    def multiplier(p: Array) -> Array:
        base = safe_power(1 - mu, p)
        return jnp.sum(weight * base * target) / jnp.sum(weight * base * base) if free_multiplier else 1 - r0

    def residual(p: Array) -> Array:
        return jnp.sum(weight * (multiplier(p) * safe_power(1 - mu, p) - target) ** 2)

    golden = (5**0.5 - 1) / 2

    def shrink(_: int, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        left, right = high - golden * (high - low), low + golden * (high - low)
        go_left = residual(left) < residual(right)
        return jnp.where(go_left, low, left), jnp.where(go_left, right, high)

    def polish(_: int, p: Array) -> Array:
        """Newton step, not taken where rounding or a flat residual would lead it out of the bracket."""
        step = p - slope(p) / curvature(p)
        return jnp.where((step > below) & (step < above), step, p)

    grid = jnp.geomspace(0.25, 400.0, 100, dtype=mu.dtype)
    best = jnp.clip(jnp.argmin(jax.vmap(residual)(grid)), 1, 98)
    below, above = grid[best - 1], grid[best + 1]
    low, high = lax.fori_loop(0, 30, shrink, (below, above))
    slope, curvature = jax.grad(residual), jax.grad(jax.grad(residual))
    p = lax.fori_loop(0, 4, polish, 0.5 * (low + high))
    return Fit(r0, multiplier(p), p, jnp.sqrt(residual(p) / jnp.sum(weight)))


@checked(eta="(1, 4.4]")
def energy_exponent(eta: Float[ArrayLike, "..."]) -> Float[Array, "..."]:
    """Exponent p for which eq (3) with m = 1 - R0 has the exact average reflectance: the energy is then right.

    p = (-3 + sqrt(1 + 8 (1 - R0) / (F_avg - R0))) / 2, with F_avg from `average_dielectric`. It grows without bound
    towards eta = 4.448, where the average falls below R0 and no exponent serves: the range is (1, 4.4].
    """
    (eta,) = floats(eta)
    r0 = f0_dielectric(eta)
    return 0.5 * (-3 + jnp.sqrt(1 + 8 * (1 - r0) / (average_dielectric(eta) - r0)))


__all__ = [
    "Fit",
    "alpha_premultiplied",
    "alpha_printed",
    "best_fit",
    "blend",
    "blend_premultiplied",
    "d3d9",
    "energy_exponent",
    "euclidean_norm",
    "max_norm",
    "metallic_reflection",
    "pixel",
    "schlick_f0",
    "total_reflection",
]
