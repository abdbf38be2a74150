"""How fast the rules on the hemisphere converge, and what they say of their own error."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, brdf, plot, quadrature
from jaxrefl.albedo import directional_albedo
from jaxrefl.chart import albedo_rule

CAPTION = """Error of the directional albedo at 60° against the evaluations of the model: solid the true one, from
closed forms, dashed what the rule says itself. The double exponential rules (normal, mirror, half) about double their
digits with every level where the chart has what is peculiar to the model on the edges of its panels: Oren-Nayar's kinks
in the normal chart alone, Minnaert's end-point power in all of them. The product rule, exact for polynomials, is the
fastest for Lommel-Seeliger and for a lobe of whole exponent (n = 100), and falls as a power of the count for kinks and
end-point powers; Monte Carlo falls as n^-1/2, quasi-Monte Carlo faster. In the model's own chart what a rule says is
never below its error, at any level; in a chart that cuts across kinks it can be."""
SIZE = (9.8, 8.0)
LABELS = {"monte_carlo": "Monte Carlo", "quasi_monte_carlo": "quasi-Monte Carlo"}
CHARTS = {"normal": (1, 2, 3, 4), "mirror": (1, 2, 3, 4), "half": (1, 2, 3, 4), "product": (0, 1, 2, 3, 4, 5)}


def modified_phong(n: float, mu: float) -> float:
    """Albedo for k_s = 1: a beta function times an integral over a lune, both by one-dimensional Gauss-Legendre."""
    node, weight = (np.asarray(x) for x in quadrature.gauss_legendre(400))
    theta, width = np.arccos(mu), np.pi - np.arccos(mu)
    angle = theta - 0.5 * np.pi + width * node
    lune = width * np.sum(weight * np.cos(angle) ** n * np.cos(angle - theta))
    beta = np.pi * np.sum(weight * np.cos(0.5 * np.pi * node) ** (n + 2))
    return float((n + 2) / (2 * np.pi) * beta * lune)


def oren_nayar(sigma: float, mu: float) -> float:
    s2, sine, theta = sigma**2, np.sqrt(1 - mu * mu), np.arccos(mu)
    g = sine * (theta - sine * mu) + 2 / 3 * sine / mu * (1 - sine**3)
    return 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) * g / np.pi


def compute(
    angle_deg: float = 60.0, n: float = 100.0, sigma: float = 0.5, k: float = 0.3, seed: int = 0, repetitions: int = 8
) -> dict:
    mu = float(np.sin(np.deg2rad(90 - angle_deg)))
    models = [brdf.OrenNayar(1.0, sigma), brdf.ModifiedPhong(1.0, n), brdf.Minnaert(1.0, k), brdf.LommelSeeliger(1.0)]
    exact = [oren_nayar(sigma, mu), modified_phong(n, mu), mu ** (k - 1), 0.5 * (1 - mu * np.log1p(1 / mu))]
    names = [f"Oren-Nayar, σ = {sigma:g}", f"modified Phong, n = {n:g}", f"Minnaert, k = {k:g}", "Lommel-Seeliger"]
    data = {"model": np.array(names), "exact": np.array(exact), "angle_deg": angle_deg}

    def all_models(wi, wo):
        return jnp.stack([model(wi, wo) for model in models])

    def keep(name, counts, value, error):
        data[f"n_{name}"] = np.array(counts)
        data[f"true_{name}"] = np.sqrt(np.mean((np.asarray(value) / data["exact"] - 1) ** 2, axis=1)).T
        data[f"stated_{name}"] = (np.asarray(error) / data["exact"]).mean(axis=1).T

    run = jax.jit(lambda rules: jax.lax.map(lambda rule: directional_albedo(all_models, mu, rule), rules))
    for chart, levels in CHARTS.items():
        rules = [albedo_rule(chart, level) for level in levels]
        found = run(_stacked(rules))
        keep(chart, [rule.evaluations for rule in rules], found.value[:, None], found.error[:, None])

    wo = Vec3(np.sqrt(1 - mu * mu), 0.0, mu)
    counts = [2**i for i in (7, 12, 17)]
    for name, rule in (("monte_carlo", quadrature.monte_carlo), ("quasi_monte_carlo", quadrature.quasi_monte_carlo)):
        found = []
        for count in counts:
            keys = jax.random.split(jax.random.fold_in(jax.random.key(seed), count), repetitions)
            one = jax.jit(
                lambda keys, rule=rule, count=count: jax.lax.map(
                    lambda key: rule(lambda wi: all_models(wi, wo) * wi.z, key, count), keys
                )
            )
            found.append(one(keys))
        keep(name, counts, [e.value for e in found], [e.error for e in found])
    return data


def _stacked(rules):
    """Rules of one chart as one pytree, each filled up with nodes of no weight: one program for all of them."""
    size = max(rule.evaluations for rule in rules)

    def filled(rule):
        columns = jax.tree.map(lambda x: np.resize(np.asarray(x), size), rule)
        inside = np.arange(size) < rule.evaluations
        names = [name for name in ("weight", "coarse", "coarsest") if hasattr(columns, name)]
        weights = {name: np.where(inside, getattr(columns, name), 0.0) for name in names}
        return dataclasses.replace(columns, **weights, level=0)

    return jax.tree.map(lambda *x: jnp.stack(x), *map(filled, rules))


def draw(data: dict, fig) -> None:
    kinds = {
        "normal": (plot.BLUE, "o"),
        "mirror": (plot.RED, "s"),
        "half": (plot.GREEN, "D"),
        "product": (plot.PINK, "^"),
        "monte_carlo": (plot.ORANGE, "v"),
        "quasi_monte_carlo": (plot.SKY, "P"),
    }
    for i, ax in enumerate(fig.subplots(2, 2).ravel()):
        for name, (color, marker) in kinds.items():
            line = {"ax": ax, "color": color, "marker": marker}
            label = {LABELS.get(name, name): data[f"true_{name}"][i]}
            plot.convergence(data[f"n_{name}"], label, legend=False, **line)
            line |= {"linestyle": "--", "markersize": 2.5, "linewidth": 0.9}
            plot.convergence(data[f"n_{name}"], data[f"stated_{name}"][i], **line)
        plot.labels(ax, title=str(data["model"][i]), xlabel="evaluations of the model", ylim=(1e-17, 100))
        plot.mark(ax, y=2.0**-52)
        if i == 1:
            plot.cartesian([], [], ax=ax, label="what it says", color=plot.GREY, linestyle="--")
            plot.legend(ax, loc="lower left")
