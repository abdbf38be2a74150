"""One battery for every reflection model: each row states what it expects of each column, and is wrong either way.

Energy, reciprocity and sign are verdicts that differ between models; that values and derivatives are finite, keep their
dtype and agree however they are computed holds for all of them, and fails for the models broken on purpose at the end.
"""

import dataclasses
import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import catalog
from jaxrefl.albedo import directional_albedo, rule_for
from jaxrefl.brdf import (
    D3D9,
    EON,
    AshikhminShirleyDiffuse,
    BlinnPhong,
    Burley,
    CoatedLambert,
    D3D9Repaired,
    Lambert,
    LiteralPhong,
    LommelSeeliger,
    Minnaert,
    Mix,
    ModifiedPhong,
    OrenNayar,
    Scaled,
    Slab,
)
from jaxrefl.params import param, parameters
from jaxrefl.vec import Vec3

COLUMNS = ("non_negative", "reciprocal", "view", "light", "delta", "finite", "same", "dtype", "derivatives")
MU = jnp.array([0.0, 1e-3, 0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0])


class Row(NamedTuple):
    """Model and its verdicts; ``view`` and ``light``: where the albedo is largest, and how large, if that is above 1."""

    name: str
    model: Any
    non_negative: bool = True
    reciprocal: bool = True
    view: tuple[float, float] | None = None
    light: tuple[float, float] | None = None
    delta: bool = True
    finite: bool = True
    same: bool = True
    dtype: bool = True
    derivatives: bool = True


TINT = (0.25, 0.5, 1.0)
AVERAGE = 0.04 + 0.96 / 21  # of 0.04 + 0.96 (1 - mu)^5
BURLEY = 1 + 13 / 42  # of f = (1 + e m^5)(1 + e) / pi at grazing view, e = 1/2 + sin cos phi: see the test below
RISING = 1.0053571428571429  # 1 - 0.045 / 0.42 + 0.225 / 2, physics of Oren and Nayar at 90 degrees
ROWS = [
    Row("lambert", Lambert(1.0)),
    Row("lambert colours", Lambert(TINT)),
    Row("literal phong", LiteralPhong(0.0, 1.0, 10.0), reciprocal=False, light=(1e-3, 20.6)),
    Row("literal phong, n = 1", LiteralPhong(0.0, 0.5, 1.0), reciprocal=False, light=(1e-3, 106.2)),
    Row("opengl", LiteralPhong(0.0, 1.0, 40.0, highlight="half_vector"), reciprocal=False, light=(1e-3, 24.9)),
    Row("modified phong", ModifiedPhong(TINT, 10.0)),
    Row("modified phong, n = 0.5", ModifiedPhong(1.0, 0.5)),
    Row("modified phong, n = 300", ModifiedPhong(1.0, 300.0)),
    Row("blinn", BlinnPhong(TINT, 10.0)),
    Row("blinn, n = 2.5", BlinnPhong(1.0, 2.5)),
    Row("oren-nayar", OrenNayar(1.0, 0.3), view=(0.0, RISING), light=(0.0, RISING)),
    Row("oren-nayar, rough", OrenNayar(TINT, 1.0)),
    Row("eon", EON(1.0, 0.5)),
    Row("eon, rough", EON(TINT, 1.0)),
    Row("eon, smooth", EON(TINT, 0.0)),
    Row("burley", Burley(1.0, 1.0), view=(0.0, BURLEY), light=(0.0, BURLEY)),
    Row("burley, smooth", Burley(1.0, 0.0)),
    Row("ashikhmin-shirley", AshikhminShirleyDiffuse(1.0, 0.0)),
    Row("ashikhmin-shirley coated", AshikhminShirleyDiffuse(TINT, 0.04)),
    Row("lommel-seeliger", LommelSeeliger(1.0)),
    Row("lommel-seeliger colours", LommelSeeliger(TINT)),
    Row("minnaert", Minnaert(1.0, 0.8), view=(1e-3, 1e-3**-0.2), light=(1e-3, 1e-3**-0.2)),
    Row("minnaert, darker", Minnaert(TINT, 1.5)),
    Row("coat", CoatedLambert(1.0, 1.5)),
    Row("coat, diamond", CoatedLambert(TINT, 2.4)),
    Row("coat of nothing", CoatedLambert(1.0, 1.0)),
    Row("slab", Slab(1.5, 0.0)),
    Row("slab colours", Slab(2.4, TINT)),
    Row("d3d9", D3D9(1.0, 0.0), view=(0.0, 2.0), light=(0.0, 2.0)),
    Row("d3d9 metallic", D3D9(0.5, 0.3, p=2.5), view=(0.0, 1.35), light=(0.0, 1.35)),
    Row("d3d9 black", D3D9(0.0, TINT)),
    Row("d3d9 sun", D3D9(1.0, 0.0, sun_fresnel=True), reciprocal=False, view=(0.0, 2 - AVERAGE)),
    Row(
        "d3d9 above 1",
        D3D9(1.0, 0.0, r0=0.5, m=0.96, sun_fresnel=True),
        non_negative=False,
        reciprocal=False,
        view=(0.0, 1 + 0.96 - 0.96 / 21),
    ),
    Row("repaired", D3D9Repaired(1.0, 0.0)),
    Row("repaired metallic", D3D9Repaired(TINT, 0.3, p=2.5)),
    Row("repaired above 1", D3D9Repaired(1.0, 0.0, r0=0.5, m=0.96), non_negative=False),
    Row("mix", Mix(Lambert(1.0), ModifiedPhong(1.0, 20.0), TINT)),
    Row("mix of coats", Mix(CoatedLambert(1.0, 1.5), Slab(1.5, 0.3), 0.3)),
    Row("mix with one that is not", Mix(Lambert(1.0), D3D9(1.0, 0.0), 0.25), view=(0.0, 1.25), light=(0.0, 1.25)),
    Row("scaled", Scaled(BlinnPhong(1.0, 10.0), TINT)),
    Row("scaled above 1", Scaled(EON(1.0, 0.5), 1.5), view=(np.nan, 1.5), light=(np.nan, 1.5)),
    Row("scaled literal", Scaled(LiteralPhong(1.0, 0.0, 10.0), 0.5)),
]


# --- directions ---


def sphere(mu, phi, z=None):
    sine = np.sqrt((1 - mu) * (1 + mu))
    return sine * np.cos(phi), sine * np.sin(phi), mu if z is None else z


SPECIAL = [
    (0.0, 0.0, 1.0),
    (1e-9, 0.0, 1.0),
    (1.0, 0.0, 0.0),
    (-1.0, 0.0, 0.0),  # opposite to the one before: they have no half vector
    sphere(0.0, 1.2, 1e-8),
    sphere(0.0, 1.2 + np.pi, 1e-8),
    sphere(0.0, 2.0, 1e-18),
    sphere(0.6, 0.3),
    sphere(0.6, 0.3 + np.pi),  # its mirror direction
    sphere(-0.6, 0.3),
]
GRID = np.array([(i, o) for i in SPECIAL for o in SPECIAL])


def pairs(array, dtype=np.float64):
    columns = jnp.asarray(array, dtype)
    return Vec3(*columns[:, 0].T), Vec3(*columns[:, 1].T)


def at_random(n, seed, least=0.02):
    rng = np.random.default_rng(seed)
    return np.stack([np.stack(sphere(rng.uniform(least, 1, n), rng.uniform(-np.pi, np.pi, n)), 1) for _ in "io"], 1)


# --- the columns, measured ---


@jax.jit
def values(model, wi, wo):
    return jax.vmap(model)(wi, wo)


@jax.jit
def pulled(model, wi, wo, cotangent):
    """Reverse mode: gradients of sum(cotangent f) in the parameters and in both directions, pair by pair."""

    def one(wi, wo):
        return jax.grad(lambda *x: jnp.sum(cotangent * x[0](x[1], x[2])), (0, 1, 2))(model, wi, wo)

    return jax.vmap(one)(wi, wo)


@jax.jit
def pushed(model, wi, wo, tangent, cotangent):
    """Forward mode along a tangent, of sum(cotangent f) and of its gradient, pair by pair."""

    def one(wi, wo):
        def f(*x):
            return jnp.sum(cotangent * x[0](x[1], x[2]))

        return jax.jvp(jax.value_and_grad(f, (0, 1, 2)), (model, wi, wo), tangent)[1]

    return jax.vmap(one)(wi, wo)


@functools.partial(jax.jit, static_argnames="fixed")
def albedos(model, rule, fixed):
    return jax.lax.map(lambda mu: directional_albedo(model, mu, rule, fixed=fixed), MU)


@jax.jit
def deltas(model, mu):
    parts = [jax.vmap(getattr(model, name))(mu) for name in ("mirror", "through") if hasattr(model, name)]
    return parts, [jax.vmap(jax.grad(lambda mu, p=p: jnp.sum(p(mu))))(mu) for p in
                   (getattr(model, name) for name in ("mirror", "through") if hasattr(model, name))]


def leaves(tree):
    return [np.asarray(leaf) for leaf in jax.tree.leaves(tree)]


def cast(model, dtype=jnp.float64):
    """Model with spectra in its spectral parameters: one compilation for all rows of a class."""
    changes = {}
    for field in dataclasses.fields(model):
        value, declared = getattr(model, field.name), field.metadata.get("param")
        if dataclasses.is_dataclass(value):
            changes[field.name] = cast(value, dtype)
        elif declared:
            shape = (3,) if declared["spectral"] else ()
            changes[field.name] = jnp.broadcast_to(jnp.asarray(value, dtype), shape)
    return dataclasses.replace(model, **changes)


def exceeds(model, fixed):
    found = albedos(model, rule_for(model, 4), fixed)
    above = np.asarray(found.value - found.error).max(axis=-1)
    largest = np.asarray(found.value).max(axis=-1)
    return (float(MU[largest.argmax()]), float(largest.max())) if above.max() > 1 else None


def ends(model):
    """The model with each of its parameters at the ends of its range (an open or infinite one, near or far enough)."""
    yield model
    for declared in parameters(model):
        old, interval = getattr(model, declared.name), declared.interval
        for value in (interval.low or 1e-3 * interval.low_open, min(interval.high, 1e3)):
            yield dataclasses.replace(model, **{declared.name: jnp.full_like(old, value)})


def is_finite(model, dtype):
    wi, wo = pairs(GRID, dtype)
    cotangent = jnp.ones((), dtype)
    return all(
        np.isfinite(leaf).all()
        for each in ends(cast(model, dtype))
        for leaf in leaves((values(each, wi, wo), pulled(each, wi, wo, cotangent), deltas(each, MU.astype(dtype))))
    )


def close(a, b, rtol, floor=0.0):
    return all(np.allclose(x, y, rtol=rtol, atol=floor * max(1.0, abs(y).max(initial=0))) for x, y in
               zip(leaves(a), leaves(b), strict=True))


def derivatives_agree(model):
    wi, wo = pairs(at_random(40, 5, 0.2))
    rng = np.random.default_rng(6)
    point = (model, wi, wo)
    tangent = jax.tree.map(lambda x: jnp.asarray(rng.normal(size=np.shape(x)[:1] if np.ndim(x) and np.shape(x)[0] == 3
                                                            else ())), (model, Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)))
    cotangent = jnp.array([0.5, -1.0, 2.0])
    along, second = pushed(model, wi, wo, tangent, cotangent)
    reverse = pulled(model, wi, wo, cotangent)
    by_reverse = sum(
        np.sum((g * t).reshape(len(g), -1), axis=1) for g, t in zip(leaves(reverse), leaves(tangent), strict=True)
    )

    def moved(h):
        return jax.tree.map(lambda x, t: x + h * t, point, tangent)

    h = 1e-5
    first = (jnp.sum(cotangent * (values(*moved(h)) - values(*moved(-h))), axis=-1)) / (2 * h)
    ahead, behind = (pulled(*moved(x), cotangent) for x in (h, -h))
    slope = jax.tree.map(lambda a, b: (a - b) / (2 * h), ahead, behind)
    return (
        close(along, by_reverse, 1e-10, 1e-12) and close(along, first, 1e-6, 1e-7) and close(second, slope, 1e-5, 1e-6)
    )


def keeps_dtype(model):
    return all(
        leaf.dtype == dtype
        for dtype in (jnp.float32, jnp.float64)
        for leaf in leaves((values(cast(model, dtype), *pairs(GRID, dtype)), deltas(cast(model, dtype), MU.astype(dtype))))
    )


def is_the_same_however_computed(model):
    wi, wo = pairs(at_random(4, 8))
    mapped = values(model, wi, wo)
    each = [jax.tree.map(lambda x, i=i: x[i], (wi, wo)) for i in range(4)]
    compiled = jnp.stack([jax.jit(lambda m, *w: m(*w))(model, *w) for w in each])
    with jax.disable_jit():
        eager = jnp.stack([model(*w) for w in each])
    return close(mapped, compiled, 1e-12, 1e-15) and close(mapped, eager, 1e-12, 1e-15)


def verdicts(model):
    model = cast(model)
    wi, wo = pairs(at_random(3000, 1, 1e-4))
    there, back = np.asarray(values(model, wi, wo)), np.asarray(values(model, wo, wi))
    edges = np.asarray(values(model, *pairs(GRID)))
    return {
        "non_negative": bool(min(there.min(), edges.min()) >= 0),
        "reciprocal": bool(np.allclose(there, back, rtol=1e-11, atol=1e-300)),
        "view": exceeds(model, "view"),
        "light": exceeds(model, "light"),
        "delta": all((part >= 0).all() for part in leaves(deltas(model, MU)[0])),
        "finite": is_finite(model, jnp.float64) and is_finite(model, jnp.float32),
        "same": is_the_same_however_computed(model),
        "dtype": keeps_dtype(model),
        "derivatives": derivatives_agree(model),
    }
