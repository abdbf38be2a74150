"""Tables of albedos over a parameter and the angle, and the files that they are saved in."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jaxtyping import Float

from .albedo import check_arguments, directional_albedo, rule_for
from .brdf.protocol import BRDF
from .chart import AlbedoRule
from .files import write_atomically
from .params import validate

ENDINGS = (".npz", ".csv", ".exr")


class Table(NamedTuple):
    """Directional albedos over a parameter and the angle."""

    parameter: str
    values: np.ndarray
    """(P,)."""
    cos_theta_o: np.ndarray
    """(M,)."""
    albedo: np.ndarray
    """(P, M) or (P, M, C)."""
    error: np.ndarray
    """Likewise."""

    def save(self, path: Path | str) -> None:
        """Write .npz, .csv or .exr (a float32 image with the channels ``albedo`` and ``error``; one row per value).

        Raises:
            ValueError: another ending.
        """
        path = Path(path)
        if path.suffix not in ENDINGS:
            raise ValueError(f"path = {str(path)!r} must end in {', '.join(ENDINGS)}")
        write_atomically(path, dict(zip(ENDINGS, (self._npz, self._csv, self._exr), strict=True))[path.suffix])

    def _npz(self, path: Path) -> None:
        with path.open("wb") as file:
            np.savez(file, **{name: np.asarray(value) for name, value in self._asdict().items()})  # type: ignore[arg-type]

    def _csv(self, path: Path) -> None:
        channels = math.prod(self.albedo.shape[2:])
        names = [""] if self.albedo.ndim == 2 else [f"_{i}" for i in range(channels)]
        head = [self.parameter, "cos_theta_o", *(f"{what}{name}" for what in ("albedo", "error") for name in names)]
        with path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(head)
            for i, value in enumerate(self.values):
                for j, mu in enumerate(self.cos_theta_o):
                    cells = np.concatenate([np.ravel(self.albedo[i, j]), np.ravel(self.error[i, j])])
                    writer.writerow([repr(float(x)) for x in (value, mu, *cells)])

    def _exr(self, path: Path) -> None:
        from .image import openexr

        channels = {}
        for what in ("albedo", "error"):
            table = np.asarray(getattr(self, what), np.float32)
            for i in range(1 if table.ndim == 2 else table.shape[2]):
                name = what if table.ndim == 2 else f"{what}.{i}"
                channels[name] = np.ascontiguousarray(table if table.ndim == 2 else table[..., i])
        exr = openexr()
        header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
        with exr.File(header, channels) as file:
            file.write(str(path))


def replaced(model: Any, path: str, value: Any) -> Any:
    """A model with one parameter replaced, whose path may lead through nested models: ``"base.rho"``.

    Raises:
        ValueError: a parameter that the model does not have; those that it has are listed.
    """
    name, _, rest = path.partition(".")
    names = [field.name for field in dataclasses.fields(model)]
    if name not in names:
        raise ValueError(f"parameter = {path!r} is not one of {type(model).__name__}: {', '.join(names)}")
    return dataclasses.replace(model, **{name: replaced(getattr(model, name), rest, value) if rest else value})


def albedo_table(
    brdf: BRDF,
    parameter: str,
    values: Sequence[float] | Float[Array, " P"],
    cos_theta_o: Sequence[float] | Float[Array, " M"],
    rule: AlbedoRule | None = None,
    *,
    part: str = "reflected",
    fixed: str = "view",
) -> Table:
    """Directional albedos over the values of one parameter and over the angle, in one compiled call.

    Args:
        brdf: model; its other parameters are as they are.
        parameter: name, or path through nested models.
        values: (P,) values of it.
        cos_theta_o: (M,) cosines, [0, 1].
        rule, part, fixed: as in `jaxrefl.albedo.directional_albedo`; the model's own rule of level 3 if None.

    Raises:
        ValueError: an unknown parameter; a value or a cosine out of its range.
    """
    rule = rule or rule_for(brdf)
    dtype = rule.weight.dtype
    values, mu = jnp.asarray(values, dtype), jnp.asarray(cos_theta_o, dtype)
    check_arguments(part, fixed, mu, brdf, rule, many=True)
    for value in np.asarray(values):
        validate(replaced(brdf, parameter, value))

    @jax.jit
    def table(values: Array, mu: Array, rule: AlbedoRule) -> Any:
        def one(pair: tuple[Array, Array]) -> Any:
            model = replaced(brdf, parameter, pair[0])
            return directional_albedo(model, pair[1], rule, part=part, fixed=fixed)

        pairs = (jnp.repeat(values, mu.size), jnp.tile(mu, values.size))
        return jax.tree.map(lambda x: x.reshape(values.size, mu.size, *x.shape[1:]), lax.map(one, pairs))

    found = table(values, mu, rule)
    return Table(parameter, *(np.asarray(x) for x in (values, mu, found.value, found.error)))
