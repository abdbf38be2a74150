"""Anti-reflection coatings of one, two and three layers on glass."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import films, plot

CAPTION = """Anti-reflection on glass, n = 1.52. Left, at normal incidence: a quarter wave of n = 1.38, magnesium
fluoride, takes the 4.26 % of bare glass to 1.26 % at 550 nm. Two quarter waves, 1.38 on 1.70, come to 0 there and are
worse than one below 464 nm and above 678 nm. With a half wave of 2.10 between quarter waves of 1.38 and 1.62, R is
below 0.8 % from 438 to 744 nm. Right, at 550 nm: all of them lose their effect towards grazing incidence; at 60° they
reflect 9.25, 5.34, 5.00 and 3.48 %."""
SIZE = (8.6, 4.0)
NAMES = ("bare glass", "one layer", "two layers", "three layers")
INDICES = ((1.38, 2.10, 1.70), (1.38, 2.10, 1.70), (1.38, 2.10, 1.70), (1.38, 2.10, 1.62))
WAVES = ((0.0, 0.0, 0.0), (0.25, 0.0, 0.0), (0.25, 0.0, 0.25), (0.25, 0.5, 0.25))


def compute(glass: float = 1.52, design_nm: float = 550.0) -> dict:
    wavelength = np.arange(380.0, 781.0, 2.0)
    theta, mu = plot.angles(181)
    n = np.array(INDICES).T[:, :, None]
    d = np.array(WAVES).T[:, :, None] * design_nm / n
    reflectance = jax.jit(lambda mu, wavelength: films.film(mu, wavelength, n, 0.0, d, 1.0, glass).R)
    return {
        "wavelength_nm": wavelength,
        "theta_deg": theta,
        "n": n[..., 0],
        "thickness_nm": d[..., 0],
        "glass": glass,
        "design_nm": design_nm,
        "over_wavelength": reflectance(jnp.ones(1), wavelength),
        "over_angle": reflectance(mu, jnp.full(1, design_nm)),
    }


def draw(data: dict, fig) -> None:
    left, right = fig.subplots(1, 2)
    colors, lines = (plot.GREY, plot.BLUE, plot.RED, plot.GREEN), ("-", "--", "-.", "-")
    for name, r, over, color, line in zip(
        NAMES, data["over_wavelength"], data["over_angle"], colors, lines, strict=True
    ):
        style = {"color": color, "linestyle": line}
        plot.cartesian(data["wavelength_nm"], 100 * r, ax=left, label=name, **style)
        plot.cartesian(data["theta_deg"], 100 * over, ax=right, label=name, **style)
    plot.mark(left, x=data["design_nm"], text="{:.0f} nm", at=0.8)
    plot.labels(left, xlabel="wavelength (nm)", ylabel="reflectance R (%)", title="normal incidence")
    plot.labels(left, xlim=(380, 780), ylim=(0, 5))
    plot.labels(right, xlabel=plot.ANGLE, ylabel="reflectance R (%)", title="550 nm, unpolarised", legend="upper left")
    plot.labels(right, xlim=(0, 80), ylim=(0, 20))
