"""Timings of the renderer: `python tests/benchmark.py [CASE]...`; no test asserts any of them.

Each case runs in a process of its own, float32: first call, and what of it is tracing and compilation; median of warm
calls, temporary memory of the compiled program, peak memory of the process. The machine is measured beside it, as
nanoseconds per element of a fused multiply-add over an array that fits the cache: compare runs by that ratio.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import time
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.light import Ambient, Directional, PointLight
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import Blend, Dielectric, Phong
from jaxrefl.texture import Checker
from jaxrefl.vec import Vec3

SIZE = 512
CAMERA = Pinhole(Vec3(0.0, -8.0, 3.0), Vec3(0.0, 0.0, 0.7))
FIVE = (
    (0.0, 0.0, 1.0, 1.0),
    (2.2, 0.5, 0.8, 0.8),
    (-2.2, 0.3, 0.9, 0.9),
    (0.9, -1.8, 0.5, 0.5),
    (-1.0, -1.9, 0.45, 0.45),
)


def mirrors(spheres: np.ndarray) -> Object:
    """Mirror spheres of random colours."""
    x, y, z, r = np.asarray(spheres, np.float32).T
    colors = np.random.default_rng(0).uniform(0.1, 0.8, (len(x), 3)).astype(np.float32)
    return Object(Sphere(Vec3(x, y, z), r), Blend(Phong(k_d=colors, k_s=0.3, shininess=40.0), 0.5))


def scene(kind: str) -> Scene:
    """The scene of a case: five mirror spheres, one of them of glass, or a hundred."""
    spheres = np.array(FIVE)
    if kind == "hundred":
        spheres = np.array([(x, y, 0.3, 0.3) for x in np.linspace(-4, 4, 10) for y in np.linspace(-3, 6, 10)])
    objects = {"mirrors": mirrors(spheres[1:] if kind == "glass" else spheres)}
    if kind == "glass":
        objects["glass"] = Object(Sphere(Vec3(*FIVE[0][:3]), FIVE[0][3]), Dielectric(1.5))
    checker = Checker([0.8, 0.8, 0.8], [0.2, 0.2, 0.2])
    objects["floor"] = Object(Plane(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)), Blend(Phong(k_d=checker), 0.2))
    lights = {
        "ambient": Ambient(0.1),
        "lamp": PointLight(Vec3(4.0, -4.0, 6.0), diffuse=0.6),
        "sun": Directional(Vec3(1.0, 2.0, -3.0), diffuse=0.5),
    }
    return Scene(objects, lights, Sky([0.3, 0.5, 0.9], [0.8, 0.85, 0.9]))


def image(scene: Scene, n_bounces: int) -> jax.Array:
    """Radiance alone: what is not asked for is not computed."""
    return render(scene, CAMERA, SIZE, SIZE, n_bounces, account=False).radiance


def on_all_cores(scene: Scene, n_bounces: int) -> jax.Array:
    """The same, tiles shared among one device per core, as `jaxrefl render` does."""
    return render(scene, CAMERA, SIZE, SIZE, n_bounces, account=False, devices=jax.devices()).radiance


def everything(scene: Scene, n_bounces: int) -> object:
    """Whole image: budget, counts, depth, normals and the rest."""
    return render(scene, CAMERA, SIZE, SIZE, n_bounces)


def mean_square(surfaces: dict, scene: Scene, n_bounces: int) -> jax.Array:
    """Loss, as a function of all materials."""
    objects = {name: Object(item.shape, surfaces[name]) for name, item in scene.objects.items()}
    return jnp.mean(image(Scene(objects, scene.lights, scene.background), n_bounces) ** 2)


def measure(function: object, *args: object) -> str:
    """Compile, run and time a function of arrays."""
    start, cpu_start = time.perf_counter(), time.process_time()
    lowered = jax.jit(function).lower(*args)
    traced = time.perf_counter() - start
    compiled = lowered.compile()
    compilation = time.perf_counter() - start - traced
    jax.block_until_ready(compiled(*args))
    first, first_cpu, times = time.perf_counter() - start, time.process_time() - cpu_start, []
    cpu_start = time.process_time()
    for _ in range(9):
        start = time.perf_counter()
        jax.block_until_ready(compiled(*args))
        times.append(1e3 * (time.perf_counter() - start))
    cpu = 1e3 * (time.process_time() - cpu_start) / len(times)
    temporary = compiled.memory_analysis().temp_size_in_bytes / 2**20
    return (
        f"first {first:6.2f} s (tracing {traced:.2f}, compilation {compilation:.2f}, CPU {first_cpu:.1f})"
        f"   warm {statistics.median(times):8.1f} ms (best {min(times):.1f}, CPU {cpu:.1f})"
        f"   temporary {temporary:6.1f} MiB"
    )


def multiply_add() -> float:
    """Nanoseconds per element of a fused multiply-add, best of many."""
    x = jnp.ones(16384, jnp.float32)
    chain = jax.jit(lambda x: jax.lax.fori_loop(0, 1000, lambda i, x: x * 0.999 + 0.001, x))
    chain(x).block_until_ready()
    times = []
    for _ in range(5):
        start = time.perf_counter()
        chain(x).block_until_ready()
        times.append(time.perf_counter() - start)
    return min(times) / 1000 / 16384 * 1e9


def cases() -> dict[str, object]:
    """Cases by name."""
    found = {}
    for kind in ("five", "hundred", "glass"):
        found[f"{kind}: image, 4 bounces"] = partial(forward, image, kind, 4)
        found[f"{kind}: image on all cores, 4 bounces"] = partial(forward, on_all_cores, kind, 4)
        found[f"{kind}: everything, 4 bounces"] = partial(forward, everything, kind, 4)
    for kind in ("five", "glass", "hundred"):
        for n in (1, 5, 10, 20) if kind != "hundred" else (4,):
            found[f"{kind}: image, {n} bounces"] = partial(forward, image, kind, n)
            found[f"{kind}: gradient, {n} bounces"] = partial(backward, kind, n)
    return found


def forward(function: object, kind: str, n_bounces: int) -> str:
    """Timing of an image."""
    return measure(partial(function, n_bounces=n_bounces), scene(kind))


def backward(kind: str, n_bounces: int) -> str:
    """Timing of the gradient of the mean square image in all materials."""
    from jaxrefl.scene import canonical

    whole = canonical(scene(kind))
    surfaces = {name: item.surface for name, item in whole.objects.items()}
    return measure(jax.grad(partial(mean_square, n_bounces=n_bounces)), surfaces, whole)


def main() -> None:
    """Run the cases whose names begin with one of the arguments, each in its own process."""
    if sys.argv[1:2] == ["--case"]:
        jax.config.update("jax_num_cpu_devices", os.cpu_count() or 1)
        line = cases()[sys.argv[2]]()
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{sys.argv[2]:34s} {line}   peak {peak:6.0f} MiB   multiply-add {multiply_add():.2f} ns", flush=True)
        return
    for name in cases():
        if not sys.argv[1:] or any(name.startswith(prefix) for prefix in sys.argv[1:]):
            subprocess.run([sys.executable, __file__, "--case", name], check=True)


if __name__ == "__main__":
    main()
