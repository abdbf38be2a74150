"""D3D9 (6) and (8) beside the form that conserves energy and is reciprocal."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, brdf, plot

CAPTION = """The D3D9 equations and their repair, white (d = 1, n = 1.5). (6) does not dim the diffuse base under the
Fresnel layer: it shows and sends up to twice the light. (8) dims it by 1 - R of the light: what leaves a beam is then
exactly 1, but seen in a uniform environment the surface shows 0.954 to 1.914, and f is not reciprocal, by 11.9 between
0° and 89°. With the base between both factors, f = d (1 - λ)(1 - R_i)(1 - R_o) / (π (1 - <R>)), albedos and ratio are
exactly 1, at every angle, for every λ."""
SIZE = (10.4, 3.8)


def compute(r0: float = 0.04, m: float = 0.96, p: float = 5.0, metallic: float = 0.5) -> dict:
    theta, mu = plot.angles(91)
    models = {}
    for key, value in (("", 0.0), ("_metallic", metallic)):
        shared = {"metallic": value, "r0": r0, "m": m, "p": p}
        models[f"eq6{key}"] = brdf.D3D9(**shared)
        models[f"eq8{key}"] = brdf.D3D9(**shared, sun_fresnel=True)
        models[f"repaired{key}"] = brdf.D3D9Repaired(**shared)
    found = {"theta_deg": theta, "metallic": metallic}
    for fixed in ("view", "light"):
        found |= {f"{name}_by_{fixed}": e.value for name, e in plot.albedos(models, fixed=fixed).items()}

    def ratio(model, sine, cosine):
        above, here = Vec3(0.0 * cosine, 0.0 * cosine, 1.0 + 0.0 * cosine), Vec3(sine, 0.0 * cosine, cosine)
        return model(above, here) / model(here, above)

    at = jnp.asarray(mu[:-1]), jnp.sqrt(1 - jnp.asarray(mu[:-1]) ** 2)
    for name in ("eq6", "eq8", "repaired"):
        found[f"{name}_ratio"] = np.asarray(jax.vmap(lambda c, s, x=models[name]: ratio(x, s, c))(*at))
    return found


def draw(data: dict, fig) -> None:
    axes = fig.subplots(1, 3)
    theta, metal = data["theta_deg"], f"λ = {float(data['metallic']):g}"
    kinds = {"repaired": ("repaired", plot.GREEN), "eq6": ("(6)", plot.RED), "eq8": ("(8)", plot.BLUE)}
    for ax, fixed in zip(axes, ("view", "light"), strict=False):
        for name, (label, color) in kinds.items():
            width = {"linewidth": 4} if name == "repaired" else {}
            plot.albedo(data[f"{name}_by_{fixed}"], theta, ax=ax, label=label, color=color, **width)
            plot.albedo(data[f"{name}_metallic_by_{fixed}"], theta, ax=ax, color=color, linestyle="--")
        plot.cartesian([], [], ax=ax, label=f"dashed: {metal}", color=plot.GREY, linestyle="--")
        plot.labels(ax, ylim=(0, 2.05))
    plot.labels(axes[0], title="seen in a uniform environment", xlabel="angle of view θ (degrees)", legend="lower left")
    plot.labels(axes[1], title="sent out of a beam", xlabel="angle of light θ (degrees)")
    for name, (label, color) in kinds.items():
        width = {"linewidth": 4} if name == "repaired" else {}
        plot.cartesian(theta[:-1], data[f"{name}_ratio"], ax=axes[2], label=label, color=color, **width)
    last = data["eq8_ratio"][-1]
    plot.mark(axes[2], y=float(last), text="{:.1f} at 89°", side="below", at=0.9)
    plot.labels(axes[2], title="reciprocity", xlabel="angle θ (degrees)", ylabel="f(0° → θ) / f(θ → 0°)", yscale="log")
    plot.labels(axes[2], xlim=(0, 90), legend="center left")
