"""The scene as the tracer wants it: equal models stacked, evaluated once for all that have them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from .light import Ambient
from .scene import Object, Scene, canonical, is_model, is_shared
from .vec import Vec3


class Near(NamedTuple):
    """The primitives of a kind, with those that a batch of rays may meet in front."""

    order: Array
    """(n,) their places in the kind, rising among those in front."""
    number: Array
    """() how many are in front."""


class Kind(NamedTuple):
    """All primitives of one shape: what the search runs over."""

    shape: Any
    """Leaves (n,)."""
    ids: tuple[int, ...]
    """Number of each in the scene."""
    near: Near | None = None
    """Which of them the search need test; None for all."""


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


def at(models: Any, i: Array) -> Any:
    """Model i of a stack; what is shared stays as it is."""
    return jax.tree.map(lambda x: x if is_shared(x) else x[i], models, is_leaf=is_shared)


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
        if is_model(value):
            yield from _models(value)


def _stack(models: list[Any]) -> Any:
    """Equal models as one, along the leading axis; a spectrum (1,) is widened where another one has C channels."""

    if len(models) == 1:
        return models[0]

    def join(*leaves: Array) -> Array:
        channels = sorted({x.shape[-1] for x in leaves if x.ndim > 1} - {1})
        if len(channels) > 1:
            raise ValueError(
                f"the spectra of the scene have {' and '.join(map(str, channels))} channels; they must agree"
            )
        rest = jnp.broadcast_shapes(*(x.shape[1:] for x in leaves))
        return jnp.concatenate([jnp.broadcast_to(x, (x.shape[0], *rest)) for x in leaves])

    return jax.tree.map(join, *models)
