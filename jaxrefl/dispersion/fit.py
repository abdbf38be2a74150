"""A Drude-Lorentz model fitted to measured n and k by least squares."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike
from jaxtyping import Float

from ..fresnel import f0_conductor
from ..params import Interval, require
from .lorentz import HC_EV_NM, DrudeLorentz

_STARTS, _EVEN = 32, 8
_PARTS, _FLAT = 8, 1e-4


class Deviation(NamedTuple):
    """Of a fit from its data: root of the mean square, and the largest magnitude."""

    rms: float
    max: float


class Fit(NamedTuple):
    """A fitted model, and how far it is from its data."""

    model: DrudeLorentz
    n: Deviation
    k: Deviation
    reflectance: Deviation
    """At normal incidence from vacuum."""
    converged: bool
    """The solver met its tolerance, or the last eighth of its steps lowered the sum of squares by less than 1e-4."""
    steps: int
    """Of the solver."""


def _model(q: Array, bounds: Array, count: int, free: bool) -> DrudeLorentz:
    """Model of unbounded parameters: each p between its bounds, with d log p / dq = 1 halfway."""
    low, high = jnp.log(bounds)
    p = jnp.exp(low + (high - low) * jax.nn.sigmoid(4 * q / (high - low)))
    s0, g0, eps_inf, (s, e, g) = p[0], p[1], p[2], p[3:].reshape(3, count)
    total = s0 if free else jnp.sum(s)
    return DrudeLorentz(jnp.sqrt(total), jnp.asarray(free, p.dtype), g0 if free else 0 * g0, s / total, e, g, eps_inf)


def _bounds(energy: np.ndarray, count: int) -> np.ndarray:
    """Lowest and highest of f0 wp^2, g0, eps_inf and, of each oscillator, f wp^2, energy, damping."""
    first, last = energy.min(), energy.max()
    narrow = (last - first) / (energy.size - 1)
    low = [1e-6, 1e-4, 0.1, *[1e-6] * count, *[first / 10] * count, *[narrow] * count]
    high = [1e5, 10 * last, 100.0, *[1e5] * count, *[10 * last] * count, *[10 * last] * count]
    return np.array([low, high])


def _starts(energy: np.ndarray, count: int, bounds: np.ndarray) -> np.ndarray:
    """Unbounded parameters to begin with, the same ones at every call.

    Of the oscillators a quarter of the starts has energies spread evenly over the range and above, the others any.
    """
    rng, (first, last) = np.random.default_rng(0), (energy.min(), energy.max())
    places = np.geomspace(first, 1.5 * last, count + 2)[1:-1]
    rows = []
    for i in range(_STARTS):
        if i < _EVEN:
            e = places * np.exp(rng.normal(0, 0.3, count))
            s, g = e**2 * np.exp(rng.normal(0, 0.7, count)), 0.4 * e * np.exp(rng.normal(0, 0.7, count))
        else:
            e = np.exp(rng.uniform(np.log(first), np.log(2.5 * last), count))
            s = e**2 * np.exp(rng.uniform(np.log(0.1), np.log(3.0), count))
            g = e * np.exp(rng.uniform(np.log(0.05), 0.0, count))
        rows.append([80 * np.exp(rng.normal(0, 0.3)), 0.1 * np.exp(rng.normal(0, 0.7)), 1.5, *s, *e, *g])
    low, high = np.log(bounds)
    at = np.clip((np.log(rows) - low) / (high - low), 1e-3, 1 - 1e-3)
    return (high - low) / 4 * np.log(at / (1 - at))


@functools.cache
def _solver(count: int, free: bool, max_steps: int) -> Callable[..., Any]:
    """Compiled fit from all starts at once."""
    import optimistix

    def residuals(q: Array, data: tuple[Array, ...]) -> Array:
        wavelength, n, k, bounds = data
        found = _model(q, bounds, count, free)(wavelength)
        of_n, of_k = ((a - b) / jnp.sqrt(n * n + k * k) for a, b in ((found.n, n), (found.k, k)))
        return jnp.concatenate([of_n, of_k, f0_conductor(*found) - f0_conductor(n, k)])

    def solve(start: Array, data: tuple[Array, ...]) -> tuple[Array, Array, Array, Array]:
        tolerance = float(jnp.finfo(start.dtype).eps) ** 0.4
        method: Any = optimistix.LevenbergMarquardt(rtol=tolerance, atol=tolerance)

        def cost(q: Array) -> Array:
            return jnp.sum(residuals(q, data) ** 2)

        def part(q: Array, _: None) -> tuple[Array, tuple[Array, Array, Array]]:
            options: dict[str, Any] = {"max_steps": -(-max_steps // _PARTS), "throw": False}
            found: Any = optimistix.least_squares(residuals, method, q, data, **options)
            done = found.result == optimistix.RESULTS.successful
            return found.value, (cost(found.value), done, found.stats["num_steps"])

        q, (costs, done, steps) = jax.lax.scan(part, start, length=_PARTS)
        return q, costs[-1], done[-1] | (costs[-2] - costs[-1] < _FLAT * costs[-1]), jnp.sum(steps)

    return jax.jit(jax.vmap(solve, in_axes=(0, None)))


def fit_drude_lorentz(
    wavelength_nm: Float[ArrayLike, " N"],
    n: Float[ArrayLike, " N"],
    k: Float[ArrayLike, " N"],
    *,
    n_oscillators: int = 3,
    free_electrons: bool = True,
    max_steps: int = 512,
) -> Fit:
    """Drude-Lorentz model closest to measured n and k, by least squares with Levenberg-Marquardt.

    What is squared: the deviations of n and of k over |n + i k|, and that of the normal reflectance.

    Args:
        wavelength_nm, n, k: the data (N,), concrete, no wavelength twice; 2 N exceeds the number of parameters.
        n_oscillators: Lorentz terms, a whole number >= 1; each adds three parameters.
        free_electrons: False leaves out Drude's term (an insulator, f0 = 0).
        max_steps: of the solver from each start, a whole number >= 1.

    Returns:
        Fit with the model (range: that of the data) and its deviations in n, k and normal reflectance. All parameters
        are positive and inside wide bounds: energies and dampings below ten times the largest energy of the data, no
        line narrower than its mean spacing. It is the best of the local minima that 32 starts, the same at every
        call, lead to; a lower one may exist.

    Raises:
        ValueError: shapes that differ, too few data, equal wavelengths, a number out of its range.

    Not differentiable. Computed in the dtype that JAX gives Python floats: with 64-bit types off, in float32, where
    exact data are met to about 1e-5. Source of the form: Rakic et al., Appl. Opt. 37, 5271 (1998).
    """
    positive = Interval(0.0, np.inf, True, True)
    count, steps_allowed = _whole("n_oscillators", n_oscillators), _whole("max_steps", max_steps)
    for name, value in {"wavelength_nm": wavelength_nm, "n": n}.items():
        require(name, value, positive)
    require("k", k, Interval(0.0, np.inf, False, True))
    x, n_data, k_data = (np.asarray(value, float) for value in (wavelength_nm, n, k))
    unknowns = 3 * count + 1 + 2 * bool(free_electrons)
    if x.ndim != 1 or not x.shape == n_data.shape == k_data.shape or 2 * x.size <= unknowns:
        shapes = (x.shape, n_data.shape, k_data.shape)
        raise ValueError(
            f"wavelength_nm, n, k have shapes {shapes}; {count} oscillators need (N,) with N >= {unknowns // 2 + 1}"
        )
    twice = np.flatnonzero(np.diff(np.sort(x)) == 0)
    if twice.size:
        raise ValueError(f"wavelength_nm = {np.sort(x)[twice[0]]:g} is there twice; a fit takes each wavelength once")
    bounds = _bounds(HC_EV_NM / x, count)
    data = tuple(jnp.asarray(value) for value in (x, n_data, k_data, bounds))
    solve = _solver(count, bool(free_electrons), steps_allowed)
    q, cost, converged, steps = solve(jnp.asarray(_starts(HC_EV_NM / x, count, bounds)), data)
    best = int(jnp.argmin(jnp.where(jnp.isfinite(cost), cost, jnp.inf)))
    found = _ascending(_model(q[best], data[3], count, bool(free_electrons)), x)
    index = found(data[0])
    errors = (index.n - data[1], index.k - data[2], f0_conductor(*index) - f0_conductor(data[1], data[2]))
    in_n, in_k, in_r = (_deviation(e) for e in errors)
    return Fit(found, in_n, in_k, in_r, bool(converged[best]), int(steps[best]))


def _whole(name: str, value: Any) -> int:
    """A whole number >= 1."""
    require(name, value, Interval(1.0, np.inf, False, True))
    if np.ndim(value) or value != int(value):
        raise ValueError(f"{name} = {value} is not a whole number")
    return int(value)


def _ascending(model: DrudeLorentz, x: np.ndarray) -> DrudeLorentz:
    """The model with its oscillators in the order of their energies, and with its range."""
    order = jnp.argsort(model.energy_ev)
    f, e, g = (y[order] for y in (model.f, model.energy_ev, model.gamma_ev))
    ends = float(x.min()), float(x.max())
    return DrudeLorentz(model.plasma_ev, model.f0, model.gamma0_ev, f, e, g, model.eps_inf, *ends)


def _deviation(error: Array) -> Deviation:
    return Deviation(float(jnp.sqrt(jnp.mean(error**2))), float(jnp.max(jnp.abs(error))))
