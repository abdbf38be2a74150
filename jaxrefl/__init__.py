"""jaxrefl: reflection models that can be plotted, trusted and differentiated.

Every reflection model is a small pure function of directions and parameters; every albedo, figure and test is a `vmap`,
a `scan` or a `grad` of it. Importing jaxrefl touches no global JAX setting, allocates nothing, and loads neither
matplotlib nor colour-science; `jaxrefl.plot` is loaded on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from . import (
    albedo,
    audit,
    brdf,
    camera,
    catalog,
    certified,
    chart,
    colour,
    d3d9,
    dispersion,
    films,
    fresnel,
    geometry,
    light,
    materials,
    params,
    quadrature,
    render,
    safe,
    scene,
    series,
    spectral,
    surface,
    tabulate,
    texture,
    trace,
    vec,
)
from .vec import Vec3

if TYPE_CHECKING:
    from . import plot

__version__ = "0.1.0"
__all__ = [
    "Vec3",
    "albedo",
    "audit",
    "brdf",
    "camera",
    "catalog",
    "certified",
    "chart",
    "colour",
    "d3d9",
    "dispersion",
    "films",
    "fresnel",
    "geometry",
    "light",
    "materials",
    "params",
    "plot",
    "quadrature",
    "render",
    "safe",
    "scene",
    "series",
    "spectral",
    "surface",
    "tabulate",
    "texture",
    "trace",
    "vec",
]


def __getattr__(name: str) -> Any:
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
