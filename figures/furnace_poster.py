"""White furnace: one sphere per model, and a perfect one vanishes."""

import jax
import numpy as np

from jaxrefl import plot
from jaxrefl.catalog import white

CAPTION = """Every sphere you can see is an energy error. Each stands in a furnace that sends the same light from
everywhere, and its parameters absorb nothing, so that it should look like the furnace; what it does not is red where
light is created and blue where it is lost, with the range in percent. Lambert, EON, the coated Lambert, the clear slab
(R and T) and the repaired D3D9 vanish. Oren-Nayar loses 10.7 % in the middle and gains 0.4 % at the rim, D3D9 (6) gains
4 % to 91.9 %, and the highlights lose what they send below the horizon. Numbers are for 0° to 89°. The pixel at offset
s shows the albedo at cos θ = sqrt(1 - s²): no ray is traced."""
SIZE = (8.4, 9.4)


def compute(sigma: float = 0.3, exponent: float = 10.0, k: float = 0.8) -> dict:
    models = white(sigma, exponent, k)
    theta, mu = plot.angles(91)
    albedo = {name: estimate.value for name, estimate in plot.albedos(models).items()}
    albedo["slab"] = albedo["slab"] + np.asarray(jax.vmap(models["slab"].through)(mu))
    seen = np.stack(list(albedo.values()))
    percent = 100 * (seen[:, theta <= 89] - 1)
    return {
        "model": np.array(list(albedo)),
        "albedo": seen,
        "lowest": percent.min(axis=1),
        "highest": percent.max(axis=1),
    }


def percent(low: float, high: float) -> str:
    ends = ["0" if abs(x) < 0.05 else f"{x:+.1f}".replace("-", "−") for x in (low, high)]
    return f"{' to '.join(dict.fromkeys(ends))} %"


def draw(data: dict, fig) -> None:
    axes = fig.subplots(4, 4).ravel()
    for i, (ax, name) in enumerate(zip(axes, data["model"], strict=True)):
        low, high = (float(data[key][i]) for key in ("lowest", "highest"))
        artist = plot.furnace(data["albedo"][i], ax=ax, title=f"{name}\n{percent(low, high)}", bar=False)
    plot.shared_bar(artist, axes, "light gained or lost (%)", shrink=0.6)
