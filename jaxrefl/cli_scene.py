"""The commands of scene files: `jaxrefl render`, `jaxrefl schema`, `jaxrefl new-scene`.

A render computes in float32, whatever the other commands do.
"""

from __future__ import annotations

import dataclasses
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

INTERRUPTED = 130
app = typer.Typer()


Report = Callable[[int, int, int], None]
"""What a render calls after each band: with the pixels done, all pixels, and the rays traced so far."""


class Meter:
    """Rays per second of a render, the first band left out: most of its time is compilation."""

    def __init__(self) -> None:
        self.start = self.first = self.last = time.perf_counter()
        self.rays_first = self.rays = 0

    def note(self, rays: int) -> None:
        """Take down the rays traced so far."""
        self.last, self.rays = time.perf_counter(), rays
        if self.first == self.start:
            self.first, self.rays_first = self.last, rays

    def __str__(self) -> str:
        rays, seconds = self.rays - self.rays_first, self.last - self.first
        if rays <= 0:
            rays, seconds = self.rays, self.last - self.start
        return f"{rays / max(seconds, 1e-9) / 1e6:.2f} Mrays/s"


@contextmanager
def progress(console: Console, name: str, meter: Meter) -> Iterator[Report]:
    """Bar with the rays per second, shown while the block runs."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(f"{escape(name)}: compiling", total=None, speed="")

        def report(done: int, total: int, rays: int) -> None:
            meter.note(rays)
            bar.update(task, description=escape(name), total=total, completed=done, speed=str(meter))

        yield report


def overrides(given: Mapping[str, Any], settings: list[str]) -> list[str]:
    """Settings of the options that were given, and then those of ``--set``."""
    return [f"render.{name}={value}" for name, value in given.items() if value is not None] + settings


@app.command()
def render(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or perrin, jhu, d3d9 or fresnel.")],
    out: Annotated[list[Path] | None, typer.Option("-o", "--out", help="A .png, .exr or .npz; several times.")] = None,
    width: Annotated[int | None, typer.Option(help="Pixels.")] = None,
    height: Annotated[int | None, typer.Option(help="Pixels.")] = None,
    bounces: Annotated[int | None, typer.Option(help="Reflections followed; 0 = first hit only.")] = None,
    spp: Annotated[int | None, typer.Option(help="Samples per pixel.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the samples.")] = None,
    exposure: Annotated[float | None, typer.Option(help="Stops; a PNG shows radiance times 2^exposure.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Such as objects.glass.surface.eta=1.33.")
    ] = None,
    gamut: Annotated[str, typer.Option(help="Colours no screen shows, in a PNG: clip or desaturate.")] = "clip",
    transparent: Annotated[bool, typer.Option("--transparent", help="Write the coverage into the PNG.")] = False,
    half: Annotated[bool, typer.Option("--half", help="Write half floats into the EXR.")] = False,
) -> None:
    """Render a scene file."""
    import jax

    from . import image, scene_file
    from .colourspace import GAMUTS
    from .render import render as render_image

    with suppress(RuntimeError):  # somebody has computed in this process before
        jax.config.update("jax_num_cpu_devices", os.cpu_count() or 1)  # tiles run side by side, one per core
    given = {
        "width": width, "height": height, "n_bounces": bounces, "spp": spp, "seed": seed, "exposure": exposure,
    }  # fmt: skip
    changes = overrides(given, settings or [])
    loaded = scene_file.load(scene_file.find(scene), settings=changes)
    s = loaded.settings
    if gamut not in GAMUTS:
        raise ValueError(f"--gamut = {gamut!r} must be one of {', '.join(GAMUTS)}")
    paths = list(dict.fromkeys(out or [Path(f"{Path(scene).stem}.png")]))
    for path in paths:
        image.format_of(path, loaded.channels)
    facts = {
        "scene": Path(loaded.name).name,
        "scene_sha256": loaded.sha256,
        "settings": dataclasses.asdict(s),
        "set": changes,
    }
    console, meter = Console(stderr=True), Meter()
    written: list[Path] = []
    try:
        with progress(console, Path(scene).stem, meter) as report:
            picture = render_image(
                loaded.scene, loaded.camera, s.width, s.height, s.n_bounces,
                spp=s.spp, seed=s.seed, alpha=s.alpha, progress=report, devices=jax.devices(),
            )  # fmt: skip
        for path in paths:
            image.write(
                path, picture, exposure=s.exposure, transparent=transparent, straight=s.alpha == "printed",
                gamut=gamut, half=half, metadata=facts,
            )  # fmt: skip
            written.append(path)
    except KeyboardInterrupt:
        kept = f"complete: {', '.join(map(str, written))}" if written else "nothing was written"
        console.print(f"interrupted; {escape(kept)}")
        raise typer.Exit(INTERRUPTED) from None
    seconds = time.perf_counter() - meter.start
    size = f"{s.width} x {s.height}, {s.n_bounces} bounces, {s.spp} spp"
    print(f"{', '.join(map(str, written))}: {size}, {seconds:.1f} s, {meter}")


@app.command()
def schema() -> None:
    """Print the JSON schema of scene files."""
    from . import scene_file

    print(json.dumps(scene_file.json_schema(), indent=1))


@app.command("new-scene")
def new_scene(
    path: Annotated[Path, typer.Argument(metavar="[PATH]", help="File to write.")] = Path("scene.toml"),
    example: Annotated[str | None, typer.Option("--from", metavar="NAME", help="A shipped scene to copy.")] = None,
) -> None:
    """Write a commented scene to begin with; an existing file is left alone."""
    from . import scene_file
    from .files import write_atomically

    if path.exists():
        raise ValueError(f"path = {str(path)!r} exists; it is not overwritten")
    text = scene_file.example(example).read_text(encoding="utf-8") if example else scene_file.starter()
    write_atomically(path, lambda part: part.write_text(text, encoding="utf-8"))
    print(f"{path}: written; render it with   jaxrefl render {path} -o {path.stem}.png")
