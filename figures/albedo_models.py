"""Directional albedo of every model of the catalog."""

import jax
import numpy as np

from jaxrefl import brdf, plot

CAPTION = """Directional albedo over the angle of view, white where a model can be. Oren-Nayar (σ = 0.3) and rough
Burley (1) end above 1, at 1.005 and 1.558; EON is 1 at every angle. Modified Phong tends to cos θ with growing n, and
Blinn-Phong falls faster, to 0.265 at 60° for n = 100: both lose what the lobe sends below the horizon. The literal
highlights (n = 10) show no more light than they get, but of a beam they send out more than comes in from 88.7° (Phong)
and 86.6° (OpenGL) on, dashed. Minnaert's albedo grows without bound to 90° for k < 1. A coat over white Lambert is
exactly 1, and so are R and T of a clear slab together; D3D9 (6) is 2 at 90°."""
SIZE = (10.4, 6.2)


def compute(sigma: float = 0.3, exponents: tuple[float, ...] = (1.0, 10.0, 100.0), k: float = 0.8) -> dict:
    theta = np.concatenate([np.arange(0.0, 80.0, 2.5), np.linspace(80.0, 90.0, 21)])
    mu = np.sin(np.deg2rad(90 - theta))
    models = {
        "diffuse": {
            "Lambert": brdf.Lambert(1.0),
            f"Oren-Nayar, σ = {sigma:g}": brdf.OrenNayar(1.0, sigma),
            "EON, r = 1": brdf.EON(1.0, 1.0),
            "Burley, roughness 0": brdf.Burley(1.0, 0.0),
            "Burley, roughness 1": brdf.Burley(1.0, 1.0),
            "Ashikhmin-Shirley diffuse": brdf.AshikhminShirleyDiffuse(1.0, 0.0),
        },
        "mirror lobe": {f"n = {n:g}": brdf.ModifiedPhong(1.0, n) for n in exponents},
        "half vector": {f"n = {n:g}": brdf.BlinnPhong(1.0, n) for n in exponents},
        "literal": {"Phong": brdf.LiteralPhong(), "OpenGL": brdf.LiteralPhong(highlight="half_vector")},
        "planetary": {
            "Lommel-Seeliger, w = 1": brdf.LommelSeeliger(1.0),
            f"Minnaert, k = {k:g}": brdf.Minnaert(1.0, k),
            "Minnaert, k = 1.5": brdf.Minnaert(1.0, 1.5),
        },
        "layers": {
            "coat, ρ = 1": brdf.CoatedLambert(1.0),
            "coat, ρ = 0.5": brdf.CoatedLambert(0.5),
            "slab, R": brdf.Slab(),
            "D3D9 (6)": brdf.D3D9(),
        },
    }
    flat = {f"{group}: {name}": model for group, few in models.items() for name, model in few.items()}
    found = {name: estimate.value for name, estimate in plot.albedos(flat, theta).items()}
    lit = plot.albedos(models["literal"], theta, fixed="light")
    found |= {f"literal: {name}, lit": estimate.value for name, estimate in lit.items()}
    found["layers: slab, T"] = np.asarray(jax.vmap(brdf.Slab().through)(mu))
    found |= {"mirror lobe: n → ∞, cos θ": mu}
    for name, values in found.items():
        if "literal" in name or "Minnaert" in name:
            found[name] = np.where(theta < 90, values, np.nan)  # at 90° itself f does not exist
    return {"theta_deg": theta, "name": np.array(list(found)), "albedo": np.stack(list(found.values()))}


def draw(data: dict, fig) -> None:
    titles = {
        "diffuse": "diffuse models, white",
        "mirror lobe": "modified Phong",
        "half vector": "Blinn-Phong",
        "literal": "literal highlights, n = 10",
        "planetary": "planetary models",
        "layers": "layers, n = 1.5",
    }
    dashed = {"Burley, roughness 0": "--", "n → ∞, cos θ": ":", "slab, T": "--", "D3D9 (6)": "-."}
    limits = {"diffuse": (0, 2.05), "literal": (0, 2.05), "planetary": (0, 2.3), "layers": (0, 2.05)}
    for ax, (group, title) in zip(fig.subplots(2, 3).ravel(), titles.items(), strict=True):
        for name, curve in zip(data["name"], data["albedo"], strict=True):
            this, _, label = str(name).partition(": ")
            if this == group:
                line = dashed.get(label, "--" if label.endswith("lit") else "-")
                text = label.replace(", lit", ", by the light")
                plot.albedo(curve, data["theta_deg"], ax=ax, label=text, linestyle=line, ylim=None)
        plot.labels(ax, title=title, ylim=limits.get(group, (0, 1.35)))
        plot.legend(ax, loc="upper left" if group in limits else "lower left")
