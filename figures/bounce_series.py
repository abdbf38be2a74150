"""PERRIN's bounce series: partial sums, weights, the two tails and the bound."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import plot, series

CAPTION = """The bounce series (5) between two facing mirrors, α = 0.9 and 0.8, colours 0.3 and 0.7. Truncation (tail 0)
rises to the limit 0.5571 from below, and setting the last α to 0 reaches it from both sides: 0.4551 and 0.5074 after
10 bounces. Middle: the weights (1 - α_i) ∏ α_k, what remains, and the error, which stays under the bound
α_max^(N+1) c_max; the bound falls below 1/255 at 49 bounces. Right: the derivative of the pixel in each α decays
with the weight: what hides behind weak mirrors has no gradient."""
SIZE = (9.6, 3.7)


def compute(
    alpha: tuple[float, ...] = (0.9, 0.8),
    color: tuple[float, ...] = (0.3, 0.7),
    bounces: int = 60,
    epsilon: float = 1 / 255,
) -> dict:
    n = bounces + 1
    a, c = (jnp.asarray(np.resize(np.asarray(x), n)) for x in (alpha, color))
    truncated = series.iterative(series.convex(c, a))

    def folded(last):
        keep = jnp.where(jnp.arange(n) < last, a, 0.0)
        return series.iterative(series.convex(c, keep)).radiance

    limit = series.periodic_limit(series.convex(np.asarray(color), np.asarray(alpha)))
    long_a, long_c = (jnp.asarray(np.resize(np.asarray(x), 8 * n)) for x in (alpha, color))
    slope = jax.grad(lambda a: series.iterative(series.convex(long_c, a)).radiance)(long_a)[:n]
    remainder = jnp.cumprod(a)
    return {
        "bounces": np.arange(n),
        "truncated": truncated.partial,
        "folded": jax.vmap(folded)(jnp.arange(n)),
        "limit": limit,
        "weights": truncated.weights,
        "remainder": remainder,
        "bound": series.truncation_bound(np.arange(n), max(alpha), max(color)),
        "slope": slope,
        "bounces_needed": series.bounces_needed(epsilon, max(alpha), max(color)),
        "weights_and_remainder": truncated.weights.sum() + truncated.remainder,
        "epsilon": epsilon,
    }


def draw(data: dict, fig) -> None:
    left, middle, right = fig.subplots(1, 3)
    n = data["bounces"]
    dots = {"marker": "o", "markersize": 3, "linewidth": 0.8}
    few = n <= 20
    plot.cartesian(n[few], data["truncated"][few], ax=left, label="tail 0", color=plot.BLUE, **dots)
    plot.cartesian(n[few], data["folded"][few], ax=left, label=r"last $\alpha$ := 0", color=plot.RED, **dots)
    plot.cartesian([], [], ax=left, label=f"limit {float(data['limit']):.4f}", color=plot.GREY, linestyle=":")
    text = {"xlabel": "number of bounces N"}
    plot.labels(left, ylabel="pixel colour $c_b$", title="partial sums", legend="lower right", **text)
    plot.mark(left, y=float(data["limit"]))
    error = np.abs(np.asarray(data["truncated"] - data["limit"]))
    curves = {
        "weight of hit N": data["weights"],
        "remainder": data["remainder"],
        "error, tail 0": error,
        "bound": data["bound"],
    }
    styles = ((plot.GREEN, "-"), (plot.PINK, "--"), (plot.BLUE, "-"), (plot.GREY, ":"))
    for (label, curve), (color, line) in zip(curves.items(), styles, strict=True):
        plot.cartesian(n, curve, ax=middle, label=label, color=color, linestyle=line)
    plot.labels(
        middle, ylabel="weight; error of $c_b$", yscale="log", title="weights, error and bound", legend=True, **text
    )
    plot.mark(middle, y=data["epsilon"], text="1/255", side="below", at=0.12)
    plot.mark(middle, x=data["bounces_needed"], text="{:.0f} bounces", side="left")
    plot.cartesian(
        n, np.abs(data["slope"]), ax=right, color=plot.ORANGE, label=r"$|\partial c_b/\partial\alpha_i|$", **dots
    )
    plot.cartesian(n, data["weights"], ax=right, color=plot.GREEN, label=r"$\partial c_b/\partial c_i$", **dots)
    plot.labels(right, yscale="log", xlabel="hit i", ylabel="derivative of the pixel", title="gradients")
    plot.legend(right, loc="upper right")
