"""Self-shadowing: the acne of float32, and the remedies of the JHU lecture, near the origin and far from it."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import SKIP, Plane, Sphere, no_remedy, nudge, offset, tolerance
from jaxrefl.light import Ambient, Directional
from jaxrefl.params import param, pytree
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import Dielectric, Phong, Whitted

CAPTION = """JHU, "Floating Point Imprecision and Self Shadowing": an orange and a glass ball, 2 m wide, in float32.
Below each picture: how many pixels of either ball are off the float64 picture by more than 0.05. Without a remedy the
balls hit themselves, in more than 20 % of the orange one and 70 % of the glass. 1 mm of tolerance, of nudge along the
ray or of offset along the normal leaves less than 0.1 %; but at coordinates of 20 km, where float32 goes in steps of 2
mm, each leaves more than 15 % and 20 %. Not testing the primitive just left needs no length and leaves less than 0.2 %
there. The lecture's form of that remedy, which leaves the object out altogether, loses what is refracted into it: more
than 95 % of the glass."""
SIZE = (11.6, 3.8)
PLACES = (0.0, 2e4)


@pytree
class Ball(Sphere):
    """Sphere that a ray which leaves it never meets again, if ``left_out`` is 1: not from the inside either."""

    left_out: Any = param("[0, 1]", default=0.0, doc="1 for the remedy as the lecture has it")

    def chord(self, n, direction):
        """Way through the inside, infinite if left out."""
        return jnp.where(self.left_out > 0.5, jnp.inf, super().chord(n, direction))


def compute(epsilon: float = 1e-3, width: int = 128, height: int = 96, threshold: float = 0.05) -> dict:
    remedies = {
        "none": (no_remedy(), 0.0),
        "tolerance": (tolerance(epsilon), 0.0),
        "nudge": (nudge(epsilon), 0.0),
        "offset": (offset(epsilon), 0.0),
        "skip": (SKIP, 0.0),
        "left_out": (SKIP, 1.0),
    }

    def picture(place, remedy, left_out, dtype):
        x = jnp.asarray(place, dtype)
        camera = Pinhole(Vec3(x + 0.3, x - 7.0, 2.6), Vec3(x, x, 0.8), field_of_view=0.5)
        return render(_scene(x, jnp.asarray(left_out, dtype)), camera, width, height, 3, remedy=remedy)

    image = picture(0.0, SKIP, 0.0, jnp.float64)
    exact, primitive = np.asarray(image.radiance), np.asarray(image.primitive)
    pictures = np.array([[picture(x, *remedy, jnp.float32).radiance for remedy in remedies.values()] for x in PLACES])
    wrong = np.abs(pictures - exact).max(axis=-1) > threshold
    return {
        "places": np.array(PLACES),
        "step": np.spacing(np.float32(PLACES[-1])),
        "epsilon": epsilon,
        "threshold": threshold,
        "remedies": np.array(list(remedies)),
        "exact": exact,
        "pictures": pictures,
        "wrong_ball": wrong[..., primitive == 0].mean(axis=-1),
        "wrong_glass": wrong[..., primitive == 2].mean(axis=-1),
    }


def _scene(x, left_out) -> Scene:
    """Two balls on a floor, at a distance from the origin."""
    floor = Plane(Vec3(x, x, 0.0), Vec3(0.0, 0.0, 1.0))
    ball, glass = (Ball(Vec3(x + a, x + b, r), r, left_out) for a, b, r in ((-1.1, 0.3, 1.0), (1.0, -0.6, 1.0)))
    orange = [0.75, 0.35, 0.1]
    return Scene(
        {
            "ball": Object(ball, Whitted(Phong(k_d=orange, k_a=orange), k_rg=0.2)),
            "floor": Object(floor, Phong(k_d=0.6, k_a=1.0)),
            "glass": Object(glass, Dielectric(1.5)),
        },
        {"sky": Ambient(0.2), "sun": Directional(Vec3(-1.0, 0.8, -1.2), diffuse=0.9)},
        Sky([0.3, 0.5, 0.9], [0.8, 0.85, 0.95], [0.2, 0.2, 0.2]),
    )


def draw(data: dict, fig) -> None:
    lines = fig.subplots(2, 7)
    length = f"{1000 * float(data['epsilon']):g} mm"
    names = {
        "none": "no remedy",
        "tolerance": f"t > {length}",
        "nudge": f"{length} along the ray",
        "offset": f"{length} along N",
        "skip": "not tested (default)",
        "left_out": "left out (lecture)",
    }
    for row, (axes, place) in enumerate(zip(lines, data["places"], strict=True)):
        first, title = axes[0], None if row else "float64"
        plot.picture(data["exact"], ax=first, title=title)
        plot.labels(
            first,
            ylabel=f"at {place / 1000:g} km" if place else "near the origin",
            xlabel=f"off by more\nthan {float(data['threshold']):g}:",
        )
        for column, key in enumerate(data["remedies"]):
            plot.picture(data["pictures"][row, column], ax=axes[column + 1], title=None if row else names[str(key)])
            parts = (("orange", data["wrong_ball"]), ("glass", data["wrong_glass"]))
            plot.labels(axes[column + 1], xlabel="\n".join(f"{name} {_percent(x[row, column])}" for name, x in parts))


def _percent(fraction) -> str:
    percent = 100 * float(fraction)
    return f"{percent:.0f} %" if percent >= 1 or percent == 0 else f"{percent:.2f} %"
