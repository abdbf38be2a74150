"""JHU's spotlight effect and attenuation, and a floor lit by spots."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot
from jaxrefl.camera import Orthographic
from jaxrefl.geometry import Plane
from jaxrefl.light import Spot, attenuation, spot_effect
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Phong

CAPTION = """JHU, "Spotlights" and "Local Illumination Equation". Top left: the spotlight effect (-L_N·L)^s: with s = 0
the cone is uniform, with s = 10 it is down to a half 21.1° from its axis, and a cutoff ends it at 25°. Bottom left: the
attenuation 1 / (a + b d + c d²). Only a = b = 0, the inverse square law, falls to a fourth at twice the distance
everywhere, and it alone exceeds 1, nearer than 1 m. Right: a white floor from above and the row through its middle.
Under each spot, 2 m high, the radiance is cos^(s+3) of the angle from the axis; the cutoff ends it 0.93 m from the
axis, where s = 0 still shows 0.74 and s = 10 only 0.28."""
SIZE = (9.6, 5.8)
INVERSE_SQUARE = (0.0, 0.0, 1.0)
LAWS = ((1.0, 0.0, 0.0), (1.0, 0.5, 0.0), (1.0, 0.0, 0.25), INVERSE_SQUARE)


def compute(
    exponents: tuple[float, ...] = (0.0, 3.0, 10.0, 50.0),
    exponent: float = 10.0,
    cutoff_deg: float = 25.0,
    height: float = 2.0,
    spacing: float = 3.2,
    width: int = 320,
) -> dict:
    spots = np.array([(exponent, 90.0), (exponent, cutoff_deg), (0.0, cutoff_deg)])  # s, cutoff in degrees
    below, pixel = spacing * np.array([-1.0, 0.0, 1.0]), 3 * spacing / width
    x, angle_deg, distance = (
        (np.arange(width) + 0.5) * pixel - 1.5 * spacing,
        np.linspace(0, 90, 901),
        np.geomspace(0.1, 10, 201),
    )

    @jax.jit
    def curves(exponents, laws, spots):
        def on_floor(spot, place):
            d = jnp.hypot(height, x - place)
            effect = spot_effect(height / d, spot[0], jnp.radians(spot[1]))
            return height**2 * attenuation(d, *INVERSE_SQUARE) * effect * (height / d)

        cosine = jnp.cos(jnp.radians(angle_deg))
        return {
            "effect": jax.vmap(lambda s: spot_effect(cosine, s, jnp.pi))(exponents),
            "effect_cut": spot_effect(cosine, spots[1, 0], jnp.radians(spots[1, 1])),
            "attenuation": jax.vmap(lambda law: attenuation(jnp.asarray(distance), *law))(laws),
            "expected": jax.vmap(on_floor)(spots, jnp.asarray(below)).sum(0),
        }

    rows = width // 3 | 1  # odd: the middle one runs through the axes of the spots
    camera = Orthographic(Vec3(0.0, 0.0, 1.0), up=Vec3(0.0, 1.0, 0.0), height=rows * pixel)
    picture = render(_floor(spots, below, height), camera, width, rows, 0).radiance
    return {
        "angle_deg": angle_deg,
        "exponents": np.array(exponents),
        "cutoff_deg": cutoff_deg,
        "distance": distance,
        "laws": np.array(LAWS),
        **curves(jnp.asarray(exponents), jnp.asarray(LAWS), jnp.asarray(spots)),
        "spots": spots,
        "below": below,
        "height": height,
        "picture": picture,
        "x": x,
        "row": picture[rows // 2, :, 0],
        "edge": height * np.tan(np.radians(cutoff_deg)),
        "at_edge": np.cos(np.radians(cutoff_deg)) ** (spots[1:, 0] + 3),
    }


def _floor(spots, below, height: float) -> Scene:
    """White floor under three spots of the inverse square law that give it a radiance of 1 below them."""
    lights = {
        f"spot_{i}": Spot(
            Vec3(place, 0.0, height),
            Vec3(0.0, 0.0, -1.0),
            exponent=s,
            cutoff=np.radians(cutoff_deg),
            diffuse=height**2,
            constant=0.0,
            quadratic=1.0,
        )
        for i, ((s, cutoff_deg), place) in enumerate(zip(spots, below, strict=True))
    }
    return Scene({"floor": Object(Plane(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)), Phong(k_d=1.0))}, lights)


def draw(data: dict, fig) -> None:
    (effect, floor), (fall, row) = fig.subplots(2, 2, width_ratios=(1, 1.3))
    colors = (plot.GREY, plot.GREEN, plot.BLUE, plot.PINK)
    for s, curve, color in zip(data["exponents"], data["effect"], colors, strict=True):
        plot.cartesian(data["angle_deg"], curve, ax=effect, label=f"s = {s:g}", color=color)
    s, cutoff = float(data["spots"][1, 0]), float(data["cutoff_deg"])
    label = f"s = {s:g}, cutoff {cutoff:g}°"
    plot.cartesian(data["angle_deg"], data["effect_cut"], ax=effect, label=label, color=plot.ORANGE, linestyle="--")
    limits = {"xlim": (0, 90), "ylim": (0, 1.05)}
    text = {"xlabel": "angle from the axis of the light (degrees)", "ylabel": r"$(-L_N \cdot L)^s$"}
    plot.labels(effect, title="spotlight effect", **text, **limits)
    plot.legend(effect, loc="upper right", bbox_to_anchor=(1.0, 0.93))

    names = [f"a, b, c = {a:g}, {b:g}, {c:g}" for a, b, c in data["laws"]]
    for name, curve, color, line in zip(names, data["attenuation"], colors, ("-", "-.", "--", "-"), strict=True):
        style = {"color": color, "linestyle": line, "marker": "", "linewidth": 1.6}
        plot.convergence(data["distance"], {name: curve}, ax=fall, **style)
    text = {"xlabel": "distance d (m)", "ylabel": r"$f_{att} = 1/(a + b\,d + c\,d^2)$"}
    plot.labels(fall, title="attenuation", legend="lower left", xlim=(0.1, 10), ylim=(0.005, 150), **text)

    plot.picture(data["picture"], ax=floor, title=f"a floor under three spots {float(data['height']):g} m high")
    names = (f"s = {s:g}", f"s = {s:g}, cutoff {cutoff:g}°", f"s = 0, cutoff {cutoff:g}°")
    rows, width = data["picture"].shape[:2]
    for i, name in enumerate(names):
        plot.note(floor, ((i + 0.5) * width / 3, 1.1 * rows), name)
    plot.cartesian(data["x"], data["row"], ax=row, color=plot.BLUE, label="rendered")
    label = r"$f_{att}\,S\,(N \cdot L)$"
    plot.cartesian(data["x"], data["expected"], ax=row, color=plot.ORANGE, linestyle=":", label=label)
    edge = float(data["below"][2] + data["edge"])
    plot.mark(row, x=edge, text=f"{float(data['edge']):.2f} m", side="right", at=0.98)
    for value in data["at_edge"]:
        plot.mark(row, y=float(value), text="{:.2f}", at=0.36)
    limits = {"xlim": (data["x"][0], data["x"][-1]), "ylim": (0, 1.2)}
    plot.labels(
        row, xlabel="place on the floor (m)", ylabel="radiance, 1 below each spot", title="middle row", **limits
    )
    plot.legend(row, loc="upper center", ncols=2)
