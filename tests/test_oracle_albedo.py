"""The albedos of the oracle table, recomputed at 40 digits: integrals in one angle, sums of bounces.

Nothing here is shared with the library; what the table has as a closed form is an integral here, and the reverse.
"""

import mpmath as mp
import pytest
from oracle_table import ALBEDOS, Recomputed

recomputes = Recomputed(
    {
        "E.modified_phong": {"check_max_abs"},  # of the 40-digit computations of its maker
        "E.oren_nayar_qualitative": {"check_G_max_abs"},
        "E.eon": {"avg_check"},
    }
)
with mp.workdps(50):
    RIGHT = mp.pi / 2
    C1, C2 = mp.mpf(1) / 2 - 2 / (3 * mp.pi), mp.mpf(2) / 3 - 28 / (15 * mp.pi)  # of EON


def cos(degrees):
    return mp.cos(mp.radians(degrees))


def fresnel(mu, n):
    """Reflectances (s, p) of a dielectric with the index n > 1."""
    inside = mp.sqrt(1 - (1 - mu * mu) / (n * n))
    return ((mu - n * inside) / (mu + n * inside)) ** 2, ((n * mu - inside) / (n * mu + inside)) ** 2


def reflectance(mu, n):
    return sum(fresnel(mu, n)) / 2


def average(f, *breaks):
    """Cosine-weighted average of f(mu)."""
    return mp.quad(lambda mu: 2 * f(mu) * mu, [0, *breaks, 1])


def phong_moment(n, theta):
    """Integral of (R . w)^n (N . w), in the angles of a lune: along it a beta function, across it an integral."""
    along = mp.beta((n + 3) / 2, mp.mpf(1) / 2)
    width = 6 / mp.sqrt(n)
    places = sorted({theta - RIGHT, *(x for x in (-width, 0, width) if theta - RIGHT < x < RIGHT), RIGHT})
    return along * mp.quad(lambda t: abs(mp.cos(t)) ** n * mp.cos(t - theta), places)


@recomputes("E.lambert", "single")
def _(_):
    hemisphere = 2 * mp.pi * mp.quad(lambda t: mp.cos(t) * mp.sin(t), [0, RIGHT])
    return {"int_cos": mp.pi, "quad": hemisphere, "inv_pi": 1 / hemisphere}


@recomputes("E.modified_phong")
def _(row):
    moment = phong_moment(row["n"], mp.radians(row["theta_deg"]))
    return {"albedo": (row["n"] + 2) / (2 * mp.pi) * moment, "I_n": moment}


@recomputes("E.modified_phong_avg")
def _(row):
    n = int(row["n"])

    def across(theta):
        """Integral of cos^n t cos(t - theta) over (theta - 90, 90) degrees by parts, in powers of sin and cos."""
        whole, s, c = mp.beta((n + 2) / mp.mpf(2), mp.mpf(1) / 2), mp.sin(theta), mp.cos(theta)
        part = mp.betainc((n + 2) / mp.mpf(2), mp.mpf(1) / 2, 0, s * s) / 2
        return c * (whole - part) + s ** (n + 2) / (n + 1)

    scale = (n + 2) / (2 * mp.pi) * mp.beta((n + 3) / mp.mpf(2), mp.mpf(1) / 2)
    with mp.workdps(20):
        places = [0, RIGHT - 6 / mp.sqrt(n), RIGHT] if n > 20 else [0, RIGHT]
        return {"albedo_bh": scale * mp.quad(lambda t: across(t) * mp.sin(2 * t), places)}


@recomputes("E.blinn_norm")
def _(row):
    n = row["n"]
    lobe = 2 * mp.pi * mp.quad(lambda t: mp.cos(t / 2) ** n * mp.cos(t) * mp.sin(t), [0, mp.pi / 8, RIGHT])
    scale = (n + 2) * (n + 4) / (8 * mp.pi * (2 ** (-n / 2) + n))
    factors = {
        "(n+8)/8pi": (n + 8) / (8 * mp.pi),
        "(n+2)/8pi": (n + 2) / (8 * mp.pi),
        "(n+2)/2pi": (n + 2) / (2 * mp.pi),
    }
    return {"N_exact": 1 / lobe, "N*I-1": scale * lobe - 1, **factors}


@recomputes("E.oren_nayar_qualitative")
def _(row):
    s2, theta = row["sigma"] ** 2, mp.radians(row["theta_deg"])
    a, b = 1 - s2 / (2 * (s2 + mp.mpf("0.33"))), mp.mpf("0.45") * s2 / (s2 + mp.mpf("0.09"))
    below = mp.quad(lambda t: mp.sin(theta) * mp.tan(t) * mp.cos(t) * mp.sin(t), [0, theta])
    above = mp.quad(lambda t: mp.sin(t) * mp.tan(theta) * mp.cos(t) * mp.sin(t), [theta, RIGHT])
    return {"A": a, "B": b, "albedo_over_rho": a + 2 * b / mp.pi * (below + above)}  # max(0, cos) has the integral 2


def fon_albedo(r, theta):
    """Directional albedo of Fujii's lobe, rho = 1: cos phi has the integral 2 where it is > 0, -2 where it is < 0."""

    def facing(t):
        return 2 * mp.sin(t) * mp.sin(theta) * (1 / mp.cos(min(t, theta)) - 1) * mp.cos(t) * mp.sin(t)

    return (1 + r / mp.pi * mp.quad(facing, sorted({mp.mpf(0), theta, RIGHT}))) / (1 + C1 * r)


def eon_bounces(rho, lost_i, lost_average):
    """rho_ms, the bounces after the first, summed one by one, and what of them leaves."""
    escapes = [rho**k * (1 - lost_average) * lost_average ** (k - 2) for k in range(2, 200)]
    return sum(escapes), sum(escapes) * lost_i


@recomputes("E.eon")
def _(row):
    r, theta, rho = row["r"], mp.radians(row["theta_deg"]), row["rho"]
    single = fon_albedo(r, theta)
    mean = (1 + C2 * r) / (1 + C1 * r)
    with mp.workdps(20):
        quadrature = mp.quad(lambda t: fon_albedo(r, t) * mp.sin(2 * t), [0, RIGHT]) if row["theta_deg"] == 30 else mean
    assert mp.almosteq(quadrature, mean, 1e-15)
    return {"E_FON": single, "E_FON_avg": mean, "E_EON": rho * single + eon_bounces(rho, 1 - single, 1 - mean)[1]}


@recomputes("E.eon", "single")
def _(_):
    return {"const1": C1, "const2": C2}


@recomputes("E.eon_point")
def _(row):
    r, rho, dphi = row["r"], row["rho"], mp.radians(row["dphi_deg"])
    angles = [mp.radians(row[name]) for name in ("theta_i", "theta_o")]
    s = mp.sin(angles[0]) * mp.sin(angles[1]) * mp.cos(dphi)
    toward = s / mp.cos(min(angles)) if s > mp.mpf(10) ** -30 else s
    lost_i, lost_o = (1 - fon_albedo(r, angle) for angle in angles)
    mean = (1 + C2 * r) / (1 + C1 * r)
    single = rho / mp.pi * (1 + r * toward) / (1 + C1 * r)
    multiple = eon_bounces(rho, 1, 1 - mean)[0] * lost_i * lost_o / (mp.pi * (1 - mean))
    return {"f_ss": single, "f_ms": multiple, "f": single + multiple}


@recomputes("E.lommel_seeliger")
def _(row):
    mu = cos(row["theta_deg"])
    return {"albedo_over_w": mp.quad(lambda x: x / (x + mu), [0, 1]) / 2}


@recomputes("E.lommel_seeliger", "single")
def _(_):
    both = mp.quad(lambda mu: mu * (1 - mu * mp.log(1 + 1 / mu)), [0, 1])
    return {"bihemispherical": both, "bh_quad": both}


@recomputes("E.minnaert")
def _(row):
    k, mu = row["k"], cos(row["theta_deg"])
    moment = mp.quad(lambda x: x**k, [0, 1])
    return {"albedo": (k + 1) * mu ** (k - 1) * moment, "bihemispherical": 2 * (k + 1) * moment**2}


def plate(f, tau):
    """Reflectance and transmittance of a plate: the bounces inside, one by one."""
    r, t, inside = f, mp.mpf(0), 1 - f
    for _ in range(2000):
        inside *= tau
        t, inside = t + inside * (1 - f), inside * f * tau
        r, inside = r + inside * (1 - f), inside * f
    return r, t


@recomputes("E.slab")
def _(row):
    mu, n = cos(row["theta_deg"]), row["n"]
    tau = mp.exp(-row["sigma_a_t"] / mp.sqrt(1 - (1 - mu * mu) / n**2))
    r, t = (sum(pair) / 2 for pair in zip(*(plate(f, tau) for f in fresnel(mu, n)), strict=True))
    return {"R": r, "T": t, "A": 1 - r - t, "R_unpolarised_shortcut": plate(reflectance(mu, n), tau)[0]}


@recomputes("E.slab_avg")
def _(row):
    return {"R_avg": average(lambda mu: sum(f / (1 + f) for f in fresnel(mu, row["n"])), mp.mpf("0.1"))}


@recomputes("E.ashikhmin_shirley_diffuse")
def _(row):
    def factor(mu):
        return 1 - (1 - mu / 2) ** 5

    return {"albedo": mp.mpf(28) / 23 * average(factor) * factor(cos(row["theta_deg"]))}


@recomputes("E.coat_lambert")
def _(row):
    n, rho, mu = row["n"], row["rho"], cos(row["theta_deg"])
    critical = mp.sqrt(1 - 1 / n**2)  # inside: total reflection below, the same as outside by reversal above
    inside = critical**2 + average(lambda out: reflectance(out, n)) / n**2
    outside = average(lambda out: reflectance(out, n))
    gathered = rho * (1 - inside) / (1 - rho * inside)
    point = rho * (1 - reflectance(mu, n)) * (1 - reflectance(1, n)) / (mp.pi * n**2 * (1 - rho * inside))

    def total(f):
        return f + (1 - f) * gathered

    return {"albedo_dir": total(reflectance(mu, n)), "f_d_i_to_normal": point, "albedo_bh": total(outside)}


@recomputes("E.ar_coating", "single")
def _(_):
    first, second = ((1 - n) / (1 + n) for n in (mp.mpf("1.38"), mp.mpf("1.52") / mp.mpf("1.38")))
    waves = [first] + [-(1 - first**2) * second * (first * second) ** j for j in range(40)]  # half a turn per passage
    bare = (mp.mpf("1.52") - 1) / (mp.mpf("1.52") + 1)
    return {"R": mp.fsum(waves) ** 2, "uncoated": bare**2}


@recomputes("G.phong_literal")
def _(row):
    ratio = phong_moment(row["n"], mp.radians(row["theta_deg"])) / cos(row["theta_deg"])
    return {"ratio_I_is_E": ratio, "ratio_I_is_E_over_pi": ratio / mp.pi}


@recomputes("G.phong_blowup")
def _(row):
    n = row["n"]

    def angle(k_s, start):
        with mp.workdps(25):
            root = mp.findroot(lambda t: k_s * phong_moment(n, RIGHT - t) - mp.sin(t), (start, start / 2))
            return mp.degrees(RIGHT - root)

    grazing = phong_moment(n, RIGHT)
    return {
        "theta_blowup_EoverPi_deg": angle(1 / mp.pi, grazing / mp.pi),
        "theta_blowup_E_deg": angle(1, grazing),
        "I_n_grazing": grazing,
    }


@recomputes("G.phong_reciprocity")
def _(row):
    return {"ratio": cos(row["theta_o"]) / cos(row["theta_i"])}


@recomputes("G.thresholds", "single")
def _(_):
    lobe = mp.findroot(lambda t: mp.cos(t) ** 50 - mp.mpf(1) / 2, 0.2)
    normal = mp.findroot(lambda n: phong_moment(n, mp.mpf(0)) - 1, 4)
    return {"n_crit": normal, "blinn_half_deg": mp.degrees(lobe), "phong_half_deg": mp.degrees(lobe) / 2}


@pytest.mark.parametrize(("block", "part"), recomputes.formulas)
def test_the_definition_gives_every_number_of(block, part):
    recomputes.compare(block, part)


@pytest.mark.parametrize("block", ALBEDOS)
def test_every_column_but_the_inputs_is_recomputed_in(block):
    recomputes.is_complete(block)
