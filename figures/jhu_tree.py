"""The attenuation example of the JHU lecture, and the tree it grows into with transmission."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import plot, series

CAPTION = """JHU, "Attenuation": I = 0.6 + 0.5 (0.3 + 0.2 · 0.8) = 0.83, with the derivatives 0.46 and 0.4 in the two
reflection coefficients; the three hits weigh 1, 0.5 and 0.1. (PERRIN's convex rule makes 0.5 of the same numbers.)
Middle: in a tree of reflected (blue) and transmitted (orange) rays the weights of a level sum to a power of
k_rg + k_tg, 0.8, 0.64, 0.512. Right: sums over the levels of a tree whose every hit shows 0.1. With k_rg + k_tg = 0.8
they converge to 0.5; with 1, a lossless surface, every level adds another 0.1; with 1.1 they explode, to 18.2 at
depth 30."""
SIZE = (10.4, 3.6)


def compute(
    local: tuple[float, ...] = (0.6, 0.3, 0.8), reflected: tuple[float, ...] = (0.5, 0.2, 0.0), depth: int = 30
) -> dict:
    shown, k = jnp.asarray(local), jnp.asarray(reflected)

    def additive(shown, k):
        return series.iterative(series.additive(shown, k))

    total = additive(shown, k)
    d_local, d_k = jax.grad(lambda s, k: additive(s, k).radiance, (0, 1))(shown, k)
    levels = [np.ones(1)]
    cases = {"converging": (0.1, 0.3, 0.5), "conserving": (0.1, 0.04, 0.96), "exploding": (0.1, 0.6, 0.5)}
    for _ in range(3):
        levels.append(np.outer(levels[-1], cases["converging"][1:]).ravel())
    return {
        "example_k": np.array(cases["converging"][1:]),
        "level_weights": np.concatenate(levels),
        "level_sums": np.array([level.sum() for level in levels]),
        "k": np.array([sum(case[1:]) for case in cases.values()]),
        "local": shown,
        "reflected": k,
        "total": total.radiance,
        "weights": total.weights,
        "partial": total.partial,
        "d_local": d_local,
        "d_reflected": d_k,
        "convex": series.iterative(series.convex(shown, k)).radiance,
        "depth": np.arange(depth + 1),
        **{name: series.tree(*case, depth).partial for name, case in cases.items()},
        "limit": series.periodic_limit(series.additive([cases["converging"][0]], [sum(cases["converging"][1:])]))[()],
    }


def draw(data: dict, fig) -> None:
    chain, branches, sums = fig.subplots(1, 3, width_ratios=(1.25, 1.1, 1))
    local, k, weights = (np.asarray(data[key]) for key in ("local", "reflected", "weights"))
    n, radius, small = len(local), 0.2, {"fontsize": "small"}
    plot.canvas(chain, (-0.75, n - 0.3), (-1.3, 1.25), f"attenuation: I = {float(data['total']):.2f}")
    plot.note(chain, (-0.55, 1.0), "eye", **small)
    plot.arrow(chain, (-0.12, 0.17), (-0.5, 0.85))
    for i in range(n):
        if i + 1 < n:
            slope = float(data["d_reflected"][i])
            plot.arrow(chain, (i + 1 - radius, 0.0), (i + radius, 0.0), color=plot.BLUE)
            text = f"$k_{{r{i + 1}}}$ = {k[i]:g}\n" + rf"$\partial I/\partial k$ = {slope:.2f}"
            plot.note(chain, (i + 0.5, 0.42), text, color=plot.BLUE, **small)
        plot.dot(chain, (i, 0.0), radius, f"{local[i]:g}")
        plot.note(chain, (i, -0.42), rf"$I_{{\mathrm{{local}}{i + 1}}}$", **small)
        plot.note(chain, (i, -0.88), f"weight {weights[i]:g}\nadds {weights[i] * local[i]:.2f}", **small)

    (k_r, k_t), level_sums = data["example_k"], data["level_sums"]
    plot.canvas(branches, (-4.6, 7.0), (-6.6, 1.0), f"tree, $k_{{rg}}$ = {k_r:g}, $k_{{tg}}$ = {k_t:g}")
    weight = iter(np.asarray(data["level_weights"]))
    for level, total in enumerate(level_sums):
        spread = 4.4 / 2.0 ** (level - 1)
        for place in range(2**level):
            x, y = spread * (place - (2**level - 1) / 2), -2.0 * level
            if level:
                parent = 2 * spread * (place // 2 - (2 ** (level - 1) - 1) / 2)
                plot.segment(branches, (parent, y + 2), (x, y), plot.ORANGE if place % 2 else plot.BLUE)
            plot.dot(branches, (x, y), 0.52, f"{next(weight):.3g}".lstrip("0"), plot.GREEN)
        plot.note(branches, (6.0, y), f"sum {total:.3g}", **small)

    for name, color, k in zip(
        ("converging", "conserving", "exploding"), (plot.GREEN, plot.BLUE, plot.RED), data["k"], strict=True
    ):
        plot.cartesian(data["depth"], data[name], ax=sums, color=color, marker="o", markersize=2.5, label=f"{k:.2g}")
    plot.mark(sums, y=float(data["limit"]), text="limit {:g}", at=0.97)
    text = {"xlabel": "depth of the tree", "ylabel": "intensity I", "title": r"sums, by $k_{rg}+k_{tg}$"}
    plot.labels(sums, yscale="log", ylim=(0.08, 40), legend="upper left", **text)
