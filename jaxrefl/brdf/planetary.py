"""Two models of planetary photometry with closed albedos: test problems."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..safe import safe_divide, safe_power
from ..vec import Vec3
from .common import above


@pytree
class LommelSeeliger:
    """Single scattering in a deep dark medium, f = (w / 4 pi) / (mu_i + mu_o).

    Reciprocal; the albedo is (w / 2)(1 - mu ln(1 + 1 / mu)), at most w / 2. f diverges where both directions graze.
    """

    w: Any = param("[0, 1]", spectral=True, default=1.0, doc="single-scattering albedo")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        (w,) = floats(self.w)
        return above(wi, wo, w / (4 * jnp.pi) * safe_divide(1.0, wi.z + wo.z))


@pytree
class Minnaert:
    """Limb darkening f = c (k + 1) / (2 pi) (mu_i mu_o)^(k - 1).

    Reciprocal; the albedo is c mu^(k - 1), which for k < 1 is without bound, and for k = 1 that of Lambert.
    Source: Minnaert 1941.
    """

    scale: Any = param("[0, 1]", spectral=True, default=1.0, doc="c, albedo at normal incidence")
    k: Any = param("(0, inf)", default=0.8, doc="k")

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        scale, k = floats(self.scale, self.k)
        product = wi.z * wo.z
        darker = safe_power(product, jnp.where(k >= 1, k - 1, 0.0))
        brighter = safe_divide(1.0, safe_power(product, jnp.where(k < 1, 1 - k, 0.0)))
        return above(wi, wo, scale * ((k + 1) / (2 * jnp.pi) * darker * brighter))
