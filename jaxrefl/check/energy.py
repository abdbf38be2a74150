"""Evaluators of the sections D, E and G: averages, the Lambertian pi, D3D9 in a white furnace, Phong as displayed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from .. import d3d9, fresnel, quadrature
from ..albedo import directional_albedo, rule_for
from ..brdf import BlinnPhong, Lambert, LiteralPhong, ModifiedPhong
from ..vec import Vec3
from .albedos import albedos
from .numerics import NODES, boundary, slopes
from .table import Columns, HostColumns, evaluates


@evaluates(
    "D.dielectric",
    "n",
    derivatives="dF_ext_dn",
    skipped={
        "closed-quad": "closed form against quadrature at 40 digits, a check of the table itself",
        "int_closed-quad": "likewise",
        "KC_ext_fit": "a published fit, which the library does not have",
        "KC_int_fit": "likewise",
        "Egan73_int_fit": "likewise",
    },
)
def _average_dielectric(c: Columns) -> dict[str, Array]:
    n = c["n"]
    return {
        "F_ext": fresnel.average_dielectric(n),
        "F_int": fresnel.average_dielectric(1 / n),
        "dF_ext_dn": slopes(fresnel.average_dielectric, n)[0],
        "schlick_avg": fresnel.average_schlick(fresnel.f0_dielectric(n)),
    }


@evaluates("D.conductor", "metal@nm eta k")
def _average_conductor(c: Columns) -> dict[str, Array]:
    eta, k = c["eta"], c["k"]
    f0, rule = fresnel.f0_conductor(eta, k), quadrature.cosine_rule(NODES)
    tint = fresnel.conductor(1 / 7, eta, k) / fresnel.schlick(1 / 7, f0)
    return {
        "F0": f0,
        "F_avg": quadrature.integrate(lambda mu: fresnel.conductor(mu, eta, k), rule),
        "schlick_avg": fresnel.average_schlick(f0),
        "F82_avg": quadrature.integrate(lambda mu: fresnel.f82_tint(mu, f0, tint), rule),
    }


@evaluates("D.d3d9_energy_p", "n")
def _energy_exponent(c: Columns) -> dict[str, Array]:
    return {"p": d3d9.energy_exponent(c["n"])}


@evaluates("D.d3d9_avg", "R0 m p")
def _average_d3d9(c: Columns) -> dict[str, Array]:
    return {"R_avg": fresnel.average_d3d9(c["R0"], c["m"], c["p"])}


@evaluates("E.lambert", given="rho=1")
def _lambert(_: Columns) -> dict[str, Array]:
    up = Vec3.from_spherical(1.0, 0.0)
    return {
        "int_cos": quadrature.cosine_integral(quadrature.hemisphere_rule(16, 16)),
        "quad": quadrature.cosine_integral_1d(quadrature.gauss_legendre(40)),
        "inv_pi": Lambert(1.0)(up, up),
    }


def _glass(cos_theta: Array, p: float = 5) -> Array:
    """R of eq (3) for n = 1.5 and m = 1 - R0."""
    r0 = fresnel.f0_dielectric(1.5)
    return fresnel.d3d9(cos_theta, r0, 1 - r0, p)


@evaluates("G.d3d9_furnace", "lambda theta_deg", given="n=1.5, p=5, m=1-R0, d=1, phi=1")
def _d3d9_furnace(c: Columns) -> dict[str, Array]:
    r0, rule, white = fresnel.f0_dielectric(1.5), quadrature.cosine_rule(NODES), jnp.ones(3)

    def one(metallic: Array, cos_theta: Array) -> dict[str, Array]:
        grey, r = metallic * white, _glass(cos_theta)
        r_tot, largest, length = d3d9.total_reflection(grey, r), d3d9.max_norm(grey), d3d9.euclidean_norm(grey)
        return {
            "R": r,
            "eq5": r_tot[0],
            "eq6_maxnorm": d3d9.pixel(white, largest, r_tot)[0],
            "eq6_l2norm": d3d9.pixel(white, length, r_tot)[0],
            "eq8_view_furnace": quadrature.integrate(lambda mu: d3d9.pixel(white, largest, r_tot, _glass(mu)), rule)[0],
            "eq8_light_hemispherical": d3d9.pixel(white, largest, r_tot, r)[0],  # sun at theta: diffuse out + mirror
        }

    def clear(mu: Array) -> Array:
        return d3d9.pixel(1.0, 0.0, d3d9.total_reflection(0.0, _glass(mu)))

    averages = {
        "R_avg": fresnel.average_d3d9(r0, 1 - r0, 5),
        "eq6_bihemispherical_lambda0": quadrature.integrate(clear, rule),
    }
    return {**jax.vmap(one)(c["lambda"], c["cos_theta"]), **averages}


@evaluates("G.eq8_reciprocity", "sigma_deg theta_deg", given="n=1.5, p=5, m=1-R0")
def _eq8_reciprocity(c: Columns) -> dict[str, Array]:
    there, back = (d3d9.pixel(1.0, 0.0, 0.0, _glass(c[sun])) for sun in ("cos_sigma", "cos_theta"))
    return {"ratio": there / back}


@evaluates("G.eq7_alpha", "theta_deg", given="n=1.5, p=5, m=1-R0, lambda=d=d_a=0, phi=1, background=0.5")
def _eq7_alpha(c: Columns) -> dict[str, Array]:
    def one(cos_theta: Array) -> dict[str, Array]:
        r = _glass(cos_theta)
        color = d3d9.pixel(0.0, 0.0, d3d9.total_reflection(0.0, r))
        return {
            "R": r,
            "eq7_blend": d3d9.blend(color, d3d9.alpha_printed(0.0, color), 0.5),
            "premultiplied_correct": d3d9.blend_premultiplied(color, d3d9.alpha_premultiplied(0.0, r), 0.5),
            "alpha_if_phi_10": d3d9.alpha_printed(0.0, d3d9.total_reflection(0.0, r, 10.0)),
        }

    return jax.vmap(one)(c["cos_theta"])


def _flux_ratio(k_s: Any, n: Any, cos_theta: Array) -> Array:
    """What literal Phong sends out of a beam, over what arrives; k_s = pi is a light whose I is its irradiance."""
    model = LiteralPhong(0.0, k_s, n)
    return directional_albedo(model, cos_theta, rule_for(model, 4), fixed="light").value


@evaluates("G.phong_literal", "n theta_deg")
def _phong_literal(c: Columns) -> dict[str, Array]:
    def ratio(k_s: float) -> Array:
        return albedos(lambda n: LiteralPhong(0.0, k_s, n), c["cos_theta"], c["n"], level=5, fixed="light")

    return {"ratio_I_is_E": ratio(np.pi), "ratio_I_is_E_over_pi": ratio(1.0)}


def _root(f: Callable[[Array], Array], start: Array) -> Array:
    """Root of an elementwise f by Newton's rule, from a start that is near."""

    def step(_: int, x: Array) -> Array:
        value, slope = jax.jvp(f, (x,), (jnp.ones_like(x),))
        return x - value / slope

    return lax.fori_loop(0, 6, step, start)


@evaluates("G.phong_blowup", "n")
def _phong_blowup(c: Columns) -> dict[str, Array]:
    def angle(k_s: float) -> Array:
        def blowup(n: Array) -> Array:
            cosine = _root(lambda mu: mu * (_flux_ratio(k_s, n, mu) - 1), jnp.asarray(0.01))
            return 90 - jnp.rad2deg(jnp.arcsin(cosine))

        return lax.map(blowup, c["n"])

    grazing = albedos(lambda n: ModifiedPhong(1.0, n), jnp.zeros_like(c["n"]), c["n"], level=5)
    return {
        "theta_blowup_EoverPi_deg": angle(1.0),
        "theta_blowup_E_deg": angle(np.pi),
        "I_n_grazing": grazing * 2 * np.pi / (c["n"] + 2),
    }


@evaluates("G.phong_reciprocity", "n theta_i theta_o")
def _phong_reciprocity(c: Columns) -> dict[str, Array]:
    def one(n: Array, theta_i: Array, theta_o: Array) -> Array:
        wi, wo = (
            Vec3(jnp.sin(t), 0.0, jnp.sin(jnp.pi / 2 - abs(t))) for t in jnp.deg2rad(jnp.stack([theta_i, -theta_o]))
        )
        return LiteralPhong(0.0, 1.0, n)(wi, wo) / LiteralPhong(0.0, 1.0, n)(wo, wi)

    return {"ratio": jax.vmap(one)(c["n"], c["theta_i"], c["theta_o"])}


@evaluates("G.thresholds", given="n=50 for the widths", jit=False)
def _thresholds(_: HostColumns) -> dict[str, Any]:
    def half(model: Any) -> np.ndarray:  # of the highlight on a sphere that is lit from the eye: wi = wo
        f = jax.jit(lambda angle: model(*2 * [Vec3.from_spherical(jnp.cos(angle), 0.0)]))
        return np.rad2deg(boundary(lambda angle: f(angle) > 0.5 * f(0.0), 0.0, np.pi / 2))

    conserving = jax.jit(lambda start: _root(lambda n: _flux_ratio(jnp.pi, n, jnp.ones(())) - 1, start))
    return {
        "n_crit": conserving(4.0),
        "blinn_half_deg": half(BlinnPhong(1.0, 50.0)),
        "phong_half_deg": half(ModifiedPhong(1.0, 50.0)),
    }


@evaluates("G.schlick_identity", given="lambda=0.7, R0=0.04, p=5, theta=60 deg")
def _schlick_identity(_: Columns) -> dict[str, Array]:
    return {
        "lhs": d3d9.total_reflection(0.7, fresnel.d3d9(0.5, 0.04, 0.96, 5)),
        "rhs": fresnel.schlick(0.5, d3d9.schlick_f0(0.7, 0.04)),
    }
