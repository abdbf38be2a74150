"""What to type into the D3D9Client: the best (m, p) for a material of known index."""

import jax.numpy as jnp
import numpy as np

from jaxrefl import d3d9, fresnel, plot, quadrature

CAPTION = """Best parameters of D3D9 (3) for water, glass and diamond, with the exact R0, least squares uniform in the
angle. A free multiplier (solid) leaves an RMS error of 0.0093, 0.0102 and 0.0125, against 0.0201, 0.0135 and 0.0239
for Schlick (m = 1 - R0, p = 5, dotted), but falls short of 1 at grazing, where R0 + m is 0.957, 0.952 and 0.936."""
SIZE = (9.6, 3.9)
NAMES = {1.33: "water", 1.5: "glass", 2.4: "diamond"}


def compute(eta: tuple[float, ...] = (1.33, 1.5, 2.4), nodes: int = 200) -> dict:
    rule = quadrature.uniform_theta_rule(nodes)
    theta, mu = plot.angles(721)
    free = [d3d9.best_fit(n, rule) for n in eta]
    tied = [d3d9.best_fit(n, rule, free_multiplier=False) for n in eta]

    def rms(n):
        error = fresnel.schlick(rule.node, fresnel.f0_dielectric(n)) - fresnel.dielectric(rule.node, n)
        return jnp.sqrt(jnp.sum(rule.weight * error**2))

    return {
        "theta_deg": theta,
        "eta": np.array(eta),
        "r0": np.array([fit.r0 for fit in free]),
        "m": np.array([fit.m for fit in free]),
        "p": np.array([fit.p for fit in free]),
        "rms": np.array([fit.rms for fit in free]),
        "p_tied": np.array([fit.p for fit in tied]),
        "rms_tied": np.array([fit.rms for fit in tied]),
        "rms_schlick": np.array([rms(n) for n in eta]),
        "exact": jnp.stack([fresnel.dielectric(mu, n) for n in eta]),
        "fitted": jnp.stack([fresnel.d3d9(mu, fit.r0, fit.m, fit.p) for fit in free]),
        "tied": jnp.stack([fresnel.d3d9(mu, fit.r0, fit.m, fit.p) for fit in tied]),
        "schlick": jnp.stack([fresnel.schlick(mu, fresnel.f0_dielectric(n)) for n in eta]),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(2, len(data["eta"]), sharex=True, sharey="row", height_ratios=(1.35, 1), squeeze=False)
    theta = data["theta_deg"]
    for i, n in enumerate(data["eta"]):
        top, bottom = axes[:, i]
        r0, m, p, tied = (float(data[key][i]) for key in ("r0", "m", "p", "p_tied"))
        name = NAMES.get(float(n), "index")
        plot.cartesian(theta, data["exact"][i], ax=top, color=plot.GREY, linewidth=4, alpha=0.45, label="exact")
        plot.cartesian(
            theta,
            data["fitted"][i],
            ax=top,
            color=plot.BLUE,
            label=f"R0 = {r0:.4f}, m = {m:.3f},\np = {p:.2f}, RMS {float(data['rms'][i]):.4f}",
        )
        plot.cartesian(
            theta, data["tied"][i], ax=top, color=plot.GREEN, linestyle="--", label=f"m = 1 - R0, p = {tied:.2f}"
        )
        plot.cartesian(
            theta,
            data["schlick"][i],
            ax=top,
            color=plot.RED,
            linestyle=":",
            label=f"Schlick, p = 5, RMS {float(data['rms_schlick'][i]):.4f}",
        )
        plot.labels(top, title=f"{name}, n = {n:g}", xlim=(0, 90), ylim=(0, 1.02), legend="upper left")
        for key, color, line in (("fitted", plot.BLUE, "-"), ("tied", plot.GREEN, "--"), ("schlick", plot.RED, ":")):
            plot.cartesian(theta, data[key][i] - data["exact"][i], ax=bottom, color=color, linestyle=line)
        plot.mark(bottom, y=0)
        plot.labels(bottom, xlabel=plot.ANGLE)
    plot.labels(axes[0, 0], ylabel="reflectance R")
    plot.labels(axes[1, 0], ylabel="fit - exact")
