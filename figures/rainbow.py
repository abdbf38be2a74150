"""The rainbow: rays traced through a drop, and where the derivative of their deflection vanishes."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import plot
from jaxrefl.materials import material
from jaxrefl.spectral import deflection, rainbow

CAPTION = """Left: the angle from the antisolar point at which a ray leaves a drop of water, traced through it by
follow(..., "TRT") and "TRRT", for 400, 550 and 700 nm. Dots: where the derivative of the traced angle by the impact
vanishes, found by bisection; many rays leave together there. Right: the two bows by wavelength, red outside in the
primary one (40.57° at 400 nm, 42.44° at 700 nm) and inside in the secondary one (53.62°, 50.24°). No ray
of these colours leaves in between: Alexander's dark band, 7.80° wide."""
SIZE = (10.5, 4.4)
WAVES = (400.0, 550.0, 700.0)
COLORS = (plot.BLUE, plot.GREEN, plot.RED)
NAMES = {1: "primary bow", 2: "secondary bow"}
ORDERS = {1: "TRT", 2: "TRRT"}


def compute(samples: int = 400, wavelengths: int = 61) -> dict:
    impact, waves = np.linspace(0.004, 0.998, samples), np.linspace(400, 700, wavelengths)
    data = {"impact": impact, "waves": waves, "wavelength_nm": np.array(WAVES)}
    data["n"] = material("water")(waves).n
    for order, branches in ORDERS.items():
        turned = jax.vmap(
            lambda n, s=branches: jax.vmap(lambda b: deflection(b, n, s))(jnp.asarray(impact)),
        )(material("water")(np.array(WAVES)).n)
        data[f"angle_{order}"] = np.rad2deg(np.abs(np.pi - np.asarray(turned)))
        bows = jax.vmap(lambda n, k=order: rainbow(n, k))(data["n"])
        data[f"bow_{order}"], data[f"at_{order}"] = np.rad2deg(bows.radius), np.asarray(bows.impact)
    return data


def draw(data: dict, fig) -> None:
    left, right = fig.subplots(1, 2)
    places = [int(np.argmin(np.abs(data["waves"] - wave))) for wave in data["wavelength_nm"]]
    for order, line in ((1, "-"), (2, "--")):
        for i, (wave, color) in enumerate(zip(data["wavelength_nm"], COLORS, strict=True)):
            plot.cartesian(
                data["impact"], data[f"angle_{order}"][i], ax=left, color=color, linestyle=line,
                label=f"{ORDERS[order]}, {wave:.0f} nm",
            )  # fmt: skip
        plot.points(left, data[f"at_{order}"][places], data[f"bow_{order}"][places])
    plot.labels(
        left, title="traced through a drop", xlabel="impact over radius", xlim=(0, 1), ylim=(0, 100),
        ylabel="angle from the antisolar point / degrees", legend="upper left",
    )  # fmt: skip
    for order, line in ((1, "-"), (2, "--")):
        plot.cartesian(data["waves"], data[f"bow_{order}"], ax=right, color=plot.BLUE, linestyle=line)
        plot.note(right, (550, data[f"bow_{order}"].mean() + 1.3 * (2 * order - 3)), NAMES[order])
    plot.labels(
        right, title="the bows", xlabel="wavelength / nm", ylabel="radius / degrees", xlim=(400, 700), ylim=(38, 56)
    )
    plot.band(right, data["bow_1"].max(), data["bow_2"].min(), plot.GREY)
    plot.note(right, (550, 46.5), "Alexander's dark band")
