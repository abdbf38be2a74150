"""All metals under three lights, a ring for each measurement."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import colour, fresnel, plot
from jaxrefl.materials import material, materials

CAPTION = """Twelve metals at normal incidence under D65, A and FL11 on a grey wall, the white of each light shown as
white (Bradford's adaptation), desaturated into the gamut. A ring for each measurement, the default innermost. Below:
the farthest two of the measurements under D65, and of the lights by one measurement. No light moves a metal by more
than CIEDE2000 4.3, and that is gold; of the seven others with several measurements six differ by them more than by the
lights, at least 1.6 times, titanium by 8.2. Silver and aluminium are the same everywhere to 0.4."""
SIZE = (11.4, 5.4)
METALS = ("Au", "Cu", "brass", "Ag", "Al", "Cr", "Fe", "Ni", "Pd", "Pt", "Ti", "W")
LIGHTS = ("D65", "A", "FL11")
GREY = 0.18
"""Reflectance of the wall behind the discs."""


def compute(cell: int = 120) -> dict:
    w = np.arange(380.0, 781.0, 5.0)
    found = [(name, source, material(name, source)) for name in METALS for source in materials()[name]]
    found = [row for row in found if row[2].provenance.kind == "measured"]
    tables = [one.model for *_, one in found]  # linear in wavelength, as the models are; without compiling each
    n, k = (np.stack([np.interp(w, t.wavelength_nm, getattr(t, part)) for t in tables]) for part in ("n", "k"))
    spectra = jax.jit(fresnel.f0_conductor)(n, k)
    rgb = np.stack([spectra @ jnp.asarray(colour.rgb_matrix(w, light)) for light in LIGHTS], axis=1)
    lab = np.asarray(colour.rgb_to_lab(rgb))
    metal = np.array([name for name, *_ in found])
    rings = {name: np.flatnonzero(metal == name) for name in METALS}
    return {
        "metal": np.array(METALS),
        "sources": np.array([len(rows) for rows in rings.values()]),
        "metal_of": metal,
        "source": np.array([source for _, source, _ in found]),
        "light": np.array(LIGHTS),
        "reflectance": spectra,
        "rgb": rgb,  # (source, light, channel)
        "spread": np.array([_farthest(lab[rows, 0]) for rows in rings.values()]),
        "change": np.array([max(_farthest(colours) for colours in lab[rows]) for rows in rings.values()]),
        "picture": np.concatenate([_row(rgb[:, i], rings.values(), cell) for i in range(len(LIGHTS))]),
    }


def _farthest(lab) -> float:
    """Largest difference between any two colours (n, 3)."""
    return float(colour.ciede2000(lab[:, None], lab[None]).max())


def _row(rgb, rings, cell: int):
    return np.concatenate([_disc(rgb[rows], cell) for rows in rings], axis=1)


def _disc(rgb, cell: int, finer: int = 4):
    """Picture (cell, cell, 3) of rings of equal width, the first colour innermost, on the grey wall."""
    at = (np.arange(cell * finer) + 0.5) / (cell * finer) * 2 - 1
    ring = np.floor(np.hypot(*np.meshgrid(at, at)) / 0.92 * len(rgb)).astype(int)
    shown = np.concatenate([colour.to_gamut(rgb), [[GREY] * 3]])[np.minimum(ring, len(rgb))]
    return shown.reshape(cell, finer, cell, finer, 3).mean(axis=(1, 3))


def draw(data: dict, fig) -> None:
    wall, chart = fig.subplots(2, 1, height_ratios=(1.55, 1))
    picture, count = data["picture"], len(data["metal"])
    cell = picture.shape[1] // count
    plot.picture(picture, ax=wall)
    for i, light in enumerate(data["light"]):
        plot.note(wall, (-0.08 * cell, (i + 0.5) * cell), light, ha="right")
    x = np.arange(count)
    for shift, key, shade, text in ((-0.2, "spread", plot.BLUE, "sources"), (0.2, "change", plot.ORANGE, "lights")):
        plot.bars(chart, x + shift, data[key], 0.4, shade, [f"{v:.1f}" if v > 0 else "" for v in data[key]])
        plot.cartesian([], [], ax=chart, color=shade, linewidth=6, label=f"farthest of its {text}")
    names = dict(zip(x, data["metal"], strict=True))
    plot.labels(chart, ylabel="CIEDE2000", xlim=(-0.5, count - 0.5), xticks=names, legend=True)
