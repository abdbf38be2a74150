"""JHU, "excessive number of ray/object intersection calculations": the tests that a picture takes, counted.

What `jaxrefl.beam` spares of them depends on how the picture is divided, and is not counted.
"""

import numpy as np

from jaxrefl import plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Sphere
from jaxrefl.light import Directional
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import Blend, Phong

CAPTION = """In a basic ray tracer every ray is tested against every primitive, and at every hit one shadow ray per
light is as well. With 64 spheres, two lights and up to 5 bounces that makes 398 tests for the average pixel of this
picture, 1152 for the worst, 17.2 million for all 43 200; the rays from the eye alone would take 64 each, which is all
where they meet the sky. The worst pixel takes 18 tests per primitive whatever their number, so that the cost grows in
proportion to it; the mean grows faster, from 3.8 to 6.2 tests per primitive, because more spheres mirror each other."""
SIZE = (9.0, 6.0)
GROUND = 1


def compute(side: int = 8, n_bounces: int = 5, width: int = 240, height: int = 180) -> dict:
    n = side * side
    rng = np.random.default_rng(6)
    order = rng.permutation(n - GROUND)
    column, row = np.divmod(np.arange(n - GROUND), side)
    radius = rng.uniform(0.28, 0.46, n - GROUND)
    place = np.stack([column - 0.5 * (side - 1), row - 0.5 * (side - 1), radius], -1)[order]
    color = rng.dirichlet([0.6, 0.6, 0.6], n)
    color[0] = 0.5, 0.42, 0.33
    surface = Blend(Phong(k_d=color, k_s=0.3, k_a=0.3 * color), reflectivity=np.r_[0.2, np.full(n - 1, 0.55)][:, None])
    counts = np.array([2**k for k in range(1, 20) if 2**k <= n])
    lights = {"sun": Directional([1.0, 1.0, -2.0], diffuse=0.8), "lamp": Directional([-2.0, 1.0, -1.5], diffuse=0.4)}
    eye = Pinhole([-1.5, -8.5, 3.2], [0.0, 0.0, 0.2], field_of_view=0.62)
    rays, shadow_rays = [], []
    for count in counts:  # the spheres after these lie where no ray comes: a scene of this number, compiled but once
        seen = np.arange(n - GROUND) < count - GROUND
        center = np.where(seen[:, None], place, [0.0, 0.0, -1e4])
        shape = Sphere(np.vstack([[0.0, 0.0, -1000.0], center]), np.r_[1000.0, np.where(seen, radius[order], 1e-3)])
        image = render(
            Scene({"balls": Object(shape, surface)}, lights, Sky([0.25, 0.45, 0.9], [0.75, 0.85, 0.95], 0.2)),
            eye,
            width,
            height,
            n_bounces,
        )
        rays.append(np.asarray(image.bounces) + 1)
        shadow_rays.append(np.asarray(image.hits) * len(lights))
    rays, shadow_rays = np.array(rays), np.array(shadow_rays)
    tests = counts[:, None, None] * (rays + shadow_rays)
    return {
        "radiance": image.radiance,
        "primitives": counts,
        "tests": tests[-1],
        "mean": tests.mean((1, 2)),
        "largest": tests.max((1, 2)),
        "rays": rays.mean((1, 2)),
        "total": tests[-1].sum(),
        "eye": counts,
    }


def draw(data: dict, fig) -> None:
    (image, cost), (histogram, growth) = fig.subplots(2, 2)
    n = int(data["primitives"][-1])
    plot.picture(data["radiance"], ax=image, title=f"{n} spheres, the ground one of them")
    plot.field(data["tests"], ax=cost, title="intersection tests per pixel", label="tests")
    values, pixels = np.unique(data["tests"], return_counts=True)
    share = 100 * pixels / data["tests"].size
    plot.bars(histogram, values, share, 0.6 * n, labels=[f"{x:.1f}" for x in share])
    mean, largest = data["mean"], data["largest"]
    plot.mark(histogram, x=float(mean[-1]), text="mean {:.0f}")
    plot.labels(histogram, xlabel="intersection tests per pixel", ylabel="pixels (%)", ylim=(0, 66))
    style = {"marker": "o", "markersize": 4}
    plot.cartesian(data["primitives"], largest, ax=growth, color=plot.RED, label="worst pixel", **style)
    plot.cartesian(data["primitives"], mean, ax=growth, color=plot.BLUE, label="mean", **style)
    plot.cartesian(data["primitives"], data["eye"], ax=growth, color=plot.GREY, label="eye ray alone", **style)
    plot.labels(growth, xlabel="primitives in the scene", ylabel="intersection tests per pixel", legend="upper left")
