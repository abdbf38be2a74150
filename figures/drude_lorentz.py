"""Drude-Lorentz models fitted to measured metals, with their residuals."""

import numpy as np

from jaxrefl import dispersion, plot
from jaxrefl.materials import material

CAPTION = """Drude-Lorentz models with three oscillators fitted to the tables of Johnson and Christy, 203 to 1937 nm
(points), and what they leave of n, k and the reflectance R at normal incidence. R is met within 0.02 for chromium and
0.06 for gold and copper; silver's plasma edge is too sharp for three Lorentz terms, the fit is off by 0.23 at
331.5 nm, on the flank. In the mean square, n and k of all four are met less well beyond 800 nm than below; there they
still give R within 0.020."""
SIZE = (9.6, 5.8)
METALS = ("Au", "Ag", "Cu", "Cr")


def compute(n_oscillators: int = 3) -> dict:
    fits, data, fine = [], [], np.geomspace(210.0, 1900.0, 400)
    for name in METALS:
        table = material(name, "Johnson").model
        fits.append(dispersion.fit_drude_lorentz(table.wavelength_nm, table.n, table.k, n_oscillators=n_oscillators))
        data.append((table.wavelength_nm, table.n, table.k))
    found = [fit.model(row[0]) for fit, row in zip(fits, data, strict=True)]
    curves = [fit.model(fine) for fit in fits]
    reflectance = [
        dispersion.normal_reflectance(fit.model, row[0])
        - dispersion.normal_reflectance(dispersion.Tabulated(*row), row[0])
        for fit, row in zip(fits, data, strict=True)
    ]
    return {
        "metals": np.array(METALS),
        "wavelength_nm": np.stack([row[0] for row in data]),
        "n": np.stack([row[1] for row in data]),
        "k": np.stack([row[2] for row in data]),
        "fine_nm": fine,
        "n_fine": np.stack([np.asarray(c.n) for c in curves]),
        "k_fine": np.stack([np.asarray(c.k) for c in curves]),
        "n_error": np.stack([np.asarray(f.n) - row[1] for f, row in zip(found, data, strict=True)]),
        "k_error": np.stack([np.asarray(f.k) - row[2] for f, row in zip(found, data, strict=True)]),
        "r_error": np.stack([np.asarray(r) for r in reflectance]),
        "rms": np.array([(fit.n.rms, fit.k.rms, fit.reflectance.rms) for fit in fits]),
        "max": np.array([(fit.n.max, fit.k.max, fit.reflectance.max) for fit in fits]),
        "converged": np.array([fit.converged for fit in fits]),
        "plasma_ev": np.array([float(fit.model.plasma_ev) for fit in fits]),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(3, len(METALS), sharex=True, sharey="row", height_ratios=(1.7, 1, 1))
    for i, (top, middle, bottom) in enumerate(axes.T):
        x, fine = (dispersion.HC_EV_NM / nm for nm in (data["wavelength_nm"][i], data["fine_nm"]))
        for what, color in (("n", plot.BLUE), ("k", plot.RED)):
            plot.cartesian(fine, data[f"{what}_fine"][i], ax=top, color=color, label=what)
            plot.cartesian(x, data[what][i], ax=top, color=color, linestyle="", marker="o", markersize=2.5)
            plot.cartesian(x, data[f"{what}_error"][i], ax=middle, color=color, marker="o", markersize=2)
        plot.cartesian(x, data["r_error"][i], ax=bottom, color=plot.GREEN, marker="o", markersize=2)
        for ax in (middle, bottom):
            plot.mark(ax, y=0)
        plot.labels(top, title=f"{data['metals'][i]}: R within {data['max'][i, 2]:.3f}", xlim=(0.5, 6.2))
        plot.labels(bottom, xlabel="photon energy (eV)")
    plot.labels(axes[0, 0], ylabel="n, k (points: measured)", legend="upper right")
    plot.labels(axes[1, 0], ylabel="fit - measured")
    plot.labels(axes[2, 0], ylabel="R: fit - measured")
