"""Qualitative Oren-Nayar reflects more than its rho near grazing; EON does not."""

import numpy as np

from jaxrefl import brdf, plot
from jaxrefl.tabulate import albedo_table

CAPTION = """Qualitative Oren-Nayar exceeds its own ρ. Left: albedo / ρ over the angle; at 90° it is above 1 for every σ
up to 0.326, while at normal incidence up to 38 % is missing (σ = 1). EON with ρ = 1 is exactly 1 for every roughness
(dashed). Right: at 90° over σ, A + B / 2, largest at σ = 0.20 with 1.015; dots are integrals over the model."""
SIZE = (8.6, 3.8)


def compute(sigmas: tuple[float, ...] = (0.1, 0.2, 0.3, 0.5, 1.0), roughness: tuple[float, ...] = (0.5, 1.0)) -> dict:
    theta, mu = plot.angles(91)
    rough = albedo_table(brdf.OrenNayar(1.0), "sigma", sigmas, mu)
    eon = albedo_table(brdf.EON(1.0), "roughness", roughness, mu)
    sigma = np.linspace(0, 1.2, 2401)
    grazing = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33) + 0.5 * 0.45 * sigma**2 / (sigma**2 + 0.09)
    return {
        "theta_deg": theta,
        "sigmas": rough.values,
        "albedo": rough.albedo,
        "eon": eon.albedo,
        "sigma": sigma,
        "grazing": grazing,
        "largest": grazing.max(),
        "largest_sigma": sigma[grazing.argmax()],
        "last_above": sigma[grazing > 1 + 1e-12].max(),
        "smallest_at_normal": rough.albedo[:, 0].min(),
    }


def draw(data: dict, fig) -> None:
    angle, grazing = fig.subplots(1, 2, width_ratios=(1.3, 1))
    for sigma, curve in zip(data["sigmas"], data["albedo"], strict=True):
        plot.albedo(curve, data["theta_deg"], ax=angle, label=f"σ = {sigma:g}")
    for i, curve in enumerate(data["eon"]):
        label = "EON, ρ = 1" if i == 0 else None
        plot.albedo(curve, data["theta_deg"], ax=angle, label=label, color=plot.GREY, linestyle="--")
    plot.labels(angle, title="Oren-Nayar", ylabel="directional albedo / ρ", ylim=(0.55, 1.06), legend="lower right")
    plot.cartesian(data["sigma"], data["grazing"], ax=grazing, color=plot.GREY)
    for i, sigma in enumerate(data["sigmas"]):
        plot.points(grazing, [sigma], [data["albedo"][i, -1]], color=f"C{i}", s=40)
    plot.mark(grazing, y=1.0, text="conserving", side="above", at=0.98)
    plot.mark(grazing, x=float(data["last_above"]), text="σ = {:.3f}", at=0.5)
    plot.labels(grazing, title="at 90°", xlabel="σ (rad)", ylabel="directional albedo / ρ", xlim=(0, 1.2))
