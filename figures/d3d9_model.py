"""D3D9 figure 2: the reflection model as a diagram, and (4)-(6) for a coloured material."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import d3d9, fresnel, plot

CAPTION = """The D3D9 reflection model. Left: light φ meets the Fresnel layer, which reflects the fraction R and passes
t = 1 - R; of that the metal reflects the colour λ; the diffuse colour d is weighted by 1 - |λ|. Right: the three
colour channels of (4)-(6) for λ = (0.8, 0.5, 0.2): the metallic part λ(1 - R) fades to 0 at grazing while the total
rises to white, 1 in every channel, and the pixel of (6) exceeds 1."""
SIZE = (9.6, 3.9)


def compute(
    r0: float = 0.04, p: float = 5.0, metallic: tuple[float, ...] = (0.8, 0.5, 0.2), diffuse: float = 0.6
) -> dict:
    theta, mu = plot.angles(361)
    lam = jnp.asarray(metallic)
    norm = d3d9.max_norm(lam)

    def at(cos_theta):
        r = fresnel.d3d9(cos_theta, r0, 1 - r0, p)
        total = d3d9.total_reflection(lam, r)
        return r, d3d9.metallic_reflection(lam, r), total, d3d9.pixel(jnp.full_like(lam, diffuse), norm, total)

    r, metallic_part, total, pixel = jax.vmap(at)(mu)
    return {
        "theta_deg": theta,
        "metallic": lam,
        "diffuse": diffuse,
        "R": r,
        "r": metallic_part,
        "R_tot": total,
        "pixel": pixel,
        "pixel_max": pixel.max(),
    }


def draw(data: dict, fig) -> None:
    scheme, curves = fig.subplots(1, 2, width_ratios=(1.05, 1.0))
    plot.canvas(scheme, (-3.1, 3.3), (-1.75, 2.2))
    layer, metal = 0.0, -1.15
    plot.band(scheme, metal, layer, plot.SKY)
    plot.band(scheme, -1.75, metal, plot.ORANGE, 0.45)
    plot.arrow(scheme, (-2.4, 2.0), (-0.9, layer), r"$\varphi$", shift=(-0.25, 0.1))
    plot.arrow(scheme, (-0.9, layer), (0.6, 2.0), r"$R\,\varphi$", color=plot.BLUE, shift=(-0.35, 0.3))
    plot.arrow(scheme, (-0.9, layer), (-0.25, metal), r"$t\varphi$", shift=(-0.3, -0.05))
    plot.arrow(scheme, (-0.25, metal), (0.4, layer), color=plot.RED)
    plot.arrow(scheme, (0.4, layer), (1.9, 2.0), r"$r=\lambda(1-R)\,\varphi$", color=plot.RED, shift=(0.75, -0.25))
    for angle in (-40, -10, 20, 50):
        step = 0.8 * np.array([np.sin(np.deg2rad(angle)), np.cos(np.deg2rad(angle))])
        plot.arrow(scheme, (2.4, metal), np.array([2.4, metal]) + step, color=plot.GREEN, width=1.1)
    plot.note(scheme, (2.35, -0.15), r"$d\,(1-|\lambda|)$", color=plot.GREEN)
    plot.note(scheme, (-2.05, -0.35), "Fresnel layer\n" + r"$t=1-R$", fontsize="small")
    plot.note(scheme, (-1.9, -1.47), r"metal of colour $\lambda$", fontsize="small")
    plot.mark(scheme, y=layer)

    theta = data["theta_deg"]
    colors = (plot.RED, plot.GREEN, plot.BLUE)
    kinds = (
        ("r", "$r$  (4)", ":"),
        ("R_tot", r"$R_{tot}$  (5)", "-"),
        ("pixel", f"$c$ for d = {data['diffuse']:g}  (6)", "--"),
    )
    for key, _, line in kinds:
        for channel, color in enumerate(colors):
            plot.cartesian(theta, data[key][:, channel], ax=curves, color=color, linestyle=line)
    plot.mark(curves, y=1.0, text="all the light", at=0.22)
    values = ", ".join(f"{x:g}" for x in np.asarray(data["metallic"]))
    plot.labels(
        curves,
        xlabel=plot.ANGLE,
        ylabel="fraction of white light φ, by channel",
        title=f"λ = ({values}); red, green, blue channel",
        xlim=(0, 90),
        ylim=(0, 1.4),
    )
    plot.legend(
        curves, {label: {"color": plot.GREY, "linestyle": line} for _, label, line in kinds}, loc="upper left", ncols=3
    )
