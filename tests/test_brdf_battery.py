"""One battery for every reflection model: each row states what it expects of each column, and is wrong either way.

Energy, reciprocity and sign are verdicts that differ between models; that values and derivatives are finite, keep their
dtype and agree however they are computed holds for all of them, and fails for the models broken on purpose at the end.
"""

import dataclasses
import functools
from typing import Any, NamedTuple

import closed_albedos as closed
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
from jaxrefl.params import param, parameters, pytree
from jaxrefl.vec import Vec3

ZERO = Vec3(0.0, 0.0, 0.0)
COLUMNS = ("non_negative", "reciprocal", "view", "light", "delta", "finite", "same", "dtype", "derivatives")
MU = jnp.array([0.0, 1e-3, 0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0])


class Row(NamedTuple):
    """Model and its verdicts; ``view`` and ``light``: where the albedo is largest and how large, if above 1."""

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


pytestmark = pytest.mark.usefixtures("quick_compilation")

TINT = (0.25, 0.5, 1.0)
METAL = (0.1, 0.2, 0.3)
AVERAGE = 0.04 + 0.96 / 21  # of 0.04 + 0.96 (1 - mu)^5
BURLEY = 1.5 + 29 / 504  # the integral over (1 + e (1 - mu)^5)(1 + e), e = 1/2 + sin theta cos phi
RISING = 1 - 0.045 / 0.42 + 0.225 / 2  # A + B / 2
PHONG_10, PHONG_1 = float(closed.literal_flux(1e-3, 10)), 0.5 * float(closed.literal_flux(1e-3, 1))
OPENGL = float(closed.blinn_moment(1e-3, 40)) / (np.pi * 1e-3)
ROWS = [
    Row("lambert", Lambert(1.0)),
    Row("lambert colours", Lambert(TINT)),
    Row("literal phong", LiteralPhong(0.0, 1.0, 10.0), reciprocal=False, light=(1e-3, PHONG_10)),
    Row("literal phong, n = 1", LiteralPhong(0.0, 0.5, 1.0), reciprocal=False, light=(1e-3, PHONG_1)),
    Row("opengl", LiteralPhong(0.0, 1.0, 40.0, highlight="half_vector"), reciprocal=False, light=(1e-3, OPENGL)),
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
    Row("coat of nothing", CoatedLambert(1.0, 1.0), derivatives=False),  # below eta = 1 there is total reflection
    Row("slab", Slab(1.5, 0.0)),
    Row("slab colours", Slab(2.4, TINT)),
    Row("d3d9", D3D9(1.0, METAL), view=(0.0, 1.7), light=(0.0, 1.7)),
    Row("d3d9 without metal", D3D9(1.0, 0.0), view=(0.0, 2.0), light=(0.0, 2.0), derivatives=False),  # |0| has a kink
    Row("d3d9 metallic", D3D9(0.5, (0.3, 0.2, 0.1), p=2.5), view=(0.0, 1.35), light=(0.0, 1.35)),
    Row("d3d9 black", D3D9(0.0, TINT)),
    Row("d3d9 sun", D3D9(1.0, METAL, sun_fresnel=True), reciprocal=False, view=(0.0, 1 + 0.7 * (1 - AVERAGE))),
    Row(
        "d3d9 above 1",
        D3D9(1.0, METAL, r0=0.5, m=0.96, sun_fresnel=True),
        non_negative=False,
        reciprocal=False,
        view=(0.0, 0.7 * (0.5 - 0.96 / 21) + 1.46 - 0.1 * 0.46),
        light=(0.0, 1.46 - 0.8 * 0.46),
    ),
    Row("repaired", D3D9Repaired(1.0, 0.0)),
    Row("repaired metallic", D3D9Repaired(TINT, 0.3, p=2.5)),
    Row("repaired above 1", D3D9Repaired(1.0, 0.0, r0=0.5, m=0.96), non_negative=False),
    Row("mix", Mix(Lambert(1.0), ModifiedPhong(1.0, 20.0), TINT)),
    Row("mix of coats", Mix(CoatedLambert(1.0, 1.5), Slab(1.5, 0.3), 0.3)),
    Row("mix with one that is not", Mix(Lambert(1.0), D3D9(1.0, METAL), 0.25), view=(0.0, 1.175), light=(0.0, 1.175)),
    Row("scaled", Scaled(BlinnPhong(1.0, 10.0), TINT)),
    Row("scaled above 1", Scaled(EON(1.0, 0.5), 1.5), view=(np.nan, 1.5), light=(np.nan, 1.5)),
    Row("scaled literal", Scaled(LiteralPhong(1.0, 0.0, 10.0), 0.5)),
]


# --- directions ---


def sphere(mu, phi, z=None):
    sine = np.sqrt((1 - mu) * (1 + mu))
    return sine * np.cos(phi), sine * np.sin(phi), mu if z is None else z


def edges(grazing):
    """Every pair of normal, horizon, nearly grazing, mirror, retro and lower directions."""
    special = [
        (0.0, 0.0, 1.0),
        (1e-9, 0.0, 1.0),
        (1.0, 0.0, 0.0),
        (-1.0, 0.0, 0.0),  # opposite to the one before: they have no half vector
        sphere(0.0, 1.2, grazing),
        sphere(0.0, 1.2 + np.pi, grazing),
        sphere(0.0, 1.2, 1e-3),
        sphere(0.6, 0.3),
        sphere(0.6, 0.3 + np.pi),  # its mirror direction
        sphere(-0.6, 0.3),
    ]
    return np.array([(i, o) for i in special for o in special])


EDGES = {jnp.float64: edges(1e-18), jnp.float32: edges(1e-8)}  # further out 1 / (mu_i mu_o)^2 is no float32


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
    """Forward mode: derivative of sum(cotangent f) along a tangent, pair by pair."""

    def one(wi, wo):
        return jax.jvp(lambda *x: jnp.sum(cotangent * x[0](x[1], x[2])), (model, wi, wo), tangent)[1]

    return jax.vmap(one)(wi, wo)


@functools.partial(jax.jit, static_argnames="fixed")
def albedos(model, rule, fixed):
    return jax.lax.map(lambda mu: directional_albedo(model, mu, rule, fixed=fixed), MU)


@jax.jit
def deltas(model, mu):
    """Delta parts, and their slopes in the angle."""
    parts = [getattr(model, name) for name in ("mirror", "through") if hasattr(model, name)]
    slopes = [jax.vmap(jax.grad(lambda mu, part=part: jnp.sum(part(mu))))(mu) for part in parts]
    return [jax.vmap(part)(mu) for part in parts], slopes


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
    """Where the albedo is largest and how large, if it is above 1 by more than its error."""
    found = albedos(model, rule_for(model, 4 if hasattr(model, "chart") else 3), fixed)
    value, error = (np.asarray(x).reshape(len(MU), -1) for x in found)
    assert (error < 0.05 * np.maximum(value, 1)).all()
    most = np.unravel_index(value.argmax(), value.shape)
    return (float(MU[most[0]]), float(value[most])) if (value - error).max() > 1 else None


def ends(model):
    """The model, and with each of its parameters at the ends of its range, near or far enough if these are open."""
    yield model
    for declared in parameters(model):
        old, interval = getattr(model, declared.name), declared.interval
        for end in (interval.low + 1e-3 * interval.low_open, min(interval.high, 1e3)):
            yield dataclasses.replace(model, **{declared.name: jnp.full_like(old, end)})


def is_finite(model, dtype):
    wi, wo = pairs(EDGES[dtype], dtype)
    found = (
        (values(each, wi, wo), pulled(each, wi, wo, jnp.ones((), dtype)), deltas(each, MU.astype(dtype)))
        for each in ends(cast(model, dtype))
    )
    return all(np.isfinite(leaf).all() for leaf in leaves(list(found)))


def close(a, b, rtol, floor=0.0):
    """Equality of all leaves, relative or to ``floor`` times their largest."""
    return all(
        np.allclose(x, y, rtol=rtol, atol=floor * max(1.0, abs(y).max(initial=0)))
        for x, y in zip(leaves(a), leaves(b), strict=True)
    )


def derivatives_agree(model):
    """Forward = reverse = finite difference along a random tangent of parameters and directions."""
    rng, point, h = np.random.default_rng(6), (model, *pairs(at_random(40, 5, 0.2))), 1e-5
    cotangent = jnp.array([0.5, -1.0, 2.0])
    tangent = jax.tree.map(lambda x: jnp.asarray(rng.normal(size=np.shape(x))), (model, ZERO, ZERO))

    def moved(step):
        return jax.tree.map(lambda x, t: x + step * t, point, tangent)

    forward = pushed(*point, tangent, cotangent)
    gradients = zip(leaves(pulled(*point, cotangent)), leaves(tangent), strict=True)
    reverse = sum(np.sum((g * t).reshape(len(g), -1), axis=1) for g, t in gradients)
    ahead, behind = (jnp.sum(cotangent * values(*moved(step)), axis=-1) for step in (h, -h))
    return close(forward, reverse, 1e-10, 1e-12) and close(forward, (ahead - behind) / (2 * h), 1e-5, 1e-7)


def keeps_dtype(model):
    def found(dtype):
        each = cast(model, dtype)
        return leaves((values(each, *pairs(EDGES[jnp.float32], dtype)), deltas(each, MU.astype(dtype))))

    return all(leaf.dtype == dtype for dtype in (jnp.float32, jnp.float64) for leaf in found(dtype))


def is_the_same_however_computed(model):
    """Mapped over pairs, compiled with all optimisations, and operation by operation."""
    wi, wo = pairs(at_random(2, 8))
    jax.config.update("jax_disable_most_optimizations", False)
    optimised = jax.jit(lambda model, wi, wo: jax.vmap(model)(wi, wo))(model, wi, wo)
    jax.config.update("jax_disable_most_optimizations", True)
    with jax.disable_jit():
        each = [model(*jax.tree.map(lambda x, i=i: x[i], (wi, wo))) for i in range(2)]
    mapped = values(model, wi, wo)
    return close(mapped, jnp.stack(each), 1e-12, 1e-15) and close(mapped, optimised, 1e-12, 1e-15)


@functools.cache
def verdicts(model):
    model = cast(model)
    wi, wo = pairs(at_random(3000, 1, 1e-4))
    there, back = np.asarray(values(model, wi, wo)), np.asarray(values(model, wo, wi))
    at_edges = np.asarray(values(model, *pairs(EDGES[jnp.float64])))
    return {
        "non_negative": bool(min(there.min(), at_edges.min()) >= 0),
        "reciprocal": bool(np.allclose(there, back, rtol=1e-11, atol=0)),
        "view": exceeds(model, "view"),
        "light": exceeds(model, "light"),
        "delta": all((part >= 0).all() for part in leaves(deltas(model, MU)[0])),
        "finite": is_finite(model, jnp.float64) and is_finite(model, jnp.float32),
        "same": is_the_same_however_computed(model),
        "dtype": keeps_dtype(model),
        "derivatives": derivatives_agree(model),
    }


def agrees(found, expected):
    """Whether a verdict is the expected one; of an excess, where (NaN: anywhere) and how large."""
    if isinstance(found, tuple) and isinstance(expected, tuple):
        where = np.isnan(expected[0]) or found[0] == pytest.approx(expected[0], abs=1e-12)
        return where and found[1] == pytest.approx(expected[1], rel=1e-6)
    return found == expected


# --- the tests ---


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("row", ROWS, ids=[row.name for row in ROWS])
def test_the_verdict_is_the_expected_one(row, column):
    assert agrees(verdicts(row.model)[column], getattr(row, column))


@pytest.mark.parametrize("column", COLUMNS)
def test_a_wrong_expectation_fails_in_either_direction(column):
    """Every row, with the opposite expected."""
    for row in ROWS[:6]:
        expected = getattr(row, column)
        opposite = not expected if isinstance(expected, bool) else (0.0, 1.5) if expected is None else None
        assert not agrees(verdicts(row.model)[column], opposite)


def test_an_excess_that_is_expected_elsewhere_or_of_another_size_fails():
    found = (0.0, 1.25)
    assert agrees(found, (0.0, 1.25))
    assert agrees(found, (np.nan, 1.25))
    assert not any(agrees(found, wrong) for wrong in ((0.1, 1.25), (0.0, 1.2501), (np.nan, 1.24), None))


def test_every_model_of_the_catalog_and_both_combinators_have_at_least_two_rows():
    counts = {model: sum(type(row.model) is model for row in ROWS) for model in (*catalog.MODELS.values(), Mix, Scaled)}
    assert min(counts.values()) >= 2, counts
    assert len({row.name for row in ROWS}) == len(ROWS)


# --- models that are broken on purpose ---


@pytree
class Broken:
    """Lambert with one thing wrong."""

    rho: Any = param("[0, 1]", spectral=True, default=0.5)

    def __call__(self, wi, wo):
        return jnp.where((wi.z < 0) | (wo.z < 0), 0.0, jnp.asarray(self.rho) / jnp.pi)


@pytree
class Negative(Broken):
    def __call__(self, wi, wo):
        return super().__call__(wi, wo) - 0.5 * self.rho * wi.z * wo.z


@pytree
class OneWay(Broken):
    def __call__(self, wi, wo):
        return super().__call__(wi, wo) * wi.z


@pytree
class Bright(Broken):
    def __call__(self, wi, wo):
        return 3 * super().__call__(wi, wo)


@pytree
class Stolen(Broken):
    def mirror(self, cos_theta_o):
        return self.rho * (cos_theta_o - 0.5)


@pytree
class Grazing(Broken):
    """Its slope at the horizon is infinite."""

    def __call__(self, wi, wo):
        return super().__call__(wi, wo) * jnp.sqrt(jnp.abs(wi.z * wo.z))


@pytree
class Doubled(Broken):
    """Always computed in double precision."""

    def __call__(self, wi, wo):
        return super().__call__(wi, wo) * np.float64(1.0)


@pytree
class Traced(Broken):
    """Another formula where values cannot be seen."""

    def __call__(self, wi, wo):
        return super().__call__(wi, wo) * (1.0 if isinstance(wi.z, jax.core.Tracer) else 0.9)


@pytree
class Detached(Broken):
    """A derivative is cut off."""

    def __call__(self, wi, wo):
        return super().__call__(wi, wo) * jax.lax.stop_gradient(wi.z * wo.z)


BROKEN = [
    (Broken(1.0), set()),
    (Negative(1.0), {"non_negative"}),
    (OneWay(1.0), {"reciprocal"}),
    (Bright(0.9), {"view", "light"}),
    (Stolen(1.0), {"delta", "view", "light"}),
    (Grazing(1.0), {"finite"}),
    (Doubled(1.0), {"dtype"}),
    (Traced(1.0), {"same"}),
    (Detached(1.0), {"derivatives"}),
]


@pytest.mark.parametrize(("model", "caught"), BROKEN, ids=[type(model).__name__ for model, _ in BROKEN])
def test_a_model_that_is_broken_on_purpose_fails_the_column_that_it_breaks_and_no_other(model, caught):
    expected = Row("broken", model)
    found = verdicts(model)
    assert {column for column in COLUMNS if not agrees(found[column], getattr(expected, column))} == caught
