"""Section I of the oracle table, the scenes: recomputed at 40 digits by another route than the one that made it.

Where a number has a closed form, the integral, the equation or the limit is taken that it solves.
"""

import mpmath as mp
import pytest
from oracle_table import BLOCKS, Recomputed, number

recomputes = Recomputed(
    {
        "I.patch_sphere": {"check_abs_diff"},  # of the quadrature of its maker
        "I.alhazen": {"outside_visible"},  # a verdict
    }
)


# --- the formulas ---


def cos(degrees):
    return mp.cos(mp.radians(degrees))


def root(f, *bracket):
    """Root of f between two places."""
    return mp.findroot(f, bracket, solver="anderson", tol=mp.mpf("1e-70"))


def reflectance(mu, n):
    """Unpolarised reflectance at the cosine of incidence mu (Born & Wolf 1.5)."""
    mu_t = mp.sqrt(1 - (1 - mu * mu) / (n * n))
    r_s, r_p = (mu - n * mu_t) / (mu + n * mu_t), (n * mu - mu_t) / (n * mu + mu_t)
    return (r_s**2 + r_p**2) / 2


def schlick(mu):
    return mp.mpf("0.04") + mp.mpf("0.96") * (1 - mu) ** 5


def disc_mean(f, *breaks):
    """Mean of f(mu) over the disc of a sphere, where mu is the cosine at the pixel sqrt(1 - mu^2)."""
    return mp.quad(lambda mu: 2 * mu * f(mu), [0, *breaks, 1])


def over_longitude(f, phase):
    """Integral over the lit and visible longitudes of f(cosine to the viewer, cosine to the light)."""
    ends = [phase - mp.pi / 2, phase / 2, mp.pi / 2]
    return mp.quad(lambda w: f(mp.cos(w), mp.cos(w - phase)) * mp.cos(w), ends)


def lambert(phase):
    return over_longitude(lambda mu, mu_i: mu_i, phase) * 2 / mp.pi


def lommel_seeliger(phase):
    return over_longitude(lambda mu, mu_i: mu_i / (mu + mu_i), phase)  # 1 at full phase


@recomputes("I.sphere_phase")
def _(row):
    phase = mp.radians(row["alpha_deg"])
    latitudes = mp.quad(lambda b: mp.cos(b) ** 3, [-mp.pi / 2, mp.pi / 2])  # of the area of the disc, pi
    return {
        "lambert": lambert(phase),
        "lommel_seeliger": lommel_seeliger(phase) if phase else 1,
        "disc_mean_NdotL": lambert(phase) * mp.pi / 2 * latitudes / mp.pi,
    }


@recomputes("I.sphere_albedo", "single")
def _(_):
    # a patch in light from the cosine x sends a fraction of x 1/2 (1 - x log(1 + 1/x)) of it back to all sides
    bond = disc_mean(lambda x: (1 - x * mp.log(1 + 1 / x)) / 2)
    p_ls = disc_mean(lambda mu: mp.mpf(1) / 8)
    with mp.workdps(20):
        phase_integral = 2 * mp.quad(lambda a: lambert(a) * mp.sin(a), [0, mp.pi])
    return {
        "p_lambert": disc_mean(lambda mu: mu),
        "q_lambert_quad": phase_integral,
        "p_ls_over_w": p_ls,
        "q_ls": bond / p_ls,
        "q_ls_quad": bond / p_ls,
        "bond_ls_over_w": bond,
    }


def oren_nayar(mu, r):
    """Radiance of Fujii's form of the Oren-Nayar model with the light at the viewer; white, irradiance pi."""
    a = 1 / (1 + (mp.mpf(1) / 2 - 2 / (3 * mp.pi)) * r)
    return (a + r * a * (1 - mu * mu) / mu) * mu


def ggx(mu, alpha):
    """Likewise of GGX with the height-correlated masking of Smith and F = 1."""
    distribution = alpha**2 / (mp.pi * (1 - (1 - alpha**2) * mu * mu) ** 2)
    masking = 1 / mp.sqrt(1 + alpha**2 * (1 - mu * mu) / (mu * mu))
    return mp.pi * distribution * masking / (4 * mu)


@recomputes("I.frontal_disc_mean")
def _(row):
    name, exponent = row["model"].split()[0], mp.mpf(row["model"].split("=")[1].split()[0])
    laws = {
        "minnaert": lambda mu: (exponent + 1) / 2 * mu ** (2 * exponent - 1),
        "phong": lambda mu: max(0, 2 * mu * mu - 1) ** exponent,
        "blinn": lambda mu: mu**exponent,
        "FON": lambda mu: oren_nayar(mu, exponent),
        "GGX": lambda mu: ggx(mu, exponent),
    }
    return {"mean": disc_mean(laws[name], mp.sqrt(mp.mpf(1) / 2), mp.mpf("0.98"))}


@recomputes("I.fresnel_sphere", "single")
def _(_):
    means = [disc_mean(lambda mu: reflectance(mu, mp.mpf("1.5")), mp.mpf("0.1")), disc_mean(schlick)]
    return {"exact_15": means[0], "schlick": means[1], "d3d9": disc_mean(lambda mu: (1 + schlick(mu)) / 2)}


@recomputes("I.mirror_ball", "single")
def _(_):
    def polar(mu):  # cosine of twice the angle of incidence
        return 2 * mu * mu - 1

    return {
        "mean_cos2": disc_mean(lambda mu: polar(mu) ** 2),
        "schlick_cos": disc_mean(lambda mu: schlick(mu) * polar(mu)),
        "schlick_uniform": disc_mean(schlick),
        "s_for_90deg": root(lambda s: polar(mp.sqrt(1 - s * s)), mp.mpf("0.5"), mp.mpf("0.9")),
    }


def patch_to_sphere(h, theta):
    """Form factor of a patch, a double integral about the direction to the sphere, the inner one done by hand."""
    rim, c, s = mp.asin(1 / h), mp.cos(theta), mp.sin(theta)

    def to(polar, azimuth):
        return c * mp.sin(polar) ** 2 / 2 + s * mp.cos(azimuth) * (polar / 2 - mp.sin(2 * polar) / 4)

    def along(azimuth):
        rim_is_seen = c * mp.cos(rim) + s * mp.sin(rim) * mp.cos(azimuth) > 0
        horizon = mp.atan2(abs(c), abs(s * mp.cos(azimuth)))
        if theta <= mp.pi / 2:
            return to(rim if rim_is_seen else horizon, azimuth)
        return to(rim, azimuth) - to(horizon, azimuth) if rim_is_seen else mp.mpf(0)

    corner = -c * mp.cos(rim) / (s * mp.sin(rim)) if s else mp.mpf(-1)
    breaks = [mp.acos(corner)] if abs(corner) < 1 else []
    return 2 / mp.pi * mp.quad(along, [0, *breaks, mp.pi])


@recomputes("I.patch_sphere")
def _(row):
    factor = patch_to_sphere(row["H"], mp.radians(row["theta_deg"]))
    return {"F": factor, "E_over_L": mp.pi * factor}


def snyder(h, theta):
    """The same in closed form (Snyder 1996), which `I.patch_sphere` has been compared with."""
    if theta <= mp.pi / 2 - mp.asin(1 / h):
        return mp.cos(theta) / h**2
    if theta >= mp.pi / 2 + mp.asin(1 / h):
        return mp.mpf(0)
    x = mp.sqrt(h * h - 1)
    y = -x * mp.cot(theta)
    rest = mp.sin(theta) * mp.sqrt(1 - y * y)
    return ((mp.cos(theta) * mp.acos(y) - x * rest) / h**2 + mp.atan(rest / x)) / mp.pi


@recomputes("I.sphere_sphere")
def _(row):
    r1, r2, d = row["r1"], row["r2"], row["d"]

    def patch(polar):
        across, along = r1 * mp.sin(polar), d - r1 * mp.cos(polar)
        return snyder(mp.hypot(across, along) / r2, polar + mp.atan2(across, along)) * mp.sin(polar) / 2

    cut, last = mp.acos((r1 + r2) / d), mp.acos((r1 - r2) / d)
    with mp.workdps(20):
        factor = mp.quad(patch, [mp.mpf("1e-30"), cut, last] if cut > 1e-9 else [mp.mpf("1e-9"), last])
    return {"F12": factor, "F21": factor * (r1 / r2) ** 2}


@recomputes("I.misc_ff", "single")
def _(_):
    def discs(r, s):  # the azimuth between two rings is integrated by hand
        a, b = 1 + r * r + s * s, 2 * r * s
        return 4 * r * s * a / (a * a - b * b) ** mp.mpf("1.5")

    with mp.workdps(20):
        disc_disc = mp.quad(discs, [0, 1], [0, 1])
    return {
        "sphere_plane": mp.quad(lambda t: (1 + mp.cos(t)) / 2 * mp.sin(t) / 2, [0, mp.pi]),
        "sphere_disc": mp.quad(lambda t: mp.sin(t) / 2, [0, mp.pi / 4]),
        "patch_disc": mp.quad(lambda t: 2 * mp.sin(t) * mp.cos(t), [0, mp.pi / 4]),
        "disc_disc": disc_disc,
    }


def furnace(rho, bounces):
    """Radiance in a closed box of emission 1, bounce by bounce; that of any number of them solves E = 1 + rho E."""
    radiance = mp.mpf(1)
    for _ in range(bounces):
        radiance = 1 + rho * radiance
    return radiance


@recomputes("I.integrating_sphere")
def _(row):
    rho = row["rho"]
    total, ported = (
        root(equation, 0, 1000)
        for equation in (
            lambda e: 1 + rho * e - e,
            lambda m: rho * (1 + mp.mpf("0.98") * m) - m,
        )
    )
    return {"E_indirect": rho * total, "E_total": total, "E_5_bounces": furnace(rho, 5), "M_port_0.02": ported}


@recomputes("I.furnace_box", "single")
def _(_):
    half = mp.mpf("0.5")
    return {"rho05": furnace(half, 200), "rho05_N4": furnace(half, 4)}


# --- rays in a plane: (x, z), in complex numbers x + i z ---


def cross(a, b):
    return (mp.conj(a) * b).imag


def dot(a, b):
    return (mp.conj(a) * b).real


def on_circle(p, d):
    """Where a ray leaves the unit disc, or enters it from the outside."""
    b, c = dot(p, d), abs(p) ** 2 - 1
    half = mp.sqrt(b * b - c)
    return p + d * (-b - half if c > mp.mpf("1e-30") else -b + half)


def mirrored(d, n):
    return d - 2 * dot(d, n) * n


def bent(d, n, eta):
    """Snell's law, n_t / n_i = eta."""
    n = n if dot(d, n) < 0 else -n
    along = (d - dot(d, n) * n) / eta
    return along - mp.sqrt(1 - abs(along) ** 2) * n


def through_ball(height, n, inner_reflections=0):
    """Point and direction of a ray that came in along z at a height."""
    d = mp.mpc(0, 1)
    p = on_circle(mp.mpc(height, -3), d)
    d = bent(d, p, n)
    for _ in range(inner_reflections):
        p = on_circle(p, d)
        d = mirrored(d, p)
    p = on_circle(p, d)
    return p, bent(d, p, 1 / n)


@recomputes("I.slab_shift")
def _(row):
    angle = mp.radians(row["theta_deg"])
    d = mp.expj(angle - mp.pi / 2)  # down, into a slab between z = 0 and z = -1
    inside = bent(d, mp.mpc(0, 1), row["n"])
    leaves = inside / -inside.imag
    straight = d / -d.imag
    return {
        "shift_perp": cross(leaves, d),
        "shift_along_face": (straight - leaves).real,
        "theta_t_deg": mp.degrees(mp.atan(leaves.real)),
    }


def focal_length(n):
    height = mp.mpf("1e-12")  # the error is of the order of its square
    p, d = through_ball(height, n)
    return -height / d.real, p.imag - p.real * d.imag / d.real


@recomputes("I.ball_lens")
def _(row):
    efl, crossing = focal_length(row["n"])
    columns = {"EFL": efl, "BFL": crossing - 1}
    for height in ("0.1", "0.5", "0.9"):
        p, d = through_ball(mp.mpf(height), row["n"])
        columns |= {
            f"dev_{height}": mp.degrees(mp.atan(-d.real / d.imag)),
            f"z_{height}": (p - d * p.real / d.real).imag,
        }
    return columns


def bow(n, order):
    """Incidence and deflection at the minimum; the deflection is the sum of what each hit turns."""

    def deflection(i):
        return 2 * (i - mp.asin(mp.sin(i) / n)) + order * (mp.pi - 2 * mp.asin(mp.sin(i) / n))

    incidence = root(lambda i: mp.diff(deflection, i), mp.mpf("0.3"), mp.mpf("1.5"))
    return incidence, deflection(incidence)


@recomputes("I.rainbow")
def _(row):
    columns = {}
    for order in (1, 2):
        incidence, deflection = bow(row["n"], order)
        d = through_ball(mp.sin(incidence), row["n"], order)[1]
        assert abs(mp.expj(mp.pi / 2 + deflection) - d) < 1e-30  # the ray of the minimum goes where the formula says
        names = f"i{order}_deg", f"D{order}_deg", f"radius{order}_deg"
        columns |= dict(zip(names, map(mp.degrees, (incidence, deflection, abs(mp.pi - deflection))), strict=True))
    return columns


@recomputes("I.derivatives", "single")
def _(_):
    step = mp.mpf("1e-12")

    def slope(f, n):
        return (f(n + step) - f(n - step)) / (2 * step)

    def shift(n):
        leaves = bent(mp.expj(-mp.pi / 6), mp.mpc(0, 1), n)
        return cross(leaves / -leaves.imag, mp.expj(-mp.pi / 6))

    n = mp.mpf("1.333")
    first, second = (slope(lambda n, order=order: bow(n, order)[1], n) for order in (1, 2))
    return {
        "drainbow1_dn": -first,
        "drainbow1_check": -first,
        "drainbow2_dn": second,
        "dEFL_dn": mp.diff(lambda n: focal_length(n)[0], mp.mpf("1.5"), h=mp.mpf("1e-8")),
        "dshift_dn": slope(shift, mp.mpf("1.5")),
    }


@recomputes("I.alhazen")
def _(row):
    eye, source = row["a"], row["b"] * mp.expj(mp.radians(row["beta_deg"]))

    def mismatch(angle):  # of the two angles with the normal, by their sines
        n = mp.expj(angle)
        return cross(n, (source - n) / abs(source - n)) - cross((eye - n) / abs(eye - n), n)

    angle = root(mismatch, max(0, mp.radians(row["beta_deg"]) - mp.acos(1 / row["b"])), mp.acos(1 / row["a"]))
    p = mp.expj(angle)
    return {
        "phi_deg": mp.degrees(angle),
        "Px": p.real,
        "Py": p.imag,
        "incidence_deg": mp.degrees(mp.acos(dot(p, eye - p) / abs(eye - p))),
        "path": abs(eye - p) + abs(source - p),
    }


@recomputes("I.convex_mirror")
def _(row):
    u, radius = row["u"], row["R"]
    depth = root(lambda v: 1 / v - 1 / u - 2 / radius, radius / 1000, radius)  # the mirror equation
    return {"image_depth": depth, "magnification": depth / u}


# --- tangents ---


def common_tangent(side):
    """Line at 2 from (0, 10) and at 1 from (0, 0), both on one side of it for side = 1: its sine, and z on the axis."""
    sine = root(lambda s: 2 - side - 10 * s, mp.mpf("0.01"), mp.mpf("0.9"))  # centres projected on its normal
    return sine, side / sine


@recomputes("I.penumbra", "single")
def _(_):
    (inner, apex), (outer, crossing) = common_tangent(1), common_tangent(-1)

    def at_floor(sine, z):
        return abs(z - 5) * mp.tan(mp.asin(sine))

    return {
        "umbra_half_deg": mp.degrees(mp.asin(inner)),
        "umbra_apex": apex,
        "penumbra_half_deg": mp.degrees(mp.asin(outer)),
        "penumbra_apex": -crossing,
        "umbra_radius_at_5": at_floor(inner, apex),
        "penumbra_radius_at_5": at_floor(outer, crossing),
    }


def grazing(lamp, height, radius):
    """Where the tangent from a lamp on the axis to a ball at a height meets the floor."""
    distance = lamp - height
    slope = root(lambda m: m * distance / mp.sqrt(1 + m * m) - radius, 0, 10)  # distance of the line from the centre
    return slope * lamp


@recomputes("I.shadow", "single")
def _(_):
    sun = mp.expj(-mp.pi / 6)  # 60 degrees from the zenith
    ends = [(mp.mpc(0, 3) + side * mp.mpc(0, 1) * sun) for side in (1, -1)]  # where the sun grazes the ball
    right, left = (p.real - p.imag * sun.real / sun.imag for p in ends)
    return {
        "offset": (right + left) / 2,
        "semi_major": abs(right - left) / 2,
        "semi_minor": 1,
        "point_radius": grazing(10, 3, 1),
    }


@recomputes("I.perspective_sphere", "single")
def _(_):
    slope = grazing(5, 0, 1) / 5
    return {
        "half_angle_deg": mp.degrees(mp.atan(slope)),
        "image_radius": slope,
        "cap_fraction": mp.quad(lambda t: mp.sin(t) / 2, [0, mp.pi / 2 - mp.atan(slope)]),
    }


@recomputes("I.visibility_gradients", "single")
def _(_):
    n, step = mp.mpf("1.5"), mp.mpf("1e-12")

    def picture(radiance):
        """Slope in the radius of the integral of radiance(mu) over a disc, and what the pixels inside add to it."""
        total = mp.diff(lambda r: mp.pi * r * r * disc_mean(radiance), 1)

        def inside(mu):  # a pixel keeps its place: mu dmu/dr = 1 - mu^2
            return mp.diff(radiance, mu, direction=-1) * (1 - mu * mu) / mu

        interior = mp.pi * disc_mean(inside)
        return total, interior, total - interior

    columns = {}
    for name, law in (("a", lambda mu: mp.mpf(1)), ("b", lambda mu: mu), ("c", lambda mu: reflectance(mu, n))):
        columns |= {f"{name}_{part}": x for part, x in zip(("total", "interior", "edge"), picture(law), strict=True)}
    radius = grazing(10, 3, 1)
    above, below = (grazing(10, 3, 1 + h) for h in (step, -step))
    return {
        **columns,
        "c_interior_quad": columns["c_interior"],
        "d_radius": radius,
        "d_dradius_dr": (above - below) / (2 * step),
        "d_dArea_dr": mp.pi * (above**2 - below**2) / (2 * step),
    }


@recomputes("I.highlight", "single")
def _(_):
    sun = mp.radians(40)

    def brightest(law):
        return mp.sin(root(lambda w: mp.diff(law, w), mp.mpf("0.1"), mp.mpf("0.9")))

    lobes = [brightest(lambda w: mp.cos(2 * w - sun)), brightest(lambda w: mp.cos(w - sun / 2))]  # R . V and N . H
    assert abs(lobes[0] - lobes[1]) < 1e-30
    return {
        "highlight": lobes[0],
        "lambert_max": brightest(lambda w: mp.cos(w - sun)),
        "terminator": mp.sin(root(lambda w: mp.cos(w - sun), -mp.mpf("1.5"), mp.mpf(0))),
    }


# --- the tests ---


@pytest.mark.parametrize(("block", "part"), recomputes.formulas)
def test_another_route_gives_every_number_of(block, part):
    recomputes.compare(block, part)


@pytest.mark.parametrize("block", [name for name in BLOCKS if name[0] == "I"])
def test_every_column_but_the_inputs_is_recomputed_in(block):
    recomputes.is_complete(block)


def test_the_verdicts_of_the_table_on_visibility_hold():
    members = BLOCKS["I.alhazen"]
    for row in members["rows"]:
        values = dict(zip(members["fields"], row, strict=True))
        a, b, phi, beta = (float(number(values[name])) for name in ("a", "b", "phi_deg", "beta_deg"))
        seen = all(distance * cos(angle) > 1 for distance, angle in ((a, phi), (b, beta - phi)))
        assert values["outside_visible"] == ("yes" if seen else "no")
