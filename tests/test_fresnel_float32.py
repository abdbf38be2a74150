"""Fresnel in single precision, on a million random points, against double precision at the same rounded inputs."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import fresnel

N = 1_000_000
EPS = float(np.finfo(np.float32).eps)

CASES = {
    "dielectric": (fresnel.dielectric, None),
    "conductor": (fresnel.conductor, lambda rng: rng.uniform(0, 10, N)),
    "conductor with k = 0": (fresnel.conductor, lambda rng: np.zeros(N)),
    "conductor with small k": (fresnel.conductor, lambda rng: rng.uniform(0, 1e-2, N)),
    "conductor with tiny k": (fresnel.conductor, lambda rng: 10 ** rng.uniform(-30, -2, N)),
}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    f, extinction = CASES[request.param]
    rng = np.random.default_rng(11)
    columns = [rng.uniform(0, 1, N), rng.uniform(0.05, 4, N)]
    if extinction is not None:
        columns.append(extinction(rng))
    return f, tuple(jnp.asarray(x, jnp.float32) for x in columns)


@functools.partial(jax.jit, static_argnums=0)
def value_and_slopes(f, *points):
    """Value and elementwise derivatives: one tangent of ones per argument."""

    def slope(i):
        return jax.jvp(lambda x: f(*points[:i], x, *points[i + 1 :]), (points[i],), (jnp.ones_like(points[i]),))[1]

    return f(*points), [slope(i) for i in range(len(points))]


@functools.partial(jax.jit, static_argnums=0)
def backward_slopes(f, *points):
    return jax.grad(lambda *x: f(*x).sum(), tuple(range(len(points))))(*points)


def error_over_allowed(single, f, points):
    wide = tuple(x.astype(jnp.float64) for x in points)
    exact, slopes = value_and_slopes(f, *wide)
    assert exact.dtype == jnp.float64
    allowed = 2e-6 + 4 * EPS * sum(abs(x * slope) for x, slope in zip(wide, slopes, strict=True))
    return abs(single.astype(jnp.float64) - exact) / allowed


def test_single_precision_is_as_good_as_its_rounded_arguments_allow(case):
    f, points = case
    single = value_and_slopes(f, *points)[0]
    assert single.dtype == jnp.float32
    ratio = error_over_allowed(single, f, points)
    worst = jnp.argmax(jnp.where(jnp.isnan(ratio), jnp.inf, ratio))
    assert ratio[worst] <= 1, [float(x[worst]) for x in points]


def test_single_precision_slopes_are_finite_forwards_and_backwards(case):
    f, points = case
    for slope in (*value_and_slopes(f, *points)[1], *backward_slopes(f, *points)):
        assert slope.dtype == jnp.float32
        assert jnp.isfinite(slope).all()


def test_the_criterion_rejects_the_printed_real_form():
    rng = np.random.default_rng(11)
    mu, eta, k = (rng.uniform(*ends, N).astype(np.float32) for ends in ((0, 1), (0.05, 1), (1e-4, 1e-2)))
    sin2 = 1 - mu * mu
    t0 = eta * eta - k * k - sin2
    root = np.sqrt(t0 * t0 + 4 * eta * eta * k * k)
    a = np.sqrt(np.maximum(0.5 * (root + t0), 0))
    r_s = (root - 2 * a * mu + mu * mu) / (root + 2 * a * mu + mu * mu)
    num, mixed = mu * mu * root + sin2 * sin2, 2 * a * mu * sin2
    printed = 0.5 * r_s * (1 + (num - mixed) / (num + mixed))
    assert printed.dtype == np.float32
    assert error_over_allowed(printed, fresnel.conductor, tuple(map(jnp.asarray, (mu, eta, k)))).max() > 10


ETA = np.array([1e-4, 1e-3, 0.1, 0.7, 1, 1.5, 10, 1e3, 1e4], np.float32)
K = np.array([0, 1e-6, 1e-3, 1, 10, 1e3, 1e4], np.float32)
MU = np.array([0, 1e-20, 1e-9, 1e-4, 0.5, 1], np.float32)


@pytest.mark.nan_debug
@pytest.mark.parametrize(
    ("function", "axes"),
    [
        (fresnel.conductor, (MU, ETA, K)),
        (fresnel.dielectric, (MU, ETA)),
        (lambda *x: jnp.stack(fresnel.transmittance_sp(*x)), (MU, ETA, K)),
        (fresnel.cos_theta_t, (MU, ETA)),
        (fresnel.schlick_dielectric, (MU, ETA)),
        (fresnel.average_dielectric, (ETA,)),
        (lambda *x: fresnel.gulbrandsen_inverse(*x)[0], (ETA, K)),
    ],
    ids=["conductor", "dielectric", "transmittance", "refraction", "schlick", "average", "normal_incidence"],
)
def test_value_and_slopes_are_finite_and_the_value_right_over_the_stated_range(function, axes):
    points = tuple(axis.ravel() for axis in np.meshgrid(*axes))
    numbers = tuple(range(len(points)))

    def everything(*x):
        return function(*x), jax.jacfwd(function, numbers)(*x), jax.jacrev(function, numbers)(*x)

    value, *slopes = jax.jit(jax.vmap(everything))(*points)
    assert value.dtype == np.float32
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves((value, slopes)))
    wide = jax.jit(jax.vmap(function))(*(x.astype(np.float64) for x in points))
    np.testing.assert_allclose(value, wide, atol=2e-6)


def test_the_edge_tint_has_four_digits_and_finite_slopes_over_the_stated_range():
    points = tuple(axis.ravel() for axis in np.meshgrid(ETA, K))
    tint = jax.jit(jax.vmap(lambda *x: fresnel.gulbrandsen_inverse(*x)[1]))
    np.testing.assert_allclose(tint(*points), tint(*(x.astype(np.float64) for x in points)), atol=5e-5)
    slopes = jax.jit(jax.vmap(jax.jacrev(lambda *x: fresnel.gulbrandsen_inverse(*x)[1], (0, 1))))(*points)
    assert np.isfinite(slopes).all()
