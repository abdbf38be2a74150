"""Evaluators of section J: colours of measured metals, and the numbers that colour-science states beside them."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from .. import colour, fresnel, quadrature
from ..materials import material
from .table import Columns, HostColumns, evaluates

NODES = 64
GRID = np.arange(360.0, 781.0)
COSINES = {"60deg": 0.5, "F82 (cos=1/7)": 1 / 7}
"""Of the cases that are an angle; the others are at normal incidence or averaged."""


def _indices(c: HostColumns, step: int) -> tuple[np.ndarray, np.ndarray]:
    """n and k (rows, wavelengths); 1 and infinity in effect where the row is the perfect reflector."""
    pairs = []
    for metal, source in zip(c["metal"], c["source"], strict=True):
        pairs.append((0 * GRID, 0 * GRID) if source == "-" else material(str(metal), str(source))(GRID))
    n, k = (np.array(columns)[:, ::step] for columns in zip(*pairs, strict=True))
    return n, k


def _columns(spectra: Any, step: int) -> dict[str, np.ndarray]:
    wavelengths = GRID[::step]
    xyz = colour.spectrum_to_xyz(spectra, wavelengths)
    rgb = colour.spectrum_to_rgb(spectra, wavelengths, white="colour")
    values = np.concatenate([xyz, rgb], axis=1).T
    return dict(zip(("X", "Y", "Z", "R_lin", "G_lin", "B_lin"), values, strict=True))


@evaluates("J.normal_incidence", "metal source step_nm", jit=False)
def _normal_incidence(c: HostColumns) -> dict[str, np.ndarray]:
    n, k = _indices(c, 1)
    perfect = c["source"][:, None] == "-"
    spectra = np.where(perfect, 1.0, fresnel.f0_conductor(np.where(perfect, 1.0, n), k))
    fine, coarse = _columns(spectra, 1), _columns(spectra[:, ::5], 5)
    found = {name: np.where(c["step_nm"] == 1, fine[name], coarse[name]) for name in fine}
    for channel in "RGB":  # of the sRGB curve, not held to 1
        found[f"{channel}_srgb"] = 1.055 * found[f"{channel}_lin"] ** (1 / 2.4) - 0.055
    return found


@evaluates("J.angles", "metal source case", jit=False)
def _angles(c: HostColumns) -> dict[str, np.ndarray]:
    n, k = _indices(c, 5)
    mu = np.array([COSINES.get(case, 1.0) for case in c["case"]])
    rule = quadrature.cosine_rule(NODES)
    average = quadrature.integrate(lambda mu: fresnel.conductor(mu, n, k), rule)
    at_angle = fresnel.conductor(mu[:, None], n, k)
    return _columns(np.where(c["case"][:, None] == "F_avg", average, at_angle), 5)


@evaluates("J.F0_rows", "metal@nm")
def _f0(c: Columns) -> dict[str, Array]:
    return {"F0": fresnel.f0_conductor(c["eta"], c["k"])}


@evaluates("J.colour_fresnel", given="n=1.5, theta=60 deg")
def _glass(c: Columns) -> dict[str, Array]:
    r_s, r_p = fresnel.dielectric_sp(0.5, 1.5)
    return {"theta_t_deg": jnp.rad2deg(jnp.arccos(fresnel.cos_theta_t(0.5, 1.5))), "R_s": r_s, "R_p": r_p}


@evaluates("J.water_n", given="water of 294 K and 1000 kg/m^3")
def _water(c: Columns) -> dict[str, Array]:
    """P. Schiebener et al., J. Phys. Chem. Ref. Data 19, 677 (1990), (7): (n^2 - 1)/(n^2 + 2) over the density."""
    w, t, uv, ir = jnp.array([400.0, 550.0, 700.0]) / 589.0, 294.0 / 273.15, 0.2292020, 5.432937
    a, b, d = 0.243905091 + 9.53518094e-3 - 1.63066183e-2, -3.64358110e-3, 2.65666426e-4
    x = a + b * t + d * w**2 * t + 1.59189325e-3 / w**2 + 2.45733798e-3 / (w**2 - uv**2) + 0.897478251 / (w**2 - ir**2)
    n = jnp.sqrt((1 + 2 * x) / (1 - x))
    return dict(zip(("n400", "n550", "n700"), n, strict=True))
