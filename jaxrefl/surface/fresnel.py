"""Smooth interfaces with the exact Fresnel reflectance."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from .. import fresnel
from ..geometry import Hit
from ..params import param, pytree
from ..vec import Vec3
from .phong import Phong
from .protocol import Local, Weights, under


def interface(hit: Hit, eta: Any) -> Float[Array, ""]:
    """Unpolarised reflectance at a hit, from the side that the ray came from."""
    return fresnel.dielectric(hit.cos_theta_o, jnp.where(hit.entering, eta, 1 / eta))


@pytree
class Dielectric:
    """Smooth glass, water or plastic: reflects F and transmits 1 - F, exact, unpolarised at each hit.

    The tracer carries basic radiance L / n^2, so that no factor eta^2 stands here; total reflection has F = 1. Without
    sigma (None) the inside is clear. Source: LAMBERT-FRESNEL.
    """

    eta: Any = param("(0, inf)", default=1.5, doc="index of the inside over the outside")
    sigma: Any = param("[0, inf)", unit="1/length", spectral=True, default=None, doc="extinction of the inside")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Nothing: a smooth interface sends a punctual light into the mirror direction alone."""
        zero = jnp.zeros_like(hit.t)
        return Local(zero, zero)

    def weights(self, hit: Hit) -> Weights:
        """0, F, 1 - F."""
        reflected = interface(hit, self.eta)
        weights = Weights(0.0, reflected, 1 - reflected, eta=self.eta)
        return weights if self.sigma is None else weights._replace(sigma=self.sigma)


@pytree
class Conductor:
    """Smooth metal of complex index eta + i k, exact Fresnel reflectance per channel. Source: LAMBERT-FRESNEL."""

    eta: Any = param("(0, inf)", spectral=True, default=0.2, doc="real index over that of the outside")
    k: Any = param("[0, inf)", spectral=True, default=3.0, doc="extinction over the index of the outside")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Nothing: see `Dielectric.local`."""
        zero = jnp.zeros_like(hit.t)
        return Local(zero, zero)

    def weights(self, hit: Hit) -> Weights:
        """0, F, 0."""
        return Weights(0.0, fresnel.conductor(hit.cos_theta_o, self.eta, self.k))


@pytree
class Coat:
    """Smooth dielectric coat over a base: reflects F, and shows 1 - F of the base.

    One Fresnel factor on the way out and none on the way in: it never adds energy, but takes none from the light that
    falls on the base, and is not reciprocal. Source: LAMBERT-FRESNEL.
    """

    base: Any = dataclasses.field(default_factory=Phong)
    eta: Any = param("(0, inf)", default=1.5, doc="index of the coat over the outside")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response of the base."""
        return self.base.local(hit, wi)

    def weights(self, hit: Hit) -> Weights:
        """1 - F for the base, F for the reflected ray."""
        reflected = fresnel.dielectric(hit.cos_theta_o, self.eta)
        return under(self.base.weights(hit), 1 - reflected, reflected)
