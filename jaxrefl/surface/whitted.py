"""The two ways to add a reflected ray to a local model: PERRIN's convex blend and Whitted's sum."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..geometry import Hit
from ..params import param, pytree
from ..vec import Vec3
from .phong import Phong
from .protocol import Local, Weights, under


@pytree
class Blend:
    """Mirror blend (1 - alpha) c_i + alpha c^(i+1) of a base colour and what is reflected.

    Never brighter than the brighter of the two. Source: PERRIN (1), (5), where reflectivity is called alpha.
    """

    base: Any = dataclasses.field(default_factory=Phong)
    reflectivity: Any = param("[0, 1]", spectral=True, default=0.5, doc="alpha_i, m.mirror in the text")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response of the base."""
        return self.base.local(hit, wi)

    def weights(self, hit: Hit) -> Weights:
        """1 - alpha for the base, alpha for the reflected ray."""
        alpha = self.reflectivity
        return under(self.base.weights(hit), 1 - alpha, alpha)


@pytree
class Whitted:
    """Sum I = I_local + k_rg I_reflected + k_tg I_transmitted, with a distance attenuation of both.

    Nothing bounds 1 + k_rg + k_tg (S32): the budget of an image shows by how much light is made. Without k_tg (None)
    the object is opaque. The attenuation exp(-sigma t) of each ray is not shown in the source; its "k_rg and k_s" is
    read as k_rg and k_tg (S30). Under total reflection k_tg is added to k_rg. Source: JHU, "Global Light Terms" and
    "Illumination Model (cont.)".
    """

    base: Any = dataclasses.field(default_factory=Phong)
    k_rg: Any = param("[0, inf)", spectral=True, default=None, doc="coefficient of the reflected ray")
    k_tg: Any = param("[0, inf)", spectral=True, default=None, doc="coefficient of the transmitted ray")
    eta: Any = param("(0, inf)", default=1.0, doc="index of the inside over the outside")
    sigma_rg: Any = param("[0, inf)", unit="1/length", spectral=True, default=None, doc="extinction of reflected rays")
    sigma_tg: Any = param("[0, inf)", unit="1/length", spectral=True, default=None, doc="extinction of the inside")

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response of the base."""
        return self.base.local(hit, wi)

    def weights(self, hit: Hit) -> Weights:
        """1 for the base, k_rg and k_tg for the rays."""
        weights = self.base.weights(hit)
        if self.k_rg is not None:
            weights = weights._replace(reflected=weights.reflected + self.k_rg)
        if self.sigma_rg is not None:
            weights = weights._replace(sigma_reflected=self.sigma_rg)
        if self.k_tg is None:
            return weights
        weights = weights._replace(transmitted=weights.transmitted + self.k_tg, eta=self.eta)
        return weights if self.sigma_tg is None else weights._replace(sigma=self.sigma_tg)
