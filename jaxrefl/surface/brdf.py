"""Any reflection model as a surface of the tracer."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp

from ..brdf import Lambert
from ..geometry import Hit
from ..params import pytree
from ..vec import Vec3, cross, dot
from .protocol import Local, Weights


@pytree
class BRDFSurface:
    """A BRDF in a scene: local = pi f cos theta_i, reflected = its ``mirror``, transmitted = its ``through``.

    A light of intensity I gives the irradiance pi I cos theta_i, so that white Lambert shows I; all of the response is
    to the light's diffuse intensity. The local frame is that of the hit: z the normal on the viewer's side, x the
    tangent. What goes ``through`` keeps its direction.
    """

    brdf: Any = dataclasses.field(default_factory=Lambert, metadata={"models": "brdf"})

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """pi f cos theta_i, 0 for light from below."""
        side = cross(hit.n, hit.tangent)

        def local(w: Vec3) -> Vec3:
            return Vec3(dot(w, hit.tangent), dot(w, side), dot(w, hit.n))

        light, view = local(wi), local(hit.wo)
        lit = light.z > 0
        # a legal direction where there is no light, so that no model meets one that it does not know
        light = Vec3(*(jnp.where(lit, a, b) for a, b in zip((light.x, light.y, light.z), (0.0, 0.0, 1.0), strict=True)))
        value = jnp.pi * self.brdf(light, view) * light.z
        return Local(jnp.where(lit, value, 0.0), jnp.zeros_like(hit.t))

    def weights(self, hit: Hit) -> Weights:
        """Delta parts of the model; what it has not is absent."""
        cos_theta = hit.cos_theta_o
        parts = {"reflected": "mirror", "transmitted": "through"}
        return Weights(
            **{name: getattr(self.brdf, part)(cos_theta) for name, part in parts.items() if hasattr(self.brdf, part)}
        )
