"""The factors of Blinn-Phong in circulation, and the exact one."""

import numpy as np

from jaxrefl import brdf, plot
from jaxrefl.tabulate import albedo_table

CAPTION = """Which factor before (N·H)^n? Left: the albedo at normal incidence, which should be 1 for a highlight that
absorbs nothing. The exact (n + 2)(n + 4) / (8 π (2^(-n/2) + n)) is 1 for every n; (n + 8) / (8 π) is right for n = 0
and for n → ∞ and gains at most 7.5 %, at n = 8.7; (n + 2) / (8 π) loses, 28 % at n = 10; (n + 2) / (2 π) belongs to a
distribution of normals, and as a factor makes light, 4 times as much for large n. Dots: integrals over the model.
Right: the albedo over the angle for n = 10; whatever is 1 at 0° falls from there."""
SIZE = (9.4, 4.0)
FACTORS = {
    "exact": lambda n: (n + 2) * (n + 4) / (8 * np.pi * (2 ** (-n / 2) + n)),
    "(n + 8) / (8 π)": lambda n: (n + 8) / (8 * np.pi),
    "(n + 2) / (8 π)": lambda n: (n + 2) / (8 * np.pi),
    "(n + 2) / (2 π)": lambda n: (n + 2) / (2 * np.pi),
}


def compute(n: float = 10.0, factors: tuple[str, ...] = tuple(FACTORS)) -> dict:
    theta, _ = plot.angles(91)
    dense, few = np.concatenate([[0.0], np.geomspace(0.1, 1000, 601)]), np.geomspace(0.1, 1000, 13)
    at_normal = albedo_table(brdf.BlinnPhong(), "shininess", few, [1.0]).albedo[:, 0]
    over_angle = plot.albedos(brdf.BlinnPhong(1.0, n)).value
    ratio = {name: (lambda n, f=FACTORS[name]: f(n) / FACTORS["exact"](n)) for name in factors}
    curves = np.stack([r(dense) for r in ratio.values()])
    gain = FACTORS["(n + 8) / (8 π)"](dense) / FACTORS["exact"](dense)
    return {
        "theta_deg": theta,
        "n": n,
        "factor": np.array(factors),
        "dense": dense,
        "few": few,
        "at_normal": curves,
        "integrals": np.stack([r(few) * at_normal for r in ratio.values()]),
        "over_angle": np.stack([r(n) * over_angle for r in ratio.values()]),
        "largest_gain": gain.max(),
        "largest_gain_n": dense[gain.argmax()],
    }


def draw(data: dict, fig) -> None:
    normal, angle = fig.subplots(1, 2)
    lines = ("-", "--", "-.", ":")
    for i, name in enumerate(data["factor"]):
        color, line = f"C{i}", lines[i % 4]
        plot.cartesian(data["dense"][1:], data["at_normal"][i, 1:], ax=normal, label=name, color=color, linestyle=line)
        dots = {"color": color, "linestyle": "", "marker": "o", "markersize": 4}
        plot.cartesian(data["few"], data["integrals"][i], ax=normal, **dots)
        plot.albedo(data["over_angle"][i], data["theta_deg"], ax=angle, color=color, linestyle=line, ylim=(0, 3))
    plot.mark(normal, y=1.0)
    plot.labels(normal, title="at normal incidence", xlabel="exponent n", ylabel="directional albedo", ylim=(0, 4.2))
    plot.labels(normal, xlim=(0.1, 1000), xscale="log", legend="center left")
    plot.labels(angle, title=f"n = {float(data['n']):g}")
