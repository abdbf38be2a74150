"""Drude's free and Lorentz's bound electrons: the closed form of metals."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax.typing import ArrayLike
from jaxtyping import Float

from ..params import param, pytree
from ..safe import safe_divide
from .closed import high_nm, low_nm
from .index import Index, from_permittivity
from .limits import Ranged, prepare, same_length

HC_EV_NM = 1239.8419843320026
"""Planck's constant times the speed of light in eV nm: photon energy times wavelength."""


@pytree
class DrudeLorentz(Ranged):
    """Permittivity eps_inf - f0 wp^2 / (w (w + i g0)) + sum_j f_j wp^2 / (w_j^2 - w^2 - i w g_j), energies in eV.

    w is the photon energy, time factor exp(-i w t): all terms absorb. Computed in real arithmetic, see
    `from_permittivity`. Differentiable in every parameter and the wavelength, at zero damping too; there a resonance
    hit exactly is left out. In float32 for |eps| < 1e19, of metals for wavelengths up to 1e11 nm. Source: A. D. Rakic
    et al., Appl. Opt. 37, 5271 (1998), (1)-(3), whose tables are in this form (their Gamma, f and omega).
    """

    plasma_ev: Any = param("(0, inf)", unit="eV", doc="plasma energy wp")
    f0: Any = param("[0, inf)", default=1.0, doc="strength of the free electrons; 0 for an insulator")
    gamma0_ev: Any = param("[0, inf)", unit="eV", default=0.0, doc="damping of the free electrons")
    f: Any = param("[0, inf)", spectral=True, default=(), doc="strengths of the oscillators (J,)")
    energy_ev: Any = param("[0, inf)", unit="eV", spectral=True, default=(), doc="their energies (J,)")
    gamma_ev: Any = param("[0, inf)", unit="eV", spectral=True, default=(), doc="their dampings (J,)")
    eps_inf: Any = param("(0, inf)", default=1.0, doc="permittivity far above all energies")
    low_nm: Any = low_nm()
    high_nm: Any = high_nm()

    def __call__(self, wavelength_nm: Float[ArrayLike, "..."]) -> Index:
        """Complex index at vacuum wavelengths in nm."""
        same_length(f=self.f, energy_ev=self.energy_ev, gamma_ev=self.gamma_ev)
        leaves = (self.plasma_ev, self.f0, self.gamma0_ev, self.f, self.energy_ev, self.gamma_ev, self.eps_inf)
        wavelength, wp, f0, g0, f, wj, gj, eps_inf = prepare(self, wavelength_nm, *leaves)
        w = HC_EV_NM / wavelength
        free = f0 * wp * wp / (w * w + g0 * g0)
        e = w[..., None]
        detuned, damped = (wj - e) * (wj + e), e * gj
        bound = f * wp * wp * safe_divide(1.0, detuned * detuned + damped * damped)
        real = eps_inf - free + jnp.sum(bound * detuned, axis=-1)
        return from_permittivity(real, free * g0 / w + jnp.sum(bound * damped, axis=-1))
