"""What RGB approximations of Fresnel's equations do to the colour of metals, by angle."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import colour, fresnel, plot
from jaxrefl.materials import material

CAPTION = """Four metals by angle in linear sRGB under D65: exact, by wavelength (solid), Schlick's approximation of the
colour at normal incidence (dotted), and F82-tint, which hits the exact colour at 81.8° too (dashed). Schlick's is off
by up to CIEDE2000 5.7 on titanium, 3.4 on aluminium, 2.6 on gold and 1.7 on copper, all beyond 80°: it cannot dip.
F82-tint is never off by more than 1.05, on gold at 66.5°, where Schlick's is by 1.23; 1 is just seen side by side."""
SIZE = (11.4, 6.4)
METALS = {
    "Au": ("gold", "Babar"),
    "Cu": ("copper", "Johnson"),
    "Al": ("aluminium", "Rakic"),
    "Ti": ("titanium", "Johnson"),
}


def compute(samples: int = 361) -> dict:
    w = np.arange(360.0, 781.0, 5.0)
    theta, mu = plot.angles(samples)
    index = [material(name, source)(w) for name, (_, source) in METALS.items()]
    n, k = (jnp.stack([jnp.asarray(getattr(one, part)) for one in index])[:, None] for part in ("n", "k"))

    @jax.jit
    def colours(mu, n, k):
        def exact(mu):
            return colour.spectrum_to_rgb(fresnel.conductor(mu, n, k), w)

        f0 = exact(1.0)
        tint = exact(1 / 7) / fresnel.schlick(1 / 7, f0)
        mu = mu[:, None]
        return jnp.stack([exact(mu), fresnel.schlick(mu, f0), fresnel.f82_tint(mu, f0, tint)], axis=1), tint[:, 0]

    rgb, tint = colours(jnp.asarray(mu), n, k)
    rgb = np.asarray(rgb)
    return {
        "theta_deg": theta,
        "metal": np.array([name for name, _ in METALS.values()]),
        "source": np.array([source for _, source in METALS.values()]),
        "rgb": rgb,  # (metal, exact, Schlick or F82, angle, channel)
        "tint": tint,
        "difference": colour.colour_difference(rgb[:, 1:], rgb[:, :1]),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(3, len(data["metal"]), sharey="row", height_ratios=(0.55, 1.5, 1))
    theta, names = data["theta_deg"], ("exact", "RGB Schlick", "F82-tint")
    for i, (bands, curves, below) in enumerate(axes.T):
        picture = np.repeat(colour.to_gamut(data["rgb"][i])[::-1], 8, axis=0)  # the first at the bottom, as on an axis
        plot.strip(picture[::-1], (0, 90), ax=bands, title=f"{data['metal'][i]} ({data['source'][i]})")
        for rgb, line in zip(data["rgb"][i], ("-", ":", "--"), strict=True):
            for channel, shade in enumerate((plot.RED, plot.GREEN, plot.BLUE)):
                plot.cartesian(theta, rgb[:, channel], ax=curves, color=shade, linestyle=line, linewidth=1.2)
        for delta, line, name in zip(data["difference"][i], (":", "--"), names[1:], strict=True):
            plot.cartesian(theta, delta, ax=below, linestyle=line, color=plot.GREY, label=name)
        plot.mark(below, y=1)
        plot.labels(curves, xlim=(0, 90), xticks=dict.fromkeys(range(0, 91, 20), ""))
        plot.labels(
            below, xlabel=plot.ANGLE.replace(" (", "\n("), xlim=(0, 90), ylim=(0, 1.04 * data["difference"].max())
        )
    for level, name in zip((5 / 6, 3 / 6, 1 / 6), names, strict=True):
        plot.note(axes[0, 0], (3, level), name, ha="left", fontsize="x-small")
    plot.labels(axes[1, 0], ylabel="linear sRGB")
    keys = {"exact, by wavelength": {"linestyle": "-"}, names[1]: {"linestyle": ":"}, names[2]: {"linestyle": "--"}}
    plot.legend(axes[1, 0], {name: {"color": plot.GREY, **line} for name, line in keys.items()}, loc="center left")
    plot.labels(axes[2, 0], ylabel="CIEDE2000\nfrom exact", legend="upper left")
