"""Scenes rendered by wavelength, seen under several lights."""

import numpy as np

from jaxrefl import plot
from jaxrefl.spectral import coated_sphere, glass_ball, metal_spheres, render_spectral

CAPTION = """Rendered by wavelength, 16 of them from 400 to 700 nm. Top: gold, silver, copper, aluminium and titanium;
one render, seen in daylight (D65), by a light bulb (A) and by a fluorescent tube (F11). To an eye used to the light the
boards are grey under each, and gold differs most: by CIEDE2000 3.4 under the tube, titanium by 0.4. Bottom: a ball of
SF11, in which each wavelength goes its own way and edges have coloured fringes; titanium under 60 nm and 120 nm of
its oxide, blue and yellow by interference alone."""
SIZE = (11.5, 4.6)
LIGHTS = {"D65": "D65, daylight", "A": "A, light bulb", "FL11": "F11, fluorescent tube"}
FILMS = (60.0, 120.0)
WAVES = np.linspace(400.0, 700.0, 16)


def compute(width: int = 224, height: int = 126, n_bounces: int = 4) -> dict:
    metals = render_spectral(*metal_spheres(), WAVES, width, height, n_bounces)
    data = {f"metals_{light}": metals.rgb(light).radiance for light in LIGHTS}
    data["metals_primitive"] = metals.primitive
    glass = render_spectral(*glass_ball(), WAVES, width, height, n_bounces)
    data |= {"glass": glass.rgb().radiance, "glass_primitive": glass.primitive}
    for i, thickness in enumerate(FILMS):
        coated = render_spectral(*coated_sphere(thickness), WAVES, width, height, n_bounces)
        data |= {f"film_{i}": coated.rgb().radiance, f"film_{i}_primitive": coated.primitive}
    return data


def draw(data: dict, fig) -> None:
    top, bottom = fig.subplots(2, 3)
    for ax, (light, name) in zip(top, LIGHTS.items(), strict=True):
        plot.picture(data[f"metals_{light}"], ax=ax, title=name)
    plot.picture(data["glass"], ax=bottom[0], title="SF11")
    for i, thickness in enumerate(FILMS):
        plot.picture(data[f"film_{i}"], ax=bottom[1 + i], title=f"titanium under {thickness:.0f} nm of oxide")
