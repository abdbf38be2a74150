"""The cards of docs/models.md: tables as the code has them, and every verdict and limit looked for anew."""

# ruff: noqa: RUF001 - the limits are quoted as the page writes them, in Greek

import importlib.util
import re
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import brdf, catalog, fresnel, gallery
from jaxrefl.reference import evaluate

DOCS = Path(__file__).resolve().parent.parent / "docs"
TEXT = (DOCS / "models.md").read_text(encoding="utf-8")
CARDS = {m[1]: m[2] for m in re.finditer(r"^## `([^`]+)`[^\n]*\n(.*?)(?=^## |\Z)", TEXT, re.MULTILINE | re.DOTALL)}
_spec = importlib.util.spec_from_file_location("update_models", DOCS / "update_models.py")
update_models = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(update_models)


def lines(card, word):
    return re.findall(rf"^- {word}: (.*)$", CARDS[card], re.MULTILINE)


VIEWS = np.array([1.0, 0.8, 0.4, 0.1, 0.01])
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(48)
_MU, _PHI = (g.ravel() for g in np.meshgrid((_NODE + 1) / 2, (np.arange(64) + 0.5) * np.pi / 32, indexing="ij"))
LIGHTS = np.stack([np.sqrt(1 - _MU**2) * np.cos(_PHI), np.sqrt(1 - _MU**2) * np.sin(_PHI), _MU], axis=-1)
COSINE_WEIGHTS = _MU * np.repeat(_WEIGHT / 2, 64) * np.pi / 32
WI = np.tile(LIGHTS, (VIEWS.size, 1))
WO = np.repeat(np.stack([np.sqrt(1 - VIEWS**2), 0 * VIEWS, VIEWS], axis=-1), len(LIGHTS), axis=0)


def shape(table):
    return table.reshape(VIEWS.size, len(LIGHTS), -1)


def albedo(model, wi=WI, wo=WO):
    """Directional albedos at `VIEWS` by a plain product rule, mirror part included; f; and delta parts, (views, C)."""
    found = {name: shape(table) for name, table in evaluate(model, wi, wo).items()}
    parts = {name: table[:, 0] for name, table in found.items() if name != "f"}
    return np.einsum("vlc,l->vc", found["f"], COSINE_WEIGHTS) + parts.get("mirror", 0.0), found["f"], parts


def smooth(model):
    return albedo(model)[0]


def is_lambert(model, rho):
    seen, f, _ = albedo(model)
    np.testing.assert_allclose(f, rho / np.pi, rtol=1e-12)
    np.testing.assert_allclose(seen, rho, rtol=1e-12)


def is_everywhere(model, value, rtol=1e-3):
    np.testing.assert_allclose(smooth(model)[:, 0], value, rtol=rtol)


def mirrored_f(mu, n):
    """Fresnel reflectance of glass as the textbooks print it."""
    t = np.sqrt(1 - (1 - mu * mu) / (n * n))
    return 0.5 * ((mu - n * t) / (mu + n * t)) ** 2 + 0.5 * ((n * mu - t) / (n * mu + t)) ** 2


def pair(model, mu_i, mu_o):
    """f for light and view on the same side, in one plane."""
    at = [np.array([[np.sqrt(1 - mu * mu), 0.0, mu]]) for mu in (mu_i, mu_o)]
    return evaluate(model, *at)["f"][0, 0]


GRAZING = 1e-7


def literal_ratio():
    model = brdf.LiteralPhong(k_d=0.0, shininess=3.0)
    np.testing.assert_allclose(pair(model, 0.8, 0.95) / pair(model, 0.95, 0.8), 0.95 / 0.8, rtol=1e-12)


def phong_limit():
    """Out to 60 degrees, beyond which the lobe of n = 400 begins to be cut."""
    seen = smooth(brdf.ModifiedPhong(0.7, 400.0))[:2, 0]
    np.testing.assert_allclose(seen, 0.7 * VIEWS[:2], rtol=2e-3)


def normal_is_k_s(model):
    for n in (0.0, 1.0, 7.5, 40.0):
        np.testing.assert_allclose(smooth(model(0.7, n))[0], 0.7, rtol=1e-3)


def grazing_oren_nayar():
    sigma = 0.4
    a, b = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33), 0.45 * sigma**2 / (sigma**2 + 0.09)
    np.testing.assert_allclose(grazing(brdf.OrenNayar(0.8, sigma)), 0.8 * (a + b / 2), rtol=2e-3)


def grazing(model):
    """Albedo for a view at 90 degrees."""
    at = np.tile([np.sqrt(1 - GRAZING**2), 0.0, GRAZING], (len(LIGHTS) * VIEWS.size, 1))
    return albedo(model, WI, at)[0][0, 0]


def slab_is(model, r, t):
    parts = albedo(model)[2]
    np.testing.assert_allclose(parts["mirror"][:, 0], r, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(parts["through"][:, 0], t, rtol=1e-12, atol=1e-15)


def slab_is_lossless():
    parts = albedo(brdf.Slab(1.7, 0.0))[2]
    np.testing.assert_allclose(parts["mirror"] + parts["through"], 1, rtol=1e-12)


def coat_without_base():
    is_everywhere(brdf.CoatedLambert(0.0, 1.5), mirrored_f(VIEWS, 1.5), 1e-12)


def mixed():
    a, b = brdf.CoatedLambert(0.7, 1.6), brdf.CoatedLambert(0.2, 1.3)
    for weight, one in ((0.0, a), (1.0, b)):
        for mine, theirs in zip(albedo(brdf.Mix(a, b, weight))[:2], albedo(one)[:2], strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=1e-13)


def scaled():
    base = brdf.CoatedLambert(0.7, 1.6)
    for mine, theirs in zip(albedo(brdf.Scaled(base, 1.0))[:2], albedo(base)[:2], strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-13)


def is_mirror(model):
    seen, f, _ = albedo(model)
    assert not f.any()
    np.testing.assert_allclose(seen, 1, rtol=1e-15)


LIMITS = {
    ("lambert", "`rho = 1` has the albedo 1 at every angle"): lambda: is_everywhere(brdf.Lambert(1.0), 1, 1e-12),
    ("literal-phong", "`k_s = 0` is Lambert of ρ = `k_d`"): lambda: is_lambert(brdf.LiteralPhong(0.3, 0.0), 0.3),
    ("literal-phong", "with `k_d = 0` f(ω_i, ω_o) / f(ω_o, ω_i) = μ_o / μ_i"): literal_ratio,
    ("modified-phong", "the albedo at normal incidence is `k_s` for every n"): lambda: normal_is_k_s(
        brdf.ModifiedPhong
    ),
    ("modified-phong", "n → ∞: the albedo tends to k_s cos θ_o"): phong_limit,
    ("blinn-phong", "`shininess = 0` is Lambert of ρ = `k_s`"): lambda: is_lambert(brdf.BlinnPhong(0.3, 0.0), 0.3),
    ("blinn-phong", "the albedo at normal incidence is `k_s` for every n"): lambda: normal_is_k_s(brdf.BlinnPhong),
    ("oren-nayar", "`sigma = 0` is Lambert"): lambda: is_lambert(brdf.OrenNayar(0.3, 0.0), 0.3),
    ("oren-nayar", "at grazing view the albedo is ρ (A + B / 2)"): grazing_oren_nayar,
    ("eon", "`roughness = 0` is Lambert"): lambda: is_lambert(brdf.EON(0.3, 0.0), 0.3),
    ("eon", "`rho = 1` has the albedo 1 at every angle"): lambda: is_everywhere(brdf.EON(1.0, 0.7), 1),
    ("burley", "both directions at the normal: f = ρ/π"): lambda: np.testing.assert_allclose(
        pair(brdf.Burley(0.8, 0.7), 1.0, 1.0), 0.8 / np.pi, rtol=1e-14
    ),
    ("burley", "`roughness = 0` at grazing view and light: f = ρ / (4π)"): lambda: np.testing.assert_allclose(
        pair(brdf.Burley(0.8, 0.0), GRAZING, GRAZING), 0.8 / (4 * np.pi), rtol=1e-5
    ),
    ("ashikhmin-shirley-diffuse", "`f0 = 1` is black"): lambda: np.testing.assert_array_equal(
        smooth(brdf.AshikhminShirleyDiffuse(1.0, 1.0)), 0
    ),
    ("ashikhmin-shirley-diffuse", "at normal view the albedo is 31/32 ρ (1 - f0)"): lambda: np.testing.assert_allclose(
        smooth(brdf.AshikhminShirleyDiffuse(0.8, 0.1))[0], 31 / 32 * 0.8 * 0.9, rtol=1e-12
    ),
    ("ashikhmin-shirley-diffuse", "at grazing view the albedo is 0"): lambda: np.testing.assert_allclose(
        grazing(brdf.AshikhminShirleyDiffuse(1.0, 0.0)), 0, atol=1e-6
    ),
    ("lommel-seeliger", "at normal view the albedo is (w/2)(1 - ln 2)"): lambda: np.testing.assert_allclose(
        smooth(brdf.LommelSeeliger(0.8))[0], 0.4 * (1 - np.log(2)), rtol=1e-12
    ),
    ("lommel-seeliger", "toward grazing view the albedo tends to w/2"): lambda: np.testing.assert_allclose(
        grazing(brdf.LommelSeeliger(0.8)), 0.4, rtol=1e-4
    ),
    ("minnaert", "`k = 1` is Lambert of ρ = c"): lambda: is_lambert(brdf.Minnaert(0.3, 1.0), 0.3),
    ("minnaert", "the albedo at normal incidence is c for every k"): lambda: [
        np.testing.assert_allclose(smooth(brdf.Minnaert(0.3, k))[0], 0.3, rtol=2e-3) for k in (0.5, 1.0, 2.5)
    ],
    ("coated-lambert", "`eta = 1` is Lambert"): lambda: is_lambert(brdf.CoatedLambert(0.3, 1.0), 0.3),
    ("coated-lambert", "`rho = 1` has the albedo 1 at every angle"): lambda: is_everywhere(brdf.CoatedLambert(1.0), 1),
    ("coated-lambert", "`rho = 0` has the albedo F"): coat_without_base,
    ("slab", "`depth = 0` has R + T = 1"): slab_is_lossless,
    ("slab", "`eta = 1` and `depth = 0` let everything through"): lambda: slab_is(brdf.Slab(1.0, 0.0), 0, 1),
    ("slab", "depth → ∞: R = F, T = 0"): lambda: slab_is(brdf.Slab(1.5, 500.0), mirrored_f(VIEWS, 1.5), 0),
    ("d3d9", "`r0 = 0` and `m = 0` is Lambert of ρ = `diffuse`"): lambda: is_lambert(
        brdf.D3D9(0.3, 0.0, 0.0, 0.0), 0.3
    ),
    ("d3d9", "`metallic = 1` and `specular = 1` is a mirror of albedo 1"): lambda: is_mirror(brdf.D3D9(metallic=1.0)),
    ("d3d9", "with `diffuse = 1` the albedo at grazing view is 2"): lambda: np.testing.assert_allclose(
        grazing(brdf.D3D9()), 2, rtol=1e-5
    ),
    ("d3d9-repaired", "`r0 = 0` and `m = 0` is Lambert of ρ = `diffuse`"): lambda: is_lambert(
        brdf.D3D9Repaired(0.3, 0.0, 0.0, 0.0), 0.3
    ),
    ("d3d9-repaired", "`diffuse = 1` and `specular = 1` has the albedo 1 at every angle"): lambda: is_everywhere(
        brdf.D3D9Repaired(metallic=0.4), 1
    ),
    ("mix", "`weight = 0` is a, `weight = 1` is b"): mixed,
    ("scaled", "`factor = 1` is the base"): scaled,
}


# parameters at which nothing is absorbed, and some at which a claim is most at risk
WHITE = {
    "lambert": [brdf.Lambert(1.0)],
    "literal-phong": [brdf.LiteralPhong(0.0, 1.0, 10.0)],
    "modified-phong": [brdf.ModifiedPhong(1.0, n) for n in (0.0, 1.0, 30.0)],
    "blinn-phong": [brdf.BlinnPhong(1.0, n) for n in (0.0, 1.0, 30.0)],
    "oren-nayar": [brdf.OrenNayar(1.0, 0.3)],
    "eon": [brdf.EON(1.0, r) for r in (0.0, 0.5, 1.0)],
    "burley": [brdf.Burley(1.0, 1.0)],
    "ashikhmin-shirley-diffuse": [brdf.AshikhminShirleyDiffuse(1.0, 0.0)],
    "lommel-seeliger": [brdf.LommelSeeliger(1.0)],
    "minnaert": [brdf.Minnaert(1.0, 0.8)],
    "coated-lambert": [brdf.CoatedLambert(1.0, eta) for eta in (1.0, 1.5, 3.0)],
    "slab": [brdf.Slab(1.5, 0.0)],
    "d3d9": [brdf.D3D9(), brdf.D3D9(sun_fresnel=True)],
    "d3d9-repaired": [brdf.D3D9Repaired(metallic=x) for x in (0.0, 0.5)],
    "mix": [brdf.Mix(brdf.Lambert(1.0), brdf.CoatedLambert(1.0), 0.3)],
    "scaled": [brdf.Scaled(brdf.CoatedLambert(1.0), 1.0)],
}


def test_every_model_has_a_card_and_every_card_a_model():
    assert list(CARDS) == [*catalog.MODELS, "mix", "scaled"]


def test_the_tables_are_those_that_the_declarations_give():
    assert update_models.updated(TEXT) == TEXT, "run python docs/update_models.py"
    stale = TEXT.replace("| [0, 1] |", "| [0, 2] |", 1)
    assert update_models.updated(stale) == TEXT, "a stale table is seen and mended"
    assert TEXT.count("| parameter | range |") == len(CARDS)


@pytest.mark.parametrize("card", CARDS)
def test_a_card_has_a_formula_verdicts_limits_a_source_and_figures_that_exist(card):
    assert re.search(r"^    \S*f = ", CARDS[card], re.MULTILINE)
    for word in ("Reciprocal", "Energy", "Source"):
        assert len(lines(card, word)) == 1
    figures = [name for line in lines(card, "Figures") for name in re.findall(r"`([^`]+)`", line)]
    assert set(figures) <= set(gallery.names())
    assert figures or card in ("mix", "scaled")


def test_every_limit_on_the_page_is_one_that_is_tested():
    assert {(card, limit) for card in CARDS for limit in lines(card, "Limit")} == set(LIMITS)


@pytest.mark.parametrize(("card", "limit"), LIMITS)
def test_the_limit_is_reached(card, limit):
    LIMITS[card, limit]()


@pytest.mark.parametrize("card", CARDS)
def test_the_card_is_right_about_reciprocity(card):
    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, len(WI), 3))
    w[..., 2] = abs(w[..., 2]) + 0.01
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    (claim,) = lines(card, "Reciprocal")
    for model in WHITE[card]:
        there, back = evaluate(model, w[0], w[1])["f"], evaluate(model, w[1], w[0])["f"]
        reciprocal = bool(np.allclose(there, back, rtol=1e-12, atol=1e-15))
        assert reciprocal == (claim.startswith("yes") and not getattr(model, "sun_fresnel", False))


@pytest.mark.parametrize("card", CARDS)
def test_the_card_is_right_about_energy(card):
    """Seen and lit; a rule of 48 cosines and 64 azimuths is right to 0.2 % here."""
    (claim,) = lines(card, "Energy")
    assert claim.startswith(("conserves", "creates"))
    largest = 0.0
    for model in WHITE[card]:
        seen, _, parts = albedo(model)
        lit = np.einsum("vlc,l->vc", shape(evaluate(model, WO, WI)["f"]), COSINE_WEIGHTS) + parts.get("mirror", 0.0)
        passed = parts.get("through", 0.0)
        largest = max(largest, (seen + passed).max(), (lit + passed).max())
    assert (largest > 1.003) == claim.startswith("creates")
    assert largest > 0.99 or card in ("ashikhmin-shirley-diffuse", "lommel-seeliger")


def test_the_formulas_of_the_albedos_on_the_cards_hold():
    """Those that no limit and no other test of this file has evaluated."""
    mu = VIEWS
    np.testing.assert_allclose(
        smooth(brdf.AshikhminShirleyDiffuse(0.8, 0.1))[:, 0], 0.72 * (1 - (1 - mu / 2) ** 5), rtol=1e-10
    )
    np.testing.assert_allclose(smooth(brdf.Minnaert(0.7, 2.5))[:, 0], 0.7 * mu**1.5, rtol=1e-4)
    np.testing.assert_allclose(smooth(brdf.LommelSeeliger(0.8))[:, 0], 0.4 * (1 - mu * np.log1p(1 / mu)), rtol=1e-3)
    f, inside = mirrored_f(mu, 1.5), float(jax.jit(fresnel.average_dielectric)(1 / 1.5))
    coat = f + (1 - f) * 0.6 * (1 - inside) / (1 - 0.6 * inside)
    np.testing.assert_allclose(smooth(brdf.CoatedLambert(0.6, 1.5))[:, 0], coat, rtol=1e-4)
    model = brdf.D3D9(diffuse=jnp.array([0.9, 0.5]), metallic=jnp.array([0.2, 0.4]), specular=0.8, sun_fresnel=True)
    reflectance = 0.04 + 0.96 * (1 - mu[:, None]) ** 5
    seen = np.array([0.2, 0.4]) * (1 - reflectance) + 0.8 * reflectance
    base = np.array([0.9, 0.5]) * (1 - 0.4) * (1 - (0.04 + 0.96 * 2 / 42))
    np.testing.assert_allclose(smooth(model), seen + base, rtol=1e-10)
