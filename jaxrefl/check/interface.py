"""Evaluators of the sections A and B: the exact equations of dielectrics and conductors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from .. import fresnel
from ..quadrature import gauss_legendre, integrate
from .numerics import extrema, slopes
from .table import VALUE_RTOL, Columns, evaluates


@evaluates("A.table", "eta theta_deg tir", derivatives="dR_dtheta_per_rad dR_dcos dR_deta")
def _dielectric(c: Columns) -> dict[str, Array]:
    mu, eta = c["cos_theta"], c["eta"]
    r = fresnel.amplitudes(mu, eta)
    r_s, r_p = fresnel.dielectric_sp(mu, eta)
    d_mu, d_eta = slopes(fresnel.dielectric, mu, eta)
    return {
        "r_s": r.r_s.real,
        "r_p": r.r_p.real,
        "R_s": r_s,
        "R_p": r_p,
        "R": fresnel.dielectric(mu, eta),
        "dR_dtheta_per_rad": -c["sin_theta"] * d_mu,
        "dR_dcos": d_mu,
        "dR_deta": d_eta,
    }


@evaluates(
    "A.special",
    "n",
    derivatives="dRdcos_grazing dR0_dn",
    skipped={"dR0_dn_check": "dR0_dn again, by finite difference"},
)
def _special_angles(c: Columns) -> dict[str, Array]:
    n = c["n"]
    brewster = fresnel.brewster_angle(n)
    return {
        "R0": fresnel.f0_dielectric(n),
        "brewster_ext_deg": jnp.rad2deg(brewster),
        "brewster_int_deg": jnp.rad2deg(fresnel.brewster_angle(1 / n)),
        "critical_deg": jnp.rad2deg(fresnel.critical_angle(1 / n)),
        "Rs_at_brewster": fresnel.dielectric_sp(jnp.cos(brewster), n)[0],
        "R_at_brewster": fresnel.dielectric(jnp.cos(brewster), n),
        "dRdcos_grazing": slopes(fresnel.dielectric, jnp.zeros_like(n), n)[0],
        "dR0_dn": slopes(fresnel.f0_dielectric, n)[0],
    }


@evaluates("A.tir_phase", "n theta_deg")
def _total_reflection_phase(c: Columns) -> dict[str, Array]:
    r = fresnel.amplitudes(c["cos_theta"], 1 / c["n"])
    # negative in the time convention exp(-i w t); an amplitude that is not of magnitude 1 has no phase to compare
    unit = jnp.abs(jnp.abs(jnp.stack(r[:2])) - 1) < VALUE_RTOL
    s, p = jnp.where(unit, -jnp.angle(jnp.stack(r[:2]), deg=True), jnp.nan)
    return {"delta_s_deg": s, "delta_p_deg": p, "delta_p-delta_s_deg": p - s}


@evaluates("A.near_normal", "n", derivatives="c2 c4")
def _near_normal(c: Columns) -> dict[str, Array]:
    def derivative(f: Callable[[Array], Array]) -> Callable[[Array], Array]:
        return lambda theta: jax.jvp(f, (theta,), (jnp.ones_like(theta),))[1]

    second = derivative(derivative(lambda theta: fresnel.dielectric(jnp.cos(theta), c["n"])))
    fourth, zero = derivative(derivative(second)), jnp.zeros_like(c["n"])
    return {"c2": second(zero) / 2, "c4": fourth(zero) / 24}


@evaluates("A.reversal", "n theta_int_deg")
def _reversal(c: Columns) -> dict[str, Array]:
    mu, n = c["cos_theta_int"], c["n"]
    mu_t = fresnel.cos_theta_t(mu, 1 / n)
    return {
        "theta_ext_deg": jnp.rad2deg(jnp.arccos(mu_t)),
        "R_int": fresnel.dielectric(mu, 1 / n),
        "R_ext": fresnel.dielectric(mu_t, n),
        "ratio": mu_t / (n * mu),
    }


@evaluates(
    "B.table",
    "material eta k theta_deg",
    derivatives="dR_deta dR_dk dR_dtheta_per_rad",
    skipped={"real_formula_max_abs_diff": "complex against real form at 40 digits, a check of the table itself"},
)
def _conductor(c: Columns) -> dict[str, Array]:
    mu, eta, k = c["cos_theta"], c["eta"], c["k"]
    r_s, r_p = fresnel.conductor_sp(mu, eta, k)
    d_mu, d_eta, d_k = slopes(fresnel.conductor, mu, eta, k)
    return {
        "R_s": r_s,
        "R_p": r_p,
        "R": fresnel.conductor(mu, eta, k),
        "dR_deta": d_eta,
        "dR_dk": d_k,
        "dR_dtheta_per_rad": -c["sin_theta"] * d_mu,
    }


@evaluates(
    "B.k_to_0",
    "eta theta_deg k",
    derivatives="R-R(k=0) (R-R0)/k",
    skipped={"eta=0.5, theta=30 deg, k=1e-8": "at the critical angle the rounding of cos 30 degrees moves R by 4e-12"},
)
def _small_extinction(c: Columns) -> dict[str, Array]:
    mu, eta, k = c["cos_theta"], c["eta"], c["k"]

    def slope(u: Array) -> Array:  # dR/dk at k u^2: smooth in u, also at the critical angle, where R is a root in k
        return 2 * u * slopes(fresnel.conductor, mu, eta, u * u * k)[2]

    mean = integrate(slope, gauss_legendre(12))  # exact to the last digit; more nodes come too close to k = 0 there
    return {"R": fresnel.conductor(mu, eta, k), "R-R(k=0)": k * mean, "(R-R0)/k": mean}


@evaluates(
    "B.attenuated_tir_slope",
    "eta theta_deg",
    derivatives="slope",
    skipped={"fd_check": "slope again, by finite difference"},
)
def _attenuated_total_reflection(c: Columns) -> dict[str, Array]:
    return {"slope": slopes(fresnel.conductor, c["cos_theta"], c["eta"], jnp.zeros_like(c["eta"]))[2]}


@evaluates("B.metals", "metal@nm eta k")
def _metals(c: Columns) -> dict[str, Array]:
    eta, k = c["eta"], c["k"]

    def r_p(mu: Any) -> Array:
        return fresnel.conductor_sp(mu, eta, k)[1]

    def r(mu: Any) -> Array:
        return fresnel.conductor(mu, eta, k)

    pseudo_brewster, dip = extrema(r_p)[1], extrema(r)[1]
    return {
        "F0": fresnel.f0_conductor(eta, k),
        "pseudoBrewster_deg": pseudo_brewster,
        "Rp_min": r_p(jnp.cos(jnp.deg2rad(pseudo_brewster))),
        "minR_deg": dip,
        "R_min": r(jnp.cos(jnp.deg2rad(dip))),
        "R_at_cos_1_7": r(1 / 7),
    }


@evaluates(
    "B.misprint_size",
    given="Au@548.6, theta=60 deg",
    skipped={"Rp_literal_denominator_theta_tan2": "the misprinted formula, which the library does not have"},
)
def _literal_square(_: Columns) -> dict[str, Array]:
    point = 0.5, 0.43, 2.455
    r = fresnel.amplitudes(*point)
    literal = 0.5 * (r.r_s**2 + r.r_p**2)
    return {
        "R_exact": fresnel.conductor(*point),
        "literal_r2_re": literal.real,
        "literal_r2_im": literal.imag,
        "Rp_exact": fresnel.conductor_sp(*point)[1],
    }
