"""The audit of a reflection model: what is right passes, what is broken on purpose is found, and where."""

import json

import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import brdf
from jaxrefl.audit import PROPERTIES, SCHEMA, assert_valid, audit, compare, from_numpy
from jaxrefl.audit.edges import lattice
from jaxrefl.params import param, pytree
from jaxrefl.sampling import Sample, cosine_hemisphere, power_lobe, tangents
from jaxrefl.vec import Vec3, cross, dot

ENERGY = ("energy_view", "energy_light", "furnace")


def above(wi, value):
    return jnp.where(wi.z < 0, 0.0, value)


def failing(report):
    return {row.name for row in report.rows if not row.ok}


# ---- models with known verdicts


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        (brdf.Lambert(1.0), set()),
        (brdf.EON(1.0, 0.5), set()),
        (brdf.CoatedLambert(1.0, 1.5), set()),
        (brdf.ModifiedPhong(1.0, 10.0), set()),
        (brdf.D3D9Repaired(), set()),
        (brdf.D3D9(), set(ENERGY)),
        (brdf.D3D9(sun_fresnel=True), {"energy_view", "furnace", "reciprocity"}),
        (brdf.OrenNayar(1.0, 0.3), set(ENERGY)),
        (brdf.LiteralPhong(0.0, 1.0, 10.0), {"energy_light", "reciprocity"}),
        (brdf.Minnaert(1.0, 0.8), set(ENERGY)),
    ],
    ids=lambda x: type(x).__name__ if not isinstance(x, set) else "",
)
def test_every_property_of_a_model_of_the_catalog_comes_out_as_its_theory_says(model, expected):
    report = audit(model)
    assert failing(report) == expected
    assert report.ok == (not expected)
    assert [row.name for row in report.rows] == list(PROPERTIES)
    assert all(row.verdict != "undecided" for row in report.rows)


def test_d3d9_returns_twice_what_arrives_at_grazing_and_1_plus_r_in_the_furnace():
    report = audit(brdf.D3D9(), ENERGY)
    for name in ("energy_view", "energy_light"):
        row = report[name]
        assert abs(row.number - 2) <= row.error < 1e-12
        assert row.where == "theta = 90°"
        assert "creates energy" in row.text
    mu = report.view.cos_theta
    np.testing.assert_allclose(report.view.value[0, :, 0], 1.04 + 0.96 * (1 - mu) ** 5, rtol=1e-13)
    np.testing.assert_allclose(report.view.offset, np.sqrt(1 - mu**2), atol=1e-15)


def test_d3d9_with_fresnel_at_the_sun_conserves_a_beam_and_still_shows_more_than_the_furnace_holds():
    """`physics.md` 4: directional-hemispherical 1 at every angle, hemispherical-directional up to 1.9142857."""
    report = audit(brdf.D3D9(sun_fresnel=True), (*ENERGY, "reciprocity"))
    average = 0.04 + 2 * 0.96 / (6 * 7)
    np.testing.assert_allclose(report["energy_view"].number, 1 + (1 - average), rtol=1e-13)
    np.testing.assert_allclose(report["energy_light"].number, 1, rtol=1e-13)
    assert report["energy_light"].where == "every angle"
    np.testing.assert_allclose(report["reciprocity"].number, 1, rtol=1e-6)  # 1 - R is 0 one way, at grazing
    assert "= 90°" in report["reciprocity"].where


def test_oren_nayar_exceeds_its_rho_at_grazing_by_the_closed_form():
    s2 = 0.09
    grazing = 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) / 2
    for rho in (1.0, 0.5):
        report = audit(brdf.OrenNayar(rho, 0.3), ("energy_view",))
        np.testing.assert_allclose(report["energy_view"].number, rho * grazing, rtol=1e-13)
        assert report.ok == (rho * grazing <= 1)


def test_the_furnace_of_lommel_and_seeliger_has_the_closed_mean():
    report = audit(brdf.LommelSeeliger(1.0), ("furnace",))
    mu = report.view.cos_theta[1:]
    np.testing.assert_allclose(report.view.value[0, 1:, 0], 0.5 * (1 - mu * np.log1p(1 / mu)), rtol=1e-10)
    assert f"mean radiance {2 / 3 * (1 - np.log(2)):.6g}," in report["furnace"].text


def test_a_model_that_neither_absorbs_nor_creates_vanishes_in_the_furnace():
    assert "vanishes" in audit(brdf.Slab(1.5, 0.0), ("furnace",))["furnace"].text
    assert "vanishes" not in audit(brdf.Slab(1.5, 0.1), ("furnace",))["furnace"].text


def test_an_albedo_without_bound_is_said_to_be_without_bound():
    assert "without bound" in audit(brdf.Minnaert(1.0, 0.8), ("energy_view",))["energy_view"].text
    assert "without bound" not in audit(brdf.D3D9(), ("energy_view",))["energy_view"].text


def test_a_narrow_lobe_is_integrated_until_its_energy_is_known():
    row = audit(brdf.BlinnPhong(1.0, 1e5), ("energy_view",))["energy_view"]
    assert row.verdict == "ok"
    assert row.error < 1e-6


# ---- models broken on purpose


def between(wi, wo):
    """Albedo 0.9 (1 + mu (1 - mu)) of the view, largest at 60 degrees; 0.9 (1 + 1/6) of every beam."""
    return above(wi, 0.9 / jnp.pi * (1 + wo.z * (1 - wo.z)))


def test_the_largest_albedo_is_found_between_the_angles_of_the_grid():
    report = audit(between, ("energy_view", "energy_light"))
    view, light = report["energy_view"], report["energy_light"]
    np.testing.assert_allclose(view.number, 0.9 * 1.25, rtol=1e-6)
    assert abs(float(view.where.split("= ")[1].rstrip("°")) - 60) < 0.1
    np.testing.assert_allclose(light.number, 0.9 * 7 / 6, rtol=1e-13)
    assert (view.verdict, light.verdict, light.where) == ("fails", "fails", "every angle")


def test_of_several_channels_the_one_that_creates_energy_is_named():
    row = audit(brdf.D3D9(diffuse=np.array([0.2, 0.9, 0.5]), r0=0.0, m=0.2), ("energy_light",))["energy_light"]
    np.testing.assert_allclose(row.number, 0.9 + 0.2, rtol=1e-12)
    assert row.where == "theta = 90°, channel 1"


def test_what_is_transmitted_counts():
    def both_sides(wi, wo):
        return jnp.where(wo.z >= 0, 0.6 / jnp.pi, 0.0)

    row = audit(both_sides, ("energy_view",))["energy_view"]
    np.testing.assert_allclose(row.number, 1.2, rtol=1e-13)
    assert "0.6 of it below the surface" in row.text
    row = audit(both_sides, ("energy_view",), part="reflected")["energy_view"]
    np.testing.assert_allclose(row.number, 0.6, rtol=1e-13)


def test_an_anisotropic_model_is_searched_over_the_azimuth():
    def brushed(wi, wo):
        c, s = np.cos(0.3), np.sin(0.3)
        along, across = c * wo.x + s * wo.y, c * wo.y - s * wo.x
        return above(wi, 0.8 / jnp.pi * (1 + 0.5 * (along**2 - across**2)))

    report = audit(brushed, ("energy_view", "energy_light", "reciprocity"))
    row = report["energy_view"]
    assert 1.195 < row.number <= 1.2 + 1e-12
    phi = float(row.where.split("phi = ")[1].rstrip("°"))
    assert abs((phi - np.rad2deg(0.3) + 90) % 180 - 90) < 5
    np.testing.assert_allclose(report["energy_light"].number, 0.8, rtol=1e-12)
    assert report["reciprocity"].verdict == "fails"
    assert report.view.phi.size > 1


def test_an_energy_that_cannot_be_told_is_undecided_and_does_not_pass():
    """The albedo is 1 + 0.5 (1 - 0.36) - 0.32 = 1, and the jump at mu = 0.6 keeps the rules from knowing it."""

    def jumping(wi, wo):
        return above(wi, (0.68 + 0.5 * (wi.z > 0.6)) / jnp.pi)

    report = audit(jumping, ("energy_view",))
    assert report["energy_view"].verdict == "undecided"
    assert not report.ok


def test_the_worst_reciprocity_is_found_inside_the_domain():
    """Relative defect 1 - exp(-2 |h(mu_i) - h(mu_o)|), h = mu (1 - mu): worst between mu = 1/2 and an end."""

    def biased(wi, wo):
        return 0.2 * jnp.exp(wi.z * (1 - wi.z) - wo.z * (1 - wo.z))

    row = audit(biased, ("reciprocity",))["reciprocity"]
    assert row.verdict == "fails"
    np.testing.assert_allclose(row.number, 1 - np.exp(-0.5), rtol=1e-9)
    angles = [float(part.split("= ")[1].rstrip("°")) for part in row.where.split(", ")[:2]]
    assert min(abs(angles[0] - 60), abs(angles[1] - 60)) < 1e-2
    np.testing.assert_allclose(abs(np.log(float(row.text.split("ratio ")[1]))), 0.5, rtol=1e-4)


def test_a_defect_of_a_millionth_is_found_and_one_of_rounding_is_not():
    def nearly(size):
        return lambda wi, wo: (1 + size * wi.z) / jnp.pi * 0.3

    assert audit(nearly(1e-6), ("reciprocity",))["reciprocity"].verdict == "fails"
    assert audit(nearly(1e-13), ("reciprocity",))["reciprocity"].verdict == "ok"


def test_a_model_that_is_negative_in_a_corner_is_found_out_with_the_corner():
    def undershoot(wi, wo):
        return above(wi, (wi.z + wo.z - 0.01) / jnp.pi * 0.3)

    row = audit(undershoot, ("negativity",))["negativity"]
    assert row.verdict == "fails"
    np.testing.assert_allclose(row.number, -0.003 / np.pi, rtol=1e-12)
    assert row.where.startswith("theta_i = 90°, theta_o = 90°")


def test_a_value_of_minus_infinity_is_negative():
    row = audit(lambda wi, wo: above(wi, 0.1 - 1 / (wi.z + wo.z)), ("negativity",))["negativity"]
    assert (row.verdict, row.number) == ("fails", -np.inf)
    assert row.where.startswith("theta_i = 90°, theta_o = 90°")


def test_a_negative_side_below_the_surface_and_a_negative_mirror_are_found():
    def below(wi, wo):
        return jnp.where(wi.z < 0, -0.1, 0.1)

    row = audit(below, ("negativity",))["negativity"]
    assert (row.verdict, row.number) == ("fails", -0.1)
    assert "below" in row.where

    @pytree
    class NegativeMirror(brdf.Lambert):
        def mirror(self, cos_theta_o):
            return cos_theta_o - 0.5

    row = audit(NegativeMirror(), ("negativity",))["negativity"]
    assert (row.verdict, row.where) == ("fails", "delta part, theta = 90°")
    np.testing.assert_allclose(row.number, -0.5)


def test_a_nan_at_grazing_is_found_in_the_value_and_in_the_albedo():
    def singular(wi, wo):
        return 0.1 / wi.z * wi.z

    report = audit(singular, ("finite_values", "energy_light"))
    assert report["finite_values"].verdict == "fails"
    assert "0" in report["finite_values"].where
    assert report["energy_light"].verdict == "fails"
    assert json.loads(report.to_json())["rows"][1]["number"] is None


@pytree
class Kinked:
    """Finite everywhere; the derivative by ``width`` is infinite at 0, and that by wo.z at grazing."""

    width: object = param("[0, 1]", default=0.0)
    rho: object = param("[0, 1]", default=0.5)

    def __call__(self, wi, wo):
        return self.rho / jnp.pi * (0.5 + 0.1 * jnp.sqrt(jnp.where(wo.z < 0, 0.0, wo.z)) + 0.1 * jnp.sqrt(self.width))


def test_a_gradient_that_is_not_finite_is_found_with_the_parameter_and_the_component():
    report = audit(Kinked(), ("finite_values", "finite_gradients"))
    assert report["finite_values"].verdict == "ok"
    row = report["finite_gradients"]
    assert row.verdict == "fails"
    assert "(width, wo.z)" in row.text


def test_the_delta_parts_are_looked_at_too():
    @pytree
    class Sharp(brdf.Lambert):
        def mirror(self, cos_theta_o):
            return 0.1 * jnp.sqrt(cos_theta_o)

    assert audit(Sharp(), ("finite_gradients",))["finite_gradients"].verdict == "fails"


def test_the_edge_lattice_has_the_pairs_that_break_formulas():
    wi, wo = (np.stack([w.x, w.y, w.z], axis=-1) for w in lattice())
    np.testing.assert_allclose(np.linalg.norm(wi, axis=-1), 1, rtol=1e-15)
    mirrored = wo * [-1, -1, 1]
    for pairs in (wi == wo, wi == -wo, wi == mirrored):
        assert pairs.all(axis=-1).any()
    assert ((wi[:, 2] == 0) & (wo[:, 2] == 0)).any()
    for z in (1.0, 0.0, 1e-7, -1e-7, -1.0):
        assert np.isclose(wi[:, 2], z, rtol=1e-12, atol=0).any()


# ---- sampling


@pytree
class Sampled(brdf.Lambert):
    """Lambert whose sampling may be broken: its density, its map, its weight, or what it says the density is."""

    density: float = param("(0, inf)", default=1.0)
    stretch: float = param("(0, inf)", default=1.0)
    heavier: float = param("(0, inf)", default=1.0)
    said: float = param("(0, inf)", default=1.0)

    def sample(self, wo, u1, u2, u_lobe):
        wi = cosine_hemisphere(u1, u2**self.stretch)
        return Sample(wi, self.rho * self.heavier / self.density, self.pdf(wi, wo) * self.said)

    def pdf(self, wi, wo):
        return self.density * jnp.where(wi.z < 0, 0.0, wi.z / jnp.pi)


SAMPLING = ("pdf_normalisation", "sampling_jacobian", "sampling_weight")


@pytest.mark.parametrize(
    ("broken", "expected"),
    [
        ({}, set()),
        ({"density": 1.01}, {"pdf_normalisation", "sampling_jacobian"}),
        ({"stretch": 2.0}, {"sampling_jacobian"}),
        ({"heavier": 1.01}, {"sampling_weight"}),
        ({"said": 0.5}, {"sampling_weight"}),
    ],
)
def test_what_is_wrong_with_a_sampler_is_named(broken, expected):
    assert failing(audit(Sampled(**broken), SAMPLING)) == expected


def test_the_integral_of_a_wrong_density_is_printed():
    np.testing.assert_allclose(audit(Sampled(density=1.25), SAMPLING)["pdf_normalisation"].number, 1.25, rtol=1e-12)


def test_a_model_without_a_sampler_offers_none_and_one_of_several_lobes_is_skipped():
    assert {audit(brdf.EON(), SAMPLING)[name].verdict for name in SAMPLING} == {"not offered"}

    @pytree
    class TwoLobes(brdf.Lambert):
        def sample(self, wo, u1, u2, u_lobe):
            wi = cosine_hemisphere(jnp.where(u_lobe < 0.5, u1, u1 + 0.5), u2)
            return Sample(wi, self.rho, self.pdf(wi, wo))

    report = audit(TwoLobes(), SAMPLING)
    assert [report[name].verdict for name in SAMPLING] == ["ok", "skipped", "ok"]


@pytest.mark.parametrize("model", [brdf.ModifiedPhong(0.7, 50.0), brdf.ModifiedPhong(0.7, 0.5)])
def test_the_sampling_of_modified_phong_is_right_for_real_exponents(model):
    assert {row.verdict for row in audit(model, SAMPLING).rows} == {"ok"}


def test_a_power_lobe_has_the_mean_cosine_of_its_density_about_any_axis():
    u = (np.arange(400) + 0.5) / 400
    u1, u2 = np.meshgrid(u[:40] * 10, u)
    for axis in (Vec3(0.6, 0.0, 0.8), Vec3(0.0, -0.8, -0.6), Vec3(0.0, 0.0, -1.0), Vec3(0.0, 0.0, 1.0)):
        for n in (0.0, 3.0, 100.0):
            wi = power_lobe(Vec3(*map(jnp.asarray, (axis.x, axis.y, axis.z))), n, u1, u2)
            np.testing.assert_allclose(dot(wi, wi), 1, rtol=1e-14)
            np.testing.assert_allclose(np.mean(dot(wi, axis)), (n + 1) / (n + 2), rtol=1e-3)


def test_the_tangents_of_an_axis_are_a_right_handed_frame():
    rng = np.random.default_rng(0)
    for x in [*rng.normal(size=(50, 3)), [0, 0, 1], [0, 0, -1], [1, 0, 0.0], [1e-9, 0, -1]]:
        x = np.asarray(x) / np.linalg.norm(x)
        axis = Vec3(*jnp.asarray(x))
        t, s = tangents(axis)
        np.testing.assert_allclose(cross(t, s).to_array(), x, atol=1e-14)
        np.testing.assert_allclose([dot(t, t), dot(s, s), dot(t, s), dot(t, axis)], [1, 1, 0, 0], atol=1e-14)


# ---- what a user brings


def test_a_numpy_function_is_audited_through_the_adapter_without_gradients():
    def lambert(wi, wo):
        assert isinstance(wi, np.ndarray)
        return np.where((wi[..., 2] < 0) | (wo[..., 2] < 0), 0, 0.5 / np.pi)[..., None] * [1.0, 0.5]

    report = audit(from_numpy(lambert))
    assert report.ok
    assert report.model == "lambert"
    np.testing.assert_allclose(report["energy_view"].number, 0.5, rtol=1e-13)
    np.testing.assert_allclose(report.view.value[0], np.tile([0.5, 0.25], (32, 1)), rtol=1e-13)
    assert report["finite_gradients"].verdict == "skipped"


def test_a_broken_numpy_function_is_found_out():
    def broken(wi, wo):
        return np.where(wo[..., 2] == 0, np.nan, 0.4 * wi[..., 2] - 0.1)

    properties = ("energy_light", "energy_view", "reciprocity", "negativity", "finite_values")
    report = audit(from_numpy(broken), properties, part="reflected")
    assert failing(report) == set(properties)
    assert "no finite number" in report["energy_view"].text
    np.testing.assert_allclose(report["negativity"].number, -0.1, rtol=1e-6)


def test_a_numpy_function_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"maps \(2, 3\) arrays to \(\); it must be \(2,\) or \(2, C\)"):
        from_numpy(lambda wi, wo: 0.5)


class Plain:
    """A model that is no pytree, with a delta part."""

    def __call__(self, wi, wo):
        return 0.0 * wi.z

    def mirror(self, cos_theta_o):
        return 1.1 - 0.2 * cos_theta_o


def test_an_object_that_is_no_pytree_keeps_its_delta_part():
    row = audit(Plain(), ("energy_view",))["energy_view"]
    np.testing.assert_allclose(row.number, 1.1, rtol=1e-14)
    assert row.verdict == "fails"


@pytest.mark.parametrize("thing", [brdf.Lambert, 0.5, "lambert"])
def test_what_is_no_model_is_refused(thing):
    with pytest.raises(ValueError, match="must be a model"):
        audit(thing)


def test_integer_parameters_are_real_numbers():
    assert audit(brdf.Lambert(1), ("finite_gradients",)).ok


@pytest.mark.usefixtures("float32")
def test_in_float32_the_verdicts_are_the_same():
    report = audit(brdf.Lambert(1.0))
    assert report.ok
    assert report.dtype == "float32"
    properties = ("energy_view", "energy_light", "reciprocity", "finite_gradients")
    assert audit(brdf.EON(1.0, 0.5), properties).ok
    assert failing(audit(brdf.D3D9(sun_fresnel=True), properties)) == {"energy_view", "reciprocity"}


# ---- the report


def test_a_report_prints_a_line_for_every_property_and_says_what_fails():
    report = audit(brdf.D3D9(), ("energy_view", "reciprocity", "sampling_weight"))
    title, head, *lines = str(report).splitlines()
    assert title.endswith("FAILS energy_view")
    assert head.split() == ["property", "verdict", "number", "where", "meaning"]
    assert [line.split()[0] for line in lines] == ["energy_view", "reciprocity", "sampling_weight"]
    assert "theta = 90°" in lines[0]
    with pytest.raises(KeyError, match="energy_view, reciprocity"):
        report["furnace"]


def test_the_json_of_a_report_has_a_version_and_round_trips():
    report = audit(brdf.Lambert(np.array([0.5, 0.25])), ("furnace", "reciprocity"))
    answer = json.loads(report.to_json())
    assert answer["schema"] == SCHEMA == "jaxrefl.audit/1"
    assert answer["ok"] is True
    assert [row["name"] for row in answer["rows"]] == ["furnace", "reciprocity"]
    np.testing.assert_allclose(np.array(answer["view"]["value"])[0], np.tile([0.5, 0.25], (32, 1)), rtol=1e-13)
    assert answer["light"] is None


def test_the_page_of_a_report_escapes_the_name_of_the_model():
    html = audit(lambda wi, wo: 0.1 + 0.0 * wi.z, ("reciprocity",))._repr_html_()
    assert "&lt;lambda&gt;" in html
    assert "<lambda>" not in html
    assert html.count("<tr>") == 2


# ---- the same in a test of a user


@pytest.mark.parametrize("name", PROPERTIES)
def test_a_valid_model_passes_one_test_per_property(name):
    assert_valid(brdf.Lambert(0.5), name)


def test_a_defect_fails_the_test_unless_it_is_expected_and_an_expected_one_must_be_there():
    with pytest.raises(AssertionError, match=r"OrenNayar\(rho=1.0.*\nenergy_view: fails \(expected ok\).*theta = 90°"):
        assert_valid(brdf.OrenNayar(1.0, 0.3), "energy_view")
    assert_valid(brdf.OrenNayar(1.0, 0.3), "energy_view", energy_view="fails", furnace="fails")
    with pytest.raises(AssertionError, match=r"energy_view: ok \(expected fails\)"):
        assert_valid(brdf.OrenNayar(0.5, 0.3), "energy_view", energy_view="fails")


@pytest.mark.parametrize(
    ("properties", "expected", "message"),
    [
        (("energy",), {}, "property = 'energy' must be one of energy_view"),
        ((), {"energy": "ok"}, "property = 'energy' must be one of"),
        (("furnace",), {"furnace": "broken"}, "furnace = 'broken' must be one of ok, fails"),
    ],
)
def test_an_unknown_property_or_verdict_is_answered_with_the_known_ones(properties, expected, message):
    with pytest.raises(ValueError, match=message):
        assert_valid(brdf.Lambert(), *properties, **expected)


# ---- two models


def test_two_lamberts_differ_by_their_reflectance_everywhere():
    found = compare(brdf.Lambert(0.5), brdf.Lambert(np.array([0.5, 0.3])))
    np.testing.assert_allclose(found.absolute.value, 0.2 / np.pi, rtol=1e-14)
    np.testing.assert_allclose(found.relative.value, 0.4, rtol=1e-14)
    np.testing.assert_allclose(found.reflected.value, 0.2 / np.pi, rtol=1e-14)
    assert found.reflected.where.startswith("theta_i = 0°")
    np.testing.assert_allclose(found.albedo[::2], [0.2, 0.5], rtol=1e-12)
    assert all(d.where.endswith("channel 1") for d in found)


def test_the_largest_difference_may_be_asked_for_away_from_grazing():
    def cosine(wi, wo):
        return 0.5 / jnp.pi + 1 - wi.z

    found = compare(brdf.Lambert(0.5), cosine, 60.0)
    np.testing.assert_allclose(found.absolute.value, 0.5, rtol=1e-12)
    assert found.absolute.where.startswith("theta_i = 60°")
    np.testing.assert_allclose([found.absolute.a, found.absolute.b], [0.5 / np.pi, 0.5 / np.pi + 0.5], rtol=1e-12)


def test_models_of_different_numbers_of_channels_are_not_compared():
    with pytest.raises(ValueError, match="b has 3 channels, a has 2"):
        compare(brdf.Lambert(np.array([0.1, 0.2])), brdf.Lambert(np.array([0.1, 0.2, 0.3])))
    with pytest.raises(ValueError, match=r"below_deg = 91.0 is outside \(0, 90\]"):
        compare(brdf.Lambert(), brdf.Lambert(), 91.0)


@pytree
class HalfSampled(brdf.Lambert):
    """Samples one half of the hemisphere, with a density that fits: every single sample is right, their mean half."""

    def sample(self, wo, u1, u2, u_lobe):
        wi = cosine_hemisphere(0.5 * u1, u2)
        return Sample(wi, 0.5 * self.rho, self.pdf(wi, wo))

    def pdf(self, wi, wo):
        return jnp.where((wi.z > 0) & (wi.y >= 0), 2 * wi.z / jnp.pi, 0.0)


def test_a_sampler_that_leaves_out_a_half_is_found_by_what_it_never_samples():
    report = audit(HalfSampled(0.6), SAMPLING)
    assert failing(report) == {"sampling_weight"}
    (row,) = (row for row in report.rows if not row.ok)
    assert abs(row.number - 0.3) < 1e-3
    assert "never sampled" in row.text


@pytree
class Peak:
    """Its albedo is no number in a band of views that no angle of the grid is in."""

    at: object = param("[0, 1]", default=0.62)

    def __call__(self, wi, wo):
        near = jnp.abs(wo.z - self.at)
        value = 0.5 / jnp.pi * (1 + 0.2 * jnp.exp(-((near / 0.02) ** 2)))
        return above(wi, jnp.where(near < 0.002, jnp.nan, value))


def test_an_albedo_that_is_no_number_between_the_angles_of_the_grid_is_no_pass():
    (row,) = audit(Peak(), ("energy_view",)).rows
    assert row.verdict == "fails"
    assert not np.isfinite(row.number)
