"""What a scene file can name: one small dict for each place, and the settings of a render."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..camera import Orthographic, Pinhole
from ..catalog import MODELS
from ..geometry import Plane, Sphere
from ..light import Ambient, Directional, PointLight, Spot
from ..params import param
from ..render import ALPHAS
from ..scene import Sky
from ..surface import D3D9, Blend, BRDFSurface, Coat, Conductor, Dielectric, Phong, ThinFilm, Whitted
from ..texture import Checker, ImageTexture

SHAPES: dict[str, Any] = {"Sphere": Sphere, "Plane": Plane}
BASES: dict[str, Any] = {"Phong": Phong}
SURFACES: dict[str, Any] = {
    **BASES,
    "Blend": Blend,
    "Whitted": Whitted,
    "D3D9": D3D9,
    "Dielectric": Dielectric,
    "Conductor": Conductor,
    "Coat": Coat,
    "ThinFilm": ThinFilm,
    "BRDF": BRDFSurface,
}
BRDFS: dict[str, Any] = {cls.__name__: cls for cls in MODELS.values()}
"""Reflection models, in the key ``brdf`` of a surface of type BRDF."""
TEXTURES: dict[str, Any] = {"Checker": Checker, "Image": ImageTexture}
LIGHTS: dict[str, Any] = {"Ambient": Ambient, "Directional": Directional, "Point": PointLight, "Spot": Spot}
CAMERAS: dict[str, Any] = {"Pinhole": Pinhole, "Orthographic": Orthographic}
BACKGROUNDS: dict[str, Any] = {"Sky": Sky}

TEXTURED_SCALARS = ((D3D9, "alpha"),)
"""Scalars of surfaces that may be textures; of the spectral parameters every one may."""

COLORSPACES = ("sRGB", "linear")


@dataclasses.dataclass(frozen=True)
class Settings:
    """Size and effort of a render, and how it is shown."""

    width: int = param("[1, 16384]", unit="pixels", default=640, doc="width of the picture")
    height: int = param("[1, 16384]", unit="pixels", default=480, doc="height of the picture")
    n_bounces: int = param("[0, 64]", default=5, doc="reflections and refractions followed; 0 = first hit only")
    spp: int = param("[1, 65536]", default=4, doc="samples per pixel")
    seed: int = param("[0, 4294967295]", default=0, doc="seed of the places of the samples in a pixel")
    exposure: float = param("[-32, 32]", unit="stops", default=0.0, doc="a PNG shows radiance times 2^exposure")
    alpha: str = dataclasses.field(
        default="premultiplied", metadata={"choices": ALPHAS, "doc": "coverage, premultiplied or as D3D9 (7) prints it"}
    )
