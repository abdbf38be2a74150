"""The properties one after the other, and the same for a test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp

from .edges import finite_gradients, finite_values
from .energy import energy, furnace
from .report import VERDICTS, Report, Row
from .sampled import pdf_normalisation, sampling_jacobian, sampling_weight
from .subject import Subject
from .symmetry import negativity, reciprocity

_CHECKS: dict[str, Callable[[Subject], Row]] = {
    "energy_view": lambda subject: energy(subject, "view"),
    "energy_light": lambda subject: energy(subject, "light"),
    "furnace": furnace,
    "reciprocity": reciprocity,
    "negativity": negativity,
    "finite_values": finite_values,
    "finite_gradients": finite_gradients,
    "pdf_normalisation": pdf_normalisation,
    "sampling_jacobian": sampling_jacobian,
    "sampling_weight": sampling_weight,
}
PROPERTIES = tuple(_CHECKS)
"""What is looked at, in the order of the rows."""


def _known(names: Sequence[str]) -> None:
    for name in names:
        if name not in PROPERTIES:
            raise ValueError(f"property = {name!r} must be one of {', '.join(PROPERTIES)}")


def audit(brdf: Any, properties: Sequence[str] = PROPERTIES, *, part: str = "both") -> Report:
    """Energy, reciprocity, sign, edges and sampling of a reflection model, each with where it is worst.

    Args:
        brdf: model, or function f(wi, wo) of two `Vec3` in JAX; a numpy function through `from_numpy`.
        properties: which of `PROPERTIES`; all of them if not given.
        part: "both", or "reflected" if f is not to be asked below the surface.

    Returns:
        Report, which prints as a table.

    Raises:
        ValueError: something that is no model, or an unknown property or part.

    Computes in the default float dtype: with `jax.enable_x64` to 8 digits or more, without to 4.
    """
    _known(properties)
    subject = Subject.of(brdf, part)
    rows = tuple(_CHECKS[name](subject) for name in properties)
    curves = {fixed: subject.__dict__.get(fixed) for fixed in ("view", "light")}
    return Report(subject.name, str(jnp.zeros(()).dtype), rows, **curves)


def assert_valid(brdf: Any, *properties: str, part: str = "both", **expected: str) -> None:
    """Raise `AssertionError`, with the rows in question, unless the audit of a model comes out as expected.

        from jaxrefl.audit import PROPERTIES, assert_valid

        @pytest.mark.parametrize("name", PROPERTIES)
        def test_my_model(name):
            assert_valid(MyModel(), name)

    Args:
        brdf, part: as for `audit`.
        properties: which of `PROPERTIES`; all if none is named.
        expected: property to verdict, such as ``reciprocity="fails"``, for a model that is known to have a defect: the
            audit must then find it. What is not named must not fail and must not be undecided.

    Raises:
        AssertionError: the audit comes out differently.
        ValueError: an unknown property or verdict.
    """
    _known([*properties, *expected])
    for name, verdict in expected.items():
        if verdict not in VERDICTS:
            raise ValueError(f"{name} = {verdict!r} must be one of {', '.join(VERDICTS)}")
    report = audit(brdf, properties or PROPERTIES, part=part)
    wrong = [r for r in report.rows if (r.verdict != expected[r.name] if r.name in expected else not r.ok)]
    if wrong:
        lines = [f"{r.name}: {r.verdict} (expected {expected.get(r.name, 'ok')}), {r.text}; {r.where}" for r in wrong]
        raise AssertionError("\n".join([report.model, *lines]))
