"""Dispersion of glasses and crystals with their Abbe numbers, and the group index."""

import jax
import numpy as np

from jaxrefl import dispersion, plot
from jaxrefl.materials import material

CAPTION = """Refractive index (solid) and group index n - λ dn/dλ (dashed) of transparent media, and their place in the
chart of glasses. The Abbe number V_d = (n_d - 1)/(n_F - n_C) is the smaller the stronger the dispersion: N-BK7 has n_d
= 1.51680 and V_d = 64.17, SF11 1.78472 and 25.76; diamond refracts most, 2.41749, and disperses less than its index
suggests, 55.30. The group index exceeds n everywhere, at 486 nm by 0.146 in SF11 and by 0.035 in N-BK7."""
SIZE = (8.6, 4.8)
NAMES = ("diamond", "SF11", "sapphire", "polycarbonate", "N-BK7", "PMMA", "fused silica", "water")


def compute() -> dict:
    wavelength = np.linspace(440.0, 700.0, 261)
    lines = np.array([dispersion.LINES_NM[line] for line in "Fd"])
    values = _values([material(name) for name in NAMES], wavelength, lines)
    n, group, at_lines, group_at_lines, abbe = (np.stack(columns) for columns in zip(*values, strict=True))
    return {
        "wavelength_nm": wavelength,
        "names": np.array(NAMES),
        "n": n,
        "group": group,
        "n_d": at_lines[:, 1],
        "abbe": abbe,
        "excess_F": group_at_lines[:, 0] - at_lines[:, 0],
    }


@jax.jit
def _values(models, wavelength, lines):
    group, abbe = dispersion.group_index, dispersion.abbe_number
    return [(m(wavelength).n, group(m, wavelength), m(lines).n, group(m, lines), abbe(m)) for m in models]


def draw(data: dict, fig) -> None:
    index, chart = fig.subplots(1, 2, width_ratios=(1.7, 1))
    colors = (plot.PINK, plot.RED, plot.SKY, plot.ORANGE, plot.BLUE, plot.GREEN, plot.GREY, "0.2")
    x = data["wavelength_nm"]
    for i, color in enumerate(colors):
        plot.cartesian(x, data["n"][i], ax=index, color=color, label=str(data["names"][i]))
        plot.cartesian(x, data["group"][i], ax=index, color=color, linestyle="--")
        name = f"{data['names'][i]} {data['abbe'][i]:.1f}"
        name = " " * 26 + name if data["names"][i] == "PMMA" else name
        shift = -4 if data["names"][i] in ("PMMA", "fused silica") else 4
        plot.points(chart, data["abbe"][i : i + 1], data["n_d"][i : i + 1], [name], dy=shift, color=color)
    plot.labels(index, xlabel="wavelength (nm)", ylabel="n (solid), group index (dashed)", xlim=(440, 700))
    plot.legend(index, ncols=2, loc="upper center", bbox_to_anchor=(0.5, 0.82))
    plot.labels(chart, xlabel=r"Abbe number $V_d$", ylabel=r"$n_d$", xlim=(88, 8), ylim=(1.25, 2.55))
