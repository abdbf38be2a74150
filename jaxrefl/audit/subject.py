"""The model under audit, and what several of its properties have in common."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import jax
import numpy as np
from jax import Array

from ..brdf.function import Opaque, as_model
from ..quadrature import gauss_legendre
from ..vec import Vec3
from .evaluate import albedos, epsilon, values
from .report import Curve
from .search import pair, scattered

TINY = 1e-30
"""Less than any value of f that counts."""
_AZIMUTHS = 8
_NODES = 25


def curve_rule() -> tuple[np.ndarray, np.ndarray]:
    """Cosines of the curves of albedos, and the weights (0 at the ends) of their average 2 int rho mu dmu."""
    node, weight = (np.asarray(x, float) for x in gauss_legendre(_NODES))
    theta, ends = 0.5 * np.pi * (1 - node), np.sin([0, 1e-6, 1e-4, 1e-2])
    mu = np.concatenate([ends, np.cos(theta), np.sin([0.45 * np.pi, 0.49 * np.pi, 0.5 * np.pi])])
    weights = np.concatenate([np.zeros(4), weight * 0.5 * np.pi * np.sin(2 * theta), np.zeros(3)])
    order = np.argsort(mu)
    return mu[order], weights[order]


@dataclasses.dataclass(frozen=True)
class Subject:
    """A model, called f(wi, wo), with what it turns out to be."""

    model: Any
    reflects_only: bool = False
    """Whether what f says below the surface has no meaning."""

    @classmethod
    def of(cls, brdf: Any, part: str = "both") -> Subject:
        """Model or function of a user, of which the part "both" or "reflected" is looked at."""
        if part not in ("both", "reflected"):
            raise ValueError(f"part = {part!r} must be both or reflected")
        return cls(as_model(brdf), part == "reflected")

    @property
    def name(self) -> str:
        """Class with the parameters, or the name of a function."""
        model = self.model.model if isinstance(self.model, Opaque) else self.model
        if hasattr(model, "__name__"):
            return str(model.__name__)
        fields = dataclasses.fields(model) if dataclasses.is_dataclass(model) else ()
        parameters = ", ".join(f"{field.name}={_brief(getattr(model, field.name))}" for field in fields)
        return f"{type(model).__name__}({parameters})"

    @property
    def has_gradient(self) -> bool:
        """False for a numpy function."""
        return bool(getattr(self.model, "has_gradient", True))

    @functools.cached_property
    def dimension(self) -> int:
        """Coordinates of a pair of directions: 3, or 4 if turning both about the normal changes the value."""
        x = scattered()
        here = values(self.model, *pair(x))
        for turn in (0.11, 0.37):
            there = values(self.model, *pair(np.column_stack([x, np.full(len(x), turn)])))
            larger = np.maximum(np.maximum(abs(here), abs(there)), self.negligible)
            if np.mean(abs(here - there) > epsilon() ** 0.5 * larger) > 1e-3:  # the rounding of a jump moves a few
                return 4
        return 3

    @functools.cached_property
    def negligible(self) -> float:
        """Value of f that is too small to matter, a millionth of the average."""
        f = abs(values(self.model, *pair(scattered())))
        average = float(np.mean(f[np.isfinite(f)])) if np.isfinite(f).any() else 0.0
        return max(1e-6 * average, TINY)

    @functools.cached_property
    def part(self) -> str:
        """Which albedo is the whole one: "both" if anything is transmitted."""
        if self.reflects_only:
            return "reflected"
        wi, wo = pair(scattered())
        below = values(self.model, Vec3(wi.x, wi.y, -wi.z), wo)
        return "both" if hasattr(self.model, "through") or np.any(below != 0) else "reflected"

    @property
    def azimuths(self) -> np.ndarray:
        """Azimuths that have to be looked at."""
        return np.zeros(1) if self.dimension == 3 else 2 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS

    def _curve(self, fixed: str) -> Curve:
        mu, _ = curve_rule()
        phi = self.azimuths
        pairs = np.tile(mu, phi.size), np.repeat(phi, mu.size)
        found = albedos(self.model, *pairs, part=self.part, fixed=fixed)
        return Curve(mu, phi, *(x.reshape(phi.size, mu.size, -1) for x in found))

    @functools.cached_property
    def view(self) -> Curve:
        """Albedos with the view held."""
        return self._curve("view")

    @functools.cached_property
    def light(self) -> Curve:
        """Albedos with the light held."""
        return self._curve("light")


def _brief(value: Any) -> str:
    if isinstance(value, (np.ndarray, Array)):
        return np.array2string(np.asarray(value), precision=6, separator=",", threshold=8)
    return getattr(value, "__name__", None) or (Subject(value).name if dataclasses.is_dataclass(value) else repr(value))


def leaves_with_names(model: Any) -> tuple[list[str], list[Any]]:
    """Parameters that a derivative can be taken by: their paths and values."""
    found = jax.tree_util.tree_leaves_with_path(model)
    return [jax.tree_util.keystr(path).lstrip(".") for path, _ in found], [leaf for _, leaf in found]
