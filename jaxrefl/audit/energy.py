"""Energy: the largest directional albedo, and the sphere in a white furnace."""

from __future__ import annotations

import numpy as np

from .evaluate import ANGLES, Albedos, albedos, epsilon, margin, refined
from .report import Curve, Row
from .subject import Subject, curve_rule

_MEANING = {
    "view": "a view in an environment of radiance 1 sees",
    "light": "of a beam of power 1 there leaves",
}
_ROUNDS = 3


def _doubtful(found: Albedos) -> np.ndarray:
    """Whether an albedo may be above 1, and is not known well enough to say."""
    return (abs(found.value - 1) <= margin(found.error)) & (found.error >= epsilon() ** 0.5)


def energy(subject: Subject, fixed: str) -> Row:
    """Row of the largest directional albedo, with the view or the light held."""
    name = f"energy_{fixed}"
    curve: Curve = getattr(subject, fixed)
    channels = curve.value.shape[-1]
    if not np.all(np.isfinite(curve.value)):
        a, m, c = (int(i[0]) for i in np.nonzero(~np.isfinite(curve.value)))
        where = _where(subject, curve.cos_theta[m], curve.phi[a], c, channels)
        return Row(name, "fails", float(curve.value[a, m, c]), where, "the albedo is no finite number")
    mu, phi, found = _searched(subject, curve, fixed)
    found = refined(subject.model, mu, phi, found, _doubtful, part=subject.part, fixed=fixed)
    strange = np.nonzero(~np.isfinite(found.value + found.error))
    if strange[0].size:
        k, c = (int(i[0]) for i in strange)
        where = _where(subject, mu[k], phi[k], c, channels)
        return Row(name, "fails", float(found.value[k, c]), where, "the albedo is no finite number")
    doubtful, creates = _doubtful(found), found.value - margin(found.error) > 1 + 4 * epsilon()
    score = np.where(creates, found.value, -np.inf) if creates.any() else found.value + found.error * doubtful
    k, c = (int(i) for i in np.unravel_index(np.argmax(score), score.shape))
    value, error = float(found.value[k, c]), float(found.error[k, c])
    level = np.ptp(curve.value[..., c]) <= 2 * curve.error.max()
    where = "every angle" if level else _where(subject, mu[k], phi[k], c, channels)
    said = f"{_MEANING[fixed]} {{}} {value:.8g} +- {error:.1g}"
    if creates.any():
        more = "; it grows without bound toward grazing" if _is_unbounded(curve, c) else ""
        if subject.part == "both":
            below = albedos(subject.model, mu[k : k + 1], phi[k : k + 1], part="transmitted", fixed=fixed)
            more += f"; {below.value[0, c]:.6g} of it below the surface, where a model of reflection alone has to be 0"
        return Row(name, "fails", value, where, f"creates energy: {said.format('up to')}{more}", error)
    if doubtful.any():
        text = f"{said.format('up to')}: the error is too large to tell; kinks() of the model may name where it jumps"
        return Row(name, "undecided", value, where, text, error)
    exactly = ", 1 within the error" if value + error > 1 else ""
    return Row(name, "ok", value, where, f"conserves energy: {said.format('at most')}{exactly}", error)


def _where(subject: Subject, mu: float, phi: float, channel: int, channels: int) -> str:
    parts = [f"theta = {90 - np.rad2deg(np.arcsin(mu)):.8g}°"]
    parts += [f"phi = {np.rad2deg(phi):.6g}°"] if subject.dimension == 4 else []
    return ", ".join(parts + ([f"channel {channel}"] if channels > 1 else []))


def _searched(subject: Subject, curve: Curve, fixed: str) -> tuple[np.ndarray, np.ndarray, Albedos]:
    """Cosines, azimuths and albedos of the curve, and last those where a search between them finds the largest."""
    mu, phi = np.tile(curve.cos_theta, curve.phi.size), np.repeat(curve.phi, curve.cos_theta.size)
    known = Albedos(*(x.reshape(mu.size, -1) for x in (curve.value, curve.error)))
    k = int(np.argmax(known.value.max(axis=-1)))
    theta, m = np.arccos(curve.cos_theta), k % curve.cos_theta.size
    low, high, turn, around = theta[min(m + 1, theta.size - 1)], theta[max(m - 1, 0)], np.pi / curve.phi.size, phi[k]
    n = 1 if subject.dimension == 3 else 4
    for _ in range(_ROUNDS):
        angle = np.linspace(low, high, ANGLES // n + 2)[1:-1]
        near = np.tile(np.cos(angle), n)
        turned = np.repeat(around + turn * np.linspace(-1, 1, n) if n > 1 else np.zeros(1), angle.size)
        found = albedos(subject.model, near, turned, part=subject.part, fixed=fixed)
        k = int(np.argmax(found.value.max(axis=-1)))
        half, middle, turn, around = (high - low) / (ANGLES // n), np.arccos(near[k]), turn / 2, turned[k]
        low, high = max(middle - half, 0.0), min(middle + half, 0.5 * np.pi)
    both = Albedos(*(np.concatenate([x, y[k : k + 1]]) for x, y in zip(known, found, strict=True)))
    return np.append(mu, near[k]), np.append(phi, turned[k]), both


def _is_unbounded(curve: Curve, channel: int) -> bool:
    """Whether the albedo keeps growing by a factor while the cosine falls from 1e-2 to 1e-4 and 1e-6."""
    far, near, nearer = (curve.value[0, np.argmin(abs(curve.cos_theta - mu)), channel] for mu in (1e-2, 1e-4, 1e-6))
    return bool(nearer > 1.2 * near > 1.44 * far)


def furnace(subject: Subject) -> Row:
    """Row of a sphere in an environment of radiance 1: mean and largest deviation of its pixels from 1."""
    curve = subject.view
    if not np.all(np.isfinite(curve.value)):
        return Row("furnace", "fails", None, "", "there are pixels whose radiance is no finite number")
    above = curve.value - 1
    mean = float(np.mean(curve_rule()[1] @ curve.value))
    seen = f"mean radiance {mean:.6g}, from {curve.value.min():.6g} to {curve.value.max():.6g}"
    fails = bool((above - margin(curve.error)).max() > 4 * epsilon())
    a, m, c = (int(i) for i in np.unravel_index(np.argmax(above if fails else abs(above)), above.shape))
    level = np.ptp(above) <= 2 * curve.error.max()
    where = "every pixel" if level else f"offset = {curve.offset[m]:.6g} of the radius"
    where += f", channel {c}" if above.shape[-1] > 1 else ""
    number, error = float(above[a, m, c]), float(curve.error[a, m, c])
    if fails:
        return Row("furnace", "fails", number, where, f"{seen}: pixels are brighter than the environment", error)
    vanishes = abs(above).max() <= max(curve.error.max(), epsilon() ** 0.5)
    text = "the sphere vanishes before the environment" if vanishes else "no pixel is brighter than the environment"
    return Row("furnace", "ok", number, where, f"{seen}: {text}", error)
