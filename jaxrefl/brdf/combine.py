"""Sums and multiples of models, delta parts included."""

from __future__ import annotations

import dataclasses
from typing import Any

from jax import Array
from jaxtyping import Float

from ..params import floats, param, pytree
from ..vec import Vec3
from .lambert import Lambert
from .protocol import chart_of, kinks_of


def _part(model: Any, name: str, cos_theta: Array) -> Any:
    """Delta part of a model, 0 where it has none."""
    return getattr(model, name)(cos_theta) if hasattr(model, name) else 0.0 * cos_theta


@pytree
class Scaled:
    """A model times a factor (C,)."""

    base: Any = dataclasses.field(default_factory=Lambert)
    factor: Any = param("[0, inf)", spectral=True, default=1.0, doc="factor")

    @property
    def chart(self) -> str:
        """That of the base."""
        return chart_of(self.base)

    def kinks(self) -> tuple[Any, ...]:
        """Those of the base."""
        return kinks_of(self.base)

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        (factor,) = floats(self.factor)
        return factor * self.base(wi, wo)

    def mirror(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Mirror part of the base, times the factor."""
        return floats(self.factor)[0] * _part(self.base, "mirror", cos_theta_o)

    def through(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Transmitted delta part of the base, times the factor."""
        return floats(self.factor)[0] * _part(self.base, "through", cos_theta_o)


@pytree
class Mix:
    """Convex combination (1 - weight) a + weight b: reciprocal and conserving where both are."""

    a: Any = dataclasses.field(default_factory=Lambert)
    b: Any = dataclasses.field(default_factory=Lambert)
    weight: Any = param("[0, 1]", spectral=True, default=0.5, doc="share of b")

    @property
    def chart(self) -> str:
        """That of both, if they agree."""
        return chart_of(self.a, self.b)

    def kinks(self) -> tuple[Any, ...]:
        """Those of both."""
        return kinks_of(self.a, self.b)

    def __call__(self, wi: Vec3, wo: Vec3) -> Float[Array, "*C"]:
        (weight,) = floats(self.weight)
        return (1 - weight) * self.a(wi, wo) + weight * self.b(wi, wo)

    def mirror(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Mirror parts, mixed."""
        return self._mixed("mirror", cos_theta_o)

    def through(self, cos_theta_o: Array) -> Float[Array, "*C"]:
        """Transmitted delta parts, mixed."""
        return self._mixed("through", cos_theta_o)

    def _mixed(self, name: str, cos_theta: Array) -> Any:
        (weight,) = floats(self.weight)
        return (1 - weight) * _part(self.a, name, cos_theta) + weight * _part(self.b, name, cos_theta)
