"""Lobes, and slices over the angles of half vector and difference."""

import numpy as np

from jaxrefl import brdf, plot

CAPTION = """Six models, in space and on paper. Left: f over the direction of view, light from 60°, each to its own
scale. Right: π f over the angle θ_h of the half vector from the normal and θ_d of the light from the half vector, with
the azimuth φ_d = 90° between them (1 is white Lambert). Blinn-Phong depends on θ_h alone: vertical stripes. The
highlight of modified Phong with a fourth of the exponent is as wide at θ_d = 0 and spreads towards grazing. Oren-Nayar
(σ = 1) and Burley (rough) are brightest where light and view graze from the same side, lower right; Lommel-Seeliger
grows along the whole edge at which both graze, and the literal highlight, over cos θ_i, as well."""
SIZE = (10.0, 8.4)


def compute(n: float = 10.0, incident_deg: float = 60.0, sigma: float = 1.0, samples: int = 90) -> dict:
    models = {
        f"Oren-Nayar, σ = {sigma:g}": brdf.OrenNayar(1.0, sigma),
        "Burley, roughness 1": brdf.Burley(1.0, 1.0),
        "Lommel-Seeliger": brdf.LommelSeeliger(1.0),
        f"modified Phong, n = {n:g}": brdf.ModifiedPhong(1.0, n),
        f"Blinn-Phong, n = {4 * n:g}": brdf.BlinnPhong(1.0, 4 * n),
        f"literal Phong, n = {n:g}": brdf.LiteralPhong(0.0, 1.0, n),
    }
    return {
        "name": np.array(list(models)),
        "incident_deg": incident_deg,
        "lobe": np.stack([plot.lobe_values(model, incident_deg) for model in models.values()]),
        "slice": np.stack([plot.slice_values(model, samples) for model in models.values()]),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(3, 4)
    slices = []
    for name, lobe, values, (left, right) in zip(
        data["name"], data["lobe"], data["slice"], axes.reshape(6, 2), strict=True
    ):
        mesh = plot.image_slice(values, ax=right, range=(0.05, 20.0), bar=False)
        plot.lobe3d(lobe, float(data["incident_deg"]), ax=left, title=name)
        slices.append(right)
    plot.shared_bar(mesh, slices, "π f", shrink=0.5)
