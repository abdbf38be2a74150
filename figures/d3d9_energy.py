"""What the D3D9 equations do to energy, in a white furnace."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import d3d9, fresnel, plot, quadrature

CAPTION = """This formula doubles the light. A white surface (d = 1) in a uniform white environment should show just 1.
D3D9 (6) shows 1 + R (1 - λ): 4 % too much at normal incidence, 8.57 % on average over the hemisphere and twice the
light at grazing, for λ = 0, n = 1.5. Read with the Euclidean norm (dotted) it loses light at normal incidence, more
the more metallic the surface: 0.345 is left for λ = 0.9. (8) sends out just what the sun brings in, for every sun
angle, but seen from one direction it shows between 0.954 and 1.914: the formula is not reciprocal, by a factor of 11.9
between 0° and 89°."""
SIZE = (9.6, 3.8)


def compute(eta: float = 1.5, p: float = 5.0, metallic: tuple[float, ...] = (0.0, 0.3, 0.6, 0.9)) -> dict:
    r0 = float(fresnel.f0_dielectric(eta))
    theta, mu = plot.angles(361)
    rule = quadrature.cosine_rule(64)

    def reflectance(cos_theta):
        return fresnel.d3d9(cos_theta, r0, 1 - r0, p)

    def furnace(lam, cos_theta):
        """Shown by a white surface under a uniform white light: (6) with either norm, (8) from and to one direction."""
        grey = jnp.full(3, lam)
        total = d3d9.total_reflection(grey, reflectance(cos_theta))

        def shown(norm, sun_reflectance=0.0):
            return d3d9.pixel(jnp.ones(3), norm, total, sun_reflectance)[0]

        largest, length = d3d9.max_norm(grey), d3d9.euclidean_norm(grey)
        viewed = quadrature.integrate(lambda cos_sun: shown(largest, reflectance(cos_sun)), rule)
        return shown(largest), shown(length), viewed, shown(largest, reflectance(cos_theta))

    eq6, eq6_length, eq8_viewed, eq8_sent = jax.jit(jax.vmap(jax.vmap(furnace, (None, 0)), (0, None)))(
        jnp.asarray(metallic), mu
    )
    average6 = jax.jit(quadrature.integrate, static_argnums=0)(
        lambda cos_theta: furnace(metallic[0], cos_theta)[0], rule
    )

    def ratio(sun, view):
        """f(sun -> view) / f(view -> sun) of the diffuse part of (8)."""
        return (1 - reflectance(jnp.cos(jnp.deg2rad(sun)))) / (1 - reflectance(jnp.cos(jnp.deg2rad(view))))

    return {
        "theta_deg": theta,
        "metallic": np.array(metallic),
        "eq6": eq6,
        "eq6_euclidean": eq6_length,
        "eq8_viewed": eq8_viewed,
        "eq8_sent": eq8_sent,
        "eq6_average": average6,
        "reciprocity_ratio": jax.vmap(ratio, (None, 0))(0.0, jnp.asarray(theta[:-4])),
        "ratio_0_89": ratio(0.0, 89.0),
    }


def draw(data: dict, fig) -> None:
    left, middle, right = fig.subplots(1, 3)
    theta = data["theta_deg"]
    text = {"xlabel": plot.ANGLE, "xlim": (0, 90)}
    labels = [f"λ = {value:g}" for value in data["metallic"]]
    for label, curve, other in zip(labels, data["eq6"], data["eq6_euclidean"], strict=True):
        (line,) = plot.cartesian(theta, curve, ax=left, label=label)
        plot.cartesian(theta, other, ax=left, color=line.get_color(), linestyle=":")
    plot.mark(left, y=1, text="conserving", side="below", at=0.4)
    plot.cartesian([], [], ax=left, label="Euclidean |λ|", color=plot.GREY, linestyle=":")
    plot.labels(left, title="(6): light is added", ylabel="light out / light in", ylim=(0, 2.05), **text)
    plot.legend(left, loc="upper left")
    for label, viewed, sent in zip(labels, data["eq8_viewed"], data["eq8_sent"], strict=True):
        (line,) = plot.cartesian(theta, viewed, ax=middle, label=label)
        plot.cartesian(theta, sent, ax=middle, color=line.get_color(), linestyle="--")
    plot.cartesian([], [], ax=middle, label="sent out, by sun angle", color=plot.GREY, linestyle="--")
    plot.labels(middle, title="(8): right in sum, wrong in view", ylim=(0, 2.05), legend="upper left", **text)
    plot.cartesian(
        theta[:-4],
        data["reciprocity_ratio"],
        ax=right,
        color=plot.RED,
        title="(8): not reciprocal",
        xlabel="angle θ (degrees)",
        ylabel="f(0° → θ) / f(θ → 0°)",
        xlim=(0, 90),
        yscale="log",
    )
    plot.mark(right, y=1, text="reciprocal", at=0.5)
    plot.mark(right, y=float(data["ratio_0_89"]), text="{:.1f} between 0° and 89°", side="below", at=0.9)
