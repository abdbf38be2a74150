"""A thin film over an opaque base, whose colour is interference."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from .. import films
from ..geometry import Hit
from ..params import param, pytree
from ..vec import Vec3
from .protocol import Local, Weights


@pytree
class ThinFilm:
    """Smooth coherent film over a smooth opaque base: reflects R of `jaxrefl.films.film`, unpolarised at each hit.

    What is not reflected is absorbed. All indices are over that of the outside, and the thickness is counted in
    wavelengths of the outside, so that no wavelength is asked for: in a ``build(wavelength_nm)`` give
    ``thickness_nm / wavelength_nm``. A thickness of 0 is the bare base.
    """

    thickness: Any = param("[0, inf)", unit="wavelengths", spectral=True, default=0.5, doc="thickness over wavelength")
    eta: Any = param("(0, inf)", spectral=True, default=1.38, doc="real index of the film")
    k: Any = param("[0, inf)", spectral=True, default=0.0, doc="extinction of the film")
    eta_base: Any = param("(0, inf)", spectral=True, default=1.5, doc="real index of the base")
    k_base: Any = param("[0, inf)", spectral=True, default=0.0, doc="extinction of the base")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Nothing: a smooth interface sends a punctual light into the mirror direction alone."""
        zero = jnp.zeros_like(hit.t)
        return Local(zero, zero)

    def weights(self, hit: Hit) -> Weights:
        """0, R, 0."""
        eta, k, thickness = (jnp.asarray(x)[None] for x in (self.eta, self.k, self.thickness))
        seen = films.film(hit.cos_theta_o, 1.0, eta, k, thickness, inside=(self.eta_base, self.k_base))
        return Weights(0.0, seen.R)
