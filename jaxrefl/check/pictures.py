"""Evaluators of section I, spheres seen from afar: photometry, highlights, mirror balls.

Every value is the radiance that `trace` brings back to a pixel of an orthographic camera which looks at a sphere from
above. Each channel is another surface, so that one ray, and one compilation, serves them all: the models of the library
and two classical laws that it does not have, Minnaert's and that of Lommel and Seeliger.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..camera import Orthographic
from ..geometry import Hit, Sphere
from ..light import Directional
from ..params import param, pytree
from ..quadrature import gauss_legendre
from ..scene import Object, Scene
from ..surface import D3D9, Blend, Coat, Local, Phong, Weights
from ..trace import trace
from ..vec import Vec3, dot
from .numerics import boundary
from .table import HostColumns, evaluates

ORIGIN, UP, BLACK = Vec3(0.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Phong(0.0)
CAMERA = Orthographic(Vec3(0.0, 0.0, 5.0), up=UP)
CHUNK = 512
LAMBERT, LOMMEL_SEELIGER, MINNAERT, PHONG, BLINN, SHINING = range(6)  # channels
FRESNEL, SCHLICK, METALLIC, COS2, SCHLICK_COS, COS = range(6, 12)


def batched(kernel: Callable[..., Any], *args: Any) -> Any:
    """Result of a kernel, a function of flat arrays that is compiled for one size, for arrays of any shapes."""
    arrays = np.broadcast_arrays(*(np.asarray(x, float) for x in args))
    shape, size = arrays[0].shape, arrays[0].size
    chunks = [np.pad(x.ravel(), (0, -size % CHUNK), mode="edge").reshape(-1, CHUNK) for x in arrays]
    parts = [kernel(*rows) for rows in zip(*chunks, strict=True)]
    return jax.tree.map(lambda *x: np.concatenate(x)[:size].reshape((*shape, *x[0].shape[1:])), *parts)


def rule(n: int, *breaks: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss-Legendre rules with n nodes between any two breaks."""
    rules = [gauss_legendre(n, a, b) for a, b in itertools.pairwise(breaks)]
    return np.concatenate([r.node for r in rules]), np.concatenate([r.weight for r in rules])


@pytree
class Everything:
    """Surface with a model in each channel, in the order of their names above; a white Lambert surface shows 1."""

    phong: Any
    blinn: Any
    k: Any = param("(0, inf)", doc="Minnaert's exponent")
    coat: Any = dataclasses.field(default_factory=lambda: Coat(BLACK, 1.5))
    clear: Any = dataclasses.field(default_factory=lambda: D3D9(BLACK))
    metallic: Any = dataclasses.field(default_factory=lambda: D3D9(BLACK, metallic=0.5))
    mirror: Any = dataclasses.field(default_factory=lambda: Blend(BLACK, 1.0))

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response of the first five."""
        phong, blinn = self.phong.local(hit, wi), self.blinn.local(hit, wi)
        lit, mu = dot(hit.n, wi) > 0, hit.cos_theta_o
        mu_i = jnp.where(lit, dot(hit.n, wi), 1.0)
        laws = jnp.stack([mu_i / (4 * (mu + mu_i)), 0.5 * (self.k + 1) * mu_i**self.k * mu ** (self.k - 1)])
        lobes = [phong.diffuse, jnp.where(lit, laws, 0.0), phong.specular, blinn.specular]
        return Local(jnp.concatenate([*lobes, jnp.zeros(7)]), jnp.zeros(12))

    def weights(self, hit: Hit) -> Weights:
        """Reflected weight of the last six."""
        models = self.coat, self.clear, self.metallic, self.mirror, self.clear, self.mirror
        reflected = [jnp.reshape(model.weights(hit).reflected, (1,)) for model in models]
        return Weights(
            reflected=jnp.concatenate([jnp.zeros(6), *reflected]),
            emitted=jnp.concatenate([jnp.zeros(5), self.phong.weights(hit).emitted, jnp.zeros(6)]),
        )


@pytree
class Surroundings:
    """What the mirrors see: 1, the cosine of the angle from the axis of the camera, or its square."""

    def __call__(self, direction: Vec3) -> Array:
        """Radiance (12,) of a direction."""
        z = direction.z
        none, one = jnp.zeros_like(z), jnp.ones_like(z)
        return jnp.stack([*[none] * 6, one, one, one, z * z, z, z])


def _radiance(x: Array, y: Array, radius: Array, phase: Array, exponent: Array) -> Array:
    """Radiance (n, 12) at places of the picture of a sphere; the light comes from the phase angle, from z towards x."""
    phong = Phong(1.0, 1.0, exponent, emission=1.0, highlight="mirror")
    surface = Everything(phong, Phong(0.0, 1.0, exponent), exponent)
    sun = Directional(Vec3(-jnp.sin(phase), 0.0 * phase, -jnp.cos(phase)))
    scene = Scene({"ball": Object(Sphere(ORIGIN, radius), surface)}, {"sun": sun}, Surroundings())
    return trace(scene, CAMERA.ray(x, y), 1, account=False).radiance


@jax.jit
def _pixels(x: Array, y: Array, dx: Array, dradius: Array, phase: Array, exponent: Array) -> tuple[Array, Array]:
    one = jnp.ones_like(dradius)
    return jax.jvp(lambda x, radius: _radiance(x, y, radius, phase, exponent), (x, one), (dx, dradius))


def pixels(
    x: Any, y: Any = 0.0, dx: Any = 0.0, *, dradius: float = 0.0, phase: float = 0.0, exponent: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Radiance (..., 12) of the unit sphere, and its derivative along (dx, dradius); exponent: shininess, and k."""
    numbers = np.float64(dradius), np.float64(phase), np.float64(exponent)
    return batched(lambda *rows: _pixels(*rows, *numbers), x, y, dx)


# --- in the light of a distant source ---


def _disc_mean(phase: float) -> np.ndarray:
    """Mean over the disc, (12,): nodes are latitudes and longitudes of the part that is lit and visible."""
    (latitude, w), (u, v) = rule(16, 0.0, np.pi / 2), rule(32, 0.0, 1.0)
    longitude, width = np.pi / 2 - (np.pi - phase) * u, (np.pi - phase) * v
    area = np.outer(w * np.cos(latitude) ** 2, width * np.cos(longitude))
    value = pixels(np.outer(np.cos(latitude), np.sin(longitude)), np.sin(latitude)[:, None], phase=phase)[0]
    return np.einsum("ij,ijc->c", area, value) * 2 / np.pi


@evaluates("I.sphere_phase", "alpha_deg", jit=False)
def _sphere_phase(c: HostColumns) -> HostColumns:
    full, mean = _disc_mean(0.0), np.stack([_disc_mean(phase) for phase in np.deg2rad(c["alpha_deg"])])
    return {
        "lambert": mean[:, LAMBERT] / full[LAMBERT],
        "lommel_seeliger": mean[:, LOMMEL_SEELIGER] / full[LOMMEL_SEELIGER],
        "disc_mean_NdotL": mean[:, LAMBERT],
    }


@evaluates(
    "I.sphere_albedo",
    skipped={"q_ls_quad": "q_ls again, by quadrature over the phase, a check of the table itself"},
    jit=False,
)
def _sphere_albedo(_: HostColumns) -> HostColumns:
    phase, w = rule(16, 0.0, np.pi)
    full, mean = _disc_mean(0.0), np.stack([_disc_mean(angle) for angle in phase])
    # all that is reflected: cosines of viewer and light in two triangles, between which the law has a ridge
    (a, u), (b, v) = rule(2, 0.0, 1.0), rule(16, 0.0, 1.0)
    larger, ratio = np.meshgrid(a, b, indexing="ij")
    mu, mu_i = np.stack([larger, larger * ratio]), np.stack([larger * ratio, larger])
    value = np.vectorize(lambda v, i: pixels(np.sin(v), phase=v - i)[0][LOMMEL_SEELIGER])(
        np.arccos(mu), np.arccos(mu_i)
    )
    bond = np.sum(4 * mu * value * np.outer(u * a, v))
    return {
        "p_lambert": full[LAMBERT],
        "q_lambert_quad": 2 * np.sum(w * np.sin(phase) * mean[:, LAMBERT]) / full[LAMBERT],
        "p_ls_over_w": full[LOMMEL_SEELIGER],
        "q_ls": bond / full[LOMMEL_SEELIGER],
        "bond_ls_over_w": bond,
    }


@evaluates(
    "I.frontal_disc_mean",
    "model",
    skipped={
        "model=FON r=1 (rho=1)": "the library has no Oren-Nayar model",
        "model=GGX hc alpha=0.25 F=1": "the library has no microfacet model",
        "model=GGX hc alpha=0.5 F=1": "likewise",
    },
    jit=False,
)
def _frontal_disc_mean(c: HostColumns) -> HostColumns:
    laws = {"minnaert": MINNAERT, "phong": PHONG, "blinn": BLINN}
    near, far = 0.5 ** np.arange(12), 1 - 0.5 ** np.arange(2, 12)
    mu, w = rule(16, 0.0, *near[:0:-1], np.sqrt(0.5), *far, 1.0)  # fine at the rim, at the lobe and at its end
    x = np.sqrt((1 - mu) * (1 + mu))

    def mean(name: str, exponent: float) -> float:
        return float(np.sum(2 * mu * w * pixels(x, exponent=exponent)[0][:, laws[name]])) if name in laws else np.nan

    names = (str(model).split()[0] for model in c["model"])
    exponents = (float(str(model).split("=")[1].split()[0]) for model in c["model"])
    return {"mean": np.array([mean(*row) for row in zip(names, exponents, strict=True)])}


@evaluates("I.highlight", given="phase angle 40 deg", jit=False)
def _highlight(_: HostColumns) -> HostColumns:
    laws, kinds = np.array([PHONG, BLINN, LAMBERT, LAMBERT]), np.arange(4)

    def before(x: np.ndarray) -> np.ndarray:  # three places where the slope vanishes, one where the light begins
        value, slope = (z[kinds, laws] for z in pixels(x, phase=np.deg2rad(40.0), exponent=50.0, dx=1.0))
        return np.where(kinds < 3, slope > 0, value == 0)

    phong, blinn, brightest, terminator = boundary(before, [0.0, 0.0, 0.0, -0.99], [0.6, 0.6, 0.9, 0.0])
    return {"highlight": (phong + blinn) / 2, "lambert_max": brightest, "terminator": terminator}


# --- mirrors ---


def frontal(dx: float = 0.0, dradius: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights of a mean over the disc, radiance at its nodes, and derivative as these move outwards by dx.

    The sphere is lit from the camera; its radius grows by ``dradius``.
    """
    mu, w = rule(48, 0.0, 1.0)
    x = np.sqrt((1 - mu) * (1 + mu))
    return 2 * mu * w, *pixels(x, dx=dx * x, dradius=dradius)


@evaluates("I.fresnel_sphere", given="n=1.5, R0=0.04, m=0.96, p=5, lambda=0.5", jit=False)
def _fresnel_sphere(_: HostColumns) -> HostColumns:
    weight, value = frontal()[:2]
    mean = weight @ value
    return {"exact_15": mean[FRESNEL], "schlick": mean[SCHLICK], "d3d9": mean[METALLIC]}


@evaluates("I.mirror_ball", given="R0=0.04", jit=False)
def _mirror_ball(_: HostColumns) -> HostColumns:
    weight, value = frontal()[:2]
    mean = weight @ value
    return {
        "mean_cos2": mean[COS2],
        "schlick_cos": mean[SCHLICK_COS],
        "schlick_uniform": mean[SCHLICK],
        "s_for_90deg": boundary(lambda x: pixels(x)[0][..., COS] > 0, 0.0, 1.0),
    }
