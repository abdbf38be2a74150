"""Energy budget of four reflection rules, pixel by pixel: the light that a rule makes out of nothing."""

import numpy as np

from jaxrefl import plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Sphere
from jaxrefl.light import Ambient, Directional
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import D3D9, Blend, Dielectric, Phong, Whitted

CAPTION = """Where nothing absorbs, the weights with which a path is shown, escapes or is cut off have to sum to 1;
below, what they sum to beyond it, light made out of nothing. PERRIN's blend (α = 0.5) and lossless glass on a PERRIN
floor make none, to 1e-14. JHU's sum with k_rg = 0.5 makes 0.5 wherever one surface is seen, 0.611 on average and up to
0.996 where balls mirror each other. D3D9 (6) with λ = 0 makes R: 0.040 where a ball is seen head on, 0.90 on the ground
below the horizon, and 1.464 where a grazing ray goes on to graze another surface."""
SIZE = (10.4, 3.75)
RULES = ("perrin", "glass", "jhu", "d3d9")
SPHERES = np.array(  # centre and radius: the ground and four balls
    [
        [0, 0, -1000, 1000],
        [-1.25, 0.4, 0.8, 0.8],
        [0.45, 1.3, 1.1, 1.1],
        [0.6, -0.9, 0.55, 0.55],
        [-0.6, -1.2, 0.4, 0.4],
    ]
)


def spheres(visible: np.ndarray) -> Sphere:
    """Those that are visible, and the others where no ray comes."""
    placed = np.where(visible[:, None], SPHERES, [0, 0, -1e5, 1])
    return Sphere(placed[:, :3], placed[:, 3])


def compute(
    reflectivity: float = 0.5, r0: float = 0.04, n_bounces: int = 7, width: int = 180, height: int = 135
) -> dict:
    color = np.array([[0.45, 0.42, 0.4], [0.8, 0.3, 0.2], [0.2, 0.45, 0.75], [0.85, 0.7, 0.3], [0.3, 0.6, 0.35]])
    base = Phong(k_d=color, k_a=color)
    surfaces = {
        "perrin": Blend(base, reflectivity=reflectivity),
        "glass": Dielectric(1.5),
        "jhu": Whitted(base, k_rg=reflectivity),
        "d3d9": D3D9(base, r0=r0, m=1 - r0),
    }
    lights = {"sky": Ambient(0.2), "sun": Directional([1.0, 1.0, -1.6], diffuse=0.7)}
    eye = Pinhole([-1.2, -6.0, 2.6], [0.0, 0.0, 0.65], field_of_view=0.62)
    ground = np.arange(len(SPHERES)) == 0
    images = []
    for rule in RULES:  # all models are in every scene, all but one out of sight: one compilation serves the four
        floor = "perrin" if rule == "glass" else rule
        visible = {name: (~ground & (name == rule)) | (ground & (name == floor)) for name in RULES}
        objects = {name: Object(spheres(visible[name]), surface) for name, surface in surfaces.items()}
        images.append(
            render(Scene(objects, lights, Sky([0.1, 0.25, 0.6], [0.55, 0.6, 0.7], 0.2)), eye, width, height, n_bounces)
        )
    excess = np.stack([image.budget.total.mean(-1) - 1 for image in images])
    hit = np.stack([image.primitive >= 0 for image in images])
    return {
        "radiance": np.stack([image.radiance for image in images]),
        "excess": excess,
        "mean": (excess * hit).sum((1, 2)) / hit.sum((1, 2)),
        "smallest": np.where(hit, excess, np.inf).min((1, 2)),
        "largest": excess.max((1, 2)),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(2, 4)
    titles = (
        r"PERRIN: $(1-\alpha)c + \alpha c^{\,\prime}$",
        r"glass: $F I_r + (1-F) I_t$",
        r"JHU: $I_{\mathrm{local}} + k_{rg} I_r$",
        r"D3D9 (6): $d\,(1-|\lambda|) + R_{tot}$",
    )
    for i, title in enumerate(titles):
        least, most = data["smallest"][i], data["largest"][i]
        rounding = np.ceil(np.log10(max(most, -least, 1e-16)))
        text = f"made: {least:.3f} to {most:.3f}" if most > 1e-6 else f"made: none, to 1e{rounding:.0f}"
        plot.picture(data["radiance"][i], ax=axes[0, i], title=title)
        label = "light made / light" if i == 3 else None
        plot.field(data["excess"][i], ax=axes[1, i], title=text, range=(0.0, 1.5), label=label)
