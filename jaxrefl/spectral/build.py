"""From ``build(wavelength_nm) -> Scene``, a function of ONE wavelength, to the scenes of many.

What of the scene depends on the wavelength is read from the program that ``build`` is. Where that are colours alone,
the scenes of n wavelengths are one scene whose spectra have n channels. Where it is anything else, such as the index of
a glass, rays of different wavelengths go different ways, and each wavelength is a scene of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.extend.core import Jaxpr, Literal
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import Interval, is_concrete, require
from ..scene import Leaf, Scene, walk

CALLS = ("jit", "pjit", "closed_call", "checkpoint", "custom_jvp_call")
"""Primitives whose inputs and outputs are those of the program inside."""
Build = Callable[[Any], Scene]
"""Scene of one wavelength in nanometres, a traceable function."""


class Family(NamedTuple):
    """Scenes of n wavelengths: the leaves that vary have a leading axis (n,)."""

    leaves: tuple[Array, ...]
    structure: Any
    varying: tuple[bool, ...]
    dispersing: tuple[str, ...]
    """Paths of what varies and is no colour: ``objects.ball.surface.eta``."""

    def at(self, i: Any) -> tuple[Array, ...]:
        """Leaves of the scene of wavelength i, or of those of several."""
        return tuple(x[i] if v else x for x, v in zip(self.leaves, self.varying, strict=True))


def family(build: Build, wavelength_nm: Float[ArrayLike, "n"]) -> Family:
    """Scenes of some wavelengths.

    Args:
        build: scene of one wavelength; a colour that varies is a number, or (k, 1) for the k primitives of an object.
        wavelength_nm: (n,) nanometres, (0, inf), ascending; not traced.

    Raises:
        ValueError: no ascending list of wavelengths; a colour of several channels; a wavelength where a material of
            ``build`` has no data (the first and the last one are tried outside of any trace).
    """
    if not is_concrete(wavelength_nm):
        raise ValueError("wavelength_nm is traced; which wavelengths there are has to be known")
    places = np.asarray(wavelength_nm, np.float64)
    if places.ndim != 1 or not places.size or not (np.diff(places) > 0).all():
        raise ValueError(f"wavelength_nm has shape {places.shape}; it must be one ascending axis, in nanometres")
    require("wavelength_nm", places, Interval.parse("(0, inf)"))
    for end in (places.min(), places.max()):
        walk(build(float(end)), "", _one_channel)
    program, scene = jax.make_jaxpr(build, return_shape=True)(jnp.asarray(places[0]))
    structure, varying = jax.tree.structure(scene), tuple(_depends(program.jaxpr, [True]))
    declared = _declared(jax.tree.unflatten(structure, range(len(varying))))
    axes = tuple(0 if flag else None for flag in varying)
    leaves = jax.vmap(lambda w: tuple(jax.tree.leaves(build(w))), out_axes=axes)(jnp.asarray(places))
    paths = {leaf.path for i, leaf in declared.items() if varying[i] and not (leaf.declared and leaf.declared.spectral)}
    return Family(tuple(map(jnp.asarray, leaves)), structure, varying, tuple(sorted(paths)))


def _depends(program: Jaxpr, given: list[bool]) -> list[bool]:
    """Whether each output depends on the inputs of a set; of a loop all outputs do if any input is in the set."""
    reached = {v for v, flag in zip(program.invars, given, strict=True) if flag}

    def flags(values: Iterable[Any]) -> list[bool]:
        return [not isinstance(v, Literal) and v in reached for v in values]

    for equation in program.eqns:
        into = flags(equation.invars)
        inner = equation.params.get("jaxpr", equation.params.get("call_jaxpr"))
        if equation.primitive.name in CALLS and inner is not None:
            out = _depends(getattr(inner, "jaxpr", inner), into)
        else:
            out = [any(into)] * len(equation.outvars)
        reached.update(v for v, flag in zip(equation.outvars, out, strict=True) if flag)
    return flags(program.outvars)


def _one_channel(leaf: Leaf) -> Any:
    """Refuse a colour of several channels."""
    if leaf.declared is not None and leaf.declared.spectral:
        shape = jnp.shape(leaf.value if isinstance(leaf.value, Array) else np.asarray(leaf.value))
        if shape and shape[-1] != 1:
            raise ValueError(f"{leaf.path} has {shape[-1]} channels; a scene of one wavelength has 1")
    return leaf.value


def _declared(numbered: Scene) -> dict[int, Leaf]:
    """Declaration of each leaf, by its number."""
    found: dict[int, Leaf] = {}

    def note(leaf: Leaf) -> Any:
        found.update(dict.fromkeys(jax.tree.leaves(leaf.value), leaf))
        return leaf.value

    walk(numbered, "", note)
    return found


def spectral_scene(build: Build, wavelength_nm: Float[ArrayLike, "n"]) -> Scene:
    """One scene with spectra (n,), for a ``build`` in which colours alone depend on the wavelength; (1,) if none does.

    Args, Raises: as of `family`; and a ValueError that names what depends on the wavelength and is no colour.

    Differentiable in whatever ``build`` closes over.
    """
    scenes = family(build, wavelength_nm)
    if scenes.dispersing:
        raise ValueError(f"{', '.join(scenes.dispersing)} depends on the wavelength: each one is a scene of its own")
    return combined(scenes)


def combined(scenes: Family) -> Scene:
    """Scenes that differ in colours alone, as one."""

    def channels(x: Array) -> Array:
        last = jnp.moveaxis(x, 0, -1)
        return last[..., 0, :] if last.ndim > 1 and last.shape[-2] == 1 else last

    pairs = zip(scenes.leaves, scenes.varying, strict=True)
    return jax.tree.unflatten(scenes.structure, [channels(x) if varies else x for x, varies in pairs])
