"""A coat over Lambert and a slab, beside the shortcuts that are not the same."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import brdf, fresnel, plot

CAPTION = """Shortcuts and what they cost (n = 1.5). Left: Lambert with ρ = 0.5 under a smooth coat, the line the
formula F + (1 - F) ρ (1 - F_i) / (1 - ρ F_i), dots the integral over the model: 0.316 at normal incidence. Without the
reflections inside the coat it is 0.234; as if the coat let all light out again, F + (1 - F) ρ, it is 0.52; the plain
sum F + ρ ends at 1.5. Middle: over white Lambert, ρ = 1, the coat is exactly 1, as it must be; without the inner
reflections 0.428 is left. Right: a clear slab. R summed over its inner reflections for each polarisation and averaged
then is 0.152 at 60°; with F averaged first it is 0.164, and at most 0.022 off, at 74°. Where R_p is 0, at 56.3°, the
slab passes all of p."""
SIZE = (10.6, 3.9)


def compute(eta: float = 1.5, rho: float = 0.5) -> dict:
    theta, mu = plot.angles(361)
    few = theta[::20]
    f, inside = fresnel.dielectric(mu, eta), fresnel.average_dielectric(1 / eta)
    f_s, f_p = fresnel.dielectric_sp(mu, eta)
    data = {"theta_deg": theta, "rho": rho, "eta": eta}
    for key, white in (("grey", rho), ("white", 1.0)):
        data[f"coat_{key}"] = plot.albedos(brdf.CoatedLambert(white, eta), few).value
        data[f"formula_{key}"] = f + (1 - f) * white * (1 - inside) / (1 - white * inside)
        data[f"once_{key}"] = f + (1 - f) * white * (1 - inside)
        data[f"dimmed_{key}"] = f + (1 - f) * white
        data[f"added_{key}"] = f + white
    slab = brdf.Slab(eta)
    reflected = jax.vmap(slab.mirror)(jnp.asarray(mu))
    wrong = 2 * f / (1 + f)
    return data | {
        "few_deg": few,
        "slab_R": reflected,
        "slab_T": jax.vmap(slab.through)(jnp.asarray(mu)),
        "slab_wrong": wrong,
        "slab_s": 2 * f_s / (1 + f_s),
        "slab_p": 2 * f_p / (1 + f_p),
        "apart": np.abs(wrong - reflected).max(),
        "apart_deg": theta[np.abs(wrong - reflected).argmax()],
        "brewster_deg": np.rad2deg(fresnel.brewster_angle(eta)),
    }


def draw(data: dict, fig) -> None:
    grey, white, slab = fig.subplots(1, 3)
    theta = data["theta_deg"]
    shortcuts = {
        "formula": ("right", {"color": plot.GREEN}),
        "once": ("no inner reflections", {"color": plot.BLUE, "linestyle": "--"}),
        "dimmed": ("F + (1 - F) ρ", {"color": plot.ORANGE, "linestyle": "-."}),
        "added": ("F + ρ", {"color": plot.RED, "linestyle": ":"}),
    }
    for ax, key in ((grey, "grey"), (white, "white")):
        for name, (label, line) in shortcuts.items():
            plot.albedo(data[f"{name}_{key}"], theta, ax=ax, label=label, **line)
        marker = {"linestyle": "", "marker": "o", "markersize": 4, "color": plot.GREEN}
        plot.albedo(data[f"coat_{key}"], data["few_deg"], ax=ax, label="integral over the model", **marker)
    plot.labels(grey, title=f"coat over Lambert, ρ = {float(data['rho']):g}", ylim=(0, 2.05), legend="upper left")
    plot.labels(white, title="coat over white Lambert, ρ = 1", ylim=(0, 2.05))
    curves = {
        "R, s": ("slab_s", plot.BLUE, "--"),
        "R, p": ("slab_p", plot.ORANGE, "-."),
        "R": ("slab_R", plot.GREEN, "-"),
        "R, averaged first": ("slab_wrong", plot.RED, ":"),
        "T": ("slab_T", plot.GREY, "-"),
    }
    for label, (key, color, line) in curves.items():
        plot.cartesian(theta, data[key], ax=slab, label=label, color=color, linestyle=line)
    plot.labels(slab, title="clear slab", xlabel=plot.ANGLE, ylabel="light out / light in", xlim=(0, 90))
    plot.labels(slab, ylim=(0, 1.02), legend="center left")
    plot.mark(slab, x=float(data["brewster_deg"]), text="Brewster {:.1f}°", side="left", at=0.72)
