"""Evaluator of the film of section E: a quarter wave on glass, by the matrices and not by the closed form."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from ..films import film
from .table import Columns, evaluates

N1, GLASS = 1.38, 1.52


@evaluates("E.ar_coating", given="n1=1.38, ns=1.52, normal incidence")
def _ar_coating(c: Columns) -> dict[str, Array]:
    waves = jnp.array([[0.25, 0.0]])  # in the layer: a quarter, none
    coated, bare = film(1.0, 550.0, [N1], 0.0, waves * 550.0 / N1, 1.0, GLASS).R
    return {"R": coated, "uncoated": bare}
