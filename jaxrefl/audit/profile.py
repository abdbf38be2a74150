"""What is drawn of a model: its lobe in the plane of incidence, and its albedo over the angle."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .evaluate import albedos, values
from .search import unit
from .subject import Subject


class Profile(NamedTuple):
    """Two curves of a model, each the mean of the channels."""

    angle: np.ndarray
    """Of the view from the normal, (N,) radians in [-pi/2, pi/2]; the light is on the negative side."""
    lobe: np.ndarray
    """f in 1/sr, (N,)."""
    theta: np.ndarray
    """(M,) radians."""
    albedo: np.ndarray
    """(M,), with the view at theta; reflected, transmitted and delta parts."""


def profile(brdf: Any, theta_i: float = 0.5, samples: int = 721, angles: int = 91) -> Profile:
    """Lobe for a light at an angle in radians, and the albedos.

    Args:
        brdf: model or function f(wi, wo).
        theta_i: [0, pi/2].
        samples, angles: numbers of points.
    """
    subject = Subject.of(brdf)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, samples)
    wo = unit(0.5 * np.pi - abs(angle), np.where(angle < 0, np.pi, 0.0))
    wi = unit(np.full(samples, 0.5 * np.pi - theta_i), np.full(samples, np.pi))
    theta = np.linspace(0.0, 0.5 * np.pi, angles)
    found = albedos(subject.model, np.sin(0.5 * np.pi - theta), np.zeros(angles), part=subject.part)
    return Profile(angle, values(subject.model, wi, wo).mean(axis=-1), theta, found.value.mean(axis=-1))
