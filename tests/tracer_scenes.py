"""Short names, cameras and scenes that the tests of the tracer share."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.geometry import Plane, Ray, Sphere
from jaxrefl.light import Ambient, Directional, PointLight, Spot
from jaxrefl.scene import Object, Scene, Sky, canonical_model
from jaxrefl.surface import D3D9, Blend, Coat, Conductor, Dielectric, Phong, Whitted
from jaxrefl.texture import Checker
from jaxrefl.trace import trace
from jaxrefl.vec import Vec3


def quick_jit(function, **options):
    """`jax.jit` with the settings of XLA, where it has them, that compile twice as fast and run slower."""
    settings = {"xla_cpu_use_fusion_emitters": False, "xla_cpu_parallel_codegen_split_count": 1}
    try:
        jax.jit(lambda x: x, compiler_options=settings).lower(0.0).compile()
    except jax.errors.JaxRuntimeError:
        settings = {}
    return jax.jit(function, compiler_options=settings, **options)


STATIC = ("n_bounces", "max_nodes", "max_waiting", "account", "terms")
quick_trace = quick_jit(trace, static_argnames=STATIC)

UP = Vec3(0.0, 0.0, 1.0)
DOWN = Vec3(0.0, 0.0, -1.0)
ORIGIN = Vec3(0.0, 0.0, 0.0)
ABOVE = Orthographic(Vec3(0.0, 0.0, 5.0), up=Vec3(0.0, 1.0, 0.0))  # looks down, one unit is half a picture
VIEW = Pinhole(Vec3(0.3, -6.0, 2.6), Vec3(0.0, 0.0, 0.7), field_of_view=0.65)  # of the zoo
BLACK = Phong(k_d=0.0)


def vec(array) -> Vec3:
    """Vector from an array (..., 3) of its own dtype."""
    array = np.asarray(array)
    return Vec3(*(jnp.asarray(array[..., i]) for i in range(3)))


def units(rng, n) -> np.ndarray:
    """Directions (n, 3), uniform on the sphere."""
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def lamp(emission) -> Phong:
    return Phong(k_d=0.0, emission=emission)


def plane(surface, point=ORIGIN, normal=UP) -> Object:
    return Object(Plane(point, normal), surface)


def ball(surface, radius=1.0, center=ORIGIN) -> Object:
    return Object(Sphere(center, radius), surface)


def rays_of(camera, width, height, dtype=jnp.float64) -> Ray:
    """Rays (height x width,) through the centres of the pixels, row by row."""
    camera, i = canonical_model(camera, dtype), jnp.arange(width * height)
    x, y = (2 * (i % width + 0.5) - width) / height, 1 - 2 * (i // width + 0.5) / height
    return jax.vmap(camera.ray)(x.astype(dtype), y.astype(dtype))


def zoo() -> Scene:
    """Every shape, surface, light and background, the names in an order that interleaves the models."""
    checks = Checker([0.8, 0.7, 0.6], [0.2, 0.3, 0.1], 1.3, 0.7)
    paint = Phong(k_d=[0.5, 0.3, 0.2], k_s=0.4, shininess=12.0, k_a=0.3)
    matt = Phong(k_d=0.1, k_s=0.8, shininess=7.5, highlight="mirror")
    many = np.array([[-1.6, 0.6, 0.6], [2.2, 0.1, 0.5]])
    metals = np.array([[0.7, 0.5, 0.3], [0.1, 0.2, 0.4]])
    objects = {
        "a_floor": plane(Blend(Phong(k_d=checks, k_a=0.2), 0.3), Vec3(0.1, 0.2, 0.0), Vec3(0.0, 0.1, 1.0)),
        "b_glass": ball(Dielectric(1.5, [0.3, 0.1, 0.2]), 0.7, Vec3(-1.0, -1.2, 0.9)),
        "c_gold": ball(Conductor([0.14, 0.43, 1.38], [3.7, 2.5, 1.9]), 0.8, Vec3(0.6, 0.4, 0.9)),
        "d_two": ball(D3D9(paint, metals, [0.04, 0.1], 0.8, [5.0, 2.5], sun_fresnel=True), [0.55, 0.5], many),
        "e_soap": ball(Whitted(matt, 0.2, 0.6, 1.3, 0.1, [0.2, 0.3, 0.1]), 0.5, Vec3(0.9, -1.3, 0.6)),
        "f_coat": ball(Coat(paint, 1.5), 0.6, Vec3(-0.4, 1.7, 0.8)),
        "g_lamp": ball(Phong(k_d=0.2, emission=[1.0, 0.5, 0.2]), 0.3, Vec3(-2.3, -1.0, 0.5)),
        "h_wall": plane(D3D9(paint, 0.3), Vec3(0.0, 3.0, 0.0), Vec3(0.0, -2.0, 0.0)),
        "i_clear": ball(Whitted(paint, 0.4), 0.4, Vec3(2.0, -1.0, 0.5)),
    }
    lights = {
        "sky": Ambient([0.2, 0.25, 0.3]),
        "sun": Directional(Vec3(0.4, 0.6, -1.0), 0.7, 0.5, 0.1),
        "fill": Directional(Vec3(-1.0, 0.3, -0.4), [0.1, 0.1, 0.2], 0.0, shadows=False),
        "bulb": PointLight(Vec3(-2.0, -2.0, 3.0), [0.9, 0.8, 0.6], 0.4, 0.2, 0.3, 0.1, 0.05),
        "candle": PointLight(Vec3(2.0, -2.0, 2.0), 0.5, [0.1, 0.5, 0.2], 0.0, 0.0, 0.0, 0.3),
        "spot": Spot(Vec3(0.5, -1.0, 4.0), Vec3(-0.2, 0.2, -1.0), 6.0, 0.5, 1.2, 1.0, 0.3, 0.4, 0.1, 0.02),
    }
    return Scene(objects, lights, Sky([0.3, 0.5, 0.9], [0.8, 0.8, 0.7], 0.1))
