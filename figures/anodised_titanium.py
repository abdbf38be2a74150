"""Colours of anodised titanium over the thickness of its oxide and the angle at which it is seen."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import colour, films, plot
from jaxrefl.materials import material

CAPTION = """Titanium under a growing film of its oxide, D65. Top: colour over thickness and angle of incidence;
middle: normal incidence. Bottom: the wavelength at which the reflectance is lowest. Neither has a colour of its own,
and yet the metal goes through bronze (28 nm), purple (40 nm) and blue (52 nm) while the first minimum crosses the
visible range, and through yellow (116 nm) and pink (150 nm) with the second. Seen at 60° a film of 50 nm has its
minimum at 601 nm, not at 640 nm, a shift of 6 % only: the index of the oxide, 2.44 at 550 nm, leaves the ray inside
almost upright."""
SIZE = (8.6, 6.0)


def compute(thickest_nm: float = 200.0) -> dict:
    wavelength = np.arange(380.0, 781.0, 5.0)
    thickness = np.linspace(0.0, thickest_nm, 201)
    theta = np.linspace(0.0, 84.0, 43)
    mu = np.cos(np.deg2rad(theta))
    oxide, metal = material("TiO2-film")(wavelength), material("Ti")(wavelength)
    n, k = films.stack(oxide)
    inside = tuple(np.asarray(part) for part in metal)
    matrix = colour.rgb_matrix(wavelength)

    @jax.jit
    def one_angle(mu):
        spectra = films.film(mu, wavelength, n, k, thickness[None, :, None], 1.0, inside).R
        i = jnp.clip(spectra.argmin(axis=-1), 1, wavelength.size - 2)
        left, here, right = (jnp.take_along_axis(spectra, (i + j)[:, None], 1)[:, 0] for j in (-1, 0, 1))
        vertex = 0.5 * (left - right) / (left - 2 * here + right)  # of the parabola through the three
        inner = (left > here) & (right > here)
        return spectra @ matrix, jnp.where(inner, wavelength[0] + 5.0 * (i + vertex), jnp.nan)

    rgb, lowest = jax.lax.map(one_angle, mu)
    return {
        "thickness_nm": thickness,
        "theta_deg": theta,
        "index": oxide.n,
        "wavelength_nm": wavelength,
        "rgb": rgb,
        "lowest_nm": lowest,
    }


def draw(data: dict, fig) -> None:
    top, middle, bottom = fig.subplots(3, 1, sharex=True, height_ratios=(3, 0.7, 2.2))
    d, last = data["thickness_nm"], float(data["theta_deg"][-1])
    picture = plot.strip(colour.to_gamut(np.asarray(data["rgb"])), (d[0], d[-1]), ax=top)
    picture.set_extent((d[0], d[-1], last, 0.0))
    plot.labels(top, yticks=[0, 20, 40, 60, 80])
    plot.labels(top, ylabel="angle θ (degrees)", title="colour over thickness of the oxide and angle of incidence")
    plot.strip(colour.to_gamut(np.asarray(data["rgb"])[:1]), (d[0], d[-1]), ax=middle)
    plot.labels(middle, title="normal incidence")
    for i, color, line in ((0, plot.BLUE, "-"), (30, plot.RED, "--")):
        plot.cartesian(
            d,
            np.asarray(data["lowest_nm"])[i],
            ax=bottom,
            label=f"θ = {data['theta_deg'][i]:.0f}°",
            color=color,
            linestyle=line,
        )
    plot.labels(bottom, xlabel="thickness of the oxide (nm)", ylabel="wavelength of the\nlowest reflectance (nm)")
    plot.labels(bottom, xlim=(d[0], d[-1]), ylim=(380, 780), legend="upper right")
    plot.labels(bottom, xticks=np.arange(0, d[-1] + 1, 25))
