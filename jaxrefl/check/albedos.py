"""Evaluators of section E: albedos of the models, by the library's own quadrature and not by their closed forms."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..albedo import bihemispherical_albedo, directional_albedo, rule_for
from ..brdf import (
    EON,
    AshikhminShirleyDiffuse,
    BlinnPhong,
    CoatedLambert,
    LiteralPhong,
    LommelSeeliger,
    Minnaert,
    ModifiedPhong,
    OrenNayar,
    Slab,
)
from ..chart import AlbedoRule
from ..params import pytree
from ..vec import Vec3
from .table import Columns, HostColumns, evaluates

CLOSED = "closed form against quadrature at 40 digits, a check of the table itself"
UP = Vec3(0.0, 0.0, 1.0)
LEVEL = 4
"""Of the rule where nothing else is said: twice the digits that float64 holds, but for narrow lobes."""


def albedos(model: Callable[..., Any], mu: Array, *columns: Array, level: int = LEVEL, **how: Any) -> Array:
    """Directional albedos, row by row, of the models that the columns are the parameters of."""
    rule = rule_for(model(*(column[0] for column in columns)), level)
    return lax.map(lambda row: directional_albedo(model(*row[1:]), row[0], rule, **how).value, (mu, *columns))


def bihemispherical(model: Callable[..., Any], *columns: np.ndarray, level: int = LEVEL, angles: int = 3) -> np.ndarray:
    """Bihemispherical albedos, row by row, the same parameters once; the angles by a rule of another level."""

    @jax.jit
    def whole(model: Any, rule: AlbedoRule) -> Array:
        return bihemispherical_albedo(model, rule).value

    rows, back = np.unique(np.stack(columns), axis=1, return_inverse=True)
    rule = dataclasses.replace(rule_for(model(*rows[:, 0]), level), level=angles)
    return np.array([whole(model(*row), rule) for row in rows.T])[back.ravel()]


def _cosine(degrees: Array) -> Array:
    return jnp.sin(jnp.deg2rad(90.0 - degrees))


@evaluates("E.modified_phong", "n theta_deg", skipped={"check_max_abs": CLOSED})
def _modified_phong(c: Columns) -> dict[str, Array]:
    n, mu = c["n"], c["cos_theta"]
    sent = albedos(lambda n: LiteralPhong(0.0, jnp.pi, n), mu, n, level=5, fixed="light")  # the lobe over cos theta_i
    return {"albedo": albedos(lambda n: ModifiedPhong(1.0, n), mu, n, level=5), "I_n": mu * sent}


@evaluates("E.modified_phong_avg", "n", jit=False)
def _modified_phong_average(c: HostColumns) -> dict[str, np.ndarray]:
    wide, narrow = {"level": 4, "angles": 3}, {"level": 5, "angles": 4}  # for n = 1000: 33 million evaluations
    rows = (
        bihemispherical(lambda n: ModifiedPhong(1.0, n), n, **(narrow if n > 100 else wide)) for n in c["n"][:, None]
    )
    return {"albedo_bh": np.concatenate(list(rows))}


@evaluates(
    "E.blinn_norm",
    "n",
    skipped={
        "(n+8)/8pi": "a factor in circulation, which no model of the library has",
        "(n+2)/8pi": "likewise",
        "(n+2)/2pi": "likewise",
    },
)
def _blinn(c: Columns) -> dict[str, Array]:
    n, ones = c["n"], jnp.ones_like(c["n"])
    one = albedos(lambda n: BlinnPhong(1.0, n), ones, n)
    return {"N_exact": jax.vmap(lambda n: BlinnPhong(1.0, n)(UP, UP))(n), "N*I-1": one - 1}


@evaluates("E.oren_nayar_qualitative", "sigma theta_deg", skipped={"check_G_max_abs": CLOSED})
def _oren_nayar(c: Columns) -> dict[str, Array]:
    half = Vec3.from_spherical(jnp.sqrt(0.5), 0.0)  # sin alpha tan beta is the root of 1/2 there, and 0 at the normal
    smooth, rough = (jnp.pi * jax.vmap(lambda s, w=w: OrenNayar(1.0, s)(w, w))(c["sigma"]) for w in (UP, half))
    return {
        "A": smooth,
        "B": (rough - smooth) * jnp.sqrt(2.0),
        "albedo_over_rho": albedos(lambda s: OrenNayar(1.0, s), c["cos_theta"], c["sigma"]),
    }


@pytree
class SingleScattering:
    """What is first order in rho of `EON`, with rho = 1: its lobe without the one of multiple scattering."""

    roughness: Any

    def __call__(self, wi: Vec3, wo: Vec3) -> Array:
        """Slope of f in rho at 0."""
        return jax.jvp(lambda rho: EON(rho, self.roughness)(wi, wo), (0.0,), (1.0,))[1]


@evaluates("E.eon", "r theta_deg rho", skipped={"avg_check": CLOSED}, jit=False)
def _eon(c: HostColumns) -> dict[str, Any]:
    @jax.jit
    def directional(r: Array, mu: Array, rho: Array) -> tuple[Array, Array]:
        return albedos(SingleScattering, mu, r), albedos(EON, mu, rho, r)

    single, whole = directional(c["r"], c["cos_theta"], c["rho"])
    normal = np.pi * SingleScattering(1.0)(UP, UP)  # the factor A for r = 1
    return {
        "E_FON": single,
        "E_FON_avg": bihemispherical(SingleScattering, c["r"], level=3),
        "E_EON": whole,
        "const1": 1 / normal - 1,
        "const2": bihemispherical(SingleScattering, np.ones(1), level=3)[0] / normal - 1,
    }


@evaluates(
    "E.eon_point",
    "r theta_i theta_o dphi_deg rho",
    looser={"f_ms": 1e-12},  # f - f_ss, of which only a thousandth is left
)
def _eon_point(c: Columns) -> dict[str, Array]:
    def one(r: Array, mu_i: Array, mu_o: Array, azimuth: Array, rho: Array) -> tuple[Array, Array]:
        wi, wo = Vec3.from_spherical(mu_i, azimuth), Vec3.from_spherical(mu_o, 0.0)
        return EON(rho, r)(wi, wo), rho * SingleScattering(r)(wi, wo)

    directions = _cosine(c["theta_i"]), _cosine(c["theta_o"]), jnp.deg2rad(c["dphi_deg"])
    f, f_ss = jax.vmap(one)(c["r"], *directions, c["rho"])
    return {"f_ss": f_ss, "f_ms": f - f_ss, "f": f}


@evaluates("E.lommel_seeliger", "theta_deg", skipped={"bh_quad": CLOSED})
def _lommel_seeliger(c: Columns) -> dict[str, Array]:
    mu, model = c["cos_theta"], LommelSeeliger(1.0)
    both = bihemispherical_albedo(model, rule_for(model, LEVEL)).value
    return {"albedo_over_w": albedos(lambda w: LommelSeeliger(w), mu, jnp.ones_like(mu)), "bihemispherical": both}


@evaluates("E.minnaert", "k theta_deg", jit=False)
def _minnaert(c: HostColumns) -> dict[str, Any]:
    directional = jax.jit(lambda k, mu: albedos(lambda k: Minnaert(1.0, k), mu, k))(c["k"], c["cos_theta"])
    return {"albedo": directional, "bihemispherical": bihemispherical(lambda k: Minnaert(1.0, k), c["k"])}


@evaluates(
    "E.slab",
    "n theta_deg sigma_a_t",
    skipped={"R_unpolarised_shortcut": "an approximation that the library does not have"},
)
def _slab(c: Columns) -> dict[str, Array]:
    def part(name: str) -> Array:
        return albedos(Slab, c["cos_theta"], c["n"], c["sigma_a_t"], level=0, part=name)

    return {"R": part("reflected"), "T": part("transmitted"), "A": 1 - part("both")}


@evaluates("E.slab_avg", "n", jit=False)
def _slab_average(c: HostColumns) -> dict[str, np.ndarray]:
    return {"R_avg": bihemispherical(Slab, c["n"], level=0)}


@evaluates("E.ashikhmin_shirley_diffuse", "theta_deg")
def _ashikhmin_shirley(c: Columns) -> dict[str, Array]:
    mu = c["cos_theta"]
    return {"albedo": albedos(lambda rho: AshikhminShirleyDiffuse(rho, 0.0), mu, jnp.ones_like(mu))}


@evaluates("E.coat_lambert", "n rho theta_deg", jit=False)
def _coat(c: HostColumns) -> dict[str, Any]:
    @jax.jit
    def directional(n: Array, rho: Array, mu: Array) -> tuple[Array, Array]:
        def to_normal(n: Array, rho: Array, mu: Array) -> Array:
            return CoatedLambert(rho, n)(Vec3.from_spherical(mu, 0.0), UP)

        return albedos(CoatedLambert, mu, rho, n, level=3), jax.vmap(to_normal)(n, rho, mu)

    total, point = directional(c["n"], c["rho"], c["cos_theta"])
    both = bihemispherical(CoatedLambert, c["rho"], c["n"], level=3)
    return {"albedo_dir": total, "f_d_i_to_normal": point, "albedo_bh": both}
