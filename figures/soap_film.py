"""Colours of a soap film over its thickness and the angle at which it is seen."""

import jax
import numpy as np

from jaxrefl import colour, films, plot
from jaxrefl.materials import material

CAPTION = """A film of water in air under D65. Top: its colour over thickness and angle of incidence, the brightest
film at each angle shown as white. Aslant, every colour belongs to a thicker film, because inside the path difference
is 2 n d cos θ. Middle: normal incidence. Bottom: the reflectance at three wavelengths. A film under 12 nm is black, R
< 0.5 %: what its two faces reflect is opposite in phase. It is brightest (7.8 %, nearly white) at 102 nm, a quarter
wave of green; beyond 1200 nm the orders overlap, and the chroma that reached 112 is below 18."""
SIZE = (8.6, 6.0)


def compute(thickest_nm: float = 1500.0) -> dict:
    wavelength = np.arange(380.0, 781.0, 5.0)
    thickness = np.linspace(0.0, thickest_nm, 501)
    theta = np.linspace(0.0, 80.0, 41)
    mu = np.cos(np.deg2rad(theta))
    n = np.asarray(material("water")(wavelength).n)
    matrix = colour.rgb_matrix(wavelength)

    @jax.jit
    def one_angle(mu):
        spectra = films.film(mu, wavelength, n[None], 0.0, thickness[None, :, None], 1.0, 1.0).R
        return spectra @ matrix, spectra[:, (450 - 380) // 5 :: 20][:, :3]

    rgb, bands = jax.lax.map(one_angle, mu)
    luminance = colour.rgb_to_xyz(rgb)[..., 1]
    shown = rgb / luminance.max(axis=1)[:, None, None]
    return {
        "thickness_nm": thickness,
        "theta_deg": theta,
        "wavelength_nm": np.array([450.0, 550.0, 650.0]),
        "index": n,
        "shown": shown,
        "bands": bands[0],
        "luminance": luminance[0],
        "brightest_nm": thickness[np.argmax(luminance[0])],
        "chroma": np.linalg.norm(np.asarray(colour.rgb_to_lab(shown[0]))[:, 1:], axis=1),
    }


def draw(data: dict, fig) -> None:
    top, middle, bottom = fig.subplots(3, 1, sharex=True, height_ratios=(3, 0.7, 2.2))
    d, last = data["thickness_nm"], float(data["theta_deg"][-1])
    picture = plot.strip(colour.to_gamut(np.asarray(data["shown"])), (d[0], d[-1]), ax=top)
    picture.set_extent((d[0], d[-1], last, 0.0))
    plot.labels(top, yticks=[0, 20, 40, 60, 80])
    plot.labels(top, ylabel="angle θ (degrees)", title="colour over thickness and angle of incidence")
    plot.strip(colour.to_gamut(np.asarray(data["shown"])[:1]), (d[0], d[-1]), ax=middle)
    plot.labels(middle, title="normal incidence")
    curves = zip(data["wavelength_nm"], np.asarray(data["bands"]).T, (plot.BLUE, plot.GREEN, plot.RED), strict=True)
    for (w, r, color), line in zip(curves, ("-", "--", "-."), strict=True):
        plot.cartesian(d, 100 * r, ax=bottom, label=f"{w:.0f} nm", color=color, linestyle=line)
    plot.mark(bottom, x=data["brightest_nm"])
    plot.labels(bottom, xlabel="thickness (nm)", ylabel="reflectance R (%)", xlim=(d[0], d[-1]), ylim=(0, 11))
    plot.legend(bottom, loc="upper right", ncols=3)
    plot.labels(bottom, xticks=np.arange(0, d[-1] + 1, 250))
