"""JHU's local illumination equation, taken apart on one sphere."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Sphere
from jaxrefl.light import Ambient, PointLight
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Phong

CAPTION = """JHU, "Local Illumination Equation", on the sphere of the slide "Specular Highlights", a red surface in
white light: one picture per term, each rendered with the other coefficients set to 0, and one with all of them, from
which the sum of the four differs by less than 1e-6. Where the diffuse term is largest, red, green and blue are as 1 :
0.07 : 0.07; where the specular term is largest, as 1 : 1 : 1. Right: in the row through the highlight (dotted) the
highlight lifts green from 0.06 to 0.86, and red by as much, to 1.60, which the picture shows as 1."""
SIZE = (9.6, 6.0)
TERMS = {
    "emission": "$E_m$",
    "ambient": "$I_a k_a$",
    "diffuse": "$f_{att} I_d k_d (L \\cdot N)$",
    "specular": "$f_{att} I_s k_s (H \\cdot N)^n$",
}


def compute(size: int = 200, shininess: float = 60.0) -> dict:
    red = jnp.asarray([0.75, 0.05, 0.05])
    coefficients = jnp.stack([jnp.asarray([0.0, 0.006, 0.05]), red, red, jnp.full(3, 0.8)])
    kept = jnp.concatenate([jnp.eye(4), jnp.ones((1, 4))])  # one row per picture: the terms that it shows
    camera = Pinhole(Vec3(0.0, -6.0, 0.0), field_of_view=0.38)

    def picture(kept):
        emission, k_a, k_d, k_s = coefficients * kept[:, None]
        sphere = Object(Sphere(Vec3(0.0, 0.0, 0.0)), Phong(k_d, k_s, shininess, k_a, emission))
        lights = {"ambient": Ambient(0.15), "lamp": PointLight(Vec3(3.0, -6.0, 4.0))}
        return render(Scene({"sphere": sphere}, lights), camera, size, size, 0).radiance

    pictures = np.asarray(jax.jit(jax.vmap(picture))(kept))
    data = dict(zip((*TERMS, "full"), pictures, strict=True)) | {"sum": pictures[:4].sum(axis=0)}
    row, column = divmod(int(data["specular"].sum(axis=-1).argmax()), size)
    brightest = {name: data[name].reshape(-1, 3)[data[name].sum(axis=-1).argmax()] for name in TERMS}
    return data | {
        "row": row,
        "column": column,
        "defect": np.abs(data["sum"] - data["full"]).max(),
        "diffuse_ratio": brightest["diffuse"] / brightest["diffuse"].max(),
        "specular_ratio": brightest["specular"] / brightest["specular"].max(),
        "without_highlight": (data["full"] - data["specular"])[row, column],
        "with_highlight": data["full"][row, column],
    }


def draw(data: dict, fig) -> None:
    (emission, ambient, diffuse), (specular, full, profile) = fig.subplots(2, 3, width_ratios=(1, 1, 1.1))
    for ax, (name, formula) in zip((emission, ambient, diffuse, specular), TERMS.items(), strict=True):
        plot.picture(data[name], ax=ax, title=f"{name}  {formula}")
    plot.picture(data["full"], ax=full, title="all four at once")
    row = int(data["row"])
    plot.mark(full, y=row, color="white")
    columns = np.arange(data["full"].shape[1])
    for channel, color in enumerate((plot.RED, plot.GREEN)):
        for key, line in (("full", "-"), ("diffuse", "--")):
            plot.cartesian(columns, data[key][row, :, channel], ax=profile, color=color, linestyle=line)
    plot.cartesian(columns, data["specular"][row, :, 1], ax=profile, color=plot.GREY, linestyle=":")
    keys = {
        "all, red": {"color": plot.RED},
        "all, green": {"color": plot.GREEN},
        "diffuse, red": {"color": plot.RED, "linestyle": "--"},
        "diffuse, green": {"color": plot.GREEN, "linestyle": "--"},
        "specular, each": {"color": plot.GREY, "linestyle": ":"},
    }
    limits = {"xlim": (0, columns[-1]), "ylim": (0, 1.75)}
    plot.labels(profile, xlabel="column (pixels)", ylabel="radiance", title="row through the highlight", **limits)
    plot.legend(profile, keys, loc="upper left")
