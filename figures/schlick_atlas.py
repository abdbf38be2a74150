"""Where Schlick's approximation of a dielectric is good, and where it is not."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxrefl import fresnel, plot
from jaxrefl.files import read_table

CAPTION = """Absolute error of Schlick's approximation over relative index and angle, with contours at 1 and 3 %. Left:
from outside; marked are real materials (red) and n = 1.1 (blue), at the angle of their largest error. Of n = 1.1,
1.33, 1.5, 2 and 2.4 the worst is 1.1, off by 0.21 at 83.1°, and the best 1.5, off by 0.036 at 85.0°; up to 45° every
index up to 2 stays within 1 %. Right: from inside, where the error at an angle of incidence is that from outside at
the angle of refraction."""
SIZE = (9.6, 4.2)


def compute(eta_max: float = 3.0, samples: int = 600) -> dict:
    rows = read_table("indices")
    index = np.array([float(row["n"]) for row in rows])
    theta, _ = plot.angles(samples + 1)
    fine, _ = plot.angles(9001)

    @jax.jit
    def error(theta_deg, eta):
        mu = jnp.sin(jnp.deg2rad(90 - theta_deg))
        return jnp.abs(fresnel.schlick_dielectric(mu, eta) - fresnel.dielectric(mu, eta))

    def worst(n):
        e = error(fine[None, :], np.atleast_1d(n)[:, None])
        return e.max(axis=1), fine[e.argmax(axis=1)]

    eta = np.linspace(1.0, eta_max, samples)
    example = np.array([1.1, 1.33, 1.5, 2.0, 2.4])
    max_error, max_error_deg = worst(index)
    example_error, example_deg = worst(example)
    below_45 = error(np.linspace(0, 45, 451)[None, :], np.linspace(1.0, 2.0, 401)[:, None])
    return {
        "theta_deg": theta,
        "eta": eta,
        "error_outside": error(theta[:, None], eta[None, :]),
        "error_inside": error(theta[:, None], 1 / eta[None, :]),
        "material": np.array([row["material"] for row in rows]),
        "index": index,
        "max_error": max_error,
        "max_error_deg": max_error_deg,
        "reversal_defect": jnp.abs(
            error(39.0, 1 / 1.5) - error(np.rad2deg(np.arcsin(1.5 * np.sin(np.deg2rad(39.0)))), 1.5)
        ),
        "example": example,
        "example_error": example_error,
        "example_deg": example_deg,
        "max_error_below_45_deg": below_45.max(),
    }


def draw(data: dict, fig) -> None:
    left, right = fig.subplots(1, 2, sharey=True)
    eta, theta = data["eta"], data["theta_deg"]
    common = {"levels": (0.01, 0.03), "range": (1e-4, 0.3), "xlabel": "relative index n of the denser side"}
    labels = {"label_contours": [(2.1, 80), (2.2, 75), (2.0, 72)], "bar": False, "ylabel": plot.ANGLE}
    plot.error_map(eta, theta, data["error_outside"], ax=left, title="from outside (η = n)", **labels, **common)
    title = r"from inside (η = 1/n), with $\theta_t$"
    plot.error_map(eta, theta, data["error_inside"], ax=right, title=title, label_contours=False, **common)
    plot.note(right, (2.3, 60), "total reflection: no error", fontsize="small")
    plot.points(left, data["index"], data["max_error_deg"])
    first = [f"{float(data['example_error'][0]):.2f}"]
    plot.points(left, data["example"][:1], data["example_deg"][:1], first, dy=-5, color=plot.BLUE)
    for n, material, gap in zip(data["index"], data["material"], np.diff(data["index"], prepend=0), strict=True):
        side = "right" if gap < 0.1 else "left"
        plot.mark(left, x=float(n), text=str(material), side=side, at=0.3, color="white")
