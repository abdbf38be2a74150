import functools
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl.safe import exp_log_power, safe_divide, safe_power, safe_sqrt

DTYPES = [jnp.float32, jnp.float64]
EXPONENTS = [0, 1, 2, 5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 5.0]


def edges(dtype, largest: float) -> jax.Array:
    info = jnp.finfo(dtype)
    low = [0.0, -0.0, float(info.smallest_subnormal), float(info.tiny) / 2, float(info.tiny), float(info.eps)]
    values = [*low, 0.5, 1.0, float(info.max) ** largest]
    return jnp.array([*values, *(-x for x in values)], dtype)


@functools.partial(jax.jit, static_argnums=0)
def value_and_slopes(f, *arguments):
    """Value and first derivatives, forwards and backwards, of a scalar function, mapped."""
    numbers = tuple(range(len(arguments)))
    return tuple(jax.vmap(g)(*arguments) for g in (f, jax.jacfwd(f, argnums=numbers), jax.jacrev(f, argnums=numbers)))


@functools.partial(jax.jit, static_argnums=0)
def curvatures(f, *arguments):
    """Second derivatives of a scalar function, mapped."""
    return jax.vmap(jax.hessian(f, argnums=tuple(range(len(arguments)))))(*arguments)


def all_finite(tree) -> bool:
    return all(bool(jnp.isfinite(leaf).all()) for leaf in jax.tree.leaves(tree))


def all_zero(tree) -> bool:
    return not any(bool(leaf.any()) for leaf in jax.tree.leaves(tree))


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
def test_square_root_and_slope_are_finite_at_every_edge(dtype):
    assert all_finite(value_and_slopes(safe_sqrt, edges(dtype, 1.0)))


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
def test_square_root_of_what_is_not_positive_is_zero_in_value_and_two_derivatives(dtype):
    x = jnp.array([0.0, -0.0, -1e-30, -1.0, -1e30], dtype)
    assert all_zero([value_and_slopes(safe_sqrt, x), curvatures(safe_sqrt, x)])


@pytest.mark.parametrize("dtype", DTYPES)
def test_square_root_of_a_positive_number_is_exact_with_two_derivatives(dtype):
    x = np.array([1e-20, 1e-3, 0.25, 2.0, 1e20], dtype)
    value, forward, backward = value_and_slopes(safe_sqrt, x)
    wide, tolerance = x.astype(np.float64), 4 * np.finfo(dtype).eps
    np.testing.assert_allclose(value, wide**0.5, rtol=tolerance)
    np.testing.assert_allclose([forward[0], backward[0]], [0.5 * wide**-0.5] * 2, rtol=tolerance)
    np.testing.assert_allclose(curvatures(safe_sqrt, x)[0][0], -0.25 * wide**-1.5, rtol=tolerance)


def test_square_root_of_a_clamped_negative_number_keeps_the_chain_rule_finite():
    assert jax.grad(lambda x: safe_sqrt(jnp.maximum(x, 0.0)) + x)(-1.0) == 1.0


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
def test_quotient_and_slopes_are_finite_for_every_denominator(dtype):
    a, b = (x.ravel() for x in jnp.meshgrid(jnp.array([0.0, 1.0, -1.0], dtype), edges(dtype, 1.0)))
    assert all_finite(value_and_slopes(safe_divide, a, b))


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
def test_quotient_by_nothing_is_the_fill_with_two_derivatives_zero(dtype):
    a = jnp.array([0.0, 1.0, 1.0, -1.0, 1.0], dtype)
    b = jnp.array([0.0, 0.0, -0.0, 1e-30, 1e-20], dtype) * (1 if dtype == jnp.float32 else 1e-140)
    assert all_zero([value_and_slopes(safe_divide, a, b), curvatures(safe_divide, a, b)])
    np.testing.assert_array_equal(safe_divide(a, b, fill=3.0), 3)


@pytest.mark.parametrize("dtype", DTYPES)
def test_quotient_by_a_regular_number_is_exact_with_its_derivatives(dtype):
    at = jnp.array([3], dtype), jnp.array([-0.5], dtype)
    both = jax.tree.map(lambda x: x.item(), (value_and_slopes(safe_divide, *at), curvatures(safe_divide, *at)))
    assert both == ((-6, (-2, -12), (-2, -12)), ((0, -4), (-4, -48)))


def test_complex_quotient_by_zero_is_the_fill_and_by_another_number_exact():
    assert safe_divide(1 + 2j, 0j) == 0
    assert safe_divide(jnp.complex64(1 + 2j), jnp.complex64(1j)) == 2 - 1j


def test_quotient_of_integers_is_true_division():
    assert safe_divide(1, 2) == 0.5
    assert safe_divide(1, 0) == 0


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("p", EXPONENTS)
def test_power_and_slope_are_finite_at_every_edge_for_a_fixed_exponent(p, dtype):
    assert all_finite(value_and_slopes(lambda x: safe_power(x, p), edges(dtype, 0.15)))


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", DTYPES)
def test_power_and_both_slopes_are_finite_at_every_edge_for_a_traced_exponent(dtype):
    x, p = jnp.array(list(itertools.product(edges(dtype, 0.15).tolist(), map(float, EXPONENTS))), dtype).T
    assert all_finite(value_and_slopes(safe_power, x, p))


@pytest.mark.parametrize("dtype", DTYPES)
def test_power_of_a_positive_number_is_exact_with_its_derivatives(dtype):
    x, p = np.array(list(itertools.product([1e-4, 0.3, 1.0, 7.0], map(float, EXPONENTS))), dtype).T
    value, forward, backward = value_and_slopes(safe_power, x, p)
    second = curvatures(safe_power, x, p)
    x, p, log_x = x.astype(np.float64), p.astype(np.float64), np.log(x.astype(np.float64))
    first = [p * x ** (p - 1), x**p * log_x]
    mixed = x ** (p - 1) * (1 + p * log_x)
    close = functools.partial(
        np.testing.assert_allclose, rtol=60 * np.finfo(dtype).eps, atol=1e-12 if dtype == jnp.float64 else 1e-5
    )
    close(value, x**p)
    close(forward, first)
    close(backward, first)
    close(second, [[p * (p - 1) * x ** (p - 2), mixed], [mixed, x**p * log_x**2]])


@pytest.mark.parametrize("p", [1, 2, 5])
def test_an_integer_power_has_the_derivatives_of_the_same_power_as_a_float(p):
    x = jnp.array([0.0, 1e-4, 0.3, 7.0])
    whole, real = (lambda x: safe_power(x, p)), (lambda x: safe_power(x, float(p)))
    for derivatives in (value_and_slopes, curvatures):
        for a, b in zip(*map(jax.tree.leaves, (derivatives(whole, x), derivatives(real, x))), strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-14)


@pytest.mark.nan_debug
def test_power_of_zero_has_the_documented_value_and_slopes():
    p = jnp.array([0, 0.5, 1, 1.5, 2, 5])
    value, forward, backward = value_and_slopes(safe_power, jnp.zeros(6), p)
    assert value.tolist() == [1, 0, 0, 0, 0, 0]
    for by_x, by_p in (forward, backward):
        assert by_x.tolist() == [0, 0, 1, 0, 0, 0]
        assert all_zero(by_p)


@pytest.mark.nan_debug
def test_power_of_a_negative_number_is_zero_with_every_slope_zero():
    p = jnp.array([0.5, 1, 2, 2.5, 5])
    assert all_zero(value_and_slopes(safe_power, jnp.full(5, -0.1), p))
    assert all_zero([value_and_slopes(lambda x, p=p: safe_power(x, p), jnp.array([-0.1])) for p in (1, 2, 5)])


@pytest.mark.nan_debug
def test_power_zero_is_one_with_slope_zero_even_of_a_negative_number():
    for p in (0, 0.0):
        value, *slopes = value_and_slopes(lambda x, p=p: safe_power(x, p), jnp.array([-1.0, 0.0, 2.0]))
        assert value.tolist() == [1, 1, 1]
        assert all_zero(slopes)


@pytest.mark.parametrize("dtype", DTYPES)
def test_the_fast_power_is_the_power_to_the_rounding_of_its_logarithm(dtype):
    x, p = np.array(list(itertools.product([1e-6, 0.01, 0.3, 0.9, 0.999, 1.0], [0.0, 0.5, 1.0, 12.5, 1e3])), dtype).T
    value, forward, backward = value_and_slopes(exp_log_power, x, p)
    wide_x, wide_p = x.astype(np.float64), p.astype(np.float64)
    exact, log_x = wide_x**wide_p, np.log(wide_x)
    kept = exact > 1e3 * np.finfo(dtype).tiny
    tolerance = 2 * (1 + wide_p * np.abs(log_x)) * np.finfo(dtype).eps
    assert (np.abs(value / np.where(kept, exact, 1) - 1) <= tolerance)[kept].all()
    assert (np.asarray(value)[~kept] <= 2e3 * np.finfo(dtype).tiny).all()
    for by_x, by_p in (forward, backward):
        for got, slope in ((by_x, wide_p * exact / wide_x), (by_p, exact * log_x)):
            assert (np.abs(got - slope) <= 3 * tolerance * np.abs(slope) + np.finfo(dtype).tiny * 1e7).all()


@pytest.mark.nan_debug
def test_the_fast_power_holds_its_base_between_zero_and_one_with_the_slopes_of_the_inside():
    x, p = jnp.array([0, -0.1, 0, 1, 1 + 1e-15, 1.5, 1e-320]), jnp.array([2.5, 2.5, 0, 2.5, 2.5, 2.5, 1.0])
    value, forward, backward = value_and_slopes(exp_log_power, x, p)
    assert value.tolist() == [0, 0, 1, 1, 1, 1, 0]
    for by_x, by_p in (forward, backward):
        assert by_x.tolist() == [0, 0, 0, 2.5, 2.5, 2.5, 0]
        assert by_p.tolist() == [0] * 7


@pytest.mark.parametrize("dtype", DTYPES)
def test_the_fast_power_and_its_slopes_are_finite_at_every_edge(dtype):
    x, p = jnp.array(list(itertools.product(edges(dtype, 0.15).tolist(), map(float, EXPONENTS))), dtype).T
    assert all_finite(value_and_slopes(exp_log_power, x, p))


@pytest.mark.parametrize("p", [2, 2.0])
def test_power_two_of_zero_has_second_derivative_two(p):
    assert jax.jit(jax.grad(jax.grad(lambda x: safe_power(x, p))))(0.0) == 2


@pytest.mark.parametrize(
    "value",
    [
        lambda nan: safe_sqrt(nan),
        lambda nan: safe_divide(nan, 1.0),
        lambda nan: safe_divide(1.0, nan),
        lambda nan: safe_power(nan, 5),
        lambda nan: safe_power(nan, 0.5),
        lambda nan: safe_power(2.0, nan),
        lambda nan: safe_power(0.0, nan),
        lambda nan: safe_power(-1.0, nan),
        lambda nan: exp_log_power(0.5, nan),
        lambda nan: exp_log_power(nan, 2.0),
        lambda nan: exp_log_power(0.0, nan),
    ],
    ids=[
        "sqrt",
        "numerator",
        "denominator",
        "base",
        "base_float",
        "exponent",
        "exponent_of_0",
        "exponent_of_negative",
        "fast_exponent",
        "fast_base",
        "fast_exponent_of_0",
    ],
)
def test_a_nan_that_comes_in_goes_out(value):
    assert jnp.isnan(value(jnp.nan))


@pytest.mark.parametrize(
    "f",
    [safe_sqrt, lambda x: safe_divide(1.0, x), lambda x: safe_power(x, 5), lambda x: safe_power(x, 2.5)],
    ids=["sqrt", "divide", "power_5", "power_2.5"],
)
def test_jit_and_vmap_return_what_the_eager_call_returns(f):
    x = edges(jnp.float64, 0.15)
    eager = f(x)
    np.testing.assert_allclose(jax.jit(jax.vmap(f))(x), eager, rtol=1e-15)
    np.testing.assert_allclose(jax.jit(f)(x), eager, rtol=1e-15)


@pytest.mark.parametrize("dtype", DTYPES)
def test_the_dtype_of_the_argument_is_kept(dtype):
    x = jnp.ones(2, dtype)
    for f in (safe_sqrt, lambda x: safe_divide(1.0, x), lambda x: safe_divide(x, 2), lambda x: safe_power(x, 0.5)):
        assert jax.eval_shape(f, x).dtype == dtype
