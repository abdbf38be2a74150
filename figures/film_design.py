"""One stack of films moved by gradient descent from grey to three target colours."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import colour, films, plot
from jaxrefl.materials import material

CAPTION = """Five layers, titanium dioxide and silica in turn, on chromium, under D65. They start at a grey, of chroma
2.3, and their thicknesses follow the gradient of the squared distance in CIE Lab, by 300 steps of Adam, to a teal, a
gold and a blue. Top: the colour at every step with the target to the right of the line, and the distance. All three
end within 0.04 of CIEDE2000, where no eye tells them apart. Bottom: the spectra, and the thicknesses; on the way to
gold the first layer has gone (0.3 nm)."""
SIZE = (9.0, 6.0)
TARGETS = {"teal": (0.02, 0.30, 0.32), "gold": (0.45, 0.25, 0.02), "blue": (0.08, 0.08, 0.40)}
LAYERS = ("TiO2-film", "fused silica", "TiO2-film", "fused silica", "TiO2-film")
START_NM = (10.0, 110.0, 40.0, 65.0, 40.0)


def compute(steps: int = 300, rate_nm: float = 1.0) -> dict:
    wavelength = np.arange(380.0, 781.0, 10.0)
    n, k = films.stack(*(material(name)(wavelength) for name in LAYERS))
    inside, matrix = tuple(jnp.asarray(part) for part in material("Cr")(wavelength)), colour.rgb_matrix(wavelength)

    def spectrum(d):
        return films.film(1.0, wavelength, n, k, d, 1.0, inside).R

    def squared(d, target):
        rgb = spectrum(d) @ matrix
        return jnp.sum((colour.rgb_to_lab(rgb) - target) ** 2), rgb

    def descend(target):
        def step(state, i):
            d, mean, square = state
            (value, rgb), slope = jax.value_and_grad(squared, has_aux=True)(d, target)
            mean, square = 0.9 * mean + 0.1 * slope, 0.99 * square + 0.01 * slope**2  # Adam, its rate falling to 0
            move = (mean / (1 - 0.9**i)) / (jnp.sqrt(square / (1 - 0.99**i)) + 1e-8)
            rate = 0.5 * rate_nm * (1 + jnp.cos(jnp.pi * i / steps))
            return (jnp.maximum(d - rate * move, 0.0), mean, square), (rgb, jnp.sqrt(value))

        start = jnp.asarray(START_NM)
        (d, *_), (rgb, distance) = jax.lax.scan(step, (start, 0 * start, 0 * start), jnp.arange(1.0, steps + 1))
        return d, spectrum(d), rgb, distance

    targets = jnp.asarray(list(TARGETS.values()))
    thickness, spectra, rgb, distance = jax.jit(jax.vmap(descend))(colour.rgb_to_lab(targets))
    return {
        "names": np.array(list(TARGETS)),
        "targets": targets,
        "wavelength_nm": wavelength,
        "start_nm": np.array(START_NM),
        "start": jax.jit(spectrum)(jnp.asarray(START_NM)),
        "thickness_nm": thickness,
        "spectra": spectra,
        "rgb": rgb,
        "distance": distance,
        "ciede2000": colour.colour_difference(spectra @ matrix, targets),
    }


def draw(data: dict, fig) -> None:
    (top, far), (below, sizes) = fig.subplots(2, 2)
    colors, lines = (plot.GREEN, plot.ORANGE, plot.BLUE), ("-", "--", "-.")
    names, steps = list(data["names"]), np.asarray(data["rgb"]).shape[1]
    ends = np.repeat(np.asarray(data["targets"])[:, None], steps // 6, axis=1)
    rows = np.concatenate([np.asarray(data["rgb"]), ends], axis=1)
    plot.strip(colour.to_gamut(rows), (0, rows.shape[1]), ax=top, title="colour at each step, and the target")
    plot.mark(top, x=steps, color="white")
    plot.labels(top, xticks=[0, 100, 200, 300], yticks=dict(zip((5 / 6, 0.5, 1 / 6), names, strict=True)))
    plot.labels(top, xlabel="step")
    for name, distance, r, color, line in zip(names, data["distance"], data["spectra"], colors, lines, strict=True):
        plot.cartesian(np.arange(steps), distance, ax=far, label=name, color=color, linestyle=line)
        plot.cartesian(data["wavelength_nm"], r, ax=below, label=name, color=color, linestyle=line)
    plot.labels(far, xlabel="step", ylabel="distance in CIE Lab", yscale="log", legend="lower left")
    plot.cartesian(data["wavelength_nm"], data["start"], ax=below, label="start", color=plot.GREY, linestyle=":")
    plot.labels(below, xlabel="wavelength (nm)", ylabel="reflectance R", ylim=(0, 1), xlim=(380, 780))
    plot.legend(below, loc="upper center", ncols=4)
    groups = {"start": (data["start_nm"], plot.GREY)}
    groups |= {name: (d, c) for name, d, c in zip(names, data["thickness_nm"], colors, strict=True)}
    for i, (d, color) in enumerate(groups.values()):
        plot.bars(sizes, np.arange(5) + 0.2 * (i - 1.5), d, 0.18, color=color)
    plot.labels(sizes, ylabel="thickness (nm)", xlabel="layer, from the outside in")
    plot.labels(sizes, xticks=dict(enumerate(["TiO$_2$", "SiO$_2$"] * 2 + ["TiO$_2$"])))
