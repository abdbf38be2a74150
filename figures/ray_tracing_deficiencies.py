"""JHU, "Basic Ray Tracing Deficiencies": no light between diffuse surfaces, and two images of one lamp."""

import numpy as np

from jaxrefl import plot
from jaxrefl.camera import Pinhole
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.light import Ambient, PointLight
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.surface import Phong, Whitted

CAPTION = """Above: a lamp of radius 0.15 over a glossy floor is seen in it twice, by its highlight k_s (H·N)^n and by
its mirror image k_rg I_r: direct and indirect light have two rules for one thing. At half maximum the highlight is 5.6°
wide (n = 120) and the image 3.0°; the first width knows the exponent alone (11.2°, 5.6°, 2.8° for n = 30, 120, 480),
the second the lamp alone (2.0° to 20.0°). Left: in a closed diffuse sphere with a lamp at its centre a ray tracer shows
the first strike, ρ, and no light between the walls, which makes it ρ/(1 - ρ): at ρ = 0.9 a tenth of the truth. The
ambient term repairs this scene with I_a = ρ/(1 - ρ)."""
SIZE = (10.0, 5.3)
LAMP, EYE, IMAGE = np.array([0.0, 0.0, 1.3]), np.array([0.0, -5.0, 1.6]), np.array([0.0, 0.0, -1.3])
WIDTH, HEIGHT = 320, 201


def shoot(floor: dict, ball: dict, eye: Pinhole, place=(0.0, 0.0, 1.0), radius=1.0, lamp=LAMP, ambient=0.0):
    """Picture of a floor and a ball under a point light without shadows: one structure, compiled once."""

    def whitted(k_d=0.0, k_s=0.0, shininess=1.0, k_a=0.0, emission=0.0, k_rg=0.0):
        return Whitted(Phong(k_d=k_d, k_s=k_s, shininess=shininess, k_a=k_a, emission=emission), k_rg=k_rg)

    objects = {
        "floor": Object(Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])), whitted(**floor)),
        "ball": Object(Sphere(np.array(place), radius), whitted(**ball)),
    }
    scene = Scene(objects, {"lamp": PointLight(np.array(lamp), shadows=False), "ambient": Ambient(ambient)})
    return np.asarray(render(scene, eye, WIDTH, HEIGHT, 2).radiance[..., 0])


def middle_row(picture: np.ndarray, field_of_view: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles in degrees from the middle of a picture along its middle row, and what is seen there."""
    x = (2 * np.arange(WIDTH) + 1 - WIDTH) / HEIGHT * np.tan(0.5 * field_of_view)
    return np.rad2deg(np.arctan(x)), picture[HEIGHT // 2]


def width(angle: np.ndarray, row: np.ndarray) -> float:
    """Angle between the two places where a row passes half of its maximum."""
    half = 0.5 * row.max()
    first, last = np.nonzero(row >= half)[0][[0, -1]]
    left = np.interp(half, row[first - 1 : first + 1], angle[first - 1 : first + 1])
    right = np.interp(-half, -row[last : last + 2], angle[last : last + 2])
    return float(right - left)


def compute(
    rho: tuple[float, ...] = (0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95),
    radii: tuple[float, ...] = (0.1, 0.25, 0.5, 0.75, 1.0),
    exponents: tuple[float, ...] = (30.0, 120.0, 480.0),
    example: tuple[float, ...] = (0.15, 120.0),
) -> dict:
    middle = (0.0, 0.0, 2.0)
    eye = Pinhole(np.array([0.3, 0.2, 2.1]), np.array([0.0, 0.5, 2.5]))
    room = {"eye": eye, "place": middle, "lamp": middle}
    traced = [shoot({}, {"k_d": r, "k_a": r}, **room) for r in rho]
    repaired = [shoot({}, {"k_d": r, "k_a": r}, **room, ambient=r / (1 - r)) for r in rho]

    view = Pinhole(EYE, np.array([0.0, -1.5, 0.25]), field_of_view=0.8)
    shine, (radius, n) = {"emission": 1.0}, example
    glossy, mirror = {"k_s": 0.8, "shininess": n}, {"k_rg": 0.8}
    pictures = [shoot({"k_d": 0.2} | floor, shine, view, LAMP, radius) for floor in (glossy, mirror, glossy | mirror)]

    def seen(floor, radius, field_of_view):
        eye = Pinhole(EYE, IMAGE, field_of_view=field_of_view)
        return middle_row(shoot(floor, shine, eye, LAMP, radius), field_of_view)

    distance = np.linalg.norm(EYE - IMAGE)
    angle, highlight = seen(glossy, radius, 0.4)
    return {
        "rho": np.array(rho),
        "traced": np.array([[image.min(), image.max()] for image in traced]),
        "repaired": np.array([[image.min(), image.max()] for image in repaired]),
        "pictures": np.array(pictures),
        "angle_deg": angle,
        "highlight": highlight,
        "image": seen(mirror, radius, 0.4)[1],
        "radius": np.array(radii),
        "image_deg": np.array([width(*seen(mirror, r, 4 * np.arcsin(r / distance))) for r in radii]),
        "exponent": np.array(exponents),
        "highlight_deg": np.array([width(*seen(glossy | {"shininess": n}, radius, 1.0)) for n in exponents]),
    }


def draw(data: dict, fig) -> None:
    (only_highlight, only_image, both), (sphere, profile, size) = fig.subplots(2, 3)
    titles = ("highlight: $k_s (H\\cdot N)^n$", "mirror image: $k_{rg} I_r$", "Whitted's sum has both")
    for picture, ax, title in zip(data["pictures"], (only_highlight, only_image, both), titles, strict=True):
        plot.picture(picture, ax=ax, title=title)

    rho = np.linspace(0.05, 0.97, 200)
    plot.cartesian(rho, rho / (1 - rho), ax=sphere, color=plot.GREEN, label=r"truth $\rho\,/\,(1-\rho)$")
    plot.cartesian(rho, rho, ax=sphere, color=plot.RED, linestyle="--", label=r"first strike $\rho$")
    points = {"marker": "o", "linestyle": "none", "markersize": 4}
    ambient = r"traced, $I_a=\rho\,/\,(1-\rho)$"
    plot.cartesian(data["rho"], data["repaired"].mean(1), ax=sphere, color=plot.BLUE, label=ambient, **points)
    plot.cartesian(data["rho"], data["traced"].mean(1), ax=sphere, color=plot.RED, label="traced", **points)
    plot.arrow(sphere, (0.9, 0.9), (0.9, 9.0), color=plot.GREY, width=1.0)
    plot.note(sphere, (0.9, 2.8), "×10", fontsize="small")
    plot.labels(sphere, xlabel="reflectance ρ", ylabel="radiance / intensity of the lamp", yscale="log")
    plot.labels(sphere, title="wall of a closed diffuse sphere", ylim=(0.04, 150), legend="upper left")

    plot.cartesian(data["angle_deg"], data["highlight"], ax=profile, color=plot.RED, label="highlight")
    plot.cartesian(data["angle_deg"], data["image"], ax=profile, color=plot.BLUE, label="mirror image")
    plot.labels(profile, xlabel="angle from the middle (degrees)", ylabel="radiance / that of the lamp", ylim=(0, 1.1))
    plot.labels(profile, title="across the spot on the floor", xlim=(-15, 15), legend="upper left")

    plot.cartesian(data["radius"], data["image_deg"], ax=size, color=plot.BLUE, marker="o", label="mirror image")
    for n, degrees in zip(data["exponent"], data["highlight_deg"], strict=True):
        plot.mark(size, y=float(degrees), text=f"n = {n:g}", color=plot.RED)
    plot.labels(size, xlabel="radius of the lamp (height 1.3)", ylabel="width at half maximum (degrees)")
    plot.labels(size, title="how wide the spot is seen", ylim=(0, 21))
    keys = {"mirror image": {"color": plot.BLUE, "marker": "o"}, "highlight": {"color": plot.RED, "linestyle": ":"}}
    plot.legend(size, keys, loc="upper left")
