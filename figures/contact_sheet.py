"""Everything that a render knows of its pixels, on one sheet."""

import numpy as np

from jaxrefl import plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.light import Ambient, Directional
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene, Sky
from jaxrefl.surface import D3D9, Phong
from jaxrefl.texture import Checker

CAPTION = """What a render knows of its pixels, for six balls and a floor of the D3D9 model. The ball nearest to the
eye, 3, is 5.38 away; alpha of the glass ball 4 (d_a = 0.1) is 0.136 where it is seen head on and 0.94 at its rim, and
the floor covers more the flatter it is seen, 0.39 to 0.99. A path has 1.55 bounces on average and at most 5; in the 3.3
% of pixels with one hit more than bounces it still met something at its end. A primitive ends at 2.9 % of the pixels
(black); a path changes at 17.8 % (grey as well), all of those among them: shadows and mirrored outlines are edges
too."""
SIZE = (10.6, 3.9)
BALLS = np.array(
    [[-1.75, 0.6, 0.8], [-0.2, 1.6, 1.0], [1.6, 0.7, 0.75], [-0.75, -0.9, 0.5], [0.75, -0.7, 0.6], [1.9, -0.9, 0.35]]
)


def edges(identity: np.ndarray) -> np.ndarray:
    """Pixels that differ from their neighbour to the right or below."""
    edge = np.zeros(identity.shape, bool)
    edge[:, :-1] |= identity[:, 1:] != identity[:, :-1]
    edge[:-1] |= identity[1:] != identity[:-1]
    return edge


def compute(width: int = 240, height: int = 160, n_bounces: int = 5) -> dict:
    color = np.array(
        [[0.7, 0.2, 0.1], [0.3, 0.3, 0.3], [0.1, 0.4, 0.6], [0.1, 0.3, 0.15], [0.0, 0.0, 0.0], [0.8, 0.6, 0.2]]
    )
    metallic = np.array([[0.0] * 3, [0.7, 0.7, 0.72], [0.0] * 3, [0.85, 0.6, 0.3], [0.0] * 3, [0.3] * 3])
    cover = np.array([1.0, 0.0, 0.6, 0.0, 0.1, 0.8])
    balls = D3D9(Phong(k_d=color, k_a=color, k_s=0.5, shininess=100.0), metallic=metallic, alpha=cover)
    tiles = Checker([0.6, 0.55, 0.5], [0.25, 0.22, 0.2])
    floor = D3D9(Phong(k_d=tiles, k_a=tiles), r0=0.1, m=0.9, alpha=0.3)
    scene = Scene(
        {
            "balls": Object(Sphere(BALLS, BALLS[:, 2]), balls),
            "floor": Object(Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])), floor),
        },
        {"sky": Ambient(0.3), "sun": Directional([1.0, 1.2, -1.6], diffuse=0.8, specular=0.8)},
        Sky([0.1, 0.25, 0.6], [0.6, 0.65, 0.75], 0.2),
    )
    eye = Pinhole(np.array([-0.6, -6.5, 2.3]), np.array([0.0, 0.0, 0.7]), field_of_view=0.6)
    image = render(scene, eye, width, height, n_bounces)
    layers = ("radiance", "alpha", "depth", "normal", "primitive", "bounces", "hits", "path_id")
    data = {name: np.asarray(getattr(image, name)) for name in layers}
    return data | {
        "primitive_edges": edges(data["primitive"]),
        "path_edges": edges(data["path_id"]),
        "distance": np.linalg.norm(BALLS - np.asarray(eye.position), axis=1) - BALLS[:, 2],
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(2, 4)
    (picture, normal, depth, primitive), (alpha, path, bounces, hits) = axes
    plot.picture(data["radiance"], ax=picture, title="radiance")
    plot.normals(data["normal"], ax=normal, title="normal: x, y, z as R, G, B")
    plot.field(data["depth"], ax=depth, title="depth (length)", range=(4.0, 12.0))
    plot.categories(data["primitive"], ax=primitive, title="number of the primitive")
    plot.field(data["alpha"], ax=alpha, title="alpha", range=(0.0, 1.0))
    plot.picture(1.0 - 0.4 * data["path_edges"] - 0.6 * data["primitive_edges"], ax=path, title="edges of path_id")
    plot.field(data["bounces"], ax=bounces, title="bounces", range=(0, 6))
    plot.field(data["hits"], ax=hits, title="hits", range=(0, 6))
