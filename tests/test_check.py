"""`jaxrefl check`: every number of the table is compared, and a library that is wrong is caught."""

import functools
import importlib.resources
import json
import math
from collections import Counter

import jax
import numpy as np
import pytest

from jaxrefl import check, d3d9, fresnel, series, trace
from jaxrefl.brdf import phong
from jaxrefl.check import rays
from jaxrefl.check.table import evaluators
from jaxrefl.vec import Vec3

TABLE = json.loads(importlib.resources.files("jaxrefl").joinpath("data/oracles.json").read_text("utf-8"))
BLOCKS = {
    f"{section[0]}.{key}": block for section, members in TABLE["sections"].items() for key, block in members.items()
}
SKIPPED_COLUMNS = {
    "A.special": {"dR0_dn_check"},
    "B.table": {"real_formula_max_abs_diff"},
    "B.attenuated_tir_slope": {"fd_check"},
    "B.misprint_size": {"Rp_literal_denominator_theta_tan2"},
    "C.d3d9_fit": {"max_abs_err_at_nodes"},
    "D.dielectric": {"closed-quad", "int_closed-quad", "KC_ext_fit", "KC_int_fit", "Egan73_int_fit"},
    "E.modified_phong": {"check_max_abs"},
    "E.blinn_norm": {"(n+8)/8pi", "(n+2)/8pi", "(n+2)/2pi"},
    "E.oren_nayar_qualitative": {"check_G_max_abs"},
    "E.eon": {"avg_check"},
    "E.lommel_seeliger": {"bh_quad"},
    "E.slab": {"R_unpolarised_shortcut"},
    "H.series": {"recursive_equals_iterative"},
    "H.tree": {"nodes"},
    "I.sphere_albedo": {"q_ls_quad"},
    "I.patch_sphere": {"check_abs_diff"},
    "I.derivatives": {"drainbow1_check"},
    "I.visibility_gradients": {"c_interior_quad"},
    "I.alhazen": {"outside_visible"},
}
SKIPPED_ROWS = {
    "B.k_to_0": {"eta=0.5, theta=30 deg, k=1e-8"},
    "I.frontal_disc_mean": {f"model={x}" for x in ("FON r=1 (rho=1)", "GGX hc alpha=0.25 F=1", "GGX hc alpha=0.5 F=1")},
}
evaluate = functools.cache(check.evaluate)


@pytest.mark.parametrize("block", BLOCKS)
def test_the_library_agrees_with_every_number_of(block):
    rows = evaluate(block)
    assert rows
    assert [row for row in rows if not row.ok] == []


@pytest.mark.parametrize("block", BLOCKS)
def test_what_is_neither_an_input_nor_skipped_for_a_reason_is_compared_in(block):
    words, members, evaluator = {"about", "how", "rtol", "fields", "rows", "values"}, BLOCKS[block], evaluators[block]
    single = {**members.get("values", {}), **{name: members[name] for name in members.keys() - words}}
    counts = {name: -len(SKIPPED_ROWS.get(block, ())) for name in members.get("fields", ())}
    for row in members.get("rows", ()):
        for name, text in zip(members["fields"], row, strict=True):
            counts[name] += text is not None
    columns = SKIPPED_COLUMNS.get(block, set())
    assert set(evaluator.skipped) == columns | SKIPPED_ROWS.get(block, set())
    assert all(evaluator.skipped.values())
    expected = {name: n for name, n in {**counts, **dict.fromkeys(single, 1)}.items() if name not in columns}
    compared = Counter(row.quantity for row in evaluate(block))
    assert {**dict(compared), **{name: counts[name] for name in evaluator.inputs}} == expected
    assert not compared.keys() & set(evaluator.inputs)


def test_the_row_that_is_skipped_hangs_on_the_rounding_of_its_cosine():
    cos_30 = 0.8660254037844386  # 5.0e-17 below the root of 3/4
    assert abs(jax.grad(fresnel.conductor)(cos_30, 0.5, 1e-8)) * 5.0e-17 > 1e-12


def test_blocks_are_named_by_section_letter_in_the_order_of_the_file():
    assert check.block_names() == list(BLOCKS)


def test_a_section_letter_selects_its_blocks_and_no_name_selects_all():
    assert check.select(["E.lambert", "A"]) == [name for name in BLOCKS if name[0] == "A"] + ["E.lambert"]
    assert check.select() == check.select([]) == list(BLOCKS)


def test_an_unknown_block_is_refused_by_name():
    with pytest.raises(ValueError, match=r"A\.tabel.*A\.table"):
        check.run(["A.tabel"])
    with pytest.raises(ValueError, match=r"A\.tabel.*A\.table"):
        check.evaluate("A.tabel")


@pytest.mark.usefixtures("float32")
def test_single_precision_is_refused_in_one_sentence():
    with pytest.raises(RuntimeError, match="compares in float64"):
        check.run(["E"])


def test_a_row_says_where_it_comes_from():
    row = evaluate("A.table")[-1]
    assert (row.block, row.label, row.quantity) == ("A.table", "eta=1/2.4, theta=89.9 deg, tir=1", "dR_deta")
    assert BLOCKS["A.table"]["how"] in row.source
    single = [row for row in evaluate("G.d3d9_furnace") if row.quantity == "R_avg"]
    assert [row.label for row in single] == ["n=1.5, p=5, m=1-R0, d=1, phi=1"]


def test_the_error_is_relative_but_for_an_oracle_of_zero_and_decides_the_verdict():
    rows = [row for block in ("A.table", "B.metals", "H.series") for row in evaluate(block)]
    assert any(row.oracle == 0 for row in rows)
    for row in rows:
        assert row.error == abs(row.value - row.oracle) / (abs(row.oracle) if row.oracle else 1)
        assert row.ok == (row.error <= row.tolerance)


@pytest.mark.parametrize(
    ("block", "quantity", "tolerance"),
    [
        ("A.table", "R", 1e-13),
        ("A.table", "dR_deta", 1e-11),
        ("B.metals", "minR_deg", 1e-12),
        ("C.d3d9_fit", "p", 1e-8),
        ("H.series", "weight", 1e-13),
        ("H.series", "dcb_dalpha", 1e-11),
        ("I.rainbow", "radius1_deg", 1e-13),
        ("I.perspective_sphere", "image_radius", 1e-13),
        ("I.perspective_sphere", "cap_fraction", 1e-12),
    ],
)
def test_the_tolerance_is_that_of_the_block_or_of_the_arithmetic_or_stated_by_the_evaluator(block, quantity, tolerance):
    assert {row.tolerance for row in evaluate(block) if row.quantity == quantity} == {tolerance}


def test_the_cosine_keeps_its_relative_accuracy_at_grazing_incidence_and_vanishes_at_90_degrees():
    assert [row.value for row in evaluate("B.table") if "theta=90 deg" in row.label and row.quantity == "R"] == [1.0]
    grazing = [row for row in evaluate("A.table") if "theta=89.9 deg, tir=0" in row.label and row.quantity == "R"]
    for row in grazing:
        assert (1 - row.value) == pytest.approx(1 - row.oracle, rel=1e-12)
    assert len(grazing) == 5


WRONG = {
    "by 1e-9": lambda x: x * (1 + 1e-9),
    "in sign": lambda x: -x,
    "in slope": jax.lax.stop_gradient,
    "by being NaN": lambda x: x * math.nan,
}
CASES = [
    (fresnel, "dielectric", "A.table", "by 1e-9", {"R", "dR_dtheta_per_rad", "dR_dcos", "dR_deta"}),
    (fresnel, "dielectric", "A.table", "in sign", {"R", "dR_dtheta_per_rad", "dR_dcos", "dR_deta"}),
    (fresnel, "dielectric", "A.table", "in slope", {"dR_dtheta_per_rad", "dR_dcos", "dR_deta"}),
    (fresnel, "amplitudes", "A.table", "in sign", {"r_s", "r_p"}),
    (fresnel, "amplitudes", "A.tir_phase", "by 1e-9", {"delta_s_deg", "delta_p_deg", "delta_p-delta_s_deg"}),
    (fresnel, "conductor", "B.attenuated_tir_slope", "in slope", {"slope"}),
    (fresnel, "conductor_sp", "B.metals", "by being NaN", {"pseudoBrewster_deg", "Rp_min"}),
    (fresnel, "average_dielectric", "D.dielectric", "by 1e-9", {"F_ext", "F_int", "dF_ext_dn"}),
    (phong, "lobe", "E.modified_phong", "by 1e-9", {"albedo", "I_n"}),
    (fresnel, "average_dielectric", "E.coat_lambert", "by 1e-9", {"albedo_dir", "f_d_i_to_normal", "albedo_bh"}),
    (fresnel, "dielectric_sp", "E.slab", "by 1e-9", {"R", "T", "A"}),
    (d3d9, "max_norm", "G.d3d9_furnace", "in sign", {"eq6_maxnorm", "eq8_view_furnace", "eq8_light_hemispherical"}),
    (series, "convex", "H.corridor", "in slope", {"dconvex_dalpha_a", "dconvex_dalpha_b"}),
]


@pytest.mark.parametrize(("module", "function", "block", "how", "caught"), CASES)
def test_a_function_that_is_wrong_fails_the_rows_it_computes(monkeypatch, module, function, block, how, caught):
    right, wrong = getattr(module, function), WRONG[how]
    monkeypatch.setattr(module, function, lambda *args: jax.tree.map(wrong, right(*args)))
    failed = {row.quantity for row in check.evaluate(block) if not row.ok}
    assert failed == caught


@pytest.fixture
def _forgets_what_follow_compiled():
    trace._followed.clear_cache()
    yield
    trace._followed.clear_cache()


@pytest.mark.usefixtures("_forgets_what_follow_compiled")
def test_a_tracer_that_is_wrong_fails_the_rows_it_computes(monkeypatch):
    right = trace.reflect
    monkeypatch.setattr(trace, "reflect", lambda w, n: right(w, n) + Vec3(1e-9, 0.0, 0.0))
    monkeypatch.setattr(rays, "_mirror", rays._directional(rays._off_ball, 5))
    failed = {row.quantity for row in check.evaluate("I.alhazen") if not row.ok}
    assert failed == {"phi_deg", "Px", "Py", "incidence_deg"}  # the path is stationary


def test_every_nonzero_value_fails_when_it_is_wrong_by_1e_9(monkeypatch):
    right = fresnel.dielectric
    monkeypatch.setattr(fresnel, "dielectric", lambda *args: right(*args) * (1 + 1e-9))
    rows = [row for row in check.evaluate("A.table") if row.quantity == "R"]
    assert not any(row.ok for row in rows)
    assert np.allclose([row.error for row in rows], 1e-9, rtol=1e-4)
