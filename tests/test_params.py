import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxrefl import Vec3
from jaxrefl.params import Interval, checked, defaults, floats, param, parameters, require, validate


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Glass:
    eta: Any = param("(0, inf)", doc="relative index")
    tint: Any = param("[0, 1]", unit="1/m", spectral=True, default=0.5, doc="colour")


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Thing:
    surface: Any
    size: Any = param("(0, inf)", default=1.0)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Lamp:
    place: Any = param("(-inf, inf)", vector=True)
    way: Any = param("(-inf, inf)", vector=True, nonzero=True, default=Vec3(0.0, 0.0, -1.0))
    colour: Any = param("[0, inf)", spectral=True, default=None)


@checked(a="[0, 1]", b="(0, inf)")
def product(a, b=1.0, c=0.0):
    return jnp.asarray(a) * b + c


def contains(text: str, value: Any) -> bool:
    return bool(Interval.parse(text).contains(np.asarray(value)))


@pytest.mark.parametrize("text", ["[0, 1]", "(0, inf)", "[0, 1)", "(-2.5, 3]", "(-inf, inf)", "[1e-06, 1e+06]"])
def test_an_interval_prints_as_it_is_written(text):
    assert str(Interval.parse(text)) == text


def test_an_infinite_end_is_open_however_it_is_written():
    assert str(Interval.parse("[-inf, inf]")) == "(-inf, inf)"
    assert not contains("[0, inf]", np.inf)


@pytest.mark.parametrize("text", ["", "0, 1", "[0, 1", "[0 1]", "[1, 0]", "[1, 1]", "[a, b]", "[0, 1, 2]", "[nan, 1]"])
def test_text_that_is_no_interval_is_refused(text):
    with pytest.raises(ValueError):
        Interval.parse(text)


@pytest.mark.parametrize("text", ["[a, b]", "[0, 1, 2]", "0, 1"])
def test_the_refusal_of_an_interval_quotes_its_text(text):
    with pytest.raises(ValueError) as refusal:
        Interval.parse(text)
    assert repr(text) in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("[0, 1]", [0.0, 0.5, 1.0], [-0.1, 1.1, np.inf]),
        ("(0, 1)", [1e-300, 0.5], [0.0, 1.0, -1e-300]),
        ("[2, inf)", [2.0, 1e300], [1.9, np.inf, -np.inf]),
        ("(-inf, inf)", [-1e300, 0.0, 1e300], [np.inf, -np.inf]),
    ],
)
def test_an_interval_contains_what_lies_between_its_ends(text, inside, outside):
    assert Interval.parse(text).contains(np.array(inside)).all()
    assert not Interval.parse(text).contains(np.array(outside)).any()


@pytest.mark.parametrize("text", ["[0, 1]", "(0, inf)", "(-inf, inf)"])
def test_nan_is_in_no_interval(text):
    assert not contains(text, np.nan)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_closed_end_admits_a_few_roundings_of_the_dtype_and_no_more(dtype):
    eps = np.finfo(dtype).eps
    assert contains("[0, 1]", dtype(1) + 4 * eps)
    assert contains("[0, 1]", -4 * eps)
    assert not contains("[0, 1]", dtype(1) + 20 * eps)
    assert not contains("[0, 1]", -20 * eps)


def test_an_open_end_has_no_slack():
    assert not contains("(0, 1)", -1e-300)
    assert not contains("(0, 1)", np.nextafter(1.0, 2.0))


def test_the_slack_grows_with_the_magnitude_of_the_end():
    assert contains("[0, 1000]", 1000 + 1e-12)
    assert not contains("[0, 1]", 1 + 1e-12)


def test_parameters_are_listed_in_the_order_of_the_fields():
    assert [(p.name, str(p.interval), p.unit, p.spectral, p.doc) for p in parameters(Glass)] == [
        ("eta", "(0, inf)", "", False, "relative index"),
        ("tint", "[0, 1]", "1/m", True, "colour"),
    ]


def test_a_vector_and_an_absent_parameter_are_declared_like_numbers():
    place, way, colour = parameters(Lamp)
    assert (place.vector, place.nonzero, place.spectral, str(place.interval)) == (True, False, False, "(-inf, inf)")
    assert (way.vector, way.nonzero) == (True, True)
    assert (colour.vector, colour.nonzero, colour.spectral) == (False, False, True)
    assert defaults(Lamp)["colour"] is None
    assert defaults(Lamp)["way"].z == -1


@pytest.mark.parametrize("colour", [0.5, None])
def test_validate_passes_a_vector_and_an_absent_parameter(colour):
    validate(Lamp(Vec3(0.0, 1.0, 2.0), colour=colour))
    with pytest.raises(ValueError, match=r"place = inf is outside \(-inf, inf\)"):
        validate(Lamp(Vec3(0.0, np.inf, 2.0), colour=colour))


def test_parameters_of_an_instance_are_those_of_its_class():
    assert list(parameters(Glass(1.5, 0.5))) == list(parameters(Glass))


def test_an_undeclared_field_is_no_parameter():
    assert [p.name for p in parameters(Thing)] == ["size"]


def test_a_field_without_a_default_is_required():
    assert defaults(Glass) == {"tint": 0.5}
    with pytest.raises(TypeError, match="eta"):
        Glass()


def test_a_bad_range_fails_where_it_is_declared():
    with pytest.raises(ValueError, match="not an interval"):
        param("0..1")


def test_validate_names_the_path_the_value_and_the_range():
    tree = {"objects": {"glass": Thing(Glass(-1.0, 0.5))}}
    with pytest.raises(ValueError) as refusal:
        validate(tree)
    assert str(refusal.value) == "objects.glass.surface.eta = -1.0 is outside (0, inf)"


def test_validate_numbers_the_elements_of_a_sequence():
    with pytest.raises(ValueError, match=r"^lights\[1\]\.size = -2\.0 is outside"):
        validate({"lights": [Thing(Glass(1.5)), Thing(Glass(1.5), size=-2.0)]})


def test_validate_names_a_field_of_a_bare_model_without_a_dot():
    with pytest.raises(ValueError, match=r"^eta = 0\.0 is outside"):
        validate(Glass(0.0, 0.5))


def test_validate_counts_the_elements_of_a_spectrum_that_are_outside():
    with pytest.raises(ValueError, match=r"^tint = 1\.5 is outside \[0, 1\] \(first of 2 such elements\)$"):
        validate(Glass(1.5, jnp.array([0.5, 1.5, 2.0])))


def test_a_scalar_field_refuses_a_spectrum_and_a_spectral_field_takes_it():
    validate(Glass(1.5, np.ones(3)))
    with pytest.raises(ValueError, match=r"^a\.eta has shape \(3,\); it is a scalar$"):
        validate({"a": Glass(np.full(3, 1.5), 0.5)})


def test_validate_passes_a_legal_tree():
    validate({"a": [Thing(Glass(1.5, 0.5)), Thing(Glass(np.float32(2), jnp.zeros(4)))], "b": (), "c": "text"})


def test_validate_ignores_a_class():
    validate({"model": Glass})


@pytest.mark.parametrize("value", ["1", None, 1j, np.array([1.0, None])])
def test_what_is_no_real_number_is_refused_by_name(value):
    with pytest.raises(ValueError, match=r"^x = .*not a real number"):
        require("x", value, Interval.parse("[0, 1]"))


@pytest.mark.parametrize("value", [True, 1, np.int32(1), jnp.bfloat16(1), jnp.float16(0.5), np.array([]), [0.25, 1]])
def test_every_kind_of_real_number_is_accepted(value):
    require("x", value, Interval.parse("[0, 1]"))


def test_checked_names_the_argument_the_value_and_the_range():
    with pytest.raises(ValueError) as refusal:
        product(1.5)
    assert str(refusal.value) == "a = 1.5 is outside [0, 1]"


def test_checked_sees_keyword_arguments():
    with pytest.raises(ValueError, match=r"^b = -1 is outside \(0, inf\)"):
        product(0.5, b=-1)


def test_checked_leaves_the_other_arguments_alone():
    assert product(0.5, 2.0, c=-1e9) == 1.0 - 1e9


def test_checked_refuses_nan():
    with pytest.raises(ValueError, match="a = nan"):
        product(np.nan)


@pytest.mark.parametrize("transform", [jax.jit, jax.grad, jax.vmap, jax.jacfwd])
def test_checked_is_silent_under_a_transformation(transform):
    argument = jnp.array([2.0]) if transform is jax.vmap else 2.0
    assert jnp.isfinite(transform(product)(argument)).all()


def test_checked_still_sees_a_concrete_argument_beside_a_traced_one():
    with pytest.raises(ValueError, match="b = -1"):
        jax.jit(lambda a: product(a, -1.0))(0.5)


def test_checked_refuses_a_range_for_an_argument_that_does_not_exist():
    with pytest.raises(ValueError, match=r"\['z'\] are not arguments of f"):

        @checked(z="[0, 1]")
        def f(x):
            return x


@pytest.mark.usefixtures("float32")
@pytest.mark.parametrize("value", [0.5, np.float64(0.5), np.full(3, 0.5), [0.5, 1.0], 1, np.float32(0.5)])
def test_checking_a_concrete_number_is_silent_in_the_default_mode_of_jax(value):
    product(value)  # a warning is an error here
    with pytest.raises(ValueError, match="a = "):
        product(np.add(value, 1))


def test_checked_keeps_the_name_the_docstring_and_the_ranges():
    assert product.__name__ == "product"
    assert {name: str(interval) for name, interval in product.ranges.items()} == {"a": "[0, 1]", "b": "(0, inf)"}


def test_a_model_survives_jit():
    out = jax.jit(lambda g: g)(Glass(1.5, jnp.ones(3)))
    assert isinstance(out, Glass)
    assert (out.eta, out.tint.shape) == (1.5, (3,))


def test_a_model_survives_vmap_with_a_model_of_axes():
    f = jax.vmap(lambda g: g.eta * g.tint, in_axes=(Glass(0, None),))
    np.testing.assert_array_equal(f(Glass(jnp.arange(3.0), 2.0)), [0, 2, 4])


@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_a_jacobian_with_respect_to_a_model_is_a_model(jacobian):
    slope = jax.jit(jacobian(lambda g: g.eta * g.tint))(Glass(3.0, jnp.array([1.0, 2.0])))
    assert isinstance(slope, Glass)
    np.testing.assert_array_equal(slope.eta, [1, 2])
    np.testing.assert_array_equal(slope.tint, 3 * np.eye(2))


def test_a_model_survives_eval_shape_although_its_leaves_are_no_numbers():
    out = jax.eval_shape(lambda g: g, Glass(1.5, jnp.ones(3)))
    assert out.tint == jax.ShapeDtypeStruct((3,), jnp.float64)


def test_an_illegal_model_can_be_built_and_is_refused_only_by_validate():
    model = Glass(-1.0, 0.5)
    with pytest.raises(ValueError):
        validate(model)


@pytest.mark.parametrize(
    ("values", "dtype"),
    [
        ((1, 2), jnp.float64),
        ((0.5, jnp.float32(1)), jnp.float32),
        ((1, jnp.ones(3, jnp.float32)), jnp.float32),
        ((np.float32(1), jnp.float64(1)), jnp.float64),
        ((np.float64(1), jnp.float32(1)), jnp.float64),
        ((jnp.arange(3),), jnp.float64),
        (([0, 1, 2],), jnp.float64),
        (((0.5, 1.0), 2), jnp.float64),
        ((jnp.bfloat16(1), 2.0), jnp.bfloat16),
    ],
)
def test_floats_have_the_common_floating_dtype_of_the_arrays(values, dtype):
    assert {x.dtype for x in floats(*values)} == {jnp.dtype(dtype)}


@pytest.mark.usefixtures("float32")
@pytest.mark.parametrize("value", [1, 0.5, [0.5, 1], np.float64(1), np.ones(3)])
def test_floats_are_single_precision_in_the_default_mode_of_jax(value):
    assert floats(value)[0].dtype == jnp.float32


def test_floats_keep_every_shape():
    assert [x.shape for x in floats(1, [1, 2], np.ones((2, 3)))] == [(), (2,), (2, 3)]


def test_floats_take_a_list_of_traced_numbers():
    assert jax.grad(lambda x: floats([x, 2.0])[0].prod())(3.0) == 2.0


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_membership_is_order_away_from_the_ends(a, b, x):
    low, high = sorted((a, b))
    slack = 1e-6 * (1 + abs(low) + abs(high))
    if high - low > slack and min(abs(x - low), abs(x - high)) > slack:
        for text in (f"[{low!r}, {high!r}]", f"({low!r}, {high!r})"):
            assert contains(text, x) == (low < x < high)
