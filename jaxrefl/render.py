"""From a scene and a camera to an image: tiles, samples, devices.

The picture is cut into tiles of equal size, whatever the number of devices, so that images are equal: to the bit, and
with a `ThinFilm` to rounding. A call without ``progress`` is one traceable function to differentiate or map; with
``progress`` the same jitted function runs band by band and pass by pass in a Python loop, which a Ctrl-C can leave.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.sharding import Mesh, PartitionSpec

from . import camera as cameras
from . import d3d9
from .geometry import SKIP, Ray, Remedy
from .loop import Trace, trace_batch
from .params import foreign_classes
from .path import Budget, Options, features
from .sampling import sample_position
from .scene import Scene, canonical_model, check
from .stage import stage
from .trace import check_loop

ALPHAS = ("premultiplied", "printed")
TILE = 12288  # rays
BLOCKS = 3  # of a tile; a block is worked on at once, and left alone if it has nothing to do
PARTS = 12  # of a tile whose rays branch: each on its own, because what waits is too much to be moved
LANES = 16
STRIP = 32  # rows, about
BANDS = 64  # largest number of progress reports per pass


class Image(NamedTuple):
    """A rendered picture; row 0 is at the top. What belongs to the first hit is that of the first sample."""

    radiance: Array
    """(H, W, C) linear radiance."""
    alpha: Array
    """(H, W) D3D9 (7); 0 where the ray left the scene."""
    depth: Array
    """(H, W) distance to the first hit, inf for a miss."""
    normal: Array
    """(H, W, 3) unit normal of the first hit, to the viewer; 0 for a miss."""
    primitive: Array
    """(H, W) int32: number of the primitive first hit, -1 for a miss."""
    bounces: Array | None
    """(H, W) mean number of rays after the first one."""
    hits: Array | None
    """(H, W) mean number of hits, each of which asks for every light."""
    path_id: Array | None
    """(H, W) uint32: equal where no edge of a primitive, a shadow or a cone lies between."""
    budget: Budget | None
    """Each (H, W, C)."""


class Plan(NamedTuple):
    """Static part of a render."""

    width: int
    height: int
    n_bounces: int
    spp: int
    rows: int
    """Of a strip; pixels are numbered strip by strip and in it column by column, so that a tile is a patch."""
    tile: int
    tiles: int
    max_nodes: int | None
    max_waiting: int
    account: bool
    classes: tuple[type, ...]
    """Those of the scene that JAX alone would confuse."""


class Job(NamedTuple):
    """What is rendered: the leaves that the picture is a function of."""

    scene: Any
    camera: Any
    options: Options
    seed: Any


def plan_of(width: int, height: int, tile: int | None = None, **settings: Any) -> Plan:
    """Plan with strips, and tiles, of equal size.

    A part is an odd multiple of the lanes of a vector unit, a block of 4 times as many: other lengths leave them idle,
    and arrays of a power of two push each other out of the cache (measured: up to four times, and a tenth).
    """
    strips = math.ceil(height / STRIP)
    rows = math.ceil(height / strips)
    pixels = strips * rows * width
    tiles = math.ceil(pixels / (TILE if tile is None else tile))
    tile = PARTS * LANES * (math.ceil(pixels / tiles / PARTS / LANES) | 1)
    return Plan(width, height, rows=rows, tile=tile, tiles=math.ceil(pixels / tile), **settings)


def _pixel(number: Any, plan: Plan) -> tuple[Any, Any]:
    """Column and row of a ray; below the picture for those that fill up a tile."""
    strip, place = number // (plan.rows * plan.width), number % (plan.rows * plan.width)
    return place // plan.rows, strip * plan.rows + place % plan.rows


def _tile(job: Job, plan: Plan, tile: Array, sample: Array) -> Trace:
    """One sample of each pixel of one tile."""
    number = tile * plan.tile + jnp.arange(plan.tile, dtype=jnp.int32)

    def ray(number: Array) -> Ray:
        column, row = _pixel(number, plan)
        row = jnp.minimum(row, plan.height - 1)  # what is too much repeats the last row
        dx = dy = 0.5
        if plan.spp > 1:
            dx, dy = sample_position(job.seed, column, row, sample)  # type: ignore[assignment]
        x = (2 * (column + dx) - plan.width) / plan.height
        y = 1 - 2 * (row + dy) / plan.height
        return job.camera.ray(jnp.asarray(x, job.scene.dtype), jnp.asarray(y, job.scene.dtype))

    return _traced(job, plan, jax.vmap(ray)(number))


def _traced(job: Job, plan: Plan, rays: Ray) -> Trace:
    """A tile, traced as suits the scene: in blocks whose rays change places, or, where rays branch, in small parts."""
    trace = functools.partial(
        trace_batch,
        job.scene,
        options=job.options,
        n_bounces=plan.n_bounces,
        max_nodes=plan.max_nodes,
        max_waiting=plan.max_waiting,
        account=plan.account,
    )
    if not features(job.scene).is_tree:
        return trace(rays, blocks=BLOCKS)
    parts = lax.map(trace, jax.tree.map(lambda x: x.reshape(PARTS, -1), rays))
    return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), parts)


def _tiles(job: Job, first: Array, samples: Array, plan: Plan, count: int, step: int = 1) -> Trace:
    """Sums over samples of every step-th tile: (count, tile, ...); what belongs to the first hit is not summed."""
    staged = stage(job.scene)
    job = job._replace(scene=staged, camera=canonical_model(job.camera, staged.dtype))

    @jax.checkpoint
    def one(tile: Array) -> Trace:
        shot = functools.partial(_tile, job, plan, tile)
        if samples.shape[0] == 1:
            return shot(samples[0])
        zero = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), jax.eval_shape(shot, samples[0]))

        def add(total: Trace, sample: Array) -> tuple[Trace, None]:
            return _sum(total, shot(sample), sample == samples[0]), None

        return lax.scan(add, zero, samples)[0]

    return lax.map(one, first + step * jnp.arange(count, dtype=jnp.int32))


def _sum(total: Trace, new: Trace, is_first: Any) -> Trace:
    """Sum of two traces; integers, depth and normal are those of the first."""
    keep = functools.partial(jax.tree.map, lambda a, b: jnp.where(is_first, b, a))
    summed = jax.tree.map(jnp.add, total, new)
    account = summed.account
    if account is not None and total.account is not None and new.account is not None:
        account = account._replace(path_id=keep(total.account.path_id, new.account.path_id))
    kept = {name: keep(getattr(total, name), getattr(new, name)) for name in ("depth", "normal", "primitive")}
    return summed._replace(account=account, **kept)


@functools.partial(jax.jit, static_argnames=("plan", "count", "devices"))
def _band(job: Job, first: Array, samples: Array, plan: Plan, count: int, devices: tuple[Any, ...]) -> Trace:
    """A run of tiles, dealt to the devices in turn: sky and scene to each; without devices where the arguments are."""
    if not devices:
        return _tiles(job, first, samples, plan, count)
    number = len(devices)
    share = math.ceil(count / number)

    def mine(start: Array) -> Trace:
        return _tiles(job, start[0], samples, plan, share, number)

    mesh, spec = Mesh(np.array(devices), ("tiles",)), PartitionSpec("tiles")
    starts = first + jnp.arange(number, dtype=jnp.int32)
    dealt = jax.shard_map(mine, mesh=mesh, in_specs=spec, out_specs=spec, check_vma=False)(starts)
    return jax.tree.map(lambda x: jnp.swapaxes(x.reshape(number, share, *x.shape[1:]), 0, 1).reshape(x.shape), dealt)


def tiles(job: Job, plan: Plan, devices: tuple[Any, ...]) -> Trace:
    """All tiles and samples of a picture; traceable."""
    return _band(job, jnp.int32(0), jnp.arange(plan.spp, dtype=jnp.int32), plan, plan.tiles, devices)


def picture(trace: Trace, plan: Plan) -> Image:
    """Picture of the tiles of a finished render."""
    strips = math.ceil(plan.height / plan.rows)

    def shape(x: Array) -> Array:
        flat = x.reshape(-1, *x.shape[2:])[: strips * plan.rows * plan.width]
        columns = flat.reshape(strips, plan.width, plan.rows, *x.shape[2:])
        return jnp.swapaxes(columns, 1, 2).reshape(-1, plan.width, *x.shape[2:])[: plan.height]

    mean = jax.tree.map(lambda x: x / plan.spp, (trace.radiance, trace.alpha))
    radiance, alpha = (shape(x) for x in mean)
    n = trace.normal
    account, dtype = trace.account, trace.radiance.dtype
    return Image(
        radiance,
        alpha,
        shape(trace.depth),
        jnp.stack([shape(n.x), shape(n.y), shape(n.z)], axis=-1),
        shape(trace.primitive),
        None if account is None else shape(account.rays.astype(dtype) / plan.spp - 1),
        None if account is None else shape(account.hits.astype(dtype) / plan.spp),
        None if account is None else shape(account.path_id),
        None if account is None else Budget(*(shape(x / plan.spp) for x in account.budget)),
    )


def render(
    scene: Scene,
    camera: Any,
    width: int,
    height: int,
    n_bounces: int,
    *,
    spp: int = 1,
    seed: int = 0,
    alpha: str = "premultiplied",
    max_nodes: int | None = None,
    max_waiting: int = 6,
    min_weight: Any = 0.0,
    remedy: Remedy = SKIP,
    account: bool = True,
    progress: Callable[[int, int, int], None] | None = None,
    devices: Sequence[Any] | None = None,
    tile: int | None = None,
) -> Image:
    """Picture of a scene.

    Args:
        scene, camera: pytrees; the dtype of the scene rules.
        width, height: pixels; the picture is ``height`` high in the camera's unit, so width / height is its aspect.
        n_bounces, max_nodes, max_waiting, min_weight, remedy: as in `jaxrefl.trace.trace`.
        spp: samples per pixel; 1 is the centre of the pixel, more are scrambled Sobol points.
        seed: of the scrambling.
        account: keep what the Image holds beyond radiance, alpha and first hit; a tenth faster without.
        alpha: "premultiplied", or "printed": max(d_a, |R_tot|), D3D9 (7).
        progress: called with (samples done, samples in all, rays traced so far) after each band; not traceable.
        devices: share the tiles among these; the image is the same, see the head of this module.
        tile: rays of a tile, about, 192 at least; of influence on speed and memory alone.

    Raises:
        ValueError: a value out of its range.

    Differentiable in every leaf of scene and camera, except for the motion of edges.
    """
    cameras.check_picture(camera, width=width, height=height, spp=spp, tile=TILE if tile is None else tile)
    if alpha not in ALPHAS:
        raise ValueError(f"alpha = {alpha!r} must be one of {', '.join(ALPHAS)}")
    check_loop(n_bounces, max_nodes, max_waiting, min_weight)
    check(scene)
    loop = {"n_bounces": n_bounces, "spp": spp, "max_nodes": max_nodes, "max_waiting": max_waiting}
    plan = plan_of(width, height, tile, **loop, account=account, classes=foreign_classes((scene, camera)))
    job = Job(scene, camera, Options(remedy, min_weight, n_bounces), seed)
    places = tuple(devices or ())
    traced = tiles(job, plan, places) if progress is None else _in_bands(job, plan, places, progress)
    image = picture(traced, plan)
    if alpha == "premultiplied":
        return image
    job, local = job._replace(options=job.options._replace(n_bounces=0)), plan._replace(n_bounces=0)
    first = tiles(job, local, places)
    coverage = picture(traced._replace(alpha=traced.coverage), plan).alpha
    r_tot = jnp.maximum(image.radiance - picture(first, plan).radiance, 0.0)
    return image._replace(alpha=jax.vmap(jax.vmap(d3d9.alpha_printed))(coverage, r_tot))


def _in_bands(job: Job, plan: Plan, devices: tuple[Any, ...], report: Callable[[int, int, int], None]) -> Trace:
    """All tiles and samples in a Python loop: passes of one sample, bands of equal numbers of tiles."""
    each = max(1, len(devices))
    count = math.ceil(plan.tiles / BANDS / each) * each
    pixels, rays, result = plan.width * plan.height, 0, None
    for sample in range(plan.spp):
        bands = []
        for first in range(0, plan.tiles, count):
            one, start = jnp.arange(sample, sample + 1), jnp.int32(first)
            band = _band(job, start, one, plan, count, devices)
            bands.append(jax.tree.map(np.asarray, band))
            done = min((first + count) * plan.tile, pixels)
            inside = _pixel(first * plan.tile + np.arange(band.depth.size), plan)[1] < plan.height
            rays += 0 if band.account is None else int(band.account.rays.reshape(-1)[inside].sum())
            report(sample * pixels + done, plan.spp * pixels, rays)
        whole = jax.tree.map(lambda *x: np.concatenate(x), *bands)
        result = whole if result is None else _sum(result, whole, False)
    assert result is not None
    return jax.tree.map(jnp.asarray, result)
