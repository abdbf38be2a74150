"""Thin films: against two other programs, 30 digits, closed forms and averages, and at every edge."""

import functools

import jax
import jax.numpy as jnp
import mpmath as mp
import numpy as np
import pytest
import tmm
from colour.phenomena import multilayer_tmm

from jaxrefl import films, fresnel
from jaxrefl.brdf import Slab

pytestmark = pytest.mark.usefixtures("quick_compilation")

ARGUMENTS = ("cos_theta", "wavelength_nm", "n", "k", "thickness_nm", "outside", "inside_n", "inside_k")
POWERS = ("R_s", "R_p", "T_s", "T_p")


solve, absorbed = jax.jit(films.film), jax.jit(films.absorbed)  # one compilation instead of one per operation
incoherent = jax.jit(films.incoherent, static_argnames="thick")


def film(cos_theta, wavelength_nm, n, k, thickness_nm, outside, inside_n, inside_k):
    return films.film(cos_theta, wavelength_nm, n, k, thickness_nm, outside, (inside_n, inside_k))


def pair(arguments):
    """Arguments of `films.film` from those of `film`."""
    return *arguments[:6], tuple(arguments[6:])


def stacks(seed, layers, count, *, lowest=0.1, absorbing=0.6, largest_k=3.0):
    """Random arguments of `film`, the layers first: about half of the media absorb, some light is totally reflected."""
    rng = np.random.default_rng(seed)

    def k(*shape):
        return rng.uniform(0, largest_k, shape) * (rng.random(shape) < absorbing)

    c, wavelength = rng.uniform(0.01, 1, count), rng.uniform(300, 900, count)
    n, d = rng.uniform(lowest, 4, (layers, count)), rng.uniform(0, 300, (layers, count))
    return [c, wavelength, n, k(layers, count), d, rng.uniform(1, 2.5, count), rng.uniform(lowest, 4, count), k(count)]


def row(arguments, i):
    """Indices from the outside in, thicknesses, cosine and wavelength of one stack."""
    c, wavelength, n, k, d, outside, n_in, k_in = (np.asarray(a)[..., i] for a in arguments)
    return [complex(outside), *(n + 1j * k), complex(n_in, k_in)], list(d), float(c), float(wavelength)


# ---------------------------------------------------------------- other programs


def test_a_thousand_stacks_are_those_of_the_tmm_package():
    for layers, count in ((4, 700), (1, 300)):
        arguments = stacks(layers, layers, count)
        ours, theirs = solve(*pair(arguments)), []
        for i in range(count):
            indices, d, c, wavelength = row(arguments, i)
            both = [tmm.coh_tmm(p, indices, [np.inf, *d, np.inf], np.arccos(c), wavelength) for p in "sp"]
            theirs.append([both[j][name] for name in "rtRT" for j in (0, 1)])
        np.testing.assert_allclose(np.stack(ours), np.array(theirs).T, rtol=0, atol=1e-12)
        assert (np.abs(np.stack(ours)[4:]) > 0.01).mean() > 0.3  # not all of them opaque mirrors


def test_a_thousand_stacks_are_those_of_colour_science():
    """Its law of refraction takes Re N: transparent media below critical angles, absorbing ones at normal incidence."""
    slanted = stacks(2, 3, 500, absorbing=0.0)
    slanted[2], slanted[6], slanted[5] = 1.2 + slanted[2] * 0.7, 1.2 + slanted[6] * 0.7, slanted[5] * 0 + 1.1
    ours, theirs = solve(*pair(slanted)), []
    for i in range(500):
        indices, d, c, wavelength = row(slanted, i)
        theirs.append(
            np.concatenate([p.ravel() for p in multilayer_tmm(indices, d, wavelength, np.rad2deg(np.arccos(c)))])
        )
    np.testing.assert_allclose(np.stack(ours[4:]), np.array(theirs).T, rtol=0, atol=1e-12)
    for seed in range(10):  # its axis of wavelengths holds another stack at each, of the same thicknesses
        normal = stacks(20 + seed, 3, 50)
        normal[0], normal[4], normal[5] = np.ones(50), np.repeat(normal[4][:, :1], 50, axis=1), np.full(50, 1.3)
        indices = np.vstack([normal[5], normal[2] + 1j * normal[3], normal[6] + 1j * normal[7]])
        reflected, transmitted = multilayer_tmm(indices, normal[4][:, 0], normal[1])
        factor = (normal[6] / normal[6][0])[:, None]  # in T it takes the last index of the first wavelength for all
        ours = solve(*pair(normal))
        np.testing.assert_allclose(np.stack(ours[4:6], -1), reflected[:, 0, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.stack(ours[6:], -1), transmitted[:, 0, 0] * factor, rtol=0, atol=1e-12)


def test_what_each_layer_absorbs_is_what_the_tmm_package_says_and_all_of_it_is_one_minus_r_minus_t():
    arguments = stacks(5, 4, 60)
    ours, whole = absorbed(*pair(arguments)), solve(*pair(arguments))
    for polarisation, a, r, t in (("s", ours[0], whole.R_s, whole.T_s), ("p", ours[1], whole.R_p, whole.T_p)):
        np.testing.assert_allclose(a.sum(axis=0), 1 - r - t, atol=1e-14)
        for i in range(60):
            indices, d, c, wavelength = row(arguments, i)
            data = tmm.coh_tmm(polarisation, indices, [np.inf, *d, np.inf], np.arccos(c), wavelength)
            np.testing.assert_allclose(a[:, i], tmm.absorp_in_each_layer(data)[1:-1], rtol=0, atol=1e-12)


def thick_stacks(seed, count, k=1e-12):
    """Coherent, thick, two coherent, thick, coherent; to order k / n of the thick ones `inc_tmm` may make light."""
    rng, arguments = np.random.default_rng(seed), stacks(seed, 6, count, lowest=1.2, largest_k=1.0)
    arguments[5] = rng.uniform(1, 1.2, count)
    for layer in (1, 4):
        arguments[3][layer] *= k
        arguments[4][layer] = rng.uniform(1e13, 1e14, count)
    return arguments


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_thick_layers_are_those_of_the_tmm_package():
    arguments = thick_stacks(3, 150)
    ours = incoherent(*arguments[:5], (1, 4), *pair(arguments)[5:])
    kinds, theirs = list("iciccici"), []
    for i in range(150):
        indices, d, c, wavelength = row(arguments, i)
        both = [tmm.inc_tmm(p, indices, [np.inf, *d, np.inf], kinds, np.arccos(c), wavelength) for p in "sp"]
        theirs.append([both[j][name] for name in "RT" for j in (0, 1)])
    np.testing.assert_allclose(np.stack(ours), np.array(theirs).T, rtol=0, atol=1e-12)
    assert (np.abs(ours.T) > 0.01).mean() > 0.1


# ---------------------------------------------------------------- 40 digits


def amplitudes_40(polarisation, indices, d, c, wavelength):
    """(r, t) from the amplitudes of the waves that go in and out on either side of each interface."""
    n = [mp.mpmathify(x) for x in indices]
    sine = n[0] * mp.sqrt(1 - mp.mpf(c) ** 2)
    q = [n[0] * c, *(mp.sqrt(x * x - sine * sine) for x in n[1:])]
    q = [-x if mp.im(x) < 0 else x for x in q]
    cosine = [x / m for x, m in zip(q, n, strict=True)]
    going, coming = mp.mpf(1), mp.mpf(0)
    for j in reversed(range(len(n) - 1)):
        a, b = (n[j], n[j + 1]) if polarisation == "s" else (n[j + 1], n[j])
        r = (a * cosine[j] - b * cosine[j + 1]) / (a * cosine[j] + b * cosine[j + 1])
        t = 2 * n[j] * cosine[j] / (a * cosine[j] + b * cosine[j + 1])
        going, coming = (going + r * coming) / t, (r * going + coming) / t
        if j:
            phase = mp.expj(2 * mp.pi * q[j] * d[j - 1] / wavelength)
            going, coming = going / phase, coming * phase
    return coming / going, 1 / going, q, n


def powers_40(polarisation, indices, d, c, wavelength):
    r, t, q, n = amplitudes_40(polarisation, indices, d, c, wavelength)
    flux = mp.re(q[-1]) if polarisation == "s" else mp.re(q[-1] / n[-1] ** 2) * abs(n[-1] / n[0]) ** 2 * n[0] ** 2
    return abs(r) ** 2, abs(t) ** 2 * flux / mp.re(q[0])


def numbers_40(values):
    """R_s, R_p, T_s, T_p from a flat list of the arguments of one stack."""
    c, wavelength, *rest, outside, n_in, k_in = values
    count = len(rest) // 3
    n, k, d = rest[:count], rest[count : 2 * count], rest[2 * count :]
    indices = [outside, *(mp.mpc(a, b) for a, b in zip(n, k, strict=True)), mp.mpc(n_in, k_in)]
    (r_s, t_s), (r_p, t_p) = (powers_40(p, indices, d, c, wavelength) for p in "sp")
    return r_s, r_p, t_s, t_p


def flat(arguments, i):
    return [mp.mpf(float(x)) for a in arguments for x in np.atleast_1d(np.asarray(a)[..., i])]


def powers(*arguments):
    return jnp.stack(solve(*pair(arguments))[4:])


AXES, ALL = (0, 0, 1, 1, 1, 0, 0, 0), tuple(range(8))


@functools.cache
def backwards():
    """Arguments and slopes, by reverse mode, of random stacks, special ones and those at the edges, in this order."""
    arguments = [np.concatenate(a, axis=-1) for a in zip(stacks(11, 3, 16), special(), edges(float), strict=True)]
    return arguments, jax.jit(jax.vmap(jax.jacrev(powers, ALL), AXES))(*arguments)


def differences_40(values):
    """Differences of `numbers_40` to the right, of second order, by every argument: (arguments, 4).

    At 50 digits with a step of 1e-15: an error of 1e-30, and none of the signs of a negative k or thickness.
    """
    step, columns = mp.mpf(10) ** -15, []
    for i in range(len(values)):
        f0, f1, f2 = (numbers_40([*values[:i], values[i] + j * step, *values[i + 1 :]]) for j in range(3))
        columns.append([(4 * b - 3 * a - c) / (2 * step) for a, b, c in zip(f0, f1, f2, strict=True)])
    return np.array(columns, dtype=object)


SPECIAL = [  # four stacks of three layers where something could go wrong, by argument
    (
        0.6,
        500.0,
        (0.8, 1.5, 0.8),
        (0.0, 0.0, 0.0),
        (300.0, 100.0, 500.0),
        1.0,
        1.0,
        0.0,
    ),  # a layer at its critical angle
    (0.5, 633.0, (1.0, 1.0, 1.38), (0.0, 0.0, 0.0), (2000.0, 700.0, 90.0), 1.5, 1.5, 0.0),  # tunnelling
    (
        0.7,
        550.0,
        (1.38, 0.05, 2.4),
        (0.0, 3.6, 0.0),
        (99.0, 10.0, 0.0),
        1.0,
        1.5,
        2.0,
    ),  # silver; a layer of thickness 0
    (0.9, 600.0, (1.5, 1.5, 1.5), (0.0, 1e-9, 1e-3), (1e5, 100.0, 1e-3), 1.5, 1.5, 0.0),  # hardly anything there
]


def special():
    columns = [np.array([row[i] for row in SPECIAL]) for i in range(8)]
    return [c.T if c.ndim == 2 else c for c in columns]


def test_values_and_slopes_in_every_argument_are_those_of_40_digits():
    """Reflectances and transmittances of 20 stacks, and their slopes by angle, wavelength, n, k, thickness, outside."""
    arguments, slopes = backwards()
    values = np.asarray(solve(*pair(arguments))[4:])
    slopes = np.concatenate([np.asarray(s).reshape(values.shape[1], 4, -1) for s in slopes], axis=-1)
    with mp.workdps(50):
        for i in range(20):
            at = flat(arguments, i)
            np.testing.assert_allclose(values[:, i], np.array(numbers_40(at), float), rtol=1e-12, atol=1e-14)
            expected = differences_40(at).astype(float).T
            error = np.abs(slopes[i] - expected)
            allowed = np.maximum(1e-9 * np.abs(expected), 1e-14 * np.abs(expected).max())
            assert (error <= allowed).all(), f"stack {i}: {np.argwhere(error > allowed)}, {error.max()}"


def test_one_layer_is_airys_sum():
    """r = (r01 + r12 e) / (1 + r01 r12 e), e = exp(4 i pi d q / lambda), at 40 digits: r and t of the field."""
    rng = np.random.default_rng(4)
    c, wavelength, d = rng.uniform(0.05, 1, 12), rng.uniform(300, 900, 12), rng.uniform(0, 2000, 12)
    n, k = rng.uniform(0.3, 3, 12), rng.uniform(0, 2, 12) * (np.arange(12) % 2)
    found = solve(c, wavelength, n[None], k[None], d[None], 1.0, (1.5, 0.5))
    with mp.workdps(40):
        for i in range(12):
            m = [mp.mpf(1), mp.mpc(n[i], k[i]), mp.mpc(1.5, 0.5)]
            q = [mp.sqrt(x * x - 1 + mp.mpf(c[i]) ** 2) for x in m]
            once = mp.expj(2 * mp.pi * d[i] * q[1] / wavelength[i])
            for kind, r_found, t_found in (("s", found.r_s, found.t_s), ("p", found.r_p, found.t_p)):
                y = q if kind == "s" else [a / b**2 for a, b in zip(q, m, strict=True)]
                r01, r12 = ((y[j] - y[j + 1]) / (y[j] + y[j + 1]) for j in (0, 1))
                r = (r01 + r12 * once**2) / (1 + r01 * r12 * once**2)
                t = (1 + r01) * (1 + r12) * once / (1 + r01 * r12 * once**2) / (1 if kind == "s" else m[2])
                assert abs(complex(r) - complex(r_found[i])) < 1e-13
                assert abs(complex(t) - complex(t_found[i])) < 1e-13


# ---------------------------------------------------------------- closed forms


def test_a_quarter_wave_of_magnesium_fluoride_on_glass():
    """((n0 ns - n1^2) / (n0 ns + n1^2))^2; a half wave does nothing, and n1 = sqrt(ns) reflects nothing."""
    n1, ns = 1.38, 1.52
    found = solve(1.0, 550.0, [n1], 0.0, jnp.array([[1.0, 2.0, 4.0]]) * 550 / (4 * n1), 1.0, ns).R
    bare = ((ns - 1) / (ns + 1)) ** 2
    np.testing.assert_allclose(found, [((ns - n1**2) / (ns + n1**2)) ** 2, bare, bare], rtol=1e-13)
    np.testing.assert_allclose(found[0], 0.012600790214630307703, rtol=1e-13)
    assert solve(1.0, 550.0, [ns**0.5], 0.0, [550 / (4 * ns**0.5)], 1.0, ns).R < 1e-30


def test_a_mirror_of_quarter_waves():
    """R = ((1 - Y) / (1 + Y))^2, Y = ns (n_H / n_L)^(2 N); T to its last digits where R is 1."""
    high, low, ns = 2.4, 1.45, 1.52
    n = jnp.asarray([high, low] * 2000)
    for pairs in (1, 5, 40, 2000):
        found = solve(1.0, 600.0, n, 0.0, jnp.where(jnp.arange(4000) < 2 * pairs, 150.0 / n, 0.0), 1.0, ns)
        y = mp.mpf(ns) * (mp.mpf(high) / low) ** (2 * pairs)
        np.testing.assert_allclose(found.R, float(((1 - y) / (1 + y)) ** 2), rtol=1e-12)
        np.testing.assert_allclose(found.T, float(4 * y / (1 + y) ** 2), rtol=1e-11 * pairs)


def test_a_layer_like_its_surroundings_only_delays():
    c, n, d, wavelength = jnp.array([1.0, 0.6, 0.2]), 1.5, 437.0, 633.0
    found = solve(c, wavelength, [n], 0.0, [d], n, n)
    np.testing.assert_allclose(found.R, 0, atol=1e-30)
    np.testing.assert_allclose(found.T, 1, rtol=1e-14)
    delay = 2 * np.pi * n * d * c / wavelength
    np.testing.assert_allclose(films.phases(found).t_s, np.angle(np.exp(1j * delay)), rtol=1e-13)
    np.testing.assert_allclose(films.phases(found).t_p, np.angle(np.exp(1j * delay)), rtol=1e-13)


def test_no_layers_and_layers_of_no_thickness_are_the_interface():
    c = np.linspace(0, 1, 41)[:, None]
    n, k = np.array([1.5, 0.6, 0.43, 1.0, 2.0]), np.array([0.0, 0.0, 2.455, 0.0, 0.1])
    expected = jax.jit(fresnel.amplitudes)(c, n, k)
    none = jnp.zeros((0, 1, 1))
    for found in (
        solve(c, 500.0, none, none, none, 1.0, (n, k)),
        solve(c, 500.0, [1.7, 0.2], [0.0, 3.0], 0.0, 1.0, (n, k)),
        solve(c, 500.0, [[1.33], [1.33]], 0.0, 0.0, 1.33, (1.33 * n, 1.33 * k)),
    ):
        np.testing.assert_allclose(np.stack(found[:4]), np.stack(expected), atol=2e-15)
        np.testing.assert_allclose(np.stack(found[4:6]), np.stack(jax.jit(fresnel.conductor_sp)(c, n, k)), atol=1e-14)
        np.testing.assert_allclose(
            np.stack(found[6:]), np.stack(jax.jit(fresnel.transmittance_sp)(c, n, k)), atol=1e-14
        )


def test_light_that_tunnels_through_metal_is_right_to_its_last_digits():
    """T of a slab of metal between equal media at 1e-12 to 1e-250; deeper it is 0, and R that of the bulk, exactly."""
    n, k, wavelength = 0.5, 3.0, 500.0
    d = np.array([400.0, 3000.0, 7000.0])
    found = solve(0.7, wavelength, [n], [k], d[None], 1.0, 1.0)
    with mp.workdps(40):
        exact = [[powers_40(p, [1, mp.mpc(n, k), 1], [x], mp.mpf(0.7), wavelength)[1] for p in "sp"] for x in d]
    np.testing.assert_allclose(np.stack(found[6:], -1), np.array(exact, float), rtol=1e-11)
    assert found.T[2] < 1e-200


def test_a_thousand_wavelengths_of_metal_are_the_bulk_in_value_and_slope():
    c, n, k = jnp.array([0.0, 1e-9, 0.3, 0.8, 1.0]), 0.43, 2.455

    def deep(c, n, k, depth):
        return jnp.stack(film(c, 550.0, [n, 1.5], [k, 0.0], [depth, 100.0], 1.0, 2.0, 0.0)[4:6])

    def bulk(c, n, k):
        return jnp.stack(fresnel.conductor_sp(c, n, k))

    both = jax.jit(jax.vmap(jax.jacfwd(twice(deep), (0, 1, 2, 3), has_aux=True), (0, None, None, None)))
    values = jax.jit(jax.vmap(bulk, (0, None, None)))(c, n, k)
    expected = jax.jit(jax.vmap(jax.jacfwd(bulk, (0, 1, 2)), (0, None, None)))(c, n, k)
    for depth in (550e3, 550e9):
        found, at = both(c, n, k, depth)
        np.testing.assert_allclose(at, values, rtol=1e-14)
        np.testing.assert_allclose(np.stack(found[:3]), np.stack(expected), rtol=1e-11, atol=1e-13)
        np.testing.assert_array_equal(found[3], 0)


def test_ellipsometry_gives_back_the_index_of_a_bulk_and_the_angles_of_the_tmm_package():
    """<eps> = sin^2 (1 + tan^2 ((1 - rho) / (1 + rho))^2), rho = tan(psi) exp(i delta): (n - i k)^2, as instruments."""
    angles = jax.jit(lambda arguments: films.ellipsometry(films.film(*arguments)))
    c, n, k, d = np.array([0.2, 0.5, 0.9, 1.0]), 0.43, 2.455, np.array([[1e5, 1e5, 1e5, 30.0]])
    psi, delta = np.asarray(angles((c, 550.0, np.array([n]), np.array([k]), d)))
    rho, sine2 = np.tan(psi[:3]) * np.exp(1j * delta[:3]), 1 - c[:3] ** 2
    index2 = sine2 * (1 + sine2 / c[:3] ** 2 * ((1 - rho) / (1 + rho)) ** 2)
    np.testing.assert_allclose(index2, (n - 1j * k) ** 2, rtol=1e-12)
    np.testing.assert_allclose((psi[3], delta[3]), (np.pi / 4, np.pi), rtol=1e-12)
    arguments = stacks(8, 2, 20)
    psi, delta = angles(pair(arguments))
    for i in range(20):
        indices, d, c, wavelength = row(arguments, i)
        theirs = tmm.ellips(indices, [np.inf, *d, np.inf], np.arccos(c), wavelength)
        assert abs(psi[i] - theirs["psi"]) < 1e-12
        assert abs(np.exp(1j * delta[i]) + np.exp(-1j * theirs["Delta"])) < 1e-11  # its delta is pi - ours


def test_a_phase_of_minus_pi_is_pi():
    """Glass to air at normal incidence, r_s > 0 and r_p < 0; the tangent of any sign of 0, eagerly and under jit."""
    arguments = 1.0, 550.0, [1.38], 0.0, [0.0], 1.5, 1.0
    for one in (films.film(*arguments), solve(*arguments)):
        assert films.ellipsometry(one).delta == films.phases(one).r_p == np.pi
        assert films.phases(one).r_s == 0
    signs = films.film(0.0, 550.0, [1.38], 0.0, [0.0], 1.5, 1.0)
    assert films.phases(signs).r_s == jax.jit(films.phases)(signs).r_s == np.pi


# ---------------------------------------------------------------- thick layers


def test_a_pane_is_the_sum_of_its_reflections():
    c, depth = np.linspace(0, 1, 21), 0.3
    wavelength, d = 500.0, 1e6
    k = depth * wavelength / (4 * np.pi * d)
    slab = Slab(1.5, depth)
    found = incoherent(c, wavelength, [1.5], [k], [d], (0,), 1.0, 1.0)
    np.testing.assert_allclose(found.R, slab.mirror(c), atol=1e-8)  # that of a real index, k = 1e-8
    np.testing.assert_allclose(found.T, slab.through(c), atol=1e-8)
    clear = incoherent(c, wavelength, [1.5], 0.0, [d], (0,))
    f_s, f_p = fresnel.dielectric_sp(c, 1.5)
    for r, t, f in ((clear.R_s, clear.T_s, f_s), (clear.R_p, clear.T_p, f_p)):
        np.testing.assert_allclose(r, 2 * f / (1 + f), rtol=1e-13)
        np.testing.assert_allclose(t, (1 - f) / (1 + f), rtol=1e-13, atol=1e-15)


def test_a_thick_layer_is_the_mean_over_its_thickness_of_the_coherent_one():
    """One period of exp(2 i delta) averages the interference away; the trapezoidal rule converges exponentially."""
    c, wavelength, n = 0.7, 600.0, 1.6
    period = wavelength / (2 * np.sqrt(n**2 - 1 + c**2))
    d = 1e4 + period * np.arange(256) / 256
    layers = [2.3, n, 0.2, 1.4], [0.0, 0.0, 3.0, 0.0]
    four = jnp.stack([jnp.full(256, 80.0), jnp.asarray(d), jnp.full(256, 12.0), jnp.full(256, 120.0)])
    coherent = solve(c, wavelength, *layers, four, 1.0, (1.5, 0.2))
    powers = incoherent(c, wavelength, *layers, four[:, 0], (1,), 1.0, (1.5, 0.2))
    for name in POWERS:
        np.testing.assert_allclose(getattr(powers, name), np.mean(getattr(coherent, name)), rtol=1e-12, atol=1e-14)
    assert np.ptp(coherent.R) > 0.1


def test_no_light_is_made_in_a_thick_layer_and_none_passes_it_beyond_its_critical_angle():
    """R + T <= 1, also where a thick layer absorbs strongly; beyond the critical angle as k = 0, where R = 1, T = 0."""
    rng, count = np.random.default_rng(7), 20000
    n, d = 10 ** rng.uniform(-1, 1, (5, count)), 10 ** rng.uniform(-1, 4, (5, count)) * (rng.random((5, count)) < 0.8)
    k = 10 ** rng.uniform(-9, 1, (5, count)) * (rng.random((5, count)) < 0.5)
    found = incoherent(rng.uniform(0, 1, count), 550.0, n, k, d, (1, 3), 1.5, 1.2)
    assert np.min(found) > -1e-14
    assert np.max([found.R_s + found.T_s, found.R_p + found.T_p]) < 1 + 1e-14
    assert np.mean(found.T > 0.01) > 0.05
    small = np.array([0.0, 1e-12, 1e-9, 1e-6])
    beyond = incoherent(0.5, 550.0, [1.0], small[None], [20.0], (0,), 1.5, 1.5)
    np.testing.assert_array_equal(beyond.T, 0)
    np.testing.assert_allclose(beyond.R_s, fresnel.conductor_sp(0.5, 1 / 1.5, small / 1.5)[0], rtol=1e-14)
    np.testing.assert_allclose(beyond.R, 1, atol=5e-6)
    c = np.sqrt(1 - (1 / 1.5) ** 2) + np.linspace(-1e-6, 1e-6, 201)  # on both sides of it there is no jump
    across = incoherent(c, 550.0, [1.0], [1e-3], [20.0], (0,), 1.5, 1.5)
    assert np.abs(np.diff(np.stack(across), axis=1)).max() < 1e-3


def test_thick_layers_without_any_thick_layer_are_coherent():
    arguments = stacks(9, 3, 40)
    ours = incoherent(*arguments[:5], (), *pair(arguments)[5:])
    np.testing.assert_array_equal(np.stack(ours), np.stack(solve(*pair(arguments))[4:]))


# ---------------------------------------------------------------- edges


def edges(dtype):
    """Every combination of angles, half-spaces and layers at which a root, a quotient or an exponential has an edge."""
    layers = [
        ((1.0, 1.0), (0.0, 0.0), (0.0, 100.0)),
        ((0.75, 1.5), (0.0, 0.0), (100.0, 0.0)),
        ((0.05, 2.0), (3.0, 0.0), (5e5, 100.0)),
        ((0.5, 0.1), (0.0, 1e-12), (6e5, 1e9)),
        ((1e-4, 1e4), (1e4, 0.0), (1.0, 1.0)),
        ((1.5, 0.75), (0.0, 0.0), (1e-9, 1e7)),
        ((0.5, 2.0), (1e-15, 1e-20), (20.0, 100.0)),
        ((0.5, 1.5), (1e-20, 1e-30), (1e6, 0.0)),
        ((1e-3, 1.5), (1e-15, 0.0), (0.0, 100.0)),
    ]
    inside = [(1.0, 0.0), (1.5, 0.0), (0.5, 0.0), (0.75, 0.0), (2.0, 1e4), (0.05, 3.0), (1.0, 1e-9)]
    cosines = (0.0, 1e-12, 0.3, 0.5, 0.75**0.5, 0.8, 1.0)
    rows = [(c, 550.0, *m, outside, *i) for c in cosines for outside in (1.0, 1.5) for i in inside for m in layers]
    columns = [np.array([row[i] for row in rows], dtype) for i in range(8)]
    for i, bottom in ((2, 1.33), (3, 0.0), (4, 0.0)):  # a third layer, of no thickness
        columns[i] = np.concatenate([columns[i].T, np.full((1, len(rows)), bottom, dtype)])
    return columns


def everything(c, wavelength, n, k, d, outside, n_in, k_in):
    """All that there is: powers, those with a thick layer, angles and phases, what the layers absorb."""
    found = film(c, wavelength, n, k, d, outside, n_in, k_in)
    thick = films.incoherent(c, wavelength, n, k, d, (0,), outside, (n_in, k_in))
    a = films.absorbed(c, wavelength, n, k, d, outside, (n_in, k_in))
    return jnp.concatenate([jnp.stack([*found[4:], *thick, *films.ellipsometry(found), *films.phases(found)]), *a])


def twice(function):
    """The value as value and as what comes along: `jacfwd` of it gives (slopes, value) from one computation."""

    def both(*arguments):
        value = function(*arguments)
        return value, value

    return both


forward = jax.jit(jax.vmap(jax.jacfwd(twice(everything), ALL, has_aux=True), AXES))


def finite(arguments, slopes):
    for name, slope in zip(ARGUMENTS, slopes, strict=True):
        bad = ~np.isfinite(np.asarray(slope).reshape(len(slope), -1)).all(axis=1)
        assert not bad.any(), f"{name}: {[tuple(a[..., i] for a in arguments) for i in np.nonzero(bad)[0][:2]]}"


def within_bounds(arguments, values, rounding):
    """R, T and R + T in [0, 1], R = 1 at grazing incidence unless there is nothing; values (cases, R_s R_p T_s T_p)."""
    assert values.min() > -rounding
    assert values.max() < 1 + rounding
    assert (values[..., :2] + values[..., 2:]).max() < 1 + rounding
    grazing = (arguments[0] == 0) & ((arguments[6] != arguments[5]) | (arguments[7] > 0))
    np.testing.assert_allclose(values[grazing, ..., :2], 1, atol=rounding)


def test_reflectances_and_slopes_by_reverse_mode_are_finite_at_every_edge_in_double_precision():
    arguments, slopes = backwards()
    finite(arguments, slopes)
    within_bounds(arguments, np.stack(solve(*pair(arguments))[4:], -1), 1e-14)


def test_everything_and_its_slopes_by_forward_mode_are_finite_at_every_edge_in_single_precision(float32):
    arguments = edges(np.float32)
    slopes, values = jax.tree.map(np.asarray, forward(*arguments))
    assert values.dtype == np.float32
    assert np.isfinite(values).all()
    finite(arguments, slopes)
    within_bounds(arguments, values[:, :4], 4e-6)
    within_bounds(arguments, values[:, 4:8], 4e-6)


def test_second_derivatives_are_those_of_first_ones():
    """In thickness and index, through the power series of a thin layer as through the exponentials of a thick one."""

    def reflectance(x):
        return film(0.8, 500.0, x[:2], jnp.array([0.1, 0.0]), x[2:], 1.0, 1.5, 0.0).R

    def along(x, v):  # first and second derivative in the direction v
        return jax.jvp(lambda y: jax.jvp(reflectance, (y,), (v,))[1], (x,), (v,))

    both = jax.jit(jax.vmap(along))
    x = jnp.array([[1.8, 2.4, 6.0, 3.0], [1.8, 2.4, 130.0, 210.0]])
    v = jnp.array([[1.0, -0.5, 7.0, 20.0]] * 2)
    h = 1e-3
    (one, two), (less, much_less) = ((both(x + s * h * v, v)[0] for s in pair) for pair in ((1, 2), (-1, -2)))
    np.testing.assert_allclose(both(x, v)[1], (8 * (one - less) - (two - much_less)) / (12 * h), rtol=1e-7, atol=1e-9)


def test_single_precision_is_kept_and_good_to_five_digits(float32):
    arguments = stacks(12, 3, 200)
    single = solve(*pair([jnp.asarray(a, jnp.float32) for a in arguments]))
    assert {x.dtype for x in single} == {jnp.dtype("float32"), jnp.dtype("complex64")}
    with jax.enable_x64(True):
        double = solve(*pair(arguments))
    np.testing.assert_allclose(np.stack(single[4:]), np.stack(double[4:]), atol=2e-5)


# ---------------------------------------------------------------- shapes and errors


def test_layers_come_first_and_the_rest_broadcasts():
    c, wavelength = np.array([[1.0], [0.5]]), np.array([400.0, 500.0, 600.0])
    n, k = films.stack((2.0 + 0.1 * wavelength / 500, 0.0), (1.45, 1e-3), (wavelength / 300, 0.2))
    assert n.shape == k.shape == (3, 3)
    d = np.array([50.0, 80.0, 10.0])
    found = films.film(c, wavelength, n, k, d, 1.0, (1.5, 0.0))
    assert {x.shape for x in found} == {(2, 3)}
    assert [x.shape for x in jax.eval_shape(films.absorbed, c, wavelength, n, k, d)] == [(3, 2, 3)] * 2
    for i, j in ((0, 2), (1, 1)):
        one = solve(c[i, 0], wavelength[j], n[:, j], k[:, j], d, 1.0, 1.5)
        assert {x.shape for x in one} == {()}
        np.testing.assert_allclose(np.stack([x[i, j] for x in found]), np.stack(one), rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cos_theta": 1.1}, r"cos_theta = 1.1 is outside \[0, 1\]"),
        ({"wavelength_nm": 0.0}, r"wavelength_nm = 0.0 is outside \(0, inf\)"),
        ({"n": [1.5, -1.0]}, r"n = -1.0 is outside \(0, inf\)"),
        ({"k": [0.0, -0.1]}, r"k = -0.1 is outside \[0, inf\)"),
        ({"thickness_nm": [np.nan, 1.0]}, r"thickness_nm = nan is outside \[0, inf\)"),
        ({"outside": 0.0}, r"outside = 0.0 is outside \(0, inf\)"),
        ({"inside": (1.5, -1.0)}, r"inside k = -1.0 is outside \[0, inf\)"),
        ({"inside": (1.5, 0.0, 0.0)}, "inside has 3 entries"),
        ({"thickness_nm": [1.0]}, "'thickness_nm': 1"),
        ({"n": 1.5, "k": 0.0, "thickness_nm": 1.0}, "the first axis of n, k and thickness_nm"),
        ({"thick": (2,)}, r"thick = \(2,\) must be a tuple of different numbers of layers, 0 to 1"),
        ({"thick": (1, 1)}, r"thick = \(1, 1\) must be a tuple of different"),
        ({"thick": 0}, r"thick = 0 must be a tuple of different numbers of layers"),
        ({"thick": (0.0,)}, r"thick = \(0.0,\) must be a tuple"),
        ({"n": [np.ones(3), 1.5]}, r"n has entries of shapes \[\(3,\), \(\)\]; they must be equal; films.stack"),
        ({"n": np.ones((2, 3)), "wavelength_nm": np.ones(4)}, r"n \(2, 3\), .*wavelength_nm \(4,\) do not broadcast"),
    ],
)
def test_a_bad_argument_is_named_with_its_value_and_range(change, message):
    good = {"cos_theta": 0.5, "wavelength_nm": 500.0, "n": [1.5, 2.0], "k": [0.0, 0.0], "thickness_nm": [10.0, 20.0]}
    function = films.incoherent if "thick" in change else films.film
    with pytest.raises(ValueError, match=message):
        function(**(good | change))


def test_a_stack_of_nothing_is_refused():
    with pytest.raises(ValueError, match="at least one layer"):
        films.stack()
    with pytest.raises(ValueError, match=r"each a pair \(n, k\)"):
        films.stack((1.5, 0.0), 2.0)
