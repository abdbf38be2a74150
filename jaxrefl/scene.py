"""The scene: named objects, named lights and a background, as one pytree.

    scene = Scene(
        objects={"floor": Object(Plane(Vec3(0, 0, 0), Vec3(0, 0, 1)), Blend(Phong(k_d=[0.8, 0.7, 0.6])))},
        lights={"sun": Directional(Vec3(1, 0, -2))},
    )

An object is one primitive, or many of one shape and one model: give its leaves a leading axis (n,), spectra (n, C).
Primitives are numbered in the alphabetical order of the names of the objects, then along that axis; the Image of a
render and ties between equal distances count so. `canonical` brings every leaf to one dtype and one leading axis;
the tracer does the same by itself.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jaxtyping import Float

from .params import Interval, Param, is_concrete, param, parameters, pytree, require
from .vec import Vec3


@pytree
class Object:
    """Shape and surface of one primitive, or of n of them."""

    shape: Any
    surface: Any


@pytree
class Scene:
    """Objects and lights by name, and what is behind them: a colour (C,) or a model ``background(direction)``."""

    objects: Mapping[str, Object] = dataclasses.field(default_factory=dict)
    lights: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    background: Any = param("[0, inf)", spectral=True, default=0.0, doc="colour (C,), or a model")


@pytree
class Sky:
    """Background that goes from the colour of the horizon to those of zenith and nadir with the height of the ray."""

    zenith: Any = param("[0, inf)", spectral=True, default=1.0, doc="colour straight up (z)")
    horizon: Any = param("[0, inf)", spectral=True, default=0.5, doc="colour at the horizon")
    nadir: Any = param("[0, inf)", spectral=True, default=0.2, doc="colour straight down")

    def __call__(self, direction: Vec3) -> Float[Array, "*C"]:
        """Colour in a direction."""
        up = direction.z
        return self.horizon + jnp.where(
            up > 0, up * (jnp.asarray(self.zenith) - self.horizon), -up * (jnp.asarray(self.nadir) - self.horizon)
        )


class Leaf(NamedTuple):
    """One declared or undeclared number of a model, found by `walk`."""

    path: str
    value: Any
    declared: Param | None


def walk(tree: Any, path: str, change: Callable[[Leaf], Any], within: Interval | None = None) -> Any:
    """The same nest of models and dicts with every field that is not itself a model replaced.

    Static fields and absent ones (None) stay as they are. The colours of a texture have the range ``within`` of the
    parameter in whose place it stands.
    """
    if isinstance(tree, Mapping):
        return {key: walk(tree[key], f"{path}.{key}".lstrip("."), change) for key in sorted(tree)}
    if not is_model(tree):
        return change(Leaf(path, tree, None))
    declared = {p.name: p._replace(interval=within) if within and p.spectral else p for p in parameters(tree)}
    fields = {}
    for field in dataclasses.fields(tree):
        value, name, known = getattr(tree, field.name), f"{path}.{field.name}".lstrip("."), declared.get(field.name)
        if field.metadata.get("static") or value is None:
            continue
        if is_model(value) or isinstance(value, Mapping):
            fields[field.name] = walk(value, name, change, known.interval if known else None)
        else:
            fields[field.name] = change(Leaf(name, value, known))
    return dataclasses.replace(tree, **fields)


def is_model(value: Any) -> bool:
    """True for a dataclass of parameters, which a `Vec3` is not."""
    return dataclasses.is_dataclass(value) and not isinstance(value, (type, Vec3))


def is_shared(model: Any) -> bool:
    """True for a model, such as an `ImageTexture`, whose leaves are shared by all primitives of its object."""
    return bool(getattr(model, "shared", False))


def canonical(scene: Scene) -> Scene:
    """The scene with every number an array of one dtype and the leaves of an object broadcast to its n primitives.

    Scalars become (n,), spectra (n, C) or (n, 1), vectors `Vec3` of (n,); lights and background have no leading axis.
    The dtype is that of the arrays in the scene, or JAX's default float where there are Python numbers alone.

    Raises:
        ValueError: leaves of two dtypes (both paths are named), or a shape that does not fit. Values are the business
            of `check`.
    """
    dtype = _dtype(scene)
    scene = walk(scene, "", lambda leaf: _array(leaf, dtype))
    return dataclasses.replace(scene, objects={name: _broadcast(name, o) for name, o in scene.objects.items()})


def canonical_model(model: Any, dtype: Any) -> Any:
    """A camera, a ray or another model with every number an array of a dtype, and every vector a `Vec3`."""
    if isinstance(model, tuple):
        return jax.tree.map(lambda x: jnp.asarray(x, dtype), model)
    return walk(model, "", lambda leaf: _array(leaf, dtype))


def check(scene: Scene) -> None:
    """Raise `ValueError` for a value of the scene that is out of its range: its path, the value, the range."""
    if not scene.objects:
        raise ValueError("objects = {} has no primitive; a scene needs one")
    check_model(scene, "")


def check_model(model: Any, path: str) -> None:
    """The same for a camera or another model."""

    def look(leaf: Leaf) -> None:
        if leaf.declared is None:
            return
        values = leaf.value
        if leaf.declared.vector and not isinstance(values, Vec3):
            array = np.asarray(values) if all(map(is_concrete, jax.tree.leaves(values))) else np.zeros(3)
            if array.ndim == 0 or array.shape[-1] != 3:
                raise ValueError(f"{leaf.path} = {values!r} is not a vector of 3 numbers")
        for x in jax.tree.leaves(values):
            require(leaf.path, x, leaf.declared.interval)
        if leaf.declared.nonzero and all(map(is_concrete, jax.tree.leaves(values))):
            length = sum(np.abs(np.asarray(x)) for x in jax.tree.leaves(values))
            if isinstance(values, Vec3) and not np.all(length > 0):
                raise ValueError(f"{leaf.path} is the zero vector; it needs a direction")

    walk(model, path, look)


def _numbers(value: Any) -> Any:
    """A value as an array, or as it is; nested sequences included, traced numbers in them too."""
    if not isinstance(value, (list, tuple)):
        return value
    if all(map(is_concrete, jax.tree.leaves(value))):
        return np.array(value)
    return jnp.stack([jnp.asarray(_numbers(item)) for item in value])


def _dtype(scene: Scene) -> Any:
    """Common dtype of the arrays of the scene."""
    first: dict[Any, str] = {}

    def note(leaf: Leaf) -> Any:
        for value in jax.tree.leaves(leaf.value):
            if isinstance(value, Array) and not value.weak_type and jnp.issubdtype(value.dtype, jnp.floating):
                first.setdefault(value.dtype, leaf.path)
        return leaf.value

    walk(scene, "", note)
    if len(first) > 1:
        (a, path_a), (b, path_b) = list(first.items())[:2]
        raise ValueError(f"{path_a} is {a} and {path_b} is {b}; a scene has one dtype")
    return next(iter(first), jax.dtypes.canonicalize_dtype(float))


def _array(leaf: Leaf, dtype: Any) -> Any:
    path, value, declared = leaf
    if declared is None and not isinstance(value, (list, tuple)):
        return jax.tree.map(lambda x: jnp.asarray(x, dtype), value)
    if declared is not None and declared.vector:
        if not isinstance(value, Vec3):
            array = _numbers(value)
            if np.ndim(array) == 0 or np.shape(array)[-1] != 3:
                raise ValueError(f"{path} = {value!r} is not a vector of 3 numbers")
            value = Vec3.from_array(array)
        return jax.tree.map(lambda x: jnp.asarray(_numbers(x), dtype), value)
    return jnp.asarray(_numbers(value), dtype)


def _broadcast(name: str, item: Object) -> Object:
    """Leaves of an object with its leading axis."""
    sizes: dict[int, str] = {}

    def lead(leaf: Leaf) -> Any:
        per_item = 1 if _is_spectral(leaf) else 0
        for x in jax.tree.leaves(leaf.value):
            if np.ndim(x) > per_item + 1:
                raise ValueError(f"{leaf.path} has shape {np.shape(x)}; at most (n{', C' * per_item}) is possible")
            if np.ndim(x) == per_item + 1:
                sizes.setdefault(np.shape(x)[0], leaf.path)
        return leaf.value

    path = f"objects.{name}"
    _walk_own(item, path, lead)
    sizes.pop(1, None)
    if len(sizes) > 1:
        (a, path_a), (b, path_b) = list(sizes.items())[:2]
        raise ValueError(f"{path_a} has {a} primitives and {path_b} has {b}; an object has one number")
    n = next(iter(sizes), 1)

    def spread(leaf: Leaf) -> Any:
        spectral = _is_spectral(leaf)

        def one(x: Array) -> Array:
            if spectral and x.ndim == 0:
                x = x[None]
            return jnp.broadcast_to(x, (n, *x.shape[-1:])) if spectral else jnp.broadcast_to(x, (n,))

        return jax.tree.map(one, leaf.value)

    return _walk_own(item, path, spread)


def _is_spectral(leaf: Leaf) -> bool:
    return leaf.declared.spectral if leaf.declared else np.ndim(leaf.value) == 2


def _walk_own(tree: Any, path: str, change: Callable[[Leaf], Any]) -> Any:
    """`walk` that leaves the shared models of an object alone."""
    fields = {}
    for field in dataclasses.fields(tree):
        value, name = getattr(tree, field.name), f"{path}.{field.name}"
        if is_model(value) and not is_shared(value):
            fields[field.name] = _walk_own(value, name, change)
        elif not is_model(value) and value is not None and not field.metadata.get("static"):
            known = next((p for p in parameters(tree) if p.name == field.name), None)
            fields[field.name] = change(Leaf(name, value, known))
    return dataclasses.replace(tree, **fields)


def primitive_names(scene: Scene) -> list[str]:
    """Name of the object of each primitive, in the order in which primitives are numbered."""
    items = canonical(scene).objects.items()
    return [name for name, item in items for _ in range(jax.tree.leaves(item.shape)[0].shape[0])]
