"""Lights: what reaches a point, from where, in three intensities that JHU's equation keeps apart.

A light is any dataclass with ``at(p) -> Illumination``, the intensities ``diffuse``, ``specular`` and ``ambient``, and
``shadows``; `Ambient` has no place and no direction. Intensities are (C,)
and defined so that a white Lambert surface that faces the light shows a radiance equal to it (irradiance = pi times
the intensity), before attenuation. A user's own light is a dataclass in the user's own file.
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from .params import param, pytree
from .safe import exp_log_power, safe_divide
from .vec import Vec3, dot, norm, normalize

Scalar = Float[Array, ""]


class Illumination(NamedTuple):
    """What one light sends to one point."""

    wi: Vec3
    """Unit direction to the light."""
    distance: Array
    """() distance to it, inf for a directional light: what lies farther away casts no shadow."""
    factor: Array
    """() attenuation times spotlight effect, f_att S_j, [0, inf)."""


def attenuation(distance: Scalar, constant: Any, linear: Any, quadratic: Any) -> Scalar:
    """Attenuation factor 1 / (a + b d + c d^2); (0, 0, 1) is the inverse square law.

    0 where the denominator is 0. Source: JHU, "Local Illumination Equation", f_att.
    """
    return safe_divide(1.0, constant + distance * (linear + distance * quadratic))


def spot_effect(cos_angle: Scalar, exponent: Any, cutoff: Any) -> Scalar:
    """Spotlight effect max(0, -L_N . L)^s inside the cone of half angle ``cutoff``, 0 outside.

    Args:
        cos_angle: -L_N . L, cosine of the angle between the axis of the light and the ray from it.
        exponent: s, [0, inf); s = 0 is a uniform cone.
        cutoff: radians, (0, pi].

    Source: JHU, "Spotlights", where L_N . L lacks its minus and its clamp (S25).
    """
    inside = cos_angle >= jnp.cos(cutoff) - 4 * jnp.finfo(cos_angle.dtype).eps
    return jnp.where(inside, exp_log_power(cos_angle, exponent), 0.0)


@pytree
class Ambient:
    """Global ambient light I_a, the constant that stands for the product of many reflections.

    Source: JHU, "Phong Reflection Model: Ambient Component" (called the global light intensity later, S28).
    """

    intensity: Any = param("[0, inf)", spectral=True, default=0.2, doc="I_a")


@pytree
class Directional:
    """Light at infinity: the same direction everywhere, no attenuation.

    Source: JHU, "Point vs. Directional Light Sources".
    """

    direction: Any = param("(-inf, inf)", vector=True, nonzero=True, doc="where the light travels, of any length but 0")
    diffuse: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_d")
    specular: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_s")
    ambient: Any = param("[0, inf)", spectral=True, default=0.0, doc="I_aj; attenuated, not shadowed")
    shadows: bool = dataclasses.field(default=True, metadata={"static": True})

    def at(self, p: Vec3) -> Illumination:
        """Illumination of a point."""
        one = jnp.ones_like(p.x)
        return Illumination(-normalize(self.direction), one * jnp.inf, one)


@pytree
class PointLight:
    """Light that shines equally in all directions, attenuated by 1 / (constant + linear d + quadratic d^2).

    Without attenuation by default, as printed; constant = 0, quadratic = 1 is the inverse square law. Source: JHU,
    "Point vs. Directional Light Sources".
    """

    position: Any = param("(-inf, inf)", vector=True, doc="where it is")
    diffuse: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_d")
    specular: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_s")
    ambient: Any = param("[0, inf)", spectral=True, default=0.0, doc="I_aj; attenuated, not shadowed")
    constant: Any = param("[0, inf)", default=1.0, doc="attenuation, constant term")
    linear: Any = param("[0, inf)", unit="1/length", default=0.0, doc="attenuation, linear term")
    quadratic: Any = param("[0, inf)", unit="1/length^2", default=0.0, doc="attenuation, quadratic term")
    shadows: bool = dataclasses.field(default=True, metadata={"static": True})

    def at(self, p: Vec3) -> Illumination:
        """Illumination of a point."""
        to_light = self.position - p
        distance = norm(to_light)
        factor = attenuation(distance, self.constant, self.linear, self.quadratic)
        return Illumination(normalize(to_light), distance, factor)


@pytree
class Spot:
    """Point light with a main direction L_N, an exponent and a hard cutoff angle.

    Source: JHU, "Spotlights" (its I_s is the intensity of the source here, not the specular one, S24).
    """

    position: Any = param("(-inf, inf)", vector=True, doc="where it is")
    direction: Any = param("(-inf, inf)", vector=True, nonzero=True, doc="L_N, where it shines, of any length but 0")
    exponent: Any = param("[0, inf)", default=0.0, doc="s")
    cutoff: Any = param("(0, 3.15]", unit="rad", default=3.141592653589793, doc="half angle of the cone")
    diffuse: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_d")
    specular: Any = param("[0, inf)", spectral=True, default=1.0, doc="I_s")
    ambient: Any = param("[0, inf)", spectral=True, default=0.0, doc="I_aj; attenuated, not shadowed")
    constant: Any = param("[0, inf)", default=1.0, doc="attenuation, constant term")
    linear: Any = param("[0, inf)", unit="1/length", default=0.0, doc="attenuation, linear term")
    quadratic: Any = param("[0, inf)", unit="1/length^2", default=0.0, doc="attenuation, quadratic term")
    shadows: bool = dataclasses.field(default=True, metadata={"static": True})

    def at(self, p: Vec3) -> Illumination:
        """Illumination of a point."""
        to_light = self.position - p
        distance, wi = norm(to_light), normalize(to_light)
        fall = attenuation(distance, self.constant, self.linear, self.quadratic)
        return Illumination(
            wi, distance, fall * spot_effect(-dot(normalize(self.direction), wi), self.exponent, self.cutoff)
        )
