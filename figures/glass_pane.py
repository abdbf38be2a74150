"""D3D9 (7): the alpha of a glass pane, as printed and premultiplied, over a background."""

import jax
import numpy as np

from jaxrefl import d3d9, fresnel, plot
from jaxrefl.geometry import Plane, Ray
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import D3D9, Phong
from jaxrefl.trace import trace
from jaxrefl.vec import Vec3

CAPTION = """A pane of D3D9 glass (R0 = 0.04, m = 0.96, p = 5, λ = d = d_a = 0) under a white sky, φ = 1, over a
background of mean 0.5: seen by a fish-eye whose radius is the angle, and along that radius. With the alpha of (7) as
printed and the straight blend the reflection counts by its square, at 0° 0.0016 instead of 0.04: up to 82.1° the pane
that mirrors a white sky is darker than the background alone, down to 0.4375 at 74.8°, and at 80° it shows 0.463. With
alpha premultiplied it shows 0.705 there, R + (1 - R) / 2, and is nowhere more than 0.018 from exact Fresnel."""
SIZE = (8.8, 6.4)
WAYS = ("printed", "premultiplied", "exact")


def checker(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Squares of 0.4 and 0.6."""
    return np.where((np.floor(x) + np.floor(y)) % 2 == 0, 0.4, 0.6)


def compute(r0: float = 0.04, m: float = 0.96, p: float = 5.0, columns: int = 720, pixels: int = 180) -> dict:
    theta = (np.arange(columns) + 0.5) * 90 / columns
    across = ((2 * np.arange(pixels) + 1) / pixels - 1) * 100
    x, y = np.meshgrid(across, across)
    glass = D3D9(Phong(k_d=0.0), r0=r0, m=m, p=p, alpha=0.0)
    scene = Scene({"pane": Object(Plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), glass)}, background=1.0)
    # angles of a radius of the fish-eye, two more, and all of its picture; beyond 90 degrees rays go to the sky
    angle = np.deg2rad(np.concatenate([theta, [0.0, 80.0], np.hypot(x, y).ravel()]))
    direction = Vec3(np.sin(angle), 0 * angle, -np.cos(angle))
    seen = trace(scene, Ray(Vec3(0 * angle, 0 * angle, 0 * angle + 1), direction), 1)
    is_glass = np.asarray(seen.primitive) >= 0
    color = np.where(is_glass, seen.radiance[:, 0], 0.0)  # beside the pane there is its background, not the sky
    reflectance = fresnel.dielectric(np.clip(np.cos(angle), 0, 1), (1 + r0**0.5) / (1 - r0**0.5))
    exact = np.where(is_glass, reflectance, 0.0)
    printed = jax.vmap(d3d9.alpha_printed)(seen.coverage, color)

    def over(background: np.ndarray, part: slice) -> np.ndarray:
        """What is shown over a background, in the order of WAYS."""
        r, full, a, b = (np.asarray(values)[part] for values in (color, exact, printed, seen.alpha))
        return np.stack(
            [d3d9.blend(r, a, background), d3d9.blend_premultiplied(r, b, background), full + (1 - full) * background]
        )

    radius, points, disc = slice(columns), slice(columns, columns + 2), slice(columns + 2, None)
    bare = checker(theta / 7.5, np.arange(80)[:, None] // 20)
    strips = over(bare, radius)
    strips[:, :20] = bare[:20]
    return {
        "theta_deg": theta,
        "shown": over(np.full(columns, 0.5), radius),
        "shown_0_80": over(np.full(2, 0.5), points),
        "from_reflection_0": over(np.zeros(2), points)[:, 0],
        "strips": strips,
        "discs": over(checker(x / 25, y / 25).ravel(), disc).reshape(3, pixels, pixels),
    }


def draw(data: dict, fig) -> None:
    axes = fig.subplots(3, 2, width_ratios=(1, 3.2), height_ratios=(1, 1, 1.5))
    theta, shown = data["theta_deg"], data["shown"]
    titles = ("(7) as printed, straight blend", "alpha premultiplied", "exact Fresnel")
    colors, lines = (plot.RED, plot.BLUE, plot.GREEN), ("-", "-", "--")
    curve = axes[2, 1]
    for i, title in enumerate(titles):
        plot.picture(data["discs"][i], ax=axes[i, 0], title=WAYS[i])
        plot.cartesian(theta, shown[i], ax=curve, color=colors[i], linestyle=lines[i], label=title)
    for i in (0, 1):
        plot.strip(data["strips"][i], (0, 90), ax=axes[i, 1], title=f"{titles[i]}; top row: the background alone")
    plot.cartesian(theta, np.full_like(theta, 0.5), ax=curve, color=plot.GREY, linestyle=":", label="background alone")
    at_80, darkest = data["shown_0_80"][:, 1], shown[0].argmin()
    plot.points(curve, [80], at_80[1:2], [f"{at_80[1]:.3f}  "], color=colors[1])
    plot.points(curve, [80], at_80[:1], [f"    {at_80[0]:.3f}"], color=colors[0], dy=-5)
    plot.points(curve, theta[darkest], shown[0, darkest], [f"{shown[0, darkest]:.4f}"], color=colors[0], dy=-5)
    plot.labels(curve, xlabel=plot.ANGLE, ylabel="shown (white = 1)", xlim=(0, 90), ylim=(0.36, 1.0))
    plot.legend(curve, loc="upper left")
