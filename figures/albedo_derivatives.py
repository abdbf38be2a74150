"""What a parameter does to the albedo: derivatives of the integrals, and of the closed forms."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import brdf, fresnel, plot, quadrature
from jaxrefl.albedo import directional_albedo, rule_for
from jaxrefl.tabulate import replaced

CAPTION = """Derivatives of directional albedos by their parameters. Lines: automatic differentiation of the integral
over the hemisphere; dots: of the closed form, which agrees to 1e-9 (for modified Phong it is a one-dimensional
integral; Blinn-Phong's is known at 0° alone, where the albedo is 1 for every n and the derivative 0). A larger n takes
light from both highlights at all other angles. A rougher facet takes from Oren-Nayar at 0° and, at σ = 0.2, hardly
anything at 90°, where the albedo is largest. A denser coat reflects more, but shuts more in: the albedo with ρ = 0.5
falls, by 0.203 per unit of η at 1°. White EON (ρ = 1) answers to ρ by more than 1, 1.27 at 1°: light that bounced twice
counts twice."""
SIZE = (10.4, 6.0)


def cases(n: float) -> dict:
    """Name -> model, parameter, closed form of the albedo over (value, mu)."""
    return {
        "Oren-Nayar, σ": (brdf.OrenNayar(1.0, 0.2), "sigma", oren_nayar),
        "EON, ρ": (brdf.EON(1.0, 1.0), "rho", eon),
        "Minnaert, k": (brdf.Minnaert(1.0, 1.5), "k", lambda k, mu: mu ** (k - 1)),
        "coated Lambert, η": (brdf.CoatedLambert(0.5, 1.5), "eta", coat),
        "modified Phong, n": (brdf.ModifiedPhong(1.0, n), "shininess", modified_phong),
        "Blinn-Phong, n": (brdf.BlinnPhong(1.0, n), "shininess", None),
    }


def oren_nayar(sigma, mu):
    s2, sine, theta = sigma**2, jnp.sqrt(1 - mu * mu), jnp.arccos(mu)
    g = sine * (theta - sine * mu) + 2 / 3 * sine / mu * (1 - sine**3)
    return 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) * g / jnp.pi


def eon(rho, mu, r=1.0):
    sine, theta = jnp.sqrt(1 - mu * mu), jnp.arccos(mu)
    a = 1 / (1 + (0.5 - 2 / (3 * jnp.pi)) * r)
    g = sine * (theta - sine * mu) + 2 / 3 * (sine / mu * (1 - sine**3) - sine)
    single, average = a * (1 + r * g / jnp.pi), a * (1 + (2 / 3 - 28 / (15 * jnp.pi)) * r)
    return rho * single + rho**2 * average / (1 - rho * (1 - average)) * (1 - single)


def coat(eta, mu, rho=0.5):
    f, inside = fresnel.dielectric(mu, eta), fresnel.average_dielectric(1 / eta)
    return f + (1 - f) * rho * (1 - inside) / (1 - rho * inside)


def modified_phong(n, mu):
    node, weight = quadrature.gauss_legendre(200)
    theta, width = jnp.arccos(mu), jnp.pi - jnp.arccos(mu)
    angle = theta - 0.5 * jnp.pi + width * node
    lune = width * jnp.sum(weight * jnp.cos(angle) ** n * jnp.cos(angle - theta))
    beta = jnp.pi * jnp.sum(weight * jnp.cos(0.5 * jnp.pi * node) ** (n + 2))
    return (n + 2) / (2 * jnp.pi) * beta * lune


def compute(n: float = 10.0) -> dict:
    theta, mu = plot.angles(89, 1.0, 89.0)
    few = slice(6, None, 12)
    chosen = cases(n)
    models = {name: (model, rule_for(model)) for name, (model, _, _) in chosen.items()}

    @jax.jit
    def integrals(models, mu):
        def slope(name, mu):
            (model, rule), parameter = models[name], chosen[name][1]
            return jax.jvp(
                lambda x: directional_albedo(replaced(model, parameter, x), mu, rule).value,
                (jnp.asarray(getattr(model, parameter)),),
                (jnp.ones(()),),
            )[1]

        return jax.lax.map(lambda mu: {name: slope(name, mu) for name in models}, mu)

    @jax.jit
    def closed(values, mu):
        forms = {name: form for name, (_, _, form) in chosen.items() if form}
        return {name: jax.vmap(jax.grad(form), (None, 0))(values[name], mu) for name, form in forms.items()}

    values = {name: float(getattr(model, parameter)) for name, (model, parameter, _) in chosen.items()}
    slopes, known = integrals(models, jnp.asarray(mu)), closed(values, jnp.asarray(mu[few]))
    differences = [np.abs(known[name] - slopes[name][few]).max() for name in known]
    return {
        "theta_deg": theta,
        "few_deg": theta[few],
        "name": np.array(list(chosen)),
        "value": np.array(list(values.values())),
        "slope": np.stack([np.asarray(slopes[name]) for name in chosen]),
        "closed": np.stack([np.asarray(known.get(name, np.full(theta[few].size, np.nan))) for name in chosen]),
        "largest_difference": max(differences),
    }


def draw(data: dict, fig) -> None:
    units = {"σ": "per rad", "η": "per unit of η", "n": "per unit of n", "ρ": "per unit of ρ", "k": "per unit of k"}
    for i, ax in enumerate(fig.subplots(2, 3).ravel()):
        model, _, symbol = str(data["name"][i]).partition(", ")
        plot.cartesian(data["theta_deg"], data["slope"][i], ax=ax, label="integral, AD", color=plot.BLUE)
        dots = {"color": plot.RED, "linestyle": "", "marker": "o", "markersize": 4}
        if np.isfinite(data["closed"][i]).all():
            plot.cartesian(data["few_deg"], data["closed"][i], ax=ax, label="closed form", **dots)
        plot.labels(ax, title=f"{model}, {symbol} = {data['value'][i]:g}", xlim=(0, 90))
        plot.labels(ax, xlabel="angle of view θ (degrees)", ylabel=f"d albedo / d{symbol} ({units[symbol]})")
        plot.mark(ax, y=0.0)
        plot.legend(ax, loc="best")
