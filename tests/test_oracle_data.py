"""The oracle table itself: recomputed at 40 digits from the textbook formulas, which share no code with the library.

The blocks of section I, the scenes, are in `test_oracle_scene`, the albedos in `test_oracle_albedo`.
"""

import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
from closed_albedos import walsh
from oracle_table import ALBEDOS, BLOCKS, TABLE, Recomputed, number, single

from jaxrefl.check.table import evaluators

recomputes = Recomputed(
    {
        "B.table": {"real_formula_max_abs_diff"},  # of the 40-digit computations of its maker
        "C.d3d9_fit": {"max_abs_err_at_nodes"},  # five digits, on one set of nodes
        "H.series": {"recursive_equals_iterative"},  # a verdict
    }
)


# --- the formulas ---


def cos(degrees):
    return mp.cos(mp.radians(degrees))


def reflection(mu, index, sqrt=mp.sqrt):
    """Amplitudes (r_s, r_p) at the cosine of incidence mu for a real or complex relative index (Born & Wolf 1.5)."""
    mu_t = sqrt(1 - (1 - mu * mu) / (index * index))
    return (mu - index * mu_t) / (mu + index * mu_t), (index * mu - mu_t) / (index * mu + mu_t)


def powers(mu, index, sqrt=mp.sqrt):
    r_s, r_p = reflection(mu, index, sqrt)
    return abs(r_s) ** 2, abs(r_p) ** 2


def exact(mu, index, sqrt=mp.sqrt):
    return sum(powers(mu, index, sqrt)) / 2


def normal(index):
    return abs((index - 1) / (index + 1)) ** 2


def schlick(mu, f0, p=5):
    return f0 + (1 - f0) * (1 - mu) ** p


def glass(mu):
    """D3D9 (3) with n = 1.5, p = 5, m = 1 - R0."""
    return schlick(mu, mp.mpf(4) / 100)


def average(f, *breaks):
    """Cosine-weighted average of f(mu)."""
    return mp.quad(lambda mu: 2 * f(mu) * mu, [0, *breaks, 1])


def rms(f):
    """Root mean square of f(mu), uniform in theta."""
    return mp.sqrt(mp.quad(lambda t: f(mp.cos(t)) ** 2, [0, mp.pi / 4, mp.pi / 2]) * 2 / mp.pi)


def lowest(f):
    """Angle in degrees and value of the minimum of f(mu): a scan of half degrees, then the root of the slope."""
    start = min(range(180), key=lambda j: f(cos(mp.mpf(j) / 2)))
    if start == 0:
        return mp.mpf(0), f(mp.mpf(1))
    bracket = [mp.mpf(start + side) / 2 for side in (-1, 1)]
    angle = mp.findroot(lambda t: mp.diff(lambda x: f(cos(x)), t), bracket, solver="anderson")
    return angle, f(cos(angle))


def highest(f):
    angle, value = lowest(lambda mu: -f(mu))
    return angle, -value


def tint(index):
    """F82, its ratio to Schlick's value, and the coefficient a (Hoffman 2019)."""
    seventh = mp.mpf(1) / 7
    f82, approximate = exact(seventh, index), schlick(seventh, normal(index))
    return f82, f82 / approximate, (approximate - f82) / (seventh * (6 * seventh) ** 6)


def series(alpha, color):
    """c^0 of the recursion c^i = (1 - alpha_i) c_i + alpha_i c^(i+1), from behind (PERRIN (1))."""
    behind = 0
    for a, c in zip(reversed(alpha), reversed(color), strict=True):
        behind = (1 - a) * c + a * behind
    return behind


def whitted(k, local):
    """I of the recursion I^i = I_local,i + k_i I^(i+1), from behind (JHU)."""
    behind = 0
    for a, c in zip(reversed(k), reversed(local), strict=True):
        behind = c + a * behind
    return behind


def with_alpha(values):
    """Reflectivities of the example, some of them replaced."""
    return [values.get(i, a) for i, a in enumerate(ALPHA)]


ALPHA, COLOR = ([Fraction(digits, 10) for digits in row] for row in ((5, 8, 3, 9, 6), (2, 9, 4, 7, 1)))


# --- the blocks ---


@recomputes("A.table")
def _(row):
    mu, eta = cos(row["theta_deg"]), row["eta"]
    r_s, r_p = (r.real for r in reflection(mu, eta))
    total = mp.sqrt(1 - mu * mu) > eta
    slopes = (
        mp.diff(lambda t: exact(mp.cos(t), eta), mp.radians(row["theta_deg"])),
        mp.diff(lambda x: exact(x, eta), mu),
        mp.diff(lambda x: exact(mu, x), eta),
    )
    names = "tir", "r_s", "r_p", "R_s", "R_p", "R", "dR_dtheta_per_rad", "dR_dcos", "dR_deta"
    values = int(total), r_s, r_p, *powers(mu, eta), exact(mu, eta), *((0, 0, 0) if total else slopes)
    return dict(zip(names, values, strict=True))


@recomputes("A.special")
def _(row):
    n = row["n"]
    brewster = mp.atan(n)
    slope = mp.diff(normal, n)
    return {
        "R0": normal(n),
        "brewster_ext_deg": mp.degrees(brewster),
        "brewster_int_deg": mp.degrees(mp.atan(1 / n)),
        "critical_deg": mp.degrees(mp.asin(1 / n)),
        "Rs_at_brewster": powers(mp.cos(brewster), n)[0],
        "R_at_brewster": exact(mp.cos(brewster), n),
        "dRdcos_grazing": mp.diff(lambda mu: exact(mu, n), 0),
        "dR0_dn": slope,
        "dR0_dn_check": slope,
    }


@recomputes("A.tir_phase")
def _(row):
    s, p = (mp.degrees(abs(mp.arg(r))) for r in reflection(cos(row["theta_deg"]), 1 / row["n"]))
    return {"delta_s_deg": s, "delta_p_deg": p, "delta_p-delta_s_deg": p - s}


@recomputes("A.near_normal")
def _(row):
    coefficients = mp.taylor(lambda t: exact(mp.cos(t), row["n"]), 0, 4)
    return {"c2": coefficients[2], "c4": coefficients[4]}


@recomputes("A.reversal")
def _(row):
    inside, n = mp.radians(row["theta_int_deg"]), row["n"]
    outside = mp.asin(n * mp.sin(inside))
    return {
        "theta_ext_deg": mp.degrees(outside),
        "R_int": exact(mp.cos(inside), 1 / n),
        "R_ext": exact(mp.cos(outside), n),
        "ratio": mp.cos(outside) / (n * mp.cos(inside)),
    }


@recomputes("B.table")
def _(row):
    theta, eta, k = mp.radians(row["theta_deg"]), row["eta"], row["k"]
    mu, index = mp.cos(theta), mp.mpc(eta, k)
    slopes = {
        "dR_deta": mp.diff(lambda x: exact(mu, mp.mpc(x, k)), eta),
        "dR_dk": mp.diff(lambda x: exact(mu, mp.mpc(eta, x)), k) if k else None,
        "dR_dtheta_per_rad": mp.diff(lambda x: exact(mp.cos(x), index), theta),
    }
    return {**dict(zip(("R_s", "R_p"), powers(mu, index), strict=True)), "R": exact(mu, index), **slopes}


@recomputes("B.k_to_0")
def _(row):
    mu, eta, k = cos(row["theta_deg"]), row["eta"], row["k"]
    r = exact(mu, mp.mpc(eta, k))
    change = r - (1 if mp.almosteq(mp.sqrt(1 - mu * mu), eta) else exact(mu, eta))
    return {"R": r, "R-R(k=0)": change, "(R-R0)/k": change / k}


@recomputes("B.attenuated_tir_slope")
def _(row):
    mu, eta, step = cos(row["theta_deg"]), row["eta"], mp.mpf("1e-15")
    g = mp.sqrt(1 - mu * mu - eta * eta)
    s, p = 2 * mu * eta / (g * (1 - eta**2)), 2 * eta * mu * (eta**2 / g + 2 * g) / (eta**4 * mu**2 + g**2)
    return {"slope": -(s + p), "fd_check": (exact(mu, mp.mpc(eta, step)) - 1) / step}


@recomputes("B.metals")
def _(row):
    index = mp.mpc(row["eta"], row["k"])
    pseudo_brewster, dip = lowest(lambda mu: powers(mu, index)[1]), lowest(lambda mu: exact(mu, index))
    names = "pseudoBrewster_deg", "Rp_min", "minR_deg", "R_min"
    extrema = dict(zip(names, (*pseudo_brewster, *dip), strict=True))
    return {"F0": normal(index), **extrema, "R_at_cos_1_7": exact(mp.mpf(1) / 7, index)}


@recomputes("B.misprint_size", "single")
def _(_):
    n, k, theta = mp.mpf("0.43"), mp.mpf("2.455"), mp.pi / 3
    s, c, t = mp.sin(theta), mp.cos(theta), mp.tan(theta)
    r_s, r_p = reflection(c, mp.mpc(n, k))
    literal = (r_s**2 + r_p**2) / 2
    t0 = n * n - k * k - s * s
    a2b2 = mp.sqrt(t0 * t0 + 4 * n * n * k * k)
    a = mp.sqrt((a2b2 + t0) / 2)
    return {
        "R_exact": exact(c, mp.mpc(n, k)),
        "literal_r2_re": literal.real,
        "literal_r2_im": literal.imag,
        "Rp_exact": abs(r_p) ** 2,
        "Rp_literal_denominator_theta_tan2": abs(r_s) ** 2 * (a2b2 - 2 * a * s * t + (s * t) ** 2) / (theta * t * t),
    }


@recomputes("C.schlick_dielectric")
def _(row):
    n = row["n"]

    def error(mu):
        return schlick(mu, normal(n)) - exact(mu, n)

    (high, most), (low, least) = highest(error), lowest(error)
    return {
        "F0": normal(n),
        "err_max": most,
        "at_deg": high,
        "err_min": least,
        "at_deg2": low,
        "max_abs": max(abs(most), abs(least)),
        "rms_theta": rms(error),
    }


@recomputes("C.schlick_conductor")
def _(row):
    index = mp.mpc(row["eta"], row["k"])
    f82, ratio, a = tint(index)

    def error(mu):
        return schlick(mu, normal(index)) - exact(mu, index)

    def tinted(mu):
        return error(mu) - a * mu * (1 - mu) ** 6

    mu, weight = nodes("theta")
    wanted = schlick(mu, float(normal(index))) - exact(mu, complex(index), np.sqrt)
    exponent, a_fit, residual = fit(mu, weight, wanted, factor=mu)
    (high, most), (low, least) = highest(error), lowest(error)
    return {
        "F0": normal(index),
        "schlick_err_max": most,
        "at_deg": high,
        "schlick_err_min": least,
        "at_deg2": low,
        "schlick_rms": rms(error),
        "F82": f82,
        "F82_tint": ratio,
        "a_F82": a,
        "F82fit_err_max": highest(tinted)[1],
        "F82fit_err_min": lowest(tinted)[1],
        "F82fit_rms": rms(tinted),
        "LSK_a": a_fit,
        "LSK_alpha": exponent,
        "LSK_rms": residual,
    }


def nodes(metric):
    """Gauss-Legendre nodes cos theta and weights in double precision, for a mean that is uniform in ``metric``."""
    x, w = np.polynomial.legendre.leggauss(400)
    x, w = (1 + x) / 2, w / 2
    return {"theta": (np.cos(x * np.pi / 2), w), "mu": (x, w), "cos": (x, 2 * x * w)}[metric]


def fit(mu, weight, wanted, factor=1.0, multiplier=None):
    """Least-squares (m, p) of m factor (1 - mu)^p and the rms residual; p by a scan, then the root of the slope.

    For each p the best m is linear, unless a multiplier is given; the slope in p is then that at fixed m.
    """

    def at(p):
        base = factor * (1 - mu) ** p
        m = multiplier or np.sum(weight * base * wanted) / np.sum(weight * base * base)
        rest = wanted - m * base
        return m, np.sqrt(np.sum(weight * rest * rest)), -m * np.sum(weight * rest * base * np.log(1 - mu))

    start = min(np.arange(1, 20, 0.25), key=lambda p: at(p)[1])
    low, high = start - 0.25, start + 0.25
    for _ in range(52):
        middle = (low + high) / 2
        low, high = (middle, high) if at(middle)[2] < 0 else (low, middle)
    return low, *at(low)[:2]


@recomputes("C.gulbrandsen")
def _(row):
    r, g = row["r"], row["g"]
    low, high = (1 - r) / (1 + r), (1 + mp.sqrt(r)) / (1 - mp.sqrt(r))
    n = g * low + (1 - g) * high
    k2 = (r * (n + 1) ** 2 - (n - 1) ** 2) / (1 - r)
    index = mp.mpc(n, mp.sqrt(max(k2, 0)))
    values = low, high, n, k2, index.imag, normal(index), exact(cos(60), index), exact(cos(80), index)
    return dict(zip(("n_min", "n_max", "n", "k2", "k", "F0_check", "R60", "R80"), values, strict=True))


@recomputes("C.gulbrandsen_inverse")
def _(row):
    fields, metals = BLOCKS["B.metals"]["fields"], BLOCKS["B.metals"]["rows"]
    metal = next(dict(zip(fields, values, strict=True)) for values in metals if values[0] == row["metal@nm"])
    n, k = mp.mpf(metal["eta"]), mp.mpf(metal["k"])
    r = normal(mp.mpc(n, k))
    low, high = (1 - r) / (1 + r), (1 + mp.sqrt(r)) / (1 - mp.sqrt(r))
    return {"r": r, "g": (high - n) / (high - low)}


@recomputes("C.d3d9_fit")
def _(row):
    (mu, weight), r0, n = nodes(row["metric"]), float(normal(row["n"])), float(row["n"])
    wanted = exact(mu, n, np.sqrt) - r0
    p, m, free = fit(mu, weight, wanted)
    p_only, _, bound = fit(mu, weight, wanted, multiplier=1 - r0)
    schlick5 = np.sqrt(np.sum(weight * (schlick(mu, r0) - r0 - wanted) ** 2))
    values = normal(row["n"]), p, m, free, r0 + m, p_only, bound, schlick5
    return dict(zip(("R0", "p", "m", "rms", "R0+m", "p_only", "rms_p_only", "rms_schlick5"), values, strict=True))


@recomputes("C.schlick_internal")
def _(row):
    mu, n = cos(row["theta_deg"]), row["n"]
    return {
        "R_exact": exact(mu, 1 / n),
        "schlick_theta_i": schlick(mu, normal(n)),
        "schlick_theta_t": schlick(mp.sqrt(1 - n * n * (1 - mu * mu)), normal(n)),
    }


@recomputes("C.d3d9_eq3")
def _(row):
    return {"R": schlick(cos(row["theta_deg"]), normal(row["n"]), row["p"])}


def polynomial(x, *coefficients):
    return sum(mp.mpf(coefficient) * x**i for i, coefficient in enumerate(coefficients))


@recomputes("D.dielectric")
def _(row):
    n = row["n"]
    critical = mp.sqrt(1 - 1 / n**2)
    outside = average(lambda mu: exact(mu, n), mp.mpf("0.01"), mp.mpf("0.2"))
    inside = critical**2 + mp.quad(lambda mu: 2 * mu * exact(mu, 1 / n), mp.linspace(critical, 1, 4))
    return {
        "F_ext": outside,
        "closed-quad": walsh(n) - outside,
        "F_int": inside,
        "int_closed-quad": 1 - (1 - walsh(n)) / n**2 - inside,
        "dF_ext_dn": mp.diff(walsh, n),
        "schlick_avg": normal(n) + (1 - normal(n)) / 21,
        "KC_ext_fit": (n - 1) / (mp.mpf("4.08567") + mp.mpf("1.00071") * n),
        "KC_int_fit": polynomial(1 / n, "0.997118", "0.1014", "-0.965241", "-0.130607"),
        "Egan73_int_fit": polynomial(n, "-1.4399", "0.7099", "0.6681", "0.0636") / n**2,
    }


@recomputes("D.conductor")
def _(row):
    index = mp.mpc(row["eta"], row["k"])
    mean = normal(index) + (1 - normal(index)) / 21
    return {
        "F0": normal(index),
        "F_avg": average(lambda mu: exact(mu, index)),
        "schlick_avg": mean,
        "F82_avg": mean - tint(index)[2] / 126,
    }


@recomputes("D.d3d9_energy_p")
def _(row):
    r0, wanted = normal(row["n"]), walsh(row["n"])
    return {"p": mp.findroot(lambda p: r0 + 2 * (1 - r0) / ((p + 1) * (p + 2)) - wanted, 5)}


@recomputes("D.d3d9_avg")
def _(row):
    return {"R_avg": average(lambda mu: row["R0"] + row["m"] * (1 - mu) ** row["p"])}


@recomputes("G.d3d9_furnace")
def _(row):
    grey, r = row["lambda"], glass(cos(row["theta_deg"]))
    r_tot, diffuse = grey * (1 - r) + r, 1 - grey
    return {
        "R": r,
        "eq5": r_tot,
        "eq6_maxnorm": diffuse + r_tot,
        "eq6_l2norm": 1 - mp.sqrt(3) * grey + r_tot,
        "eq8_view_furnace": average(lambda mu: diffuse * (1 - glass(mu)) + r_tot),
        "eq8_light_hemispherical": diffuse * (1 - r) + r_tot,
    }


@recomputes("G.d3d9_furnace", "single")
def _(_):
    mean = average(glass)
    return {"R_avg": mean, "eq6_bihemispherical_lambda0": 1 + mean}


@recomputes("G.eq8_reciprocity")
def _(row):
    return {"ratio": (1 - glass(cos(row["sigma_deg"]))) / (1 - glass(cos(row["theta_deg"])))}


@recomputes("G.eq7_alpha")
def _(row):
    r, background = glass(cos(row["theta_deg"])), mp.mpf("0.5")
    through = (1 - r) * background
    return {"R": r, "eq7_blend": r * r + through, "premultiplied_correct": r + through, "alpha_if_phi_10": 10 * r}


@recomputes("G.schlick_identity", "single")
def _(_):
    grey, r = Fraction(7, 10), Fraction(4, 100) + Fraction(96, 100) * Fraction(1, 2) ** 5
    raised = grey + Fraction(4, 100) * (1 - grey)
    return {"lhs": grey * (1 - r) + r, "rhs": raised + (1 - raised) * Fraction(1, 2) ** 5}


@recomputes("H.series")
def _(row):
    i = int(row["i"])
    w = math.prod(ALPHA[:i], start=Fraction(1))
    return {
        "alpha": ALPHA[i],
        "c": COLOR[i],
        "w": w,
        "weight": w * (1 - ALPHA[i]),
        "tail_c^i": series(ALPHA[i:], COLOR[i:]),
        "dcb_dalpha": series(with_alpha({i: 1}), COLOR) - series(with_alpha({i: 0}), COLOR),  # it is linear in each
        "dcb_dc": series(ALPHA, [int(j == i) for j in range(5)]),
    }


@recomputes("H.series", "single")
def _(_):
    return {
        "c_b": series(ALPHA, COLOR),
        "remaining_weight": 1 - series(ALPHA, [1] * 5),
        "c_b_last_alpha_zero": series(with_alpha({4: 0}), COLOR),
    }


@recomputes("H.hessian")
def _(row):
    j, k = int(row["j"]), int(row["k"])
    corners = {(a, b): series(with_alpha({j: a, k: b}), COLOR) for a in (0, 1) for b in (0, 1)}
    return {"value": corners[1, 1] - corners[1, 0] - corners[0, 1] + corners[0, 0]}


@recomputes("H.constant")
def _(row):
    alpha, c, n = row["alpha"], row["c"], int(row["N"])
    whole = series([alpha] * (n + 1), [c] * (n + 1))
    return {"c_b": whole, "truncation": c - whole, "dcb_dalpha_total": -c * (n + 1) * alpha**n}


@recomputes("H.jhu", "single")
def _(_):
    k, local = [Fraction(x, 10) for x in (5, 2, 0)], [Fraction(x, 10) for x in (6, 3, 8)]
    return {
        "additive": whitted(k, local),
        "convex": series(k, local),
        **{f"dI_dkr{i + 1}": whitted([*k[:i], k[i] + 1, *k[i + 1 :]], local) - whitted(k, local) for i in range(2)},
        **{f"dI_dIlocal{i + 1}": whitted(k, [int(j == i) for j in range(3)]) for i in range(3)},
        "convex_c1_needed_for_same_image": local[0] / (1 - k[0]),
        "convex_c2_needed": local[1] / (1 - k[1]),
    }


@recomputes("H.tree")
def _(row):
    local, k_r, k_t, depth = row["L"], row["k_r"], row["k_t"], int(row["depth"])
    radiance, count = local, 1
    for _ in range(depth):
        radiance, count = local + k_r * radiance + k_t * radiance, 1 + 2 * count
    diverges = mp.almosteq(k_r + k_t, 1)
    return {
        "I_D": radiance,
        "remainder_to_inf": None if diverges else local / (1 - k_r - k_t) - radiance,
        "nodes": count,
    }


def corridor(rule, alpha, n):
    """Sum over N + 1 hits on two facing mirrors in turn; 2000 of them are as good as all."""
    hits = 2000 if mp.isinf(n) else int(n) + 1
    return rule([alpha[i % 2] for i in range(hits)], [mp.mpf((3, 7)[i % 2]) / 10 for i in range(hits)])


@recomputes("H.corridor")
def _(row):
    alpha = mp.mpf("0.9"), mp.mpf("0.8")
    return {"convex": corridor(series, alpha, row["N"]), "additive": corridor(whitted, alpha, row["N"])}


@recomputes("H.corridor", "single")
def _(_):
    a, b = mp.mpf("0.9"), mp.mpf("0.8")
    return {
        "dconvex_dalpha_a": mp.diff(lambda x: corridor(series, (x, b), mp.inf), a),
        "dconvex_dalpha_b": mp.diff(lambda x: corridor(series, (a, x), mp.inf), b),
    }


@recomputes("H.glass_sphere_tree")
def _(row):
    orders = []
    for r in powers(mp.sqrt(1 - row["b"] ** 2), row["n"]):
        orders.append([r, *((1 - r) ** 2 * r**i for i in range(5))])
    mean = [(s + p) / 2 for s, p in zip(*orders, strict=True)]
    return {**{f"p{i}": order for i, order in enumerate(mean)}, "deficit": 1 - sum(mean)}


# --- the tests ---


@pytest.mark.parametrize(("block", "part"), recomputes.formulas)
def test_the_textbook_gives_every_number_of(block, part):
    recomputes.compare(block, part)


@pytest.mark.parametrize("block", [name for name in BLOCKS if name[0] not in "IJ" and name not in ALBEDOS])
def test_every_column_but_the_inputs_is_recomputed_in(block):
    recomputes.is_complete(block)


@pytest.mark.parametrize("block", BLOCKS)
def test_the_text_is_well_formed_in(block):
    members = BLOCKS[block]
    assert members["about"]
    assert members["how"]
    assert 1e-18 <= members["rtol"] <= 1e-8
    assert members.get("rows") or members.get("values")
    assert all(len(row) == len(members["fields"]) for row in members.get("rows", ()))
    words = {"material", "metal@nm", "metric", "recursive_equals_iterative", "model", "tag", "outside_visible"}
    words |= {"metal", "source", "case"}
    texts = {name: [row[i] for row in members["rows"]] for i, name in enumerate(members.get("fields", ()))}
    for name, column in {**texts, **{name: [text] for name, text in single(members).items()}}.items():
        assert all(text is None or name in words or isinstance(number(text), mp.mpf) for text in column), name
        assert any(text is not None for text in column), name


def test_the_table_says_what_it_is_where_it_comes_from_and_under_which_licence():
    assert TABLE.keys() == {"about", "source", "licence", "sections"}
    assert all(TABLE.values())


@pytest.mark.parametrize("block", [name for name in BLOCKS if "rows" in BLOCKS[name]])
def test_no_two_rows_have_the_same_inputs_in(block):
    members = BLOCKS[block]
    where = [members["fields"].index(name) for name in evaluators[block].inputs]
    inputs = [tuple(row[i] for i in where) for row in members["rows"]]
    assert len(set(inputs)) == len(inputs)
