"""Fresnel reflectance of metals, with Schlick's approximation over it."""

import jax.numpy as jnp
import numpy as np

from jaxrefl import fresnel, plot
from jaxrefl.files import read_table

CAPTION = """Unpolarised reflectance of gold, silver, copper and aluminium at a blue, a green and a red measured
wavelength (solid), with Schlick's approximation from the same F0 (dotted). Metals dip before they rise to 1, which
Schlick cannot: his error is largest for red light on aluminium, 0.130 at 84.0°, and below 0.01 for silver
everywhere."""
SIZE = (9.4, 4.6)


def compute() -> dict:
    rows = read_table("metals")
    theta, mu = plot.angles(9001)
    eta, k = (jnp.asarray([float(row[key]) for row in rows]) for key in ("n", "k"))
    exact = fresnel.conductor(mu, eta[:, None], k[:, None])
    schlick = fresnel.schlick(mu, fresnel.f0_conductor(eta, k)[:, None])
    error = schlick - exact
    return {
        "theta_deg": theta,
        "metal": np.array([row["metal"] for row in rows]),
        "wavelength_nm": np.array([float(row["wavelength_nm"]) for row in rows]),
        "eta": eta,
        "k": k,
        "exact": exact,
        "schlick": schlick,
        "max_error": jnp.max(jnp.abs(error), axis=1),
        "max_error_deg": theta[jnp.argmax(jnp.abs(error), axis=1)],
    }


def draw(data: dict, fig) -> None:
    metals = list(dict.fromkeys(data["metal"]))
    axes = fig.subplots(2, len(metals), sharex=True, sharey="row", height_ratios=(1.7, 1))
    theta = data["theta_deg"]
    for (top, bottom), metal in zip(axes.T, metals, strict=True):
        for i, color in zip(np.nonzero(data["metal"] == metal)[0], (plot.BLUE, plot.GREEN, plot.RED), strict=True):
            label = f"{data['wavelength_nm'][i]:.0f} nm"
            plot.cartesian(theta, data["exact"][i], ax=top, label=label, color=color)
            plot.cartesian(theta, data["schlick"][i], ax=top, color=color, linestyle=":")
            plot.cartesian(theta, data["schlick"][i] - data["exact"][i], ax=bottom, color=color)
        plot.cartesian([], [], ax=top, label="Schlick", color=plot.GREY, linestyle=":")
        plot.labels(top, title=metal, xlim=(0, 90), ylim=(0, 1.02), legend="lower left")
        plot.mark(bottom, y=0)
    plot.labels(axes[0, 0], ylabel="reflectance R")
    plot.labels(axes[1, 0], ylabel="Schlick - exact")
    for ax in axes[1]:
        plot.labels(ax, xlabel=plot.ANGLE.replace(" (", "\n("))
