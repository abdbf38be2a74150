"""The real form of the conductor printed in LAMBERT-FRESNEL, as a second implementation, and what its misprints do."""

import mpmath
import numpy as np
import pytest

from jaxrefl import fresnel

GOLD = 0.43, 2.455  # at 548.6 nm


def squares(sin2, n_t, k_t, n_i=1.0, sqrt=np.sqrt):
    """a^2 and b^2 as printed first, with 1 / (2 n_i^2); n_i = 1 gives the normalised pair."""
    t0 = n_t**2 - k_t**2 - n_i**2 * sin2
    root = sqrt(t0**2 + 4 * n_t**2 * k_t**2)
    return (root + t0) / (2 * n_i**2), (root - t0) / (2 * n_i**2)


def tangent_form(theta, a2, b2, lib=np):
    """R_s and R_p of the first block, its denominator corrected (S37)."""
    sin, cos, tan, a = lib.sin(theta), lib.cos(theta), lib.tan(theta), lib.sqrt(a2)
    r_s = (a2 + b2 - 2 * a * cos + cos**2) / (a2 + b2 + 2 * a * cos + cos**2)
    num = a2 + b2 - 2 * a * sin * tan + sin**2 * tan**2
    return r_s, r_s * num / (a2 + b2 + 2 * a * sin * tan + sin**2 * tan**2)


def cosine_form(theta, a2, b2, lib=np):
    """R_s and R_p of the last block, multiplied through by cos^2."""
    sin, cos, a = lib.sin(theta), lib.cos(theta), lib.sqrt(a2)
    r_s = (a2 + b2 - 2 * a * cos + cos**2) / (a2 + b2 + 2 * a * cos + cos**2)
    num = cos**2 * (a2 + b2) - 2 * a * cos * sin**2 + sin**4
    return r_s, r_s * num / (cos**2 * (a2 + b2) + 2 * a * cos * sin**2 + sin**4)


def points(n: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(4)
    return rng.uniform(0, np.radians(89), n), rng.uniform(0.05, 4, n), rng.uniform(0.1, 10, n), rng.uniform(1, 2, n)


@pytest.mark.parametrize("form", [tangent_form, cosine_form])
def test_the_printed_real_form_agrees_in_double_precision(form):
    theta, eta, k, _ = points(1000)
    printed = form(theta, *squares(np.sin(theta) ** 2, eta, k))
    np.testing.assert_allclose(printed, fresnel.conductor_sp(np.cos(theta), eta, k), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("form", [tangent_form, cosine_form])
def test_the_printed_real_form_agrees_to_forty_digits_rounded(form):
    with mpmath.workdps(40):
        for theta, eta, k in zip(*(x.tolist() for x in points(100)[:3]), strict=True):
            mu = float(mpmath.cos(theta))
            angle = mpmath.acos(mu)
            pair = squares(mpmath.sin(angle) ** 2, mpmath.mpf(eta), mpmath.mpf(k), sqrt=mpmath.sqrt)
            np.testing.assert_allclose(
                fresnel.conductor_sp(mu, eta, k), np.array(form(angle, *pair, lib=mpmath), float), rtol=2e-14
            )


@pytest.mark.parametrize("form", [tangent_form, cosine_form])
def test_both_normalisations_agree_when_the_incident_medium_is_not_vacuum(form):
    theta, n_t, k_t, n_i = points(1000)
    sin2 = np.sin(theta) ** 2
    first, second = squares(sin2, n_t, k_t, n_i), squares(sin2, n_t / n_i, k_t / n_i)
    np.testing.assert_allclose(first, second, rtol=1e-9, atol=1e-12)
    library = fresnel.conductor_sp(np.cos(theta), n_t / n_i, k_t / n_i)
    np.testing.assert_allclose(form(theta, *first), library, rtol=1e-9, atol=1e-12)


def test_the_short_sum_of_squares_needs_the_normalised_index():
    theta, n_t, k_t, n_i = points(1000)
    sin2 = np.sin(theta) ** 2
    total = np.add(*squares(sin2, n_t, k_t, n_i))

    def short(n, k, s2):
        return np.sqrt((n**2 - k**2 - s2) ** 2 + 4 * n**2 * k**2)

    np.testing.assert_allclose(total, short(n_t / n_i, k_t / n_i, sin2), rtol=1e-12)
    unnormalised = short(n_t, k_t, n_i**2 * sin2)
    np.testing.assert_allclose(unnormalised / n_i**2, total, rtol=1e-12)
    assert (abs(unnormalised / total - n_i**2) < 1e-9).all()
    assert abs(unnormalised / total - 1).max() > 1


def test_the_printed_denominator_of_r_p_is_a_misprint():
    theta = np.radians(60)
    a2, b2 = squares(np.sin(theta) ** 2, *GOLD)
    sin, tan, a = np.sin(theta), np.tan(theta), np.sqrt(a2)
    r_s, correct = tangent_form(theta, a2, b2)
    printed = r_s * (a2 + b2 - 2 * a * sin * tan + sin**2 * tan**2) / (theta * tan**2)
    np.testing.assert_allclose(printed, 2.2603756, rtol=1e-7)
    np.testing.assert_allclose([correct, fresnel.conductor_sp(0.5, *GOLD)[1]], 0.68344343120246834, rtol=1e-13)


def test_the_printed_square_of_a_complex_amplitude_is_a_misprint():
    found = fresnel.amplitudes(0.5, *GOLD)
    literal = sum(np.asarray(r) ** 2 for r in (found.r_s, found.r_p)) / 2
    np.testing.assert_allclose([literal.real, abs(literal.imag)], [0.0061899208, 0.41483388], rtol=1e-7)
    np.testing.assert_allclose(fresnel.conductor(0.5, *GOLD), 0.7881319032032609, rtol=1e-14)


def test_the_other_time_factor_conjugates_the_amplitudes_and_keeps_the_reflectances():
    theta, eta, k, _ = points(1000)
    n, mu = eta - 1j * k, np.cos(theta)
    cos_t = np.sqrt(1 - np.sin(theta) ** 2 / n**2)
    r_s, r_p = (mu - n * cos_t) / (mu + n * cos_t), (n * mu - cos_t) / (n * mu + cos_t)
    found = fresnel.amplitudes(mu, eta, k)
    np.testing.assert_allclose([found.r_s.conj(), found.r_p.conj()], [r_s, r_p], rtol=1e-11)
    np.testing.assert_allclose(fresnel.conductor_sp(mu, eta, k), np.abs([r_s, r_p]) ** 2, rtol=1e-11)
