"""What a reflection model has to offer."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from jax import Array
from jaxtyping import Float

from ..vec import Vec3


@runtime_checkable
class BRDF(Protocol):
    """Reflection model in the local frame: z = normal, x = tangent; both directions leave the surface."""

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        """Value f(wi, wo) in 1/sr, (C,) or scalar, cosine NOT included."""
        ...
