"""Scenes made of validated tables, and the checks that need more than one key."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..image import read_texture
from ..params import parameters
from ..scene import Leaf, Object, Scene, canonical, check, check_model, walk
from ..texture import ImageTexture
from ..vec import Vec3, cross, norm, normalize
from .catalog import Settings
from .problems import shown
from .tables import Table

DIRECTIONS = ("direction", "normal")
"""Vectors of any length but 0."""
PARALLEL = 1e-4


class Built(NamedTuple):
    """What a document describes."""

    scene: Scene
    camera: Any
    settings: Settings
    channels: int


class Context(NamedTuple):
    """Folder of the scene file, and where problems are told."""

    folder: Path
    note: Callable[[str], None]


def _numbers(value: Any, vector: bool, degrees: bool) -> Any:
    array = jnp.asarray(np.radians(value) if degrees else value, float)
    return Vec3.from_array(array) if vector else array


def model_of(table: Table, path: str, context: Context) -> Any:
    """Model of a table: the keys that were given, the defaults of the dataclass for the others."""
    given = {name: getattr(table, name) for name in sorted(table.model_fields_set - {"type"})}
    declared = {p.name: p for p in parameters(table.builds)}
    if table.builds is ImageTexture:
        given["pixels"] = _pixels(table, path, given.pop("path"), given.pop("colorspace", "sRGB"), context)
    for name, value in given.items():
        if isinstance(value, Table):
            given[name] = model_of(value, f"{path}.{name}", context)
        elif name in declared and name != "pixels" and table.builds is not Settings:
            given[name] = _numbers(value, declared[name].vector, declared[name].unit == "rad")
    return table.builds(**given)


def _pixels(table: Table, path: str, file: str, colorspace: str, context: Context) -> Array:
    """Pixels of an image texture, each in the range of the parameter; where there are none, black."""
    try:
        pixels = read_texture(context.folder / file, colorspace)
    except ValueError as error:
        context.note(f"{path}.path = {shown(file)}: {error}")
        return jnp.zeros((1, 1, 1))
    assert table.interval is not None
    inside = table.interval.contains(pixels)
    if not inside.all():
        worst = pixels[~inside].flat[0]
        context.note(f"{path}.path = {shown(file)} has a pixel of {worst:g}, which is outside {table.interval}")
    return jnp.asarray(pixels, float)


def build(document: Any, folder: Path) -> tuple[Built, list[str]]:
    """What a validated document describes, and what is wrong with it all the same."""
    problems: list[str] = []
    context = Context(folder, problems.append)
    objects = {}
    for name, item in document.objects.items():
        shape = model_of(item.shape, f"objects.{name}.shape", context)
        objects[name] = Object(shape, model_of(item.surface, f"objects.{name}.surface", context))
    lights = {name: model_of(light, f"lights.{name}", context) for name, light in document.lights.items()}
    background = document.background
    if isinstance(background, Table):
        background = model_of(background, "background", context)
    else:
        background = _numbers(background, False, False)
    scene = Scene(objects, lights, background)
    camera = model_of(document.camera, "camera", context)
    settings = model_of(document.render, "render", context) if document.render else Settings()
    channels, wrong = _channels(scene)
    problems += [*wrong, *_zero_directions(scene), *_camera_problems(camera)]
    if not problems:
        try:
            check(scene)
            check_model(camera, "camera")
            canonical(scene)
        except ValueError as error:
            problems.append(str(error))
    return Built(scene, camera, settings, channels), problems


def _leaves(scene: Scene) -> Iterator[Leaf]:
    leaves: list[Leaf] = []

    def note(leaf: Leaf) -> Any:
        leaves.append(leaf)
        return leaf.value

    walk(scene, "", note)
    return iter(leaves)


def _channels(scene: Scene) -> tuple[int, list[str]]:
    """Number of channels of a scene: that of its spectra, of which those of length 1 are grey."""
    first: dict[int, str] = {}
    for path, value, declared in _leaves(scene):
        spectral = declared.spectral if declared else path == "background"
        if spectral and np.ndim(value) > 0:
            first.setdefault(np.shape(value)[-1], path)
    first.pop(1, None)
    if len(first) > 1:
        (a, path_a), (b, path_b) = list(first.items())[:2]
        return a, [f"{path_a} has {a} channels and {path_b} has {b}; a scene has one number of channels"]
    return next(iter(first), 1), []


def _zero_directions(scene: Scene) -> list[str]:
    found = []
    for path, value, _ in _leaves(scene):
        if isinstance(value, Vec3) and path.rpartition(".")[2] in DIRECTIONS and not bool(jnp.all(norm(value) > 0)):
            found.append(f"{path} has length 0; any other length is allowed")
    return found


def _camera_problems(camera: Any) -> list[str]:
    """Cameras that look nowhere, or along their own up."""
    view = camera.target - camera.position
    if not float(norm(view)) > 0:
        return ["camera.target is where camera.position is; the camera looks nowhere"]
    up = jax.tree.map(lambda x: jnp.asarray(x, float), camera.up)
    if not float(norm(up)) > 0:
        return ["camera.up has length 0; any other length is allowed"]
    if float(norm(cross(normalize(view), normalize(up)))) < PARALLEL:
        return ["camera.up is parallel to the view from camera.position to camera.target"]
    return []
