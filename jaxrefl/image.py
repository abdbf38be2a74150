"""Pictures: PNG for the eye, EXR and NPZ for the numbers, and pictures read as textures.

A PNG shows radiance times 2^exposure through the sRGB curve, brought into [0, 1] by a named method. EXR and NPZ keep
radiance as it is, linear and unbounded, with depth and normal; NPZ keeps everything there is. Every file says in its
metadata what made it, and is complete or not there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import __version__
from .colourspace import GAMUTS, to_gamut
from .files import write_atomically

FORMATS = ("png", "exr", "npz")
KEY = "jaxrefl"
"""Name of the metadata in every format; their value is JSON."""
CHANNELS = {1: ("Y",), 3: ("R", "G", "B")}


def encode_srgb(linear: Any) -> np.ndarray:
    """sRGB code in [0, 1] of linear values, which are held to [0, 1]; NaN becomes 0. Source: IEC 61966-2-1."""
    x = np.clip(np.nan_to_num(np.asarray(linear), nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def decode_srgb(code: Any) -> np.ndarray:
    """Linear values of sRGB codes in [0, 1]. Source: IEC 61966-2-1."""
    x = np.asarray(code)
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0.04045) + 0.055) / 1.055) ** 2.4)


def to_bytes(
    radiance: Any, exposure: float = 0.0, alpha: Any = None, straight: bool = False, gamut: str = "clip"
) -> np.ndarray:
    """Picture as a PNG holds it: (H, W, C) of 8 bits, C = 1 or 3, and one more for the coverage.

    Args:
        radiance: (H, W, C), linear.
        exposure: stops; radiance is multiplied by 2^exposure.
        alpha: (H, W) coverage, held to [0, 1]; without it the picture is opaque.
        straight: False if radiance holds its coverage already and has to be divided by it, as a PNG wants it.
        gamut: what is done to colours that a screen cannot show: "clip" or "desaturate", see `colourspace.to_gamut`.

    Raises:
        ValueError: C is neither 1 nor 3; another gamut.
    """
    shown = np.asarray(radiance, np.float64) * 2.0**exposure
    if shown.ndim != 3 or shown.shape[-1] not in CHANNELS:
        raise ValueError(
            f"radiance has shape {shown.shape}; a PNG has 1 or 3 channels, write EXR or NPZ or convert to RGB"
        )
    parts = [shown]
    if alpha is not None:
        cover = np.clip(np.nan_to_num(np.asarray(alpha, np.float64)), 0.0, 1.0)[..., None]
        if not straight:
            parts = [shown / np.where(cover > 0, cover, 1.0)]
        parts = [np.where(cover > 0, parts[0], 0.0), cover]
    if gamut not in GAMUTS:
        raise ValueError(f"gamut = {gamut!r} must be one of {', '.join(GAMUTS)}")
    if gamut == "desaturate" and shown.shape[-1] == 3:
        parts[0] = to_gamut(np.nan_to_num(parts[0]), gamut)
    codes = np.concatenate([encode_srgb(parts[0]), *parts[1:]], axis=-1)
    return np.rint(codes * 255).astype(np.uint8)


def flatten(record: Any, path: str = "") -> dict[str, np.ndarray]:
    """Arrays of a nest of records by path: ``radiance``, ``budget.shaded``."""
    if not hasattr(record, "_asdict"):
        return {path: np.asarray(record)}
    found: dict[str, np.ndarray] = {}
    for name, value in record._asdict().items():
        found |= flatten(value, f"{path}.{name}".lstrip("."))
    return found


def _facts(metadata: Mapping[str, Any] | None) -> str:
    return json.dumps({"version": __version__, **(metadata or {})}, ensure_ascii=True)


def write_png(
    path: Path, image: Any, *, exposure: float = 0.0, transparent: bool = False, straight: bool = False,
    gamut: str = "clip", metadata: Mapping[str, Any] | None = None,
) -> None:  # fmt: skip
    """Picture for the eye, see `to_bytes`."""
    import imageio.v3 as iio
    from PIL.PngImagePlugin import PngInfo

    if hasattr(image, "wavelength_nm"):
        raise ValueError(f"path = {str(path)!r}: a picture by wavelength is no PNG; write image.rgb()")
    pixels = to_bytes(image.radiance, exposure, image.alpha if transparent else None, straight, gamut)
    info = PngInfo()
    info.add(b"sRGB", b"\0")  # the intent is perceptual
    info.add_text("Software", f"jaxrefl {__version__}")
    info.add_text(KEY, _facts({"exposure": exposure, "gamut": gamut, **(metadata or {})}))
    squeezed = pixels[..., 0] if pixels.shape[-1] == 1 else pixels
    write_atomically(
        path, lambda part: iio.imwrite(part, squeezed, extension=".png", plugin="pillow", pnginfo=info)
    )  # fmt: skip


def openexr() -> Any:
    """The module OpenEXR.

    Raises:
        ValueError: it is not installed; the message says how it would be.
    """
    try:
        import OpenEXR
    except ImportError:
        raise ValueError('EXR files need the package OpenEXR: pip install "jaxrefl[image]"') from None
    return OpenEXR


def exr_channels(image: Any, half: bool = False) -> dict[str, np.ndarray]:
    """Channels of an EXR file: R, G, B or Y or radiance.000 and so on, A, Z and normal.X, .Y, .Z.

    A picture by wavelength has S0.550,000000nm and so on. Source: Fichet, Pacanowski & Wilkie, JCGT 10(3), 2021.
    """
    radiance = np.asarray(image.radiance)
    count = radiance.shape[-1]
    names = CHANNELS.get(count) or tuple(f"radiance.{i:03d}" for i in range(count))
    if hasattr(image, "wavelength_nm"):
        names = tuple(f"S0.{w:.6f}nm".replace(".", ",").replace(",", ".", 1) for w in np.asarray(image.wavelength_nm))
    kind = np.float16 if half else np.float32
    largest = float(np.finfo(kind).max)
    channels = {name: np.clip(radiance[..., i], -largest, largest).astype(kind) for i, name in enumerate(names)}
    channels["A"] = np.asarray(image.alpha).astype(kind)
    channels["Z"] = np.asarray(image.depth).astype(np.float32)
    normal = np.asarray(image.normal).astype(kind)
    channels |= {f"normal.{axis}": normal[..., i] for i, axis in enumerate("XYZ")}
    return {name: np.ascontiguousarray(values) for name, values in channels.items()}


def write_exr(path: Path, image: Any, *, half: bool = False, metadata: Mapping[str, Any] | None = None) -> None:
    """Linear radiance with coverage, depth and normal, as float, or as half with the depth still float."""
    module, channels = openexr(), exr_channels(image, half)
    header = {
        "compression": module.ZIP_COMPRESSION,
        "type": module.scanlineimage,
        "software": f"jaxrefl {__version__}",
        KEY: _facts(metadata),
    }
    if hasattr(image, "wavelength_nm"):
        header |= {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1"}
    write_atomically(path, lambda part: module.File(header, channels).write(str(part)))


def write_npz(path: Path, image: Any, *, metadata: Mapping[str, Any] | None = None) -> None:
    """Every array of an image as it is, by its path, and the metadata as a string of JSON."""
    arrays = {**flatten(image), KEY: np.asarray(_facts(metadata))}

    def write(part: Path) -> None:
        with part.open("wb") as file:
            np.savez_compressed(file, **arrays)  # type: ignore[arg-type]

    write_atomically(path, write)


def format_of(path: Path, channels: int | None = None) -> str:
    """Format of a file by its suffix, found possible before anything is rendered.

    Raises:
        ValueError: another suffix, a PNG of other than 1 or 3 channels, or EXR without its package.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join(f'.{name}' for name in FORMATS)}")
    if kind == "png" and channels is not None and channels not in CHANNELS:
        raise ValueError(f"path = {str(path)!r}: a PNG has 1 or 3 channels, not {channels}; write EXR or NPZ")
    if kind == "exr":
        openexr()
    return kind


def write(
    path: Path, image: Any, *, exposure: float = 0.0, transparent: bool = False, straight: bool = False,
    gamut: str = "clip", half: bool = False, metadata: Mapping[str, Any] | None = None,
) -> None:  # fmt: skip
    """Image in the format of the suffix: `write_png`, `write_exr` or `write_npz`."""
    kind = format_of(path)
    if kind == "png":
        write_png(
            path, image, exposure=exposure, transparent=transparent, straight=straight, gamut=gamut, metadata=metadata
        )
    elif kind == "exr":
        write_exr(path, image, half=half, metadata=metadata)
    else:
        write_npz(path, image, metadata=metadata)


def read_metadata(path: Path) -> dict[str, Any]:
    """What made a file: version, scene, hash, settings."""
    kind = format_of(path)
    if kind == "npz":
        with np.load(path) as arrays:
            text = str(arrays[KEY])
    elif kind == "exr":
        with openexr().File(str(path), separate_channels=True) as file:
            text = file.header()[KEY]
    else:
        import imageio.v3 as iio

        text = iio.immeta(path, plugin="pillow")[KEY]
    return dict(json.loads(text))


def read_texture(path: Path, colorspace: str = "sRGB") -> np.ndarray:
    """Pixels (H, W, C) of an image file, linear float32, C = 1 or 3; transparency is left out.

    Args:
        path: PNG, JPEG or whatever Pillow reads; or EXR, which is linear, whatever is said.
        colorspace: "sRGB" if the file holds codes of sRGB, "linear" if it holds what is to be used.

    Raises:
        ValueError: the file is not there, is no picture, or the colour space is unknown.
    """
    if colorspace not in ("sRGB", "linear"):
        raise ValueError(f"colorspace = {colorspace!r} must be sRGB or linear")
    if not path.is_file():
        raise ValueError("there is no such file")
    if path.suffix.lower() == ".exr":
        return _read_exr(path)
    pixels = _read_integers(path)
    largest = float(np.iinfo(pixels.dtype).max) if pixels.dtype.kind in "ui" else 1.0
    values = pixels / largest
    return np.asarray(decode_srgb(values) if colorspace == "sRGB" else values, np.float32)


def _read_integers(path: Path) -> np.ndarray:
    import imageio.v3 as iio

    try:
        pixels = np.asarray(iio.imread(path, plugin="pillow", index=0))
    except Exception as error:
        raise ValueError(f"it is no picture that can be read: {error}") from None
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    return pixels[..., : 3 if pixels.shape[-1] >= 3 else 1]


def _read_exr(path: Path) -> np.ndarray:
    module = openexr()
    try:
        with module.File(str(path), separate_channels=True) as file:
            channels: dict[str, np.ndarray] = {name: channel.pixels for name, channel in file.channels().items()}
    except Exception as error:
        raise ValueError(f"it is no EXR file that can be read: {error}") from None
    for names in CHANNELS.values():
        if set(names) <= set(channels):
            return np.stack([np.asarray(channels[name], np.float32) for name in names], axis=-1)
    raise ValueError(f"it has the channels {', '.join(channels)}, and neither Y nor R, G, B")


__all__: list[str] = [
    "FORMATS", "decode_srgb", "encode_srgb", "exr_channels", "flatten", "format_of", "openexr", "read_metadata",
    "read_texture", "to_bytes", "write", "write_exr", "write_npz", "write_png",
]  # fmt: skip
