"""A room between two mirrors with more and more bounces, from the terms of one trace."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot, series
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.light import Ambient, PointLight
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import Blend, Phong
from jaxrefl.texture import Checker
from jaxrefl.trace import trace

CAPTION = """PERRIN (5) in a room between two mirrors of α = 0.85: the pictures with 0 to 10 bounces are partial sums of
the terms of one trace. Each bounce adds an image farther down the mirrors. Top right: what bounce n adds to a pixel
stays under the bound α^n c_max. The largest change follows it, 0.149 under 0.208 at n = 10; the mean falls faster, from
0.085 at n = 1 to 0.0007 at n = 10, for most rays end on what reflects little. Bottom right: after 10 bounces 0.167 =
α^11 of the weight is left where a ray has met nothing but mirrors."""
SIZE = (11.4, 4.6)
SHOWN = (0, 1, 2, 3, 5, 10)


def compute(reflectivity: float = 0.85, n_bounces: int = 24, width: int = 200, height: int = 150) -> dict:
    camera = Pinhole(Vec3(1.7, -2.8, 1.5), Vec3(-2.0, -0.2, 0.7), field_of_view=0.9)
    x, y = (2 * np.arange(width) + 1 - width) / height, 1 - (2 * np.arange(height) + 1) / height
    last = SHOWN[-1]

    @jax.jit
    def shoot(scene):
        rays = jax.vmap(camera.ray)(*(jnp.asarray(a.ravel()) for a in np.meshgrid(x, y)))
        found = trace(scene, rays, n_bounces, terms=True)
        color, local, _, weight = found.terms
        added = weight * local * color
        partial = jnp.cumsum(added, axis=1)
        return {
            "pictures": jnp.moveaxis(partial[:, jnp.asarray(SHOWN)], 1, 0).reshape(-1, height, width, 3),
            "left": weight[:, last + 1].max(axis=-1).reshape(height, width),
            "change_mean": added.mean(axis=(0, 2)),
            "change_max": added.max(axis=(0, 2)),
            "brightest": color.max(),
            "defect": jnp.abs(partial[:, -1] - found.radiance).max(),
        }

    data = shoot(_room(reflectivity))
    n = np.arange(n_bounces + 1)
    return data | {
        "bounce": n,
        "shown": np.array(SHOWN),
        "bound": series.truncation_bound(n, reflectivity, data["brightest"]),  # of what is left out after n bounces
        "reflectivity": reflectivity,
    }


def _room(reflectivity: float) -> Scene:
    """Two facing mirrors, a floor, a wall at the end, and three balls."""
    up, mirror = (
        Vec3(0.0, 0.0, 1.0),
        Blend(Phong(k_d=[0.1, 0.2, 0.15], k_a=[0.1, 0.2, 0.15]), reflectivity=reflectivity),
    )
    tiles, bricks = (
        Checker(even, odd, density, density)
        for even, odd, density in (
            ([0.8, 0.7, 0.55], [0.25, 0.18, 0.14], 1.25),
            ([0.35, 0.5, 0.8], [0.25, 0.4, 0.7], 1.0),
        )
    )
    colors = jnp.asarray([[0.85, 0.2, 0.1], [0.1, 0.45, 0.3], [0.9, 0.65, 0.15]])
    reflects = jnp.asarray([[0.05], [0.3], [0.15]])
    x, y, r = jnp.asarray([[-0.6, 0.9, -0.9], [-1.7, -0.1, 0.6], [0.45, 0.6, 0.75]])
    return Scene(
        {
            "left": Object(Plane(Vec3(-2.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)), mirror),
            "right": Object(Plane(Vec3(2.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0)), mirror),
            "floor": Object(Plane(Vec3(0.0, 0.0, 0.0), up), Blend(Phong(k_d=tiles, k_a=tiles), reflectivity=0.1)),
            "end": Object(
                Plane(Vec3(0.0, 5.0, 0.0), Vec3(0.0, -1.0, 0.0)), Blend(Phong(k_d=bricks, k_a=bricks), reflectivity=0.1)
            ),
            "balls": Object(Sphere(Vec3(x, y, r), r), Blend(Phong(k_d=colors, k_a=colors, k_s=0.4), reflects)),
        },
        {"ambient": Ambient(0.35), "lamp": PointLight(Vec3(0.0, -2.0, 3.2), diffuse=0.65, specular=0.5)},
        Sky([0.35, 0.5, 0.8], [0.85, 0.88, 0.95], 0.1),
    )


def draw(data: dict, fig) -> None:
    axes = fig.subplots(2, 4, width_ratios=(1, 1, 1, 1.15))
    for ax, picture, n in zip(axes[:, :3].ravel(), data["pictures"], data["shown"], strict=True):
        plot.picture(picture, ax=ax, title=f"{n} bounce{'' if n == 1 else 's'}")
    change, left = axes[:, 3]
    n = data["bounce"][1:]
    alpha = float(data["reflectivity"])
    dots = {"marker": "o", "markersize": 2.5, "linewidth": 1.0}
    plot.cartesian(
        n, data["bound"][:-1], ax=change, color=plot.GREY, linestyle=":", label=rf"bound ${alpha:g}^n c_{{max}}$"
    )
    plot.cartesian(n, data["change_max"][1:], ax=change, color=plot.ORANGE, label="largest", **dots)
    plot.cartesian(n, data["change_mean"][1:], ax=change, color=plot.BLUE, label="mean", **dots)
    text = {"xlabel": "bounce n", "ylabel": "radiance it adds", "title": "change of the pixels"}
    plot.labels(change, yscale="log", ylim=(2e-6, 2), legend="lower left", **text)
    last = int(data["shown"][-1])
    plot.field(data["left"], ax=left, title=f"weight left after {last} bounces", label="weight")
