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
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jaxtyping import Float

from .light import Ambient
from .params import Param, is_concrete, param, parameters, require
from .vec import Vec3


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """Shape and surface of one primitive, or of n of them."""

    shape: Any
    surface: Any


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
class Scene:
    """Objects and lights by name, and what is behind them: a colour (C,) or a model ``background(direction)``."""

    objects: Mapping[str, Object] = dataclasses.field(default_factory=dict)
    lights: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    background: Any = 0.0


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True, eq=False)
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


def walk(tree: Any, path: str, change: Callable[[Leaf], Any]) -> Any:
    """The same nest of models and dicts with every field that is not itself a model replaced.

    Static fields and absent ones (None) stay as they are.
    """
    if isinstance(tree, Mapping):
        return {key: walk(tree[key], f"{path}.{key}".lstrip("."), change) for key in sorted(tree)}
    if not _is_model(tree):
        return change(Leaf(path, tree, None))
    declared = {p.name: p for p in parameters(tree)}
    fields = {}
    for field in dataclasses.fields(tree):
        value, name = getattr(tree, field.name), f"{path}.{field.name}".lstrip(".")
        if field.metadata.get("static") or value is None:
            continue
        nested = _is_model(value) or isinstance(value, Mapping)
        fields[field.name] = (
            walk(value, name, change) if nested else change(Leaf(name, value, declared.get(field.name)))
        )
    return dataclasses.replace(tree, **fields)


def _is_model(value: Any) -> bool:
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

    walk(model, path, look)


def _numbers(value: Any) -> Any:
    """A value as jnp or np takes it; a sequence that names a `Vec3` or a spectrum included."""
    if isinstance(value, (list, tuple)):
        return jnp.stack([jnp.asarray(v) for v in value]) if any(not is_concrete(v) for v in value) else np.array(value)
    return value


def _dtype(scene: Scene) -> Any:
    """Common dtype of the arrays of the scene."""
    first: dict[Any, str] = {}

    def note(leaf: Leaf) -> Any:
        for value in jax.tree.leaves(leaf.value):
            dtype = getattr(value, "dtype", None)
            if isinstance(value, Array) and not value.weak_type and jnp.issubdtype(dtype, jnp.floating):
                first.setdefault(dtype, leaf.path)
        return leaf.value

    walk(scene, "", note)
    if len(first) > 1:
        (a, path_a), (b, path_b) = list(first.items())[:2]
        raise ValueError(f"{path_a} is {a} and {path_b} is {b}; a scene has one dtype")
    return next(iter(first), jax.dtypes.canonicalize_dtype(float))


def _array(leaf: Leaf, dtype: Any) -> Any:
    path, value, declared = leaf
    if declared is None:
        return jax.tree.map(lambda x: jnp.asarray(_numbers(x), dtype), value)
    if declared.vector:
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
        if _is_model(value) and not is_shared(value):
            fields[field.name] = _walk_own(value, name, change)
        elif not _is_model(value) and value is not None and not field.metadata.get("static"):
            known = next((p for p in parameters(tree) if p.name == field.name), None)
            fields[field.name] = change(Leaf(name, value, known))
    return dataclasses.replace(tree, **fields)


def primitive_names(scene: Scene) -> list[str]:
    """Name of the object of each primitive, in the order in which primitives are numbered."""
    items = canonical(scene).objects.items()
    return [name for name, item in items for _ in range(jax.tree.leaves(item.shape)[0].shape[0])]


class Kind(NamedTuple):
    """All primitives of one shape: what the search runs over."""

    shape: Any
    """Leaves (n,)."""
    ids: tuple[int, ...]
    """Number of each in the scene."""


class Group(NamedTuple):
    """Primitives of one shape and one model of surface: what is shaded together."""

    surface: Any
    """Leaves (n, ...)."""
    ids: tuple[int, ...]
    """Number of each in the scene."""
    kind: int
    """Which of the kinds they are of."""


class Stage(NamedTuple):
    """Scene as the tracer wants it: equal models stacked."""

    kinds: tuple[Kind, ...]
    groups: tuple[Group, ...]
    lights: tuple[Any, ...]
    """Stacked lights, one entry per model."""
    ambient: Any
    """(C,) sum of the global ambient intensities."""
    background: Any

    @property
    def dtype(self) -> Any:
        """Dtype of every leaf."""
        return jax.tree.leaves(self.kinds[0].shape)[0].dtype

    def radiance_behind(self, direction: Vec3) -> Array:
        """Background in a direction."""
        return self.background(direction) if callable(self.background) else self.background


def stage(scene: Scene) -> Stage:
    """Scene with equal models stacked: objects by shape, then by surface; lights by model. Traceable."""
    scene = canonical(scene)
    sizes = {name: jax.tree.leaves(item.shape)[0].shape[0] for name, item in scene.objects.items()}
    first = dict(zip(sizes, np.cumsum([0, *sizes.values()]).tolist(), strict=False))
    numbers = {name: tuple(range(first[name], first[name] + size)) for name, size in sizes.items()}
    kinds, groups = [], []
    for members in _alike(scene.objects, lambda item: jax.tree.structure(item.shape)):
        shapes = [scene.objects[name].shape for name in members]
        kinds.append(Kind(_stack(shapes), tuple(i for name in members for i in numbers[name])))
        for names in _alike({name: scene.objects[name] for name in members}, _surface_key):
            surface = _stack([scene.objects[name].surface for name in names])
            groups.append(Group(surface, tuple(i for name in names for i in numbers[name]), len(kinds) - 1))
    ambient = [light.intensity for light in scene.lights.values() if isinstance(light, Ambient)]
    others = {k: jax.tree.map(lambda x: x[None], v) for k, v in scene.lights.items() if not isinstance(v, Ambient)}
    lights = tuple(_stack([others[name] for name in names]) for names in _alike(others, jax.tree.structure))
    return Stage(tuple(kinds), tuple(groups), lights, sum(ambient) if ambient else 0.0, scene.background)


def _alike(items: Mapping[str, Any], key: Callable[[Any], Any]) -> list[list[str]]:
    """Names of the items in lists of equal key, in order."""
    lists: dict[Any, list[str]] = {}
    for name, item in items.items():
        lists.setdefault(key(item), []).append(name)
    return list(lists.values())


def _surface_key(item: Object) -> Any:
    """Equal for objects whose surfaces can be stacked: of one structure, and nothing shared."""
    shared = any(is_shared(model) for model in _models(item.surface))
    return jax.tree.structure(item.surface), id(item) if shared else None


def _models(tree: Any) -> Iterator[Any]:
    """A model and the models in its fields."""
    yield tree
    for field in dataclasses.fields(tree):
        value = getattr(tree, field.name)
        if _is_model(value):
            yield from _models(value)


def _stack(models: list[Any]) -> Any:
    """Equal models as one, along the leading axis; a spectrum (1,) is widened where another one has C channels."""

    if len(models) == 1:
        return models[0]

    def join(*leaves: Array) -> Array:
        rest = jnp.broadcast_shapes(*(x.shape[1:] for x in leaves))
        return jnp.concatenate([jnp.broadcast_to(x, (x.shape[0], *rest)) for x in leaves])

    return jax.tree.map(join, *models)
