"""Pictures by wavelength: a cube of radiance, and what an eye sees of it."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from .. import colour
from ..camera import check_picture
from ..geometry import SKIP, Remedy
from ..params import foreign_classes
from ..path import Options
from ..render import TILE, Image, Job, Plan, picture, plan_of, render, tiles
from ..scene import check
from ..trace import check_loop
from .build import Build, combined, family

CHUNK = 8  # wavelengths traced together where each is a scene of its own


class SpectralImage(NamedTuple):
    """A picture by wavelength; row 0 is at the top. What belongs to the first hit is that of the first wavelength."""

    radiance: Array
    """(H, W, n) linear radiance at the wavelengths."""
    wavelength_nm: np.ndarray
    """(n,) nanometres, not traced."""
    alpha: Array
    """(H, W) as of `jaxrefl.render.Image`; the mean over the wavelengths."""
    depth: Array
    """(H, W) distance to the first hit, inf for a miss."""
    normal: Array
    """(H, W, 3) unit normal of the first hit; 0 for a miss."""
    primitive: Array
    """(H, W) int32: number of the primitive first hit, -1 for a miss."""

    def rgb(self, illuminant: Any = "D65", observer: str = colour.OBSERVER, white: str = "exact") -> Image:
        """Picture in linear sRGB, unclipped, if all light has the spectrum of an illuminant times that of the scene.

        Lights and background of the scene are then relative to the illuminant: a spectrum of ones is its own. One
        render so serves any illuminant. Arguments and errors as of `jaxrefl.colour.spectrum_to_rgb`. Differentiable;
        under `jit` where the picture is made there, too, because its wavelengths must be known.
        """
        radiance = colour.spectrum_to_rgb(self.radiance, self.wavelength_nm, illuminant, observer, white)
        return self._shown(radiance)

    def xyz(self, illuminant: Any = "D65", observer: str = colour.OBSERVER) -> Image:
        """The same in XYZ, Y = 1 for radiance 1 at every wavelength."""
        return self._shown(colour.spectrum_to_xyz(self.radiance, self.wavelength_nm, illuminant, observer))

    def _shown(self, radiance: Array) -> Image:
        return Image(radiance, self.alpha, self.depth, self.normal, self.primitive, None, None, None, None)


def render_spectral(
    build: Build,
    camera: Any,
    wavelength_nm: Float[ArrayLike, "n"],
    width: int,
    height: int,
    n_bounces: int,
    *,
    spp: int = 1,
    seed: int = 0,
    max_nodes: int | None = None,
    max_waiting: int = 6,
    min_weight: Any = 0.0,
    remedy: Remedy = SKIP,
    progress: Callable[[int, int, int], None] | None = None,
    devices: Sequence[Any] | None = None,
) -> SpectralImage:
    """Picture of a scene by wavelength.

    Args:
        build: scene of ONE wavelength in nanometres; pure and traceable, so that indices are evaluated there.
        camera, width, height, n_bounces, spp, seed, max_nodes, max_waiting, min_weight, remedy, devices: as of
            `jaxrefl.render.render`.
        wavelength_nm: (n,) nanometres, ascending, any number; not traced.
        progress: called with (samples done, samples in all, 0: rays are not counted); not traceable.

    Raises:
        ValueError: a value out of its range at any of the wavelengths; a colour of several channels in the scene of
            one; a wavelength outside the data of a material.

    Where colours alone depend on the wavelength, one pass carries spectra of n channels; else the same trace is
    mapped over the wavelengths, `CHUNK` of them at a time, which share the search for the first hit.
    Differentiable in the camera and in whatever ``build`` closes over, but for the motion of edges.
    """
    scenes = family(build, wavelength_nm)
    places = np.asarray(wavelength_nm, np.float64)
    count = len(places)
    loop: dict[str, Any] = {"n_bounces": n_bounces, "spp": spp, "max_nodes": max_nodes, "max_waiting": max_waiting}
    if not scenes.dispersing:
        image = render(
            combined(scenes), camera, width, height, seed=seed, min_weight=min_weight, remedy=remedy, account=False,
            progress=progress, devices=devices, tile=_tile(count / 3), **loop,
        )  # fmt: skip
        radiance = jnp.broadcast_to(image.radiance, (*image.radiance.shape[:2], count))  # of one, if nothing depends
        return _spectral(image._replace(radiance=radiance), places)
    check_picture(camera, width=width, height=height, spp=spp)
    check_loop(n_bounces, max_nodes, max_waiting, min_weight)
    each = [jax.tree.unflatten(scenes.structure, scenes.at(i)) for i in range(count)]
    for scene in each:
        check(scene)
    chunk = min(CHUNK, count)
    plan = plan_of(width, height, _tile(chunk), **loop, account=False, classes=foreign_classes((each[0], camera)))
    options, images, form = Options(remedy, min_weight, n_bounces), [], (scenes.structure, scenes.varying)
    for first in range(0, count, chunk):
        some = scenes.at(np.minimum(np.arange(first, first + chunk), count - 1))
        image = _mapped(some, camera, options, seed, *form, plan, tuple(devices or ()))
        images.append(image._replace(radiance=image.radiance[: count - first], alpha=image.alpha[: count - first]))
        if progress is not None:
            done = min(first + chunk, count) * width * height * spp
            image.radiance.block_until_ready()
            progress(done, count * width * height * spp, 0)
    radiance = jnp.concatenate([image.radiance[..., 0] for image in images])
    alpha = jnp.concatenate([image.alpha for image in images])
    return _spectral(images[0]._replace(radiance=jnp.moveaxis(radiance, 0, -1), alpha=alpha.mean(axis=0)), places)


def _tile(copies: float) -> int:
    """Rays of a tile that carry so many times what a ray of three channels does: what fits the cache stays so."""
    return min(TILE, math.ceil(4 * TILE / copies))


@functools.partial(jax.jit, static_argnames=("structure", "varying", "plan", "devices"))
def _mapped(
    leaves: Any, camera: Any, options: Options, seed: Any, structure: Any, varying: Any, plan: Plan, devices: Any
) -> Image:
    """Pictures of several scenes; what belongs to the first hit, of the first one."""

    def one(*leaves: Array) -> Image:
        job = Job(jax.tree.unflatten(structure, leaves), camera, options, seed)
        return picture(tiles(job, plan, devices), plan)

    image = jax.vmap(one, in_axes=tuple(0 if varies else None for varies in varying))(*leaves)
    return image._replace(depth=image.depth[0], normal=image.normal[0], primitive=image.primitive[0])


def _spectral(image: Image, wavelength_nm: np.ndarray) -> SpectralImage:
    return SpectralImage(image.radiance, wavelength_nm, image.alpha, image.depth, image.normal, image.primitive)
