import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from jax import lax

from jaxrefl import Vec3
from jaxrefl.vec import cross, dot, norm, normalize, reflect, where

coordinates = st.floats(-10, 10)
vectors = st.builds(Vec3, coordinates, coordinates, coordinates)
V = Vec3(1.0, 2.0, 3.0)


def components(v: Vec3) -> list:
    return np.asarray(v.to_array()).tolist()


def as_leaves(v: Vec3) -> Vec3:
    return jax.tree.map(jnp.asarray, v)


def weighted(v: Vec3):
    return v.x**2 + 3 * v.x * v.y + 5 * v.z


def test_the_gradient_with_respect_to_a_vector_is_a_vector():
    slope = jax.grad(weighted)(V)
    assert isinstance(slope, Vec3)
    assert components(slope) == [8, 3, 5]


@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_the_jacobian_of_a_vector_by_a_vector_is_a_vector_of_vectors(jacobian):
    slope = jacobian(lambda v: cross(v, Vec3(0.0, 0.0, 1.0)))(V)
    assert [components(row) for row in (slope.x, slope.y, slope.z)] == [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]


def test_the_hessian_of_a_scalar_of_a_vector_is_a_vector_of_vectors():
    second = jax.jit(jax.hessian(weighted))(V)
    assert [components(row) for row in (second.x, second.y, second.z)] == [[2, 3, 0], [3, 0, 0], [0, 0, 0]]


def test_vmap_takes_a_vector_of_axes():
    f = jax.vmap(lambda v: v.x + 10 * v.y + 100 * v.z, in_axes=(Vec3(0, None, 0),))
    np.testing.assert_array_equal(f(Vec3(jnp.arange(2.0), 1.0, jnp.arange(2.0))), [10, 111])


def test_vmap_over_axis_zero_maps_one_function_of_one_vector():
    batch = Vec3(*np.arange(6.0).reshape(3, 2))
    np.testing.assert_array_equal(jax.vmap(norm)(batch), np.linalg.norm(np.arange(6.0).reshape(3, 2), axis=0))


def test_a_vector_can_be_the_carry_of_a_scan():
    def step(v, _):
        return v * 2.0, v.x

    end, seen = lax.scan(step, as_leaves(V), None, length=3)
    assert components(end) == [8, 16, 24]
    assert seen.tolist() == [1, 2, 4]


def test_eval_shape_passes_through_a_vector_of_placeholders():
    out = jax.eval_shape(lambda v: normalize(v), Vec3(*(jnp.ones((4, 5)),) * 3))
    assert {leaf.shape for leaf in jax.tree.leaves(out)} == {(4, 5)}


def test_tree_map_rebuilds_a_vector_even_of_things_that_are_no_numbers():
    assert jax.tree.map(str, Vec3(1, 2, 3)).z == "3"
    assert jax.tree.leaves(Vec3(None, 2, 3)) == [2, 3]


@pytest.mark.parametrize(
    "two", [2, 2.0, np.float64(2), np.float32(2), np.int64(2), np.array(2.0), jnp.float64(2), jnp.array(2)]
)
def test_a_number_of_any_kind_on_either_side_scales_a_vector(two):
    for scaled in (two * V, V * two):
        assert isinstance(scaled, Vec3)
        assert components(scaled) == [2, 4, 6]
    assert components(V / two) == [0.5, 1, 1.5]


@pytest.mark.parametrize("array", [np.array([1.0, 2.0]), jnp.array([1.0, 2.0])])
def test_an_array_on_either_side_makes_a_batch_of_vectors(array):
    for batch in (array * V, V * array):
        assert isinstance(batch, Vec3)
        assert components(batch) == [[1, 2, 3], [2, 4, 6]]


@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_every_operation_keeps_the_dtype(dtype):
    def everything(v: Vec3):
        numbers = [v * 2, 2.0 * v, v / 3, norm(v), dot(v, v), v.to_array(), Vec3.from_spherical(v.x, 1)]
        return numbers, [v + v, v - v, -v, cross(v, v), normalize(v), reflect(v, v), where(True, v, -v)]

    results = jax.eval_shape(everything, Vec3.from_array(jnp.ones(3, dtype)))
    assert {leaf.dtype for leaf in jax.tree.leaves(results)} == {jnp.dtype(dtype)}


@pytest.mark.usefixtures("float32")
def test_a_numpy_double_leaves_a_vector_in_single_precision_in_the_default_mode_of_jax():
    v = np.float64(2) * Vec3.from_array(np.ones(3))
    assert {leaf.dtype for leaf in jax.tree.leaves(v)} == {jnp.dtype("float32")}


@pytest.mark.parametrize(
    "operation",
    [
        lambda: V * V,
        lambda: V / V,
        lambda: V + 1,
        lambda: 1.0 - V,
        lambda: np.float64(1) + V,
        lambda: 1 / V,
        lambda: np.ones(3) / V,
        lambda: V**2,
    ],
)
def test_an_operation_without_meaning_is_refused(operation):
    with pytest.raises(TypeError):
        operation()


def test_the_refusal_of_a_product_says_what_to_use():
    with pytest.raises(TypeError, match=r"dot.*cross"):
        V * V


@pytest.mark.parametrize("axis", [-1, 0, 1])
def test_an_array_goes_to_a_vector_and_back_along_any_axis(axis):
    array = np.moveaxis(np.arange(12.0).reshape(2, 2, 3), -1, axis)
    v = Vec3.from_array(array, axis=axis)
    np.testing.assert_array_equal(v.y, np.arange(12.0).reshape(2, 2, 3)[..., 1])
    np.testing.assert_array_equal(v.to_array(axis=axis), array)


@pytest.mark.parametrize(("shape", "axis"), [((), -1), ((4,), -1), ((3, 2), -1), ((2, 3), 0)])
def test_an_array_of_another_shape_is_refused_with_its_shape(shape, axis):
    with pytest.raises(ValueError, match=rf"shape \({', '.join(map(str, shape))}"):
        Vec3.from_array(np.ones(shape), axis=axis)


def test_components_of_different_shapes_broadcast_in_the_array():
    assert Vec3(jnp.ones(2), 0.0, jnp.ones((4, 1))).to_array().shape == (4, 2, 3)


@given(st.floats(-1, 1), st.floats(-7, 7))
def test_spherical_coordinates_are_those_of_the_textbook(cos_theta, phi):
    theta = math.acos(cos_theta)
    truth = [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), cos_theta]
    v = Vec3.from_spherical(cos_theta, phi)
    np.testing.assert_allclose(v.to_array(), truth, atol=2e-15)
    assert abs(norm(v) - 1) < 4e-16


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_at_a_pole_the_direction_is_the_axis_and_the_derivatives_are_finite(pole, dtype):
    def array(cos_theta, phi):
        return Vec3.from_spherical(cos_theta, phi).to_array()

    derivatives = (mode(array, argnums=(0, 1)) for mode in (jax.jacfwd, jax.jacrev))
    value, *slopes = jax.jit(lambda *x: (array(*x), *(f(*x) for f in derivatives)))(dtype(pole), dtype(0.7))
    assert value.tolist() == [0, 0, pole]
    assert [[slope.tolist() for slope in pair] for pair in slopes] == [[[0, 0, 1], [0, 0, 0]]] * 2


@pytest.mark.nan_debug
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_the_zero_vector_has_length_zero_stays_zero_and_has_zero_derivatives(dtype):
    functions = (norm, normalize, jax.grad(norm), jax.hessian(norm), jax.jacfwd(normalize), jax.jacrev(normalize))
    everything = jax.jit(lambda v: [f(v) for f in functions])(Vec3(*(dtype(0),) * 3))
    assert not any(leaf.any() for leaf in jax.tree.leaves(everything))


@pytest.mark.parametrize("scale", [1e-100, 1e-8, 1.0, 1e100])
def test_a_unit_vector_does_not_depend_on_the_scale(scale):
    np.testing.assert_allclose(normalize(Vec3(2.0, -3.0, 6.0) * scale).to_array(), np.array([2, -3, 6]) / 7, rtol=4e-16)


def test_the_derivative_of_a_unit_vector_is_the_projector_over_the_length():
    v = np.array([2.0, -3.0, 6.0])
    rows = jax.jacfwd(normalize)(as_leaves(Vec3(*v)))
    jacobian = np.array([components(row) for row in (rows.x, rows.y, rows.z)])
    np.testing.assert_allclose(jacobian, (np.eye(3) - np.outer(v, v) / 49) / 7, atol=1e-16)


def test_selection_is_componentwise_and_per_element():
    chosen = where(jnp.array([True, False]), Vec3(*jnp.ones((3, 2))), Vec3(*jnp.zeros((3, 2))))
    assert components(chosen) == [[1, 1, 1], [0, 0, 0]]


def test_the_axes_are_right_handed():
    x, y, z = (Vec3(*row) for row in np.eye(3))
    assert [components(cross(*pair)) for pair in ((x, y), (y, z), (z, x))] == [components(v) for v in (z, x, y)]


@given(vectors, vectors)
def test_dot_and_cross_are_those_of_numpy(a, b):
    p, q = a.to_array(), b.to_array()
    np.testing.assert_allclose(dot(a, b), np.dot(p, q), atol=1e-13)
    np.testing.assert_allclose(cross(a, b).to_array(), np.cross(p, q), atol=1e-13)


@given(vectors, vectors)
def test_lagranges_identity_holds(a, b):
    normal = cross(a, b)
    assert math.isclose(dot(normal, normal), dot(a, a) * dot(b, b) - dot(a, b) ** 2, rel_tol=1e-12, abs_tol=1e-10)


@given(vectors, vectors)
def test_a_cross_product_is_perpendicular_to_its_factors(a, b):
    assert abs(dot(cross(a, b), a)) < 1e-11
    assert abs(dot(cross(a, b), b)) < 1e-11


@given(vectors, vectors, vectors)
def test_the_vector_triple_product_expands(a, b, c):
    difference = cross(a, cross(b, c)) - (b * dot(a, c) - c * dot(a, b))
    assert norm(difference) < 1e-11


@given(vectors, vectors)
def test_reflecting_twice_is_the_identity_and_reflection_keeps_the_length_and_the_cosine(w, axis):
    assume(norm(axis) > 0.1)
    n = normalize(axis)
    mirrored = reflect(w, n)
    np.testing.assert_allclose(reflect(mirrored, n).to_array(), w.to_array(), atol=2e-14)
    assert abs(norm(mirrored) - norm(w)) < 2e-14
    assert abs(dot(mirrored, n) - dot(w, n)) < 2e-14


def test_a_mirror_direction_lies_in_the_plane_of_incidence_on_the_other_side():
    assert components(reflect(Vec3(0.6, 0.0, 0.8), Vec3(0.0, 0.0, 1.0))) == [-0.6, 0, 0.8]
