"""The way of gold's colour from normal to grazing incidence over the chromaticity diagram."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import colour, fresnel, plot
from jaxrefl.image import encode_srgb
from jaxrefl.materials import material

CAPTION = """Gold under D65 from normal to grazing incidence, as CIE 1931 chromaticities: the whole diagram with the
triangle of sRGB, and the path enlarged, with the colours of Babar's measurement. It keeps its colour long and ends in
that of the light: it is half way at 80.5°. The chromaticity never leaves the triangle; out of the gamut is the red
channel, 1.059 at 0° and above 1 up to 85.0°. At 0° Johnson's gold is CIEDE2000 4.3 from Babar's, McPeak's 1.2 and
Olmon's 1.1."""
SIZE = (9.6, 4.6)
SOURCES = ("Babar", "Johnson", "McPeak", "Olmon")
SHADES = (plot.ORANGE, plot.BLUE, plot.GREEN, plot.PINK)
MARKED = (0, 60, 75, 80, 85)


def compute(samples: int = 181) -> dict:
    w = np.arange(360.0, 781.0, 5.0)
    theta, mu = plot.angles(samples)
    index = [material("Au", source)(w) for source in SOURCES]
    n, k = (jnp.stack([jnp.asarray(getattr(one, part)) for one in index])[:, None] for part in ("n", "k"))

    @jax.jit
    def path(n, k):
        spectra = fresnel.conductor(mu[:, None], n, k)
        return colour.spectrum_to_xyz(spectra, w), colour.spectrum_to_rgb(spectra, w)

    xyz, rgb = (np.asarray(part) for part in path(n, k))
    triangle = np.asarray(colour.rgb_to_xyz(np.eye(3)[[0, 1, 2, 0]]))
    rim = np.arange(380.0, 701.0, 1.0)
    return {
        "theta_deg": theta,
        "source": np.array(SOURCES),
        "xyz": xyz,
        "xy": _xy(xyz),
        "rgb": rgb,
        "white": _xy(colour.xyz_matrix(w).sum(axis=0)),
        "triangle": _xy(triangle),
        "wavelength_nm": rim,
        "locus": colour.spectral_locus(rim),
        "difference": colour.colour_difference(rgb[:, 0], rgb[:1, 0]),
    }


def _xy(xyz):
    return xyz[..., :2] / xyz.sum(axis=-1, keepdims=True)


def draw(data: dict, fig) -> None:
    whole, near = fig.subplots(1, 2, width_ratios=(1, 1.25))
    rim = data["locus"]
    closed = np.concatenate([rim, rim[:1]])
    _colours(whole)
    for ax, zorder in ((whole, 6), (near, 2)):
        plot.cartesian(*closed.T, ax=ax, color=plot.GREY, linewidth=1, zorder=zorder)
        plot.cartesian(*data["triangle"].T, ax=ax, color=plot.GREY, linewidth=1, linestyle="--", zorder=zorder)
        for i, (shade, line) in enumerate(zip(SHADES, ("-", "-", "-", "--"), strict=True)):
            plot.cartesian(
                *data["xy"][i].T,
                ax=ax,
                color=shade,
                linestyle=line,
                label=data["source"][i],
                zorder=zorder,
                linewidth=1.3,
            )
        plot.points(ax, *data["white"], ["D65"], dy=-5, color=plot.GREY)
    for nm in (460, 480, 500, 520, 540, 560, 580, 600, 620):
        at = rim[data["wavelength_nm"] == nm][0]
        away = 0.045 * (at - data["white"]) / np.linalg.norm(at - data["white"])
        plot.note(whole, at + away, f"{nm}", fontsize="x-small")
    plot.note(whole, (0.24, 0.6), "sRGB", color=plot.GREY)
    plot.labels(whole, xlabel="x", ylabel="y", xlim=(-0.04, 0.8), ylim=(-0.02, 0.9), aspect="equal")
    where = np.isin(data["theta_deg"], MARKED)
    shown = colour.to_gamut(data["rgb"][0, where])
    names = [f"{theta:.0f}°" for theta in data["theta_deg"][where]]
    plot.points(near, *data["xy"][0, where].T, names, dy=6, s=60, color=encode_srgb(shown), edgecolors=plot.GREY)
    plot.labels(near, xlabel="x", ylabel="y", xlim=(0.305, 0.42), ylim=(0.32, 0.41), legend="lower right")


def _colours(ax, side: int = 90) -> None:
    """The triangle of sRGB filled with its colours, the largest channel of each 1."""
    r, g = (part.ravel() for part in np.meshgrid(*2 * [np.linspace(0, 1, side)]))
    share = np.stack([r, g, 1 - r - g], axis=-1)[r + g <= 1 + 1e-12]  # of the primaries, in chromaticity
    xyz = np.asarray(colour.rgb_to_xyz(np.eye(3)))
    rgb = share / xyz.sum(axis=1)
    shown = encode_srgb(rgb / rgb.max(axis=-1, keepdims=True))
    plot.points(ax, *(share @ _xy(xyz)).T, color=shown, s=12, marker="s", linewidths=0)
