"""Scenes by wavelength: spheres of metal, a ball of glass that disperses, a sphere under a thin film."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..camera import Pinhole
from ..geometry import Plane, Sphere
from ..light import Ambient, Directional
from ..materials import material
from ..scene import Object, Scene, Sky
from ..surface import Conductor, Dielectric, Phong, ThinFilm
from ..texture import Checker
from ..vec import Vec3
from .build import Build

METALS = ("Au", "Ag", "Cu", "Al", "Ti")
UP = Vec3(0.0, 0.0, 1.0)


def _around(objects: dict[str, Object]) -> Scene:
    """Objects on a checkerboard of greys, in daylight of one spectrum."""
    floor = Object(Plane(Vec3(0.0, 0.0, 0.0), UP), Phong(k_d=Checker(0.75, 0.15)))
    lights = {"sky": Ambient(0.25), "sun": Directional(Vec3(1.0, 2.0, -3.0), diffuse=0.7)}
    return Scene({**objects, "floor": floor}, lights, Sky(zenith=0.55, horizon=1.0))


def metal_spheres(metals: Sequence[str] = METALS, source: str | None = None) -> tuple[Build, Pinhole]:
    """A row of spheres of measured metals, from left to right, and a camera.

    Args:
        metals: names of `jaxrefl.materials.material`.
        source: of all of them.

    Raises:
        ValueError: an unknown metal or source.
    """
    models = [material(name, source) for name in metals]
    x = np.arange(len(metals)) * 2.1 - 1.05 * (len(metals) - 1)

    def build(wavelength_nm: Any) -> Scene:
        balls = {}
        for i, model in enumerate(models):
            index = model(wavelength_nm)
            shape = Sphere(Vec3(float(x[i]), 0.0, 1.0), 1.0)
            balls[f"ball_{i}"] = Object(shape, Conductor(index.n, index.k))
        return _around(balls)

    distance = 2.0 + 2.1 * len(metals)  # a picture of 16 : 9 holds them all
    return build, Pinhole(Vec3(0.0, -distance, 3.0), Vec3(0.0, 0.0, 0.7), UP, 0.52)


def glass_ball(glass: Any = "SF11", radius: float = 1.0) -> tuple[Build, Pinhole]:
    """A ball of glass on a checkerboard, and a camera; rays of each wavelength go their own way.

    Args:
        glass: name of `jaxrefl.materials.material`, or a dispersion model.
        radius: of the ball, (0, inf).
    """
    model = material(glass) if isinstance(glass, str) else glass

    def build(wavelength_nm: Any) -> Scene:
        ball = Object(Sphere(Vec3(0.0, 0.0, radius), radius), Dielectric(model(wavelength_nm).n))
        return _around({"ball": ball})

    return build, Pinhole(Vec3(0.0, -6.0, 2.2), Vec3(0.0, 0.0, 0.9), UP, 0.5)


def coated_sphere(thickness_nm: Any = 60.0, film: Any = "TiO2-film", base: Any = "Ti") -> tuple[Build, Pinhole]:
    """A sphere of metal under a coherent film, such as anodised titanium, and a camera.

    Args:
        thickness_nm: of the film, [0, inf) nanometres; a leaf, to be differentiated.
        film, base: names of `jaxrefl.materials.material`, or dispersion models.
    """
    layer, below = (material(model) if isinstance(model, str) else model for model in (film, base))

    def build(wavelength_nm: Any) -> Scene:
        coat, metal = layer(wavelength_nm), below(wavelength_nm)
        surface = ThinFilm(thickness_nm / wavelength_nm, coat.n, coat.k, metal.n, metal.k)
        ball = Object(Sphere(Vec3(0.0, 0.0, 1.0), 1.0), surface)
        return _around({"ball": ball})

    return build, Pinhole(Vec3(0.0, -6.0, 2.2), Vec3(0.0, 0.0, 0.9), UP, 0.45)
