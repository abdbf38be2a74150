"""Fresnel reflectance of a dielectric from both sides."""

import jax.numpy as jnp
import numpy as np

from jaxrefl import fresnel, plot

CAPTION = """Fresnel reflectance of glass, n = 1.5, from outside and from inside: both start at R0 = 0.04. R_p vanishes
at Brewster's angle, 56.3° outside and 33.7° inside, which add up to 90°; from inside, reflection is total beyond the
critical angle, 41.8°. Schlick's approximation follows from inside only if it is given the angle of refraction
(dotted); with the angle of incidence (loosely dotted) it is blind to total reflection."""
SIZE = (8.6, 4.0)


def compute(eta: float = 1.5) -> dict:
    theta, mu = plot.angles(1801)
    return {
        "eta": eta,
        "theta_deg": theta,
        "outside_sp": jnp.stack(fresnel.dielectric_sp(mu, eta)),
        "inside_sp": jnp.stack(fresnel.dielectric_sp(mu, 1 / eta)),
        "schlick_outside": fresnel.schlick_dielectric(mu, eta),
        "schlick_inside": fresnel.schlick_dielectric(mu, 1 / eta),
        "schlick_inside_wrong": fresnel.schlick(mu, fresnel.f0_dielectric(eta)),
        "brewster_deg": np.rad2deg([fresnel.brewster_angle(eta), fresnel.brewster_angle(1 / eta)]),
        "critical_deg": np.rad2deg(fresnel.critical_angle(1 / eta)),
        "normal": fresnel.dielectric(1.0, np.array([eta, 1 / eta])),
    }


def draw(data: dict, fig) -> None:
    outside, inside = fig.subplots(1, 2, sharey=True)
    n, theta = data["eta"], data["theta_deg"]
    plot.fresnel(n, ax=outside, title=f"from air into glass, η = {n:g}", legend=False)
    plot.fresnel(1 / n, ax=inside, title=f"from glass into air, η = 1/{n:g}", legend=False)
    plot.labels(inside, ylabel="")
    schlick = {"color": plot.PINK, "linestyle": ":"}
    plot.cartesian(theta, data["schlick_outside"], ax=outside, label="Schlick", legend="upper left", **schlick)
    plot.cartesian(theta, data["schlick_inside"], ax=inside, label=r"Schlick with $\theta_t$", **schlick)
    loose = {"color": plot.PINK, "linestyle": (0, (1, 4))}
    wrong = data["schlick_inside_wrong"]
    plot.cartesian(theta, wrong, ax=inside, label=r"Schlick with $\theta_i$", **loose)
    plot.legend(inside, loc="center left", bbox_to_anchor=(0.5, 0.55))
