"""The D3D9Client model as a surface."""

from __future__ import annotations

import dataclasses
from typing import Any

from jax import Array
from jaxtyping import Float

from .. import d3d9
from ..geometry import Hit, cosine
from ..params import param, pytree
from ..vec import Vec3
from .phong import Phong
from .protocol import Local, Weights, under


@pytree
class D3D9:
    """Diffuse base under a metallic and a Fresnel reflection: c = d (1 - |lambda|) + (lambda (1 - R) + s R) phi.

    R = R0 + m (1 - cos theta)^p, phi is what the reflected ray brings. By (6) the base is not dimmed by 1 - R, so that
    light is added (S4); with ``sun_fresnel`` the diffuse response to punctual lights is multiplied by 1 - R(sigma), as
    in (8). ``alpha`` is the d_a of (7), the coverage of the material or texture. |lambda| is the largest channel (S3)
    unless ``metallic_norm`` says otherwise, which it has to where wavelengths are rendered one by one.
    Source: D3D9 (3)-(8).
    """

    base: Any = dataclasses.field(default_factory=Phong)
    metallic: Any = param("[0, 1]", spectral=True, default=0.0, doc="lambda, reflectivity colour")
    r0: Any = param("[0, 1]", default=0.04, doc="R0, offset")
    m: Any = param("[0, 1]", default=0.96, doc="m, multiplier")
    p: Any = param("[0, inf)", default=5.0, doc="p, exponent")
    specular: Any = param("[0, 1]", spectral=True, default=1.0, doc="s, colour of the Fresnel reflection")
    alpha: Any = param("[0, 1]", default=1.0, doc="d_a, coverage")
    metallic_norm: Any = param("[0, 1]", default=None, doc="|lambda|")
    sun_fresnel: bool = dataclasses.field(default=False, metadata={"static": True})

    def _reflectance(self, cos_theta: Array) -> Float[Array, ""]:
        return d3d9.d3d9(cos_theta, self.r0, self.m, self.p)

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response of the base, its diffuse part by (6) or (8)."""
        base = self.base.local(hit, wi)
        if not self.sun_fresnel:
            return base
        return Local(base.diffuse * (1 - self._reflectance(cosine(hit.n, wi))), base.specular)

    def weights(self, hit: Hit) -> Weights:
        """1 - |lambda| for the base, lambda (1 - R) + s R for the reflected ray."""
        metallic = self.metallic
        size = d3d9.max_norm(metallic) if self.metallic_norm is None else self.metallic_norm
        reflected = d3d9.total_reflection(metallic, self._reflectance(hit.cos_theta_o), 1.0, self.specular)
        alpha = self.alpha
        return under(self.base.weights(hit), 1 - size, reflected)._replace(alpha=alpha)
