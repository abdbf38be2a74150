"""What two misprints of the Lambert/Fresnel notes would do to a metal."""

import jax.numpy as jnp
import numpy as np

from jaxrefl import fresnel, plot

CAPTION = """Two misprints in the conductor formulas, for gold at 548.6 nm (η = 0.43, k = 2.455). Left: (r_s² + r_p²)/2
with complex r, as printed, instead of |r|²: not even real; at 60° it is 0.006 + 0.415i where the reflectance is 0.788.
Right: θ tan²θ printed as the denominator of R_p: at 60° R_p = 2.26 instead of 0.683, infinite at normal incidence."""
SIZE = (8.6, 3.8)


def compute(eta: float = 0.43, k: float = 2.455) -> dict:
    def both(theta_deg):
        theta = np.deg2rad(np.asarray(theta_deg))
        mu = np.cos(theta)
        r = fresnel.amplitudes(mu, eta, k)
        r_s, r_p = fresnel.conductor_sp(mu, eta, k)
        sin2, tan2 = jnp.sin(theta) ** 2, jnp.tan(theta) ** 2
        t0 = eta**2 - k**2 - sin2
        modulus = jnp.sqrt(t0**2 + 4 * eta**2 * k**2)
        a = jnp.sqrt(0.5 * (modulus + t0))
        numerator = modulus - 2 * a * jnp.sqrt(sin2 * tan2) + sin2 * tan2
        return r_p, 0.5 * (r_s + r_p), 0.5 * (r.r_s**2 + r.r_p**2), r_s * numerator / (theta * tan2)

    theta, _ = plot.angles(886, 1.0, 89.5)
    exact_p, exact, squared, denominator = both(theta)
    at_60 = both(60.0)
    return {
        "theta_deg": theta,
        "eta": eta,
        "k": k,
        "R_p": exact_p,
        "R": exact,
        "literal_squares": squared,
        "literal_denominator": denominator,
        "R_p_60": at_60[0],
        "R_60": at_60[1],
        "literal_squares_60": at_60[2],
        "literal_denominator_60": at_60[3],
    }


def draw(data: dict, fig) -> None:
    left, right = fig.subplots(1, 2)
    theta, squared = data["theta_deg"], np.asarray(data["literal_squares"])
    name = f"η = {data['eta']:g}, k = {data['k']:g}"
    text = {"xlabel": plot.ANGLE, "ylabel": "reflectance", "xlim": (0, 90)}
    plot.cartesian(theta, data["R"], ax=left, label=r"$(|r_s|^2+|r_p|^2)/2$", color=plot.GREEN)
    plot.cartesian(
        theta, squared.real, ax=left, label=r"real part of $(r_s^2+r_p^2)/2$", color=plot.RED, linestyle="--"
    )
    plot.cartesian(theta, squared.imag, ax=left, label="its imaginary part", color=plot.RED, linestyle=":")
    plot.labels(left, title=f"squares of complex amplitudes; {name}", ylim=(-0.45, 1.4), **text)
    plot.legend(left, loc="upper left")
    plot.mark(left, x=60)
    plot.cartesian(theta, data["R_p"], ax=right, label=r"$R_p$", color=plot.GREEN)
    wrong = {"label": r"$R_p$ over $\theta\,\tan^2\theta$", "color": plot.RED, "linestyle": "--"}
    plot.cartesian(theta, data["literal_denominator"], ax=right, **wrong)
    plot.labels(right, title=f"misprinted denominator; {name}", ylim=(0.1, 1000), yscale="log", **text)
    plot.legend(right, loc="upper right")
    plot.mark(right, x=60)
    plot.mark(right, y=1, text="all the light", at=0.4)
