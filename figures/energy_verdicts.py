"""Does it conserve energy, is it reciprocal: every model of the catalog."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot
from jaxrefl.catalog import white

CAPTION = """Verdicts on every model of the catalog where its parameters absorb nothing. Left: the largest directional
albedo, seen or lit from 0° to 90° in steps of 1°. Above 1 light is created: Oren-Nayar by 0.5 %, rough Burley by 55.8
%, D3D9 (6) by 100 %; of Minnaert's model (k = 0.8) and of the literal highlights (n = 10) there is no largest albedo,
it grows without bound to 90°. Right: the largest ratio of f with light and view exchanged, for angles up to 89°: the
literal highlights and D3D9 (8) are not reciprocal, all the others are to the last digits."""
SIZE = (9.6, 5.0)


def compute(angle_deg: float = 89.0, exponent: float = 10.0, k: float = 0.8, sigma: float = 0.3) -> dict:
    models = white(sigma, exponent, k)
    theta, mu = plot.angles(91)
    ratio = largest_ratios(models, angle_deg)
    viewed = {name: estimate.value for name, estimate in plot.albedos(models).items()}
    one_way = {name: model for name, model in models.items() if ratio[name] > 1 + 1e-9}
    lit = viewed | {name: estimate.value for name, estimate in plot.albedos(one_way, fixed="light").items()}
    through = {"slab": np.asarray(jax.vmap(models["slab"].through)(mu))}
    largest = np.stack([np.maximum(viewed[name], lit[name]) + through.get(name, 0.0) for name in models])
    return {
        "model": np.array(list(models)),
        "theta_deg": theta,
        "viewed": np.stack(list(viewed.values())),
        "lit": np.stack(list(lit.values())),
        "largest": largest.max(axis=1),
        "largest_deg": theta[largest.argmax(axis=1)],
        "ratio": np.array([ratio[name] for name in models]),
    }


def largest_ratios(models: dict, angle_deg: float) -> dict:
    """Largest f(wi, wo) / f(wo, wi) over angles up to ``angle_deg`` and azimuths, where there is any light at all."""
    theta = np.deg2rad(np.linspace(0, angle_deg, 24))
    i, o, phi = (x.ravel() for x in np.meshgrid(theta, theta, np.linspace(0, np.pi, 13)))
    a, b = (Vec3(np.sin(x) * np.cos(p), np.sin(x) * np.sin(p), np.cos(x)) for x, p in ((i, 0 * phi), (o, phi)))

    @jax.jit
    def ratios(models):
        both = {name: (jax.vmap(model)(a, b), jax.vmap(model)(b, a)) for name, model in models.items()}
        return {
            name: jnp.where(back > 0, there / jnp.where(back > 0, back, 1.0), 1.0).max()
            for name, (there, back) in both.items()
        }

    return {name: float(ratio) for name, ratio in ratios(models).items()}


def draw(data: dict, fig) -> None:
    energy, reciprocity = fig.subplots(1, 2, width_ratios=(1.3, 1))
    largest, ratio = data["largest"], data["ratio"]
    creates, differs = largest > 1 + 1e-9, ratio > 1 + 1e-9
    grows = creates & np.isin(data["largest_deg"], [89.0])
    texts = [
        f"{'over ' if more else ''}{value:.4g} at {angle:.0f}°" if bad else f"{value:.3g}"
        for value, angle, bad, more in zip(largest, data["largest_deg"], creates, grows, strict=True)
    ]
    colors = [plot.RED if bad else plot.BLUE for bad in creates]
    plot.rows(energy, list(data["model"]), largest, base=1, colors=colors, texts=texts, xlim=(0, 4.3))
    plot.labels(energy, title="energy: the largest directional albedo", xlabel="light out / light in")
    colors = [plot.RED if bad else plot.BLUE for bad in differs]
    texts = [f"{value:.3g}" if bad else "" for value, bad in zip(ratio, differs, strict=True)]
    plot.rows(reciprocity, [""] * len(ratio), ratio, base=1, colors=colors, texts=texts, xlim=(0.8, 300), log=True)
    plot.labels(reciprocity, title="reciprocity: the largest ratio", xlabel="f(i → o) / f(o → i)")
