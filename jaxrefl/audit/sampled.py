"""Sampling: the density integrates to 1, belongs to the map of the unit square, and gives the weight.

For models with ``sample(wo, u1, u2, u_lobe) -> Sample(wi, weight, pdf)`` and ``pdf(wi, wo)``.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..brdf.protocol import chart_of, kinks_of
from ..params import foreign_classes, pytree
from ..quadrature import spread_points
from ..safe import safe_divide
from ..vec import Vec3, cross, norm
from .evaluate import albedos, epsilon, margin, refined
from .report import Row
from .search import unit
from .subject import TINY, Subject

_THETA = (0.0, 30.0, 60.0, 80.0, 89.0)
_SAMPLES = 256  # per angle
_ROUGH = 1e-4  # error of an integral of 1 that is worth a finer rule; lobes with an edge below the surface have it


class _Of:
    """Another function of the directions of a model, integrated as the model is."""

    model: Any

    @property
    def chart(self) -> str:
        return chart_of(self.model)

    def kinks(self) -> tuple[Any, ...]:
        return kinks_of(self.model)


@pytree
class _Density(_Of):
    """A density as a reflection model whose albedo is its integral."""

    model: Any

    def __call__(self, wi: Vec3, wo: Vec3) -> Array:
        return safe_divide(self.model.pdf(wi, wo), jnp.abs(wi.z))


@pytree
class _Missed(_Of):
    """What a model reflects into directions that it never samples."""

    model: Any

    def __call__(self, wi: Vec3, wo: Vec3) -> Array:
        return jnp.where(self.model.pdf(wi, wo) > 0, 0.0, jnp.max(jnp.abs(jnp.atleast_1d(self.model(wi, wo)))))


def _offers(subject: Subject) -> bool:
    return hasattr(subject.model, "sample") and hasattr(subject.model, "pdf")


def _views(subject: Subject) -> tuple[np.ndarray, np.ndarray]:
    """Elevations and azimuths to look from."""
    phi, elevation = np.meshgrid(subject.azimuths, np.deg2rad(90 - np.array(_THETA)), indexing="ij")
    return elevation.ravel(), phi.ravel()


def _at(subject: Subject, elevation: float, phi: float) -> str:
    turned = f", phi_o = {np.rad2deg(phi):.6g}°" if subject.dimension == 4 else ""
    return f"theta_o = {90 - np.rad2deg(elevation):.6g}°{turned}"


def pdf_normalisation(subject: Subject) -> Row:
    """Row of the integral of the density over the sphere that is farthest from 1."""
    name = "pdf_normalisation"
    if not _offers(subject):
        return Row(name, "not offered", None, "", "the model has no sample(...) and pdf(...)")
    elevation, phi = _views(subject)
    density, strict = _Density(subject.model), max(1e-6, 10 * epsilon() ** 0.5)
    found = albedos(density, np.sin(elevation), phi, part="both")
    found = refined(density, np.sin(elevation), phi, found, lambda x: x.error > _ROUGH, part="both")
    value, error = found.value[:, 0], found.error[:, 0]
    apart = np.where(np.isnan(value), np.inf, abs(value - 1))
    allowed = np.where(error < strict, strict, np.maximum(margin(error), 10 * _ROUGH))
    k = int(np.argmax(apart / allowed))
    verdict = "fails" if apart[k] > allowed[k] else "undecided" if error.max() > 100 * _ROUGH else "ok"
    text = f"the integral of the density is {value[k]:.8g} +- {error[k]:.1g}"
    return Row(name, verdict, float(value[k]), _at(subject, elevation[k], phi[k]), text, float(error[k]))


@functools.partial(jax.jit, static_argnames="classes")
def _draw(model: Any, wo: Vec3, u1: Array, u2: Array, classes: Any) -> dict[str, Any]:
    def one(wo: Vec3, u1: Array, u2: Array) -> dict[str, Any]:
        def direction(u1: Array, u2: Array, u_lobe: float = 0.5) -> Vec3:
            return model.sample(wo, u1, u2, jnp.asarray(u_lobe, u1.dtype)).wi

        drawn = model.sample(wo, u1, u2, jnp.full_like(u1, 0.5))
        by_u = jax.jacfwd(direction, argnums=(0, 1))(u1, u2)
        other = [direction(u1, u2, u) for u in (1e-3, 0.999)]
        return {
            "area": norm(cross(*(Vec3(by_u.x[i], by_u.y[i], by_u.z[i]) for i in (0, 1)))),
            "pdf": model.pdf(drawn.wi, wo),
            "own": drawn.pdf,
            "weight": jnp.ravel(drawn.weight),
            "flux": jnp.ravel(model(drawn.wi, wo) * jnp.abs(drawn.wi.z)),
            "lobes": sum(norm(drawn.wi - w) for w in other),
            "length": norm(drawn.wi),
        }

    return jax.vmap(one)(wo, u1, u2)


def _drawn(subject: Subject) -> tuple[dict[str, np.ndarray], list[str]]:
    """Samples on an even lattice of the square from each angle, and where they were drawn."""
    elevation, phi = _views(subject)
    u = spread_points(_SAMPLES + 1).T[1:]
    where = [f"{_at(subject, e, p)}, u = ({a:.4f}, {b:.4f})" for e, p in zip(elevation, phi, strict=True) for a, b in u]
    wo = unit(np.repeat(elevation, _SAMPLES), np.repeat(phi, _SAMPLES))
    u1, u2 = (jnp.asarray(np.tile(u[:, i], elevation.size), float) for i in (0, 1))
    found = _draw(subject.model, wo, u1, u2, foreign_classes(subject.model))
    return {key: np.asarray(x) for key, x in found.items()}, where


def sampling_jacobian(subject: Subject) -> Row:
    """Row of the density times the solid angle per unit of the square that is farthest from 1."""
    name = "sampling_jacobian"
    if not _offers(subject):
        return Row(name, "not offered", None, "", "the model has no sample(...) and pdf(...)")
    drawn, where = _drawn(subject)
    if np.nanmax(drawn["lobes"]) > 0:
        return Row(name, "skipped", None, "", "several lobes: the density is not that of the map of one of them")
    product = drawn["pdf"] * drawn["area"]
    apart = np.maximum(abs(product - 1), abs(drawn["length"] - 1))
    k = int(np.argmax(np.where(np.isnan(apart), np.inf, apart)))
    verdict = "ok" if apart[k] <= 10 * epsilon() ** 0.5 else "fails"
    text = f"pdf = {drawn['pdf'][k]:.6g}, 1 / |d wi / d (u1, u2)| = {1 / max(drawn['area'][k], 1e-300):.6g}"
    return Row(name, verdict, float(product[k]), where[k], text)


def sampling_weight(subject: Subject) -> Row:
    """Row of the largest difference of weight * pdf and f |cos theta_i|, and of ``Sample.pdf`` and ``pdf(wi, wo)``.

    Before these, of what is reflected into directions that are never sampled.
    """
    name = "sampling_weight"
    if not _offers(subject):
        return Row(name, "not offered", None, "", "the model has no sample(...) and pdf(...)")
    elevation, phi = _views(subject)
    missed = albedos(_Missed(subject.model), np.sin(elevation), phi, part="both").value[:, 0]
    k = int(np.argmax(missed))
    if missed[k] > 1e-6:
        text = f"the density is 0 where f is not: an albedo of {missed[k]:.6g} is never sampled"
        return Row(name, "fails", float(missed[k]), _at(subject, elevation[k], phi[k]), text)
    drawn, where = _drawn(subject)
    flux = drawn["weight"] * drawn["pdf"][:, None]
    scale = np.maximum(abs(drawn["flux"]).max(axis=1), TINY)
    weight_apart = (abs(flux - drawn["flux"]) / scale[:, None]).max(axis=1)
    pdf_apart = abs(drawn["own"] - drawn["pdf"]) / np.maximum(abs(drawn["pdf"]), TINY)
    apart = np.maximum(weight_apart, pdf_apart)
    k = int(np.argmax(np.where(np.isnan(apart), np.inf, apart)))
    verdict = "ok" if apart[k] <= 10 * epsilon() ** 0.5 else "fails"
    text = f"weight * pdf = {flux[k].max():.6g}, f |cos| = {drawn['flux'][k].max():.6g}"
    text += f"; Sample.pdf = {drawn['own'][k]:.6g}, pdf(wi, wo) = {drawn['pdf'][k]:.6g}"
    return Row(name, verdict, float(apart[k]), where[k], text)
