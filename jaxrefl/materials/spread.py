"""How far the measurements of one material are apart."""

from __future__ import annotations

import functools
import itertools
import json
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from ..dispersion import normal_reflectance
from .named import material, materials, provenance

VISIBLE_NM = (380.0, 780.0)
_POINTS = 161


class Spread(NamedTuple):
    """Largest differences between two sources of a material, over the visible wavelengths that they share."""

    n: float
    k: float | None
    """None where fewer than two sources give k."""
    reflectance: float
    """At normal incidence, from vacuum."""
    sources: tuple[str, ...]
    range_nm: tuple[float, float]
    """Smallest and largest wavelength compared; each pair over what the two have in common."""


@functools.cache
def _stored() -> dict[str, Any]:
    text = resources.files("jaxrefl").joinpath("data/materials/spread.json").read_text(encoding="utf-8")
    return json.loads(text)


def spread(name: str) -> Spread | None:
    """Largest difference of n, of k and of the normal reflectance between any two sources of a material.

    As stored by the script that wrote the tables; `computed_spread` computes it.

    Args, Returns, Raises: as there.
    """
    found = _stored()[provenance(name).material]
    if found is None:
        return None
    return Spread(found["n"], found["k"], found["reflectance"], tuple(found["sources"]), tuple(found["range_nm"]))


def computed_spread(name: str) -> Spread | None:
    """`spread`, from the tables and formulas themselves.

    Compared at 161 wavelengths in the part of 380 to 780 nm that a pair has in common; models (Drude-Lorentz fits of
    several data sets) are left out, and k where a source gives none.

    Args:
        name: as in `material`.

    Returns:
        Spread, or None if the package has fewer than two measurements.

    Raises:
        ValueError: no such material.
    """
    about = [provenance(name, source) for source in materials()[provenance(name).material]]
    about = [a for a in about if a.kind != "model"]
    n, k, reflectance, ends = [], [], [], []
    for a, b in itertools.combinations(about, 2):
        low = max(VISIBLE_NM[0], a.range_nm[0], b.range_nm[0])
        high = min(VISIBLE_NM[1], a.range_nm[1], b.range_nm[1])
        if low < high:
            wavelength = np.linspace(low, high, _POINTS)
            models = [material(name, source.source) for source in (a, b)]
            one, two = (model(wavelength) for model in models)
            n.append(np.abs(one.n - two.n).max())
            if a.has_k and b.has_k:
                k.append(np.abs(one.k - two.k).max())
            r = [np.asarray(normal_reflectance(model, wavelength)) for model in models]
            reflectance.append(np.abs(r[0] - r[1]).max())
            ends.append((low, high))
    if not n:
        return None
    low, high = min(e[0] for e in ends), max(e[1] for e in ends)
    largest_k = float(max(k)) if k else None
    return Spread(float(max(n)), largest_k, float(max(reflectance)), tuple(a.source for a in about), (low, high))
