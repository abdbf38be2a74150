"""What a reflection model has to offer."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from jax import Array
from jaxtyping import Float

from ..vec import Vec3

DELTA_PARTS = ("mirror", "through")
"""Methods of cos theta_o that a model may have beside f."""


@runtime_checkable
class BRDF(Protocol):
    """Reflection model in the local frame: z = normal, x = tangent; both directions leave the surface."""

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        """Value f(wi, wo) in 1/sr, (C,) or scalar, cosine NOT included."""
        ...


def chart_of(*models: Any) -> str:
    """Chart that suits models: what their attribute ``chart`` says, if they agree, "normal" otherwise."""
    charts = {str(getattr(model, "chart", "normal")) for model in models}
    return charts.pop() if len(charts) == 1 else "normal"


def kinks_of(*models: Any) -> tuple[Any, ...]:
    """Cosines of theta_i at which one of the models has a kink: their methods ``kinks()``, where they have one."""
    return tuple(kink for model in models if hasattr(model, "kinks") for kink in model.kinks())
