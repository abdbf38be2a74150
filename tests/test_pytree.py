"""Models as pytrees: two classes never share compiled code, nor does a class defined twice."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxrefl
from jaxrefl.brdf import BlinnPhong, Lambert, LommelSeeliger, ModifiedPhong
from jaxrefl.certified import albedo_to
from jaxrefl.params import foreign_classes, param, pytree
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import BRDFSurface


def numbered(number, decorate):
    class Model:
        x: Any = 1.0

        def number(self):
            return float(number)

    Model.__annotations__ = {"x": Any}
    return decorate(Model)


def test_structures_of_different_classes_differ_and_of_one_class_agree():
    structure = jax.tree.structure
    assert structure(Lambert(0.5)) != structure(LommelSeeliger(0.5))
    assert structure(ModifiedPhong()) != structure(BlinnPhong())
    assert structure(Lambert(0.5)) == structure(Lambert(0.7))
    assert hash(structure(Lambert(0.5))) == hash(structure(Lambert(0.7)))


def test_four_hundred_classes_of_one_field_are_four_hundred_programs():
    shown = jax.jit(lambda model: model.x * 0 + model.number())
    assert [float(shown(numbered(i, pytree)(1.0))) for i in range(400)] == list(range(400))


def test_a_pytree_flattens_by_name_keeps_what_is_static_and_comes_back():
    @pytree
    class Lens:
        power: Any = param("(-inf, inf)")
        kind: str = dataclasses.field(default="thin", metadata={"static": True})

    lens = Lens(2.0, kind="thick")
    (((key,), value),), structure = jax.tree_util.tree_flatten_with_path(lens)
    assert (key.name, value) == ("power", 2.0)
    assert structure != jax.tree.structure(Lens(2.0))
    back = jax.tree.map(lambda x: 3 * x, lens)
    assert (type(back), back.power, back.kind) == (Lens, 6.0, "thick")
    with pytest.raises(dataclasses.FrozenInstanceError):
        lens.power = 1.0
    assert jax.grad(lambda lens: lens.power**2)(lens).power == 4


def register(cls):
    return jax.tree_util.register_dataclass(dataclasses.dataclass(frozen=True, eq=False)(cls))


def test_a_users_class_registered_with_jax_alone_is_told_apart_where_the_library_compiles():
    """Each of these has the structure of the others; the albedo of rho / pi is rho."""

    def scaled(factor):
        class Model:
            rho: Any = 1.0

            def __call__(self, wi, wo):
                return self.rho * factor / jnp.pi + 0 * wi.z

        Model.__annotations__ = {"rho": Any}
        return register(Model)

    models = [scaled(i / 16) for i in range(16)]
    assert foreign_classes(models[3](1.0)) == (models[3],)
    scene = Scene({"a": Object(jaxrefl.geometry.Sphere(jaxrefl.Vec3(0.0, 0.0, 0.0)), BRDFSurface(models[5](0.5)))})
    assert foreign_classes(scene) == (models[5],)
    assert foreign_classes(Scene({})) == ()
    found = [float(albedo_to(model(1.0), 0.5, 1e-6).value) for model in models]
    np.testing.assert_allclose(found, np.arange(16) / 16, atol=1e-6)


def test_every_model_of_the_library_is_a_pytree():
    for module in (jaxrefl.brdf, jaxrefl.surface, jaxrefl.light, jaxrefl.geometry, jaxrefl.camera, jaxrefl.texture):
        for value in vars(module).values():
            if isinstance(value, type) and dataclasses.is_dataclass(value):
                assert "__pytree__" in vars(value), value
