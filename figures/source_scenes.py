"""The four source documents as scenes, and where the weight of their rays goes."""

import numpy as np

from jaxrefl import plot, scene_file
from jaxrefl.render import render

CAPTION = """The four source documents, rendered from the scene files that ship with jaxrefl. Below each: by how much
the weights of the rays of a pixel add up to more than 1 (red) or less (blue), in the largest channel. PERRIN's blend
gives away what it reflects: exactly 1 everywhere. JHU's coefficients are bounded by nothing: up to 2.9 too much, in the
transparent ball. D3D9 (6) adds the Fresnel reflection to a base that is not dimmed by it: up to 1.7 too much, on rims
and toward the horizon. F and 1 - F make no light anywhere; metal and coloured glass take some, up to 0.59."""
SIZE = (12.0, 5.2)
DOCUMENTS = {
    "perrin": ("PERRIN", r"$(1 - \alpha)\,c + \alpha\,c'$"),
    "jhu": ("JHU", r"$I_{local} + k_{rg} I_r + k_{tg} I_t$"),
    "d3d9": ("D3D9", r"$d\,(1 - |\lambda|) + R_{tot}$"),
    "fresnel": ("LAMBERT-FRESNEL", "$F$ and $1 - F$"),
}


def compute(width: int = 240, height: int = 150, spp: int = 1) -> dict:
    data = {"names": np.array(list(DOCUMENTS))}
    for name in DOCUMENTS:
        file = scene_file.load(scene_file.example(name))
        image = render(file.scene, file.camera, width, height, file.settings.n_bounces, spp=spp)
        data[name] = image.radiance * 2**file.settings.exposure
        data[f"{name}_excess"] = image.budget.total.max(axis=-1) - 1
        data[f"{name}_primitive"] = image.primitive
    return data


def draw(data: dict, fig) -> None:
    pictures, maps = fig.subplots(2, 4)
    for picture, ax, name in zip(pictures, maps, data["names"], strict=True):
        document, rule = DOCUMENTS[str(name)]
        plot.picture(data[str(name)], ax=picture, title=f"{document}:  {rule}")
        scale = plot.field(data[f"{name}_excess"], ax=ax, range=(-1, 3), diverging=True, bar=False)
    plot.shared_bar(scale, maps, "sum of the weights of a pixel, minus 1", shrink=0.4)
