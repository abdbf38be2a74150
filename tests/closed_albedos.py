"""Albedos in closed form or as integrals in one angle, in mpmath, without the library: the truth of the albedo tests.

All take the cosine of the fixed direction first and mpf (or float) parameters, and want `mp.workdps(30)` or more.
"""

import mpmath as mp


def lambert(mu, rho):
    return mp.mpf(rho)


def lune(mu, n):
    """Integral of cos^n t cos(t - theta) over (theta - 90, 90) degrees, by parts: any real n >= 0."""
    half, sine2 = mp.mpf(1) / 2, (1 - mu) * (1 + mu)
    whole, part = mp.beta((n + 2) / 2, half), half * mp.betainc((n + 2) / 2, half, 0, sine2)
    return mu * (whole - part) + sine2 ** ((n + 2) / 2) / (n + 1)


def phong_moment(mu, n):
    """Integral of (R . w)^n (N . w) over the hemisphere, R with the cosine mu to the normal."""
    mu, n = mp.mpf(mu), mp.mpf(n)
    return mp.beta((n + 3) / 2, mp.mpf(1) / 2) * lune(mu, n)


def modified_phong(mu, k_s, n):
    """Lafortune and Willems's lobe, Arvo's integral (1995) by lunes."""
    return mp.mpf(k_s) * (mp.mpf(n) + 2) / (2 * mp.pi) * phong_moment(mu, n)


def literal_flux(mu, n):
    """What literal Phong with k_s = 1 sends out of a beam over what arrives, I = E / pi."""
    return phong_moment(mu, n) / (mp.pi * mp.mpf(mu))


def blinn_moment(mu, n):
    """Integral of (N . H)^n (N . w): over half vectors, in closed form in their azimuth."""
    mu, n = mp.mpf(mu), mp.mpf(n)
    sine, theta_o = mp.sqrt((1 - mu) * (1 + mu)), mp.acos(mu)

    def ring(theta):
        c, s = mp.cos(theta), mp.sin(theta)
        a, b = mu * c, sine * s  # wo . h = a + b cos phi; wi.z = 2 c (wo . h) - mu, from there on where it is > 0
        if b == 0:
            phi = mp.pi if 2 * c * a > mu else mp.mpf(0)
        else:
            edge = (mu / (2 * c) - a) / b
            phi = mp.mpf(0) if edge >= 1 else mp.pi if edge <= -1 else mp.acos(edge)
        constant = (2 * c * a * a - mu * a) * phi + (4 * c * a - mu) * b * mp.sin(phi)
        return 2 * (constant + c * b * b * (phi + mp.sin(phi) * mp.cos(phi))) * c**n * s

    width, last = 1 / mp.sqrt(n + 1), mp.pi / 4 + theta_o / 2
    places = [0, mp.pi / 4 - theta_o / 2, last, *(width * k for k in (1, 2, 4, 8, 16, 32))]
    return 4 * mp.quad(ring, sorted({x for x in places if 0 <= x <= last}))


def blinn(mu, k_s, n):
    n = mp.mpf(n)
    return mp.mpf(k_s) * (n + 2) * (n + 4) / (8 * mp.pi * (2 ** (-n / 2) + n)) * blinn_moment(mu, n)


def rough(mu):
    """G_q = sin (theta - sin cos) + 2/3 tan (1 - sin^3), without the tangent."""
    mu = mp.mpf(mu)
    s = mp.sqrt((1 - mu) * (1 + mu))
    return s * (mp.acos(mu) - s * mu) + mp.mpf(2) / 3 * s * mu * (1 + s + s * s) / (1 + s)


def oren_nayar(mu, rho, sigma):
    s2 = mp.mpf(sigma) ** 2
    a = 1 - s2 / (2 * (s2 + mp.mpf(33) / 100))
    return mp.mpf(rho) * (a + mp.mpf(45) / 100 * s2 / (s2 + mp.mpf(9) / 100) / mp.pi * rough(mu))


def eon(mu, rho, r):
    mu, rho, r = mp.mpf(mu), mp.mpf(rho), mp.mpf(r)
    a = 1 / (1 + (mp.mpf(1) / 2 - 2 / (3 * mp.pi)) * r)
    single = a * (1 + r / mp.pi * (rough(mu) - mp.mpf(2) / 3 * mp.sqrt((1 - mu) * (1 + mu))))
    mean = a * (1 + (mp.mpf(2) / 3 - 28 / (15 * mp.pi)) * r)
    return rho * single + rho**2 * mean / (1 - rho * (1 - mean)) * (1 - single)


def lommel_seeliger(mu, w):
    mu = mp.mpf(mu)
    return mp.mpf(w) / 2 * (1 - (mu * mp.log1p(1 / mu) if mu else 0))


def minnaert(mu, c, k):
    return mp.mpf(c) * mp.mpf(mu) ** (mp.mpf(k) - 1)


def ashikhmin_shirley(mu, rho, f0):
    return mp.mpf(rho) * (1 - mp.mpf(f0)) * (1 - (1 - mp.mpf(mu) / 2) ** 5)


def fresnel(mu, n):
    """Reflectances (s, p) of a dielectric with the index n > 1."""
    mu, n = mp.mpf(mu), mp.mpf(n)
    inside = mp.sqrt(1 - (1 - mu * mu) / (n * n))
    return ((mu - n * inside) / (mu + n * inside)) ** 2, ((n * mu - inside) / (n * mu + inside)) ** 2


def walsh(n):
    """Average reflectance from outside, in closed form (Walsh 1926)."""
    n = mp.mpf(n)
    n2, n4 = n * n, n**4
    return (
        mp.mpf(1) / 2
        + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
        + n2 * (n2 - 1) ** 2 / (n2 + 1) ** 3 * mp.log((n - 1) / (n + 1))
        - 2 * n**3 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1))
        + 8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) ** 2) * mp.log(n)
    )


def coat(mu, rho, n):
    rho, n = mp.mpf(rho), mp.mpf(n)
    f, inside = sum(fresnel(mu, n)) / 2, 1 - (1 - walsh(n)) / n**2
    return f + (1 - f) * rho * (1 - inside) / (1 - rho * inside)


def slab(mu, n, depth):
    """Reflectance and transmittance, per polarisation."""
    mu, n = mp.mpf(mu), mp.mpf(n)
    tau = mp.exp(-mp.mpf(depth) / mp.sqrt(1 - (1 - mu * mu) / n**2))
    r = t = mp.mpf(0)
    for f in fresnel(mu, n):
        loss = 1 - f * f * tau * tau
        one = (1 - f) ** 2 * tau / loss if loss else mp.mpf(0)
        r, t = r + (f + f * tau * one) / 2, t + one / 2
    return r, t


def d3d9_reflectance(mu, r0, m, p):
    return mp.mpf(r0) + mp.mpf(m) * (1 - mp.mpf(mu)) ** mp.mpf(p)


def d3d9_average(r0, m, p):
    return mp.mpf(r0) + 2 * mp.mpf(m) / ((mp.mpf(p) + 1) * (mp.mpf(p) + 2))


def d3d9(mu, d, metallic, r0, m, p):
    """d (1 - lambda) + lambda (1 - R) + R."""
    r, metallic = d3d9_reflectance(mu, r0, m, p), mp.mpf(metallic)
    return mp.mpf(d) * (1 - metallic) + metallic * (1 - r) + r


def d3d9_repaired(mu, d, metallic, r0, m, p):
    r, metallic = d3d9_reflectance(mu, r0, m, p), mp.mpf(metallic)
    return mp.mpf(d) * (1 - metallic) * (1 - r) + metallic * (1 - r) + r


def burley(mu, rho, roughness):
    """One integral in the angle: over the azimuth wi . wo has the mean mu_i mu_o, its square that and half the rest."""
    mu, r = mp.mpf(mu), mp.mpf(roughness)

    def ring(x):
        e = r * (1 + x * mu) - mp.mpf(1) / 2
        e2 = e * e + r * r * (1 - x * x) * (1 - mu * mu) / 2
        a, b = (1 - x) ** 5, (1 - mu) ** 5
        return 2 * x * (1 + e * (a + b) + e2 * a * b)

    return mp.mpf(rho) * mp.quad(ring, [0, 1])


def von_mises_fisher(k, theta):
    """Integral of k / (2 pi) exp(k (w . d - 1)) cos over the hemisphere, d at the angle theta from the normal."""
    k, theta = mp.mpf(k), mp.mpf(theta)
    places = [0, mp.pi / 2, *(theta + j / mp.sqrt(k) for j in (-16, -8, -4, -2, 0, 2, 4, 8, 16))]

    def ring(t):
        a = k * mp.sin(t) * mp.sin(theta)
        if a < 500:
            scaled = mp.besseli(0, a) * mp.exp(-a)
        else:  # the asymptotic series, whose terms fall by 4 digits each
            scaled = sum(mp.rf(mp.mpf(1) / 2, j) ** 2 / (mp.factorial(j) * (2 * a) ** j) for j in range(14))
            scaled /= mp.sqrt(2 * mp.pi * a)
        return mp.exp(k * (mp.cos(t - theta) - 1)) * scaled * mp.cos(t) * mp.sin(t)

    return k * mp.quad(ring, sorted({x for x in places if 0 <= x <= mp.pi / 2}))
