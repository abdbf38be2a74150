"""Phong's and Blinn's highlight with the same exponent, and how little separates them once the exponents match."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import Vec3, plot
from jaxrefl.camera import Orthographic
from jaxrefl.geometry import Sphere
from jaxrefl.light import Directional
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Phong
from jaxrefl.surface.phong import blinn_lobe, phong_lobe

CAPTION = """Phong's (R·V)^n and Blinn's (H·N)^n highlight. Top left: the lobes over the direction to the viewer, light
from 40°; both point in the mirror direction. Top right: over a sphere seen from the light. With the same n = 20 Blinn's
highlight is half as bright at 15.0°, Phong's at 7.5°: a factor of exactly 2. Bottom left: three spheres, circles at
half the maximum; the middle one has twice the radius. Blinn with 4 n looks like Phong with n: they differ by 0.0069 at
most for n = 20, and by e^-2 / n for large n (bottom right)."""
SIZE = (9.6, 6.6)
NORMAL = Vec3(0.0, 0.0, 1.0)
LOBES = {"phong": phong_lobe, "blinn": blinn_lobe}


def compute(
    exponents: tuple[float, ...] = (5.0, 50.0), n: float = 20.0, incident_deg: float = 40.0, height: int = 150
) -> dict:
    out = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721)
    tilt_deg, fine, many = np.linspace(0, 30, 301), np.linspace(0, 0.5 * np.pi, 20001), np.geomspace(1, 1000, 31)
    data = {"out": out, "tilt_deg": tilt_deg, "n": n, "incident_deg": incident_deg, "exponents": np.array(exponents)}

    @jax.jit
    def curves(exponents, n):
        found, to_light = {}, _tilted(jnp.radians(-incident_deg))
        for name, lobe in LOBES.items():
            found[name] = jax.vmap(lambda x, lobe=lobe: lobe(NORMAL, to_light, _tilted(out), x))(exponents)
            found[f"{name}_radius_deg"] = jnp.rad2deg(jax.vmap(lambda x, lobe=lobe: _half_width(lobe, x))(many))
            found[f"{name}_n_radius_deg"] = jnp.rad2deg(_half_width(lobe, n))
        for name, lobe, x in (("phong_n", phong_lobe, n), ("blinn_n", blinn_lobe, n), ("blinn_4n", blinn_lobe, 4 * n)):
            found[name] = lobe(_tilted(np.radians(tilt_deg)), NORMAL, NORMAL, x)
        return found | {"difference": jax.vmap(lambda x: _difference(fine, x))(many), "gap": _difference(fine, n)}

    data |= curves(jnp.asarray(exponents), jnp.asarray(n)) | {"many": many}
    picture = render(
        _spheres(n), Orthographic(Vec3(0.0, 0.0, 5.0), up=Vec3(0.0, 1.0, 0.0), height=2.2), 3 * height, height, 0
    )
    data["picture"] = picture.radiance
    highlight = np.asarray(picture.radiance)[..., 1]  # green, which the red spheres show nowhere else
    area = [(part > 0.5 * highlight.max()).sum() * (2.2 / height) ** 2 for part in np.hsplit(highlight, 3)]
    return data | {"picture_radius_deg": np.rad2deg(np.arcsin(np.sqrt(np.array(area) / np.pi)))}


def _tilted(angle) -> Vec3:
    return Vec3(jnp.sin(angle), 0.0 * angle, jnp.cos(angle))


def _half_width(lobe, n):
    """Angle of the normal at which a highlight that is seen from the light has half its maximum."""

    def halve(_, ends):
        middle = 0.5 * (ends[0] + ends[1])
        inside = lobe(_tilted(middle), NORMAL, NORMAL, n) > 0.5
        return jnp.where(inside, middle, ends[0]), jnp.where(inside, ends[1], middle)

    return jax.lax.fori_loop(0, 60, halve, (0.0 * n, 0.0 * n + 0.5 * jnp.pi))[0]


def _difference(angles, n):
    """Largest difference between Blinn's highlight with 4 n and Phong's with n."""
    n_tilted = _tilted(angles)
    return jnp.abs(blinn_lobe(n_tilted, NORMAL, NORMAL, 4 * n) - phong_lobe(n_tilted, NORMAL, NORMAL, n)).max()


def _spheres(n: float) -> Scene:
    """Three spheres: Phong n, Blinn n, Blinn 4 n."""
    color = {"k_d": [0.45, 0.0, 0.0], "k_s": 0.9}
    half_vector = Phong(**color, shininess=jnp.asarray([n, 4 * n]))
    return Scene(
        {
            "mirror": Object(Sphere(Vec3(-2.2, 0.0, 0.0)), Phong(**color, shininess=n, highlight="mirror")),
            "half_vector": Object(Sphere(Vec3(jnp.asarray([0.0, 2.2]), 0.0, 0.0)), half_vector),
        },
        {"light": Directional(Vec3(0.0, 0.0, -1.0))},
    )


def draw(data: dict, fig) -> None:
    (lobes, profile), (spheres, remains) = fig.subplots(2, 2)
    n, incident = float(data["n"]), np.radians(float(data["incident_deg"]))
    colors = (plot.RED, plot.BLUE)
    plot.canvas(lobes, (-1.15, 1.35), (-0.3, 1.22), "lobes over the direction to the viewer")
    plot.segment(lobes, (-1.1, 0.0), (1.1, 0.0))
    for name, line in (("phong", "-"), ("blinn", "--")):
        for curve, color in zip(np.asarray(data[name]), colors, strict=True):
            x, y = curve * np.sin(data["out"]), curve * np.cos(data["out"])
            plot.cartesian(x, y, ax=lobes, color=color, linestyle=line)
    toward = np.array([-np.sin(incident), np.cos(incident)])
    plot.arrow(lobes, 1.1 * toward, 0.04 * toward, "light", shift=(-0.22, 0.05))
    plot.arrow(lobes, (0.0, 0.0), (0.0, 1.05), color=plot.GREY, width=1.0)
    plot.note(lobes, (0.0, 1.13), "N", color=plot.GREY)
    plot.note(lobes, 1.1 * toward * (-1, 1), "R", color=plot.GREY)
    keys = {f"n = {x:g}": {"color": color} for x, color in zip(data["exponents"], colors, strict=True)}
    keys |= {"Phong": {"color": plot.GREY}, "Blinn": {"color": plot.GREY, "linestyle": "--"}}
    plot.legend(lobes, keys, loc="lower center", ncols=5, columnspacing=1.2, handlelength=1.6)

    curves = (
        ("phong_n", f"Phong, n = {n:g}", plot.RED, "-"),
        ("blinn_n", f"Blinn, n = {n:g}", plot.BLUE, "-"),
        ("blinn_4n", f"Blinn, 4 n = {4 * n:g}", plot.ORANGE, "--"),
    )
    for key, label, color, line in curves:
        plot.cartesian(data["tilt_deg"], data[key], ax=profile, label=label, color=color, linestyle=line)
    plot.mark(profile, y=0.5, text="half", at=0.99)
    plot.mark(profile, x=float(data["phong_n_radius_deg"]), text="{:.1f}°", side="left", at=0.3)
    plot.mark(profile, x=float(data["blinn_n_radius_deg"]), text="{:.1f}°", side="left", at=0.3)
    limits = {"xlim": (0, data["tilt_deg"][-1]), "ylim": (0, 1.02)}
    plot.labels(
        profile,
        xlabel="angle on the sphere from the middle of the highlight (degrees)",
        ylabel="highlight, fraction of its maximum",
        title="highlight of a sphere seen from the light",
        legend="upper right",
        **limits,
    )

    plot.picture(data["picture"], ax=spheres, title="rendered; dotted circles at half the maximum")
    size, turn = data["picture"].shape[0], np.linspace(0, 2 * np.pi, 181)
    angles = (data["phong_n_radius_deg"], data["blinn_n_radius_deg"], data["phong_n_radius_deg"])
    for i, ((_, label, _, _), angle) in enumerate(zip(curves, angles, strict=True)):
        reach = np.sin(np.radians(float(angle))) * size / 2.2
        x, y = (i + 0.5) * size - 0.5 + reach * np.cos(turn), 0.5 * size - 0.5 + reach * np.sin(turn)
        plot.cartesian(x, y, ax=spheres, color="black", linestyle=":", linewidth=1)
        plot.note(spheres, ((i + 0.5) * size, 1.1 * size), label)

    plot.cartesian(
        data["many"], np.exp(-2) / data["many"], ax=remains, color=plot.GREY, linestyle=":", label=r"$e^{-2}/n$"
    )
    plot.convergence(
        data["many"],
        {r"|Blinn$_{4n}$ − Phong$_n$|": data["difference"]},
        ax=remains,
        xlabel="Phong's exponent n",
        ylabel="largest difference",
        title="what is left with matched exponents",
        color=plot.ORANGE,
        markersize=3,
    )
