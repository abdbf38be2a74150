"""D3D9 figure 1 and the families of its equation (3)."""

import jax.numpy as jnp
import numpy as np

from jaxrefl import fresnel, plot

CAPTION = """D3D9 (3), R = R0 + m (1 - cos θ)^p, for R0 = 0.04. Top left: figure 1 of the document, p = 2 in red and p
= 4 in blue; at 60° they give 0.28 and 0.10. A larger p keeps the surface dark longer, m sets the value at grazing,
R0 + m, and R0 the value at normal incidence; with m = 1 - R0 every curve ends at 1."""
SIZE = (7.2, 5.6)


def compute(
    r0: float = 0.04,
    p: tuple[float, ...] = (1.0, 2.0, 3.0, 4.0, 5.0, 8.0),
    m: tuple[float, ...] = (0.2, 0.4, 0.6, 0.8, 0.96),
    offsets: tuple[float, ...] = (0.0, 0.04, 0.1, 0.2, 0.35),
) -> dict:
    theta, mu = plot.angles(721)
    column = jnp.asarray
    return {
        "theta_deg": theta,
        "p2": fresnel.d3d9(mu, r0, 1 - r0, 2),
        "p4": fresnel.d3d9(mu, r0, 1 - r0, 4),
        "p": np.array(p),
        "m": np.array(m),
        "r0": np.array(offsets),
        "over_p": fresnel.d3d9(mu, r0, 1 - r0, column(p)[:, None]),
        "over_m": fresnel.d3d9(mu, r0, column(m)[:, None], 4),
        "over_r0": fresnel.d3d9(mu, column(offsets)[:, None], 1 - column(offsets)[:, None], 4),
        "at_60_deg": fresnel.d3d9(0.5, r0, 1 - r0, column([2.0, 4.0])),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(2, 2, sharex=True, sharey=True)
    theta = data["theta_deg"]
    text = {"xlim": (0, 90), "ylim": (0, 1.02), "legend": "upper left"}
    first = axes[0, 0]
    plot.cartesian(theta, data["p2"], ax=first, label="p = 2", color=plot.RED)
    plot.cartesian(
        theta, data["p4"], ax=first, label="p = 4", color=plot.BLUE, title="figure 1 of the document", **text
    )
    families = (
        (axes[0, 1], "p", data["p"], data["over_p"], "exponent p, m = 1 - R0"),
        (axes[1, 0], "m", data["m"], data["over_m"], "multiplier m, p = 4"),
        (axes[1, 1], "R0", data["r0"], data["over_r0"], "offset R0, m = 1 - R0, p = 4"),
    )
    for ax, name, values, curves, title in families:
        plot.cartesian(
            theta, {f"{name} = {v:g}": c for v, c in zip(values, curves, strict=True)}, ax=ax, title=title, **text
        )
    for ax in axes[1]:
        plot.labels(ax, xlabel=plot.ANGLE)
    for ax in axes[:, 0]:
        plot.labels(ax, ylabel="reflectance R")
