"""Why pi: the integral of the cosine over the hemisphere, by every rule."""

import functools

import jax
import numpy as np

from jaxrefl import plot, quadrature

CAPTION = """The pi of f = ρ/π is the integral of cos θ over the hemisphere. Gauss-Legendre in cos θ is exact from its
first node on (errors of 0 are drawn at 1e-17); in the angle, on π sin 2θ, it converges exponentially and is down to
rounding with 10 nodes; the midpoint rule falls as n^-2, Simpson's as n^-4, and Monte Carlo stays near its sigma,
1/sqrt(3 n): a million samples give three digits."""
SIZE = (7.2, 4.4)


def compute(seed: int = 0, repetitions: int = 16) -> dict:
    one_d = {"midpoint": quadrature.midpoint, "simpson": quadrature.simpson, "gauss_theta": quadrature.gauss_legendre}
    counts = {
        "gauss_cos": np.array([1, 2, 4, 16, 64]),
        "gauss_theta": np.array([1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 32, 64]),
        "simpson": 2 ** np.arange(1, 14, 2),
        "midpoint": 2 ** np.arange(0, 15, 2),
        "monte_carlo": 2 ** np.arange(2, 21, 3),
    }

    integral, integral_1d = jax.jit(quadrature.cosine_integral), jax.jit(quadrature.cosine_integral_1d)

    def error(value):
        return abs(float(value) - np.pi) / np.pi

    @functools.partial(jax.jit, static_argnums=0)
    def estimates(n, keys):
        return jax.lax.map(lambda key: quadrature.cosine_integral_mc(key, n), keys)

    def monte_carlo(n):
        """Root-mean-square error of several independent estimates, and their mean sigma."""
        keys = jax.random.split(jax.random.fold_in(jax.random.key(seed), n), repetitions)
        value, sigma = estimates(n, keys)
        return np.sqrt(np.mean((np.asarray(value) / np.pi - 1) ** 2)), np.mean(sigma) / np.pi

    errors = {"gauss_cos": [error(integral(quadrature.hemisphere_rule(int(n), 1))) for n in counts["gauss_cos"]]}
    for name, rule in one_d.items():
        errors[name] = [error(integral_1d(rule(int(n)))) for n in counts[name]]
    sampled = [monte_carlo(int(n)) for n in counts["monte_carlo"]]
    errors["monte_carlo"] = [rms for rms, _ in sampled]
    return {
        **{f"n_{name}": n for name, n in counts.items()},
        **{f"error_{name}": np.array(e) for name, e in errors.items()},
        "sigma_monte_carlo": np.array([sigma for _, sigma in sampled]),
    }


def draw(data: dict, fig) -> None:
    ax = fig.subplots()
    labels = {
        "midpoint": "midpoint in θ",
        "simpson": "Simpson in θ",
        "gauss_theta": "Gauss-Legendre in θ",
        "gauss_cos": "Gauss-Legendre in cos θ",
        "monte_carlo": "Monte Carlo (rms)",
    }
    n = {label: data[f"n_{name}"] for name, label in labels.items()}
    error = {label: data[f"error_{name}"] for name, label in labels.items()}
    plot.convergence(n, error, ax=ax, ylabel="relative error of π", legend=False)
    counts = data["n_monte_carlo"]
    plot.cartesian(counts, 1 / np.sqrt(3 * counts), ax=ax, color=plot.GREY, linestyle=":", label=r"$1/\sqrt{3n}$")
    plot.mark(ax, y=2.0**-52, text="float64 epsilon", at=0.99)
    plot.legend(ax, loc="center right")
