"""What three channels do to metals: the same scene by wavelength and in RGB."""

import numpy as np

from jaxrefl import colour, fresnel, plot
from jaxrefl.materials import material
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.spectral import metal_spheres, render_spectral
from jaxrefl.surface import D3D9, Phong

CAPTION = """Five metals by wavelength (41 of them), the same in RGB, and the difference of each pixel in CIEDE2000.
RGB has a colour at normal incidence and Schlick's rise to white. Titanium, whose reflectance rises otherwise, is off by
up to 5.7 at its rim, and a pixel of aluminium that mirrors that rim by 6.9. Gold would have to reflect 1.04 of red,
which a reflectance in RGB may not: it is off by 1.1 all over. The grey boards agree."""
SIZE = (12.0, 2.9)
METALS = ("Au", "Ag", "Cu", "Al", "Ti")


def schlick(scene: Scene, f0: dict) -> Scene:
    """The scene with every metal replaced by its F0 colour and Schlick's rise, D3D9 with R = (1 - cos)^5."""
    objects = dict(scene.objects)
    for name, color in f0.items():
        surface = D3D9(Phong(k_d=0.0), metallic=np.clip(color, 0, 1), r0=0.0, m=1.0, p=5.0, specular=1.0)
        objects[name] = Object(scene.objects[name].shape, surface)
    return Scene(objects, scene.lights, scene.background)


def compute(width: int = 224, height: int = 126, n_bounces: int = 4) -> dict:
    waves = np.linspace(380.0, 780.0, 41)
    build, camera = metal_spheres(METALS)
    image = render_spectral(build, camera, waves, width, height, n_bounces)
    indices = [material(name)(waves) for name in METALS]
    f0 = {f"ball_{i}": colour.spectrum_to_rgb(fresnel.conductor(1.0, *x), waves) for i, x in enumerate(indices)}
    rgb = render(schlick(build(550.0), f0), camera, width, height, n_bounces, account=False)
    spectral = image.rgb().radiance
    difference = colour.colour_difference(spectral, rgb.radiance)
    data = {"spectral": spectral, "rgb": rgb.radiance, "difference": difference, "primitive": image.primitive}
    return {**data, "red_of_gold": f0["ball_0"][0]}


def draw(data: dict, fig) -> None:
    left, middle, right = fig.subplots(1, 3)
    plot.picture(data["spectral"], ax=left, title="by wavelength")
    plot.picture(data["rgb"], ax=middle, title="RGB, F0 and Schlick")
    plot.field(data["difference"], ax=right, title="CIEDE2000", range=(0, 6))
