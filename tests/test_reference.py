"""Reference vectors and their files, and what is said about the files of another renderer."""

import json
import shutil
import subprocess
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from jaxrefl import brdf
from jaxrefl.params import param, pytree
from jaxrefl.reference import compare, evaluate, explain, read, reference_vectors, spread_directions, write
from jaxrefl.vec import Vec3

N = 400
AT = spread_directions(N, seed=5)
EXPONENT = 6.0
PHONG = brdf.LiteralPhong(k_d=0.3, k_s=0.6, shininess=EXPONENT)  # not reciprocal: a swap shows


def phong(wi, wo):
    """`PHONG` in numpy, (N, 3) to (N,)."""
    along = wi[:, 2] * wo[:, 2] - wi[:, 0] * wo[:, 0] - wi[:, 1] * wo[:, 1]
    return (0.3 + 0.6 * np.maximum(along, 0) ** EXPONENT / wi[:, 2]) / np.pi


def save(path, wi, wo, f, **columns):
    table = np.column_stack([wi, wo, f, *columns.values()])
    names = ["f"] if np.ndim(f) == 1 else [f"f_{c}" for c in range(np.shape(f)[1])]
    head = ",".join(["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z", *names, *columns])
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=head, comments="")
    return read(path)


@pytest.mark.parametrize("n", [1, 2, 7, 30, 1000, 5000])
def test_directions_are_unit_above_the_surface_as_many_as_asked_for_and_all_different(n):
    at = spread_directions(n)
    assert at.wi.shape == at.wo.shape == (n, 3)
    for w in (at.wi, at.wo):
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, rtol=1e-15)
        assert w[:, 2].min() >= 0.999e-3
    assert len(np.unique(np.hstack([at.wi, at.wo]), axis=0)) == n
    np.testing.assert_array_equal(at.cos_theta_o[at.view], at.wo[:, 2])


def test_directions_depend_on_the_seed_and_on_nothing_else():
    np.testing.assert_array_equal(spread_directions(N, seed=5).wi, AT.wi)
    assert not (spread_directions(N, seed=6).wi == AT.wi).all()


def test_every_view_meets_its_mirror_and_retro_direction_the_normal_and_grazing_light():
    at = spread_directions(1000)
    assert len(at.cos_theta_o) == 31
    assert at.cos_theta_o.min() == 1e-3
    assert at.cos_theta_o.max() == 1
    for v in range(31):
        wi, wo = at.wi[at.view == v], at.wo[at.view == v][0]
        for edge in (wo, wo * [-1, -1, 1], [0, 0, 1]):
            assert abs(wi - edge).max(axis=1).min() < 1e-15
        low = wi[wi[:, 2] < 1.001e-3]
        along = low[:, :2] @ wo[:2] / max(np.hypot(*wo[:2]), 1e-9)
        assert wo[2] == 1 or all(abs(along - x).min() < 1e-5 for x in (-1, 0, 1)), "no grazing light from three sides"
        angles = np.arccos(np.clip(wi @ (wo * [-1, -1, 1]), -1, 1))
        assert ((angles > 1e-4) & (angles < 0.03)).any(), "no light near the mirror direction"


def test_lights_fill_the_hemisphere():
    """No cap of 20 degrees that lies wholly above the surface is empty."""
    at = spread_directions(1000)
    rng = np.random.default_rng(0)
    mu, phi = rng.uniform(np.sin(np.deg2rad(20)), 1, 500), rng.uniform(0, 2 * np.pi, 500)
    sine = np.sqrt(1 - mu * mu)
    centres = np.stack([sine * np.cos(phi), sine * np.sin(phi), mu], axis=-1)
    assert (centres @ at.wi.T).max(axis=1).min() > np.cos(np.deg2rad(20))


@pytest.mark.parametrize(("argument", "value"), [("n", 0), ("n", 2.5), ("seed", -1)])
def test_a_wrong_number_of_directions_is_refused_by_name(argument, value):
    with pytest.raises(ValueError, match=f"{argument} = {value}"):
        spread_directions(**{"n": 10} | {argument: value})


@pytest.fixture(scope="module")
def vectors():
    return reference_vectors(PHONG, N, 5, name="literal-phong")


def test_the_values_are_those_of_the_formula_in_numpy(vectors):
    np.testing.assert_allclose(vectors.values["f"][:, 0], phong(AT.wi, AT.wo), rtol=1e-12)
    assert vectors.parameters == {"k_d": 0.3, "k_s": 0.6, "shininess": EXPONENT, "highlight": "mirror"}
    assert "pdf" not in vectors.values, "no density is invented"


def test_the_albedos_are_within_their_errors_of_the_closed_form():
    """Lommel-Seeliger: (w / 2)(1 - mu ln(1 + 1 / mu))."""
    found = reference_vectors(brdf.LommelSeeliger(jnp.array([0.9, 0.2])), 50)
    mu = found.wo[:, 2:]
    exact = np.array([0.9, 0.2]) / 2 * (1 - mu * np.log1p(1 / mu))
    assert found.values["albedo"].shape == (50, 2)
    assert (abs(found.values["albedo"] - exact) <= found.values["albedo_error"]).all()
    assert (found.values["albedo_error"] <= 1e-10 * exact).all()


def test_delta_parts_have_their_columns_and_are_in_the_albedo():
    found = reference_vectors(brdf.CoatedLambert(rho=1.0), 20)
    mu = found.wo[:, 2]
    transmitted = np.sqrt(1 - (1 - mu * mu) / 2.25)
    s, p = (mu - 1.5 * transmitted) / (mu + 1.5 * transmitted), (1.5 * mu - transmitted) / (1.5 * mu + transmitted)
    np.testing.assert_allclose(found.values["mirror"][:, 0], (s * s + p * p) / 2, rtol=1e-12)
    np.testing.assert_allclose(found.values["albedo"], 1, rtol=1e-9)
    assert "through" not in found.values


def test_a_function_and_a_nest_of_models_have_reference_vectors():
    found = reference_vectors(lambda wi, wo: 0.5 / jnp.pi + 0 * wi.z, 10, name="constant")
    np.testing.assert_allclose(found.values["albedo"], 0.5, rtol=1e-12)
    assert found.parameters == {}
    mixed = reference_vectors(brdf.Scaled(brdf.Lambert(0.5), 0.5), 10)
    np.testing.assert_allclose(mixed.values["f"], 0.25 / np.pi, rtol=1e-15)
    assert mixed.parameters == {"base": "Lambert", "base.rho": 0.5, "factor": 0.5}


def test_a_model_that_is_not_finite_is_refused_with_the_directions():
    with pytest.raises(ValueError, match=r"f = \[.*\] is not finite at wi = .*, wo = "):
        reference_vectors(lambda wi, wo: jnp.log(wi.z - 0.5), 30)


@pytest.mark.usefixtures("float32")
def test_float32_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match="jax_enable_x64"):
        evaluate(PHONG, AT.wi, AT.wo)


@pytest.mark.parametrize("ending", ["csv", "json"])
def test_a_file_comes_back_bit_for_bit_and_states_its_conventions(vectors, tmp_path, ending):
    path = tmp_path / f"ref.{ending}"
    write(vectors, path)
    given = read(path)
    np.testing.assert_array_equal(given.wi, vectors.wi)
    np.testing.assert_array_equal(given.wo, vectors.wo)
    np.testing.assert_array_equal(given.values["f"], vectors.values["f"])
    text = path.read_text()
    for phrase in ("literal-phong", "z is the surface normal", "BOTH LEAVING", "cosine of wi NOT included", "1/sr"):
        assert phrase in text
    for phrase in ("alpha = roughness^2", "radians", "0.1.0", "bound on the error of albedo"):
        assert phrase in text
    assert "density of wi" not in text, "there is no pdf to explain"


def test_the_json_has_a_schema_version_and_what_the_model_is(vectors, tmp_path):
    write(vectors, tmp_path / "ref.json")
    document = json.loads((tmp_path / "ref.json").read_text())
    assert document["schema"] == 1
    assert document["parameters"]["highlight"] == "mirror"
    assert document["count"] == N
    assert document["channels"] == {"f": 1, "albedo": 1, "albedo_error": 1}
    assert np.shape(document["albedo"]) == (N, 1)


def test_equal_vectors_are_equal_files_with_seventeen_digits(vectors, tmp_path):
    for name in ("a.csv", "b.csv"):
        write(vectors, tmp_path / name)
    text = (tmp_path / "a.csv").read_bytes()
    assert text == (tmp_path / "b.csv").read_bytes()
    rows = [line.split(",") for line in text.decode().splitlines() if not line.startswith("#")]
    assert rows[0] == ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z", "f", "albedo", "albedo_error"]
    assert len(rows) == N + 1
    assert max(len(cell.strip("-").replace(".", "").lstrip("0").partition("e")[0]) for cell in rows[20]) == 17


def test_an_ending_that_nobody_reads_is_refused(vectors, tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.csv, \.json, \.h"):
        write(vectors, tmp_path / "ref.xml")


@pytest.mark.parametrize("compiler", [("gcc", "-std=c89", "c"), ("g++", "-std=c++98", "cpp")], ids=lambda c: c[0])
def test_the_header_compiles_without_a_warning_and_holds_the_same_numbers(tmp_path, compiler):
    command, standard, ending = compiler
    if shutil.which(command) is None:
        pytest.skip(f"no {command} here")
    rho = jnp.array([0.9, 0.5, 0.1])
    found = reference_vectors(brdf.D3D9Repaired(diffuse=rho), 40, name="/* path */to/my model.py:My-Model")
    write(found, tmp_path / "ref.h")
    source = tmp_path / f"main.{ending}"
    source.write_text(
        '#include <stdio.h>\n#include "ref.h"\n#include "ref.h"\n'
        "int main(void) {\n  int i, c;\n  for (i = 0; i < JAXREFL_MY_MODEL_COUNT; i++) {\n"
        "    const struct jaxrefl_my_model_vector *v = &jaxrefl_my_model[i];\n"
        '    printf("%.17g %.17g ", v->wi[0], v->wo[2]);\n'
        '    for (c = 0; c < JAXREFL_MY_MODEL_CHANNELS; c++) printf("%.17g ", v->f[c]);\n'
        '    printf("%.17g %.17g\\n", v->mirror[0], v->albedo[2]);\n  }\n  return 0;\n}\n'
    )
    flags = [standard, "-pedantic", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([command, *flags, str(source), "-o", str(tmp_path / "main")], check=True, timeout=100)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True, timeout=100).stdout
    v = found.values
    expected = [found.wi[:, :1], found.wo[:, 2:], v["f"], v["mirror"][:, :1], v["albedo"][:, 2:]]
    np.testing.assert_array_equal(np.loadtxt(printed.splitlines()), np.hstack(expected))


HEAD = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f\n"
ROW = "0,0,1,0,0,1,0.5\n"
BAD = {
    HEAD + ROW + "0,0,1,0,0,one,0.5\n": "line 3, column wo_z: 'one' is not a number",
    "# made by us\n\n" + HEAD + ROW + "0,0,1,0,0,1,\n": "line 5, column f: '' is not a number",
    HEAD + ROW + "0,0,1,0,0,1\n": "line 3: 6 cells where the header has 7",
    HEAD + ROW + "0,0,2,0,0,1,1\n": "line 3, wi = 0, 0, 2: has length 2, not 1",
    HEAD + "0,0,1,0,nan,1,1\n": "line 2, wo = 0, nan, 1: has length nan",
    HEAD: "has no rows",
    "# nothing\n": "has no header row; needed are the columns wi_x",
    "wi_x,wi_y,f\n0,0,1\n": "needed columns only wix, wiy, f; needed are wi_x",
    HEAD.replace(",f", ",value") + ROW: "has no column f",
    HEAD.replace("wi_y", "WI_X") + ROW: "line 1: the column WI_X, wi_x is there more than once",
}


BAD_JSON = {
    '{"wi": [[0, 0, 1]],\n "wo" [[0, 0, 1]]}': "line 2: Expecting ':' delimiter",
    '{"wi": [[0, 0, 1]], "wo": [[0, 0]], "f": [1]}': "wo: its shape is (1, 2)",
    '{"wi": [[0, 0, 1]], "wo": [[0, 0, 1]], "f": [1, 2]}': "f: 2 rows where the others have 1",
    '{"wi": [[0, 0, "up"]], "wo": [[0, 0, 1]], "f": [1]}': "wi: it is not an array of numbers",
    '{"wi": [[0, 0, 1]], "wo": [[0, 0, -3]], "f": [1]}': "row 0, wo = 0, 0, -3: has length 3",
    "[1, 2]": "is not an object with wi, wo and f",
}


CASES = [("theirs.csv", *case) for case in BAD.items()] + [("theirs.json", *case) for case in BAD_JSON.items()]


@pytest.mark.parametrize(("name", "text", "message"), CASES, ids=range(len(CASES)))
def test_a_bad_table_is_refused_by_file_and_place(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError) as caught:
        read(path)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)


def test_a_file_that_is_not_there_or_is_no_text_is_refused(tmp_path):
    with pytest.raises(ValueError, match="there is no file"):
        read(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe\x00")
    with pytest.raises(ValueError, match="is not a text file"):
        read(tmp_path / "picture.csv")


def test_names_separators_and_channels_are_read_as_people_write_them(tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_bytes(
        b"\xef\xbb\xbfWi.X;wiY;WI-Z;note;Wo X;wo_y;wo_z;F_B;F_R;F_G;PDF\r\n0;0;1;hello;0;0;1;3;1;2;nan\r\n"
    )
    given = read(path)
    np.testing.assert_array_equal(given.values["f"], [[1, 2, 3]])
    assert np.isnan(given.values["pdf"]).all()
    assert given.where == ["line 2"]


def test_digits_are_those_of_the_relative_error_of_the_worst_channel(tmp_path):
    f = phong(AT.wi, AT.wo)[:, None] * np.array([1.0, 1 + 1e-7, 1.0])
    found = compare(PHONG, save(tmp_path / "a.csv", AT.wi, AT.wo, f)).comparisons[0]
    assert abs(found.median - 7) < 1e-3
    assert abs(found.worst - 7) < 1e-3
    assert found.failing == 0


def test_one_wrong_row_fails_is_named_and_is_no_difference_of_convention(tmp_path):
    f = phong(AT.wi, AT.wo)
    for wrong in (f[123] * 1.001, np.nan, np.inf, -f[123]):
        g = np.where(np.arange(N) == 123, wrong, f)
        given = save(tmp_path / "a.csv", AT.wi, AT.wo, g)
        found = compare(PHONG, given)
        (f_row,) = found.comparisons
        assert not found.ok
        assert (f_row.failing, f_row.worst_at, f_row.points) == (1, "line 125", N)
        np.testing.assert_array_equal(f_row.wi, AT.wi[123])
        np.testing.assert_array_equal(f_row.theirs, [wrong])
        assert f_row.worst == 0 if wrong != f[123] * 1.001 else abs(f_row.worst - 3) < 1e-3
        assert f_row.median > 13
        assert explain(PHONG, given) is None


def test_an_implementation_in_single_precision_agrees_to_five_digits(tmp_path):
    f = phong(AT.wi.astype(np.float32), AT.wo.astype(np.float32)).astype(np.float32)
    found = compare(PHONG, save(tmp_path / "a.csv", AT.wi, AT.wo, f))
    assert found.ok
    assert 5 < found.comparisons[0].worst < 8


def test_rows_that_are_zero_in_both_say_nothing(tmp_path):
    model = brdf.ModifiedPhong(shininess=200.0)
    mine = evaluate(model, AT.wi, AT.wo)["f"][:, 0]
    f = np.where(mine < 1e-9 * mine.max(), 0, mine)
    found = compare(model, save(tmp_path / "a.csv", AT.wi, AT.wo, f))
    assert found.ok
    assert 20 < found.comparisons[0].points < N / 2


COSINE, PI, LESS = "the cosine of wi is included", "a factor 1/pi is missing", "a factor 1/pi is there once too often"
SWAP, UP = "wi and wo are swapped", "the normal is y, not z"
INWARD = {
    s: f"{w} toward the surface" for s, w in {"i": "wi points", "o": "wo points", "io": "wi and wo point"}.items()
}


def lifted(w):
    """The same direction in a frame whose y is the normal: z, the old normal, becomes y."""
    return np.stack([w[:, 0], w[:, 2], -w[:, 1]], axis=-1)


def made(name):
    """Table of a renderer with a convention of its own, and the names that it should be recognised by."""
    wi, wo, f = AT.wi, AT.wo, phong(AT.wi, AT.wo)
    cosine = wi[:, 2]
    return {
        "cosine": (wi, wo, f * cosine, {COSINE}),
        "no cosine at all": (wi, wo, f / cosine, {"it is divided by the cosine of wi"}),
        "pi": (wi, wo, f * np.pi, {PI}),
        "pi twice": (wi, wo, f / np.pi, {LESS}),
        "cosine and pi": (wi, wo, f * cosine * np.pi, {COSINE, PI}),
        "swapped": (wo, wi, f, {SWAP}),
        "swapped with cosine": (wo, wi, f * cosine, {SWAP, COSINE}),
        "inward light": (-wi, wo, f, {INWARD["i"]}),
        "inward view": (wi, -wo, f, {INWARD["o"]}),
        "inward both": (-wi, -wo, f, {INWARD["io"]}),
        "y up": (lifted(wi), lifted(wo), f, {UP}),
        "y up, inward, pi": (-lifted(wi), lifted(wo), f * np.pi, {UP, INWARD["i"], PI}),
        "factor": (wi, wo, 0.3 * f, {"constant factor"}),
        "single precision": (wi, wo, (f * cosine).astype(np.float32), {COSINE}),
        "four digits": (wi, wo, np.round(f * np.pi, 4), {PI}),
        "a few wrong rows": (wi, wo, np.where(np.arange(N) % 20 == 3, 0.7, f * np.pi), {PI}),
    }[name]


@pytest.mark.parametrize(
    "name",
    [
        *("cosine", "no cosine at all", "pi", "pi twice", "cosine and pi", "swapped", "swapped with cosine"),
        *("inward light", "inward view", "inward both", "y up", "y up, inward, pi", "factor"),
        *("single precision", "four digits", "a few wrong rows"),
    ],
)
def test_a_difference_of_convention_is_recognised_by_name(tmp_path, name):
    wi, wo, f, names = made(name)
    given = save(tmp_path / "a.csv", wi, wo, f)
    assert not compare(PHONG, given).ok
    found = explain(PHONG, given)
    assert set(found.names) == names
    assert found.median > (3.5 if name == "four digits" else 6)
    assert found.factor is None or abs(found.factor - 0.3) < 1e-12


def test_a_model_that_depends_on_the_azimuth_has_its_albedos_there_and_its_frame_turned_the_right_way(tmp_path):
    """f = (1 + x_i^2 x_o^2) / (2 pi), whose albedo is (1 + x_o^2 / 4) / 2; and one that knows left from right."""
    found = reference_vectors(lambda wi, wo: (1 + (wi.x * wo.x) ** 2) / (2 * jnp.pi), 40)
    np.testing.assert_allclose(found.values["albedo"][:, 0], 0.5 + found.wo[:, 0] ** 2 / 8, rtol=1e-9)

    def handed(wi, wo):
        return (1 + 0.4 * (wi.x * wo.y - wi.y * wo.x)) / jnp.pi

    f = (1 + 0.4 * (AT.wi[:, 0] * AT.wo[:, 1] - AT.wi[:, 1] * AT.wo[:, 0])) / np.pi
    assert explain(handed, save(tmp_path / "a.csv", lifted(AT.wi), lifted(AT.wo), f)).names == (UP,)


def test_another_model_is_not_explained_away(tmp_path):
    for f in (evaluate(brdf.Burley(roughness=1.0), AT.wi, AT.wo)["f"][:, 0], phong(AT.wi, AT.wo) ** 1.5, np.zeros(N)):
        assert explain(PHONG, save(tmp_path / "a.csv", AT.wi, AT.wo, f)) is None


@pytest.mark.parametrize(("theirs", "word"), [(0.49, "square"), (0.7**0.5, "square root")])
def test_alpha_against_roughness_is_recognised_in_both_directions(tmp_path, theirs, word):
    f = evaluate(brdf.Burley(0.8, theirs), AT.wi, AT.wo)["f"]
    (name,) = explain(brdf.Burley(0.8, 0.7), save(tmp_path / "a.csv", AT.wi, AT.wo, f)).names
    assert name.startswith(f"theirs has roughness = {theirs:.6g}, the {word} of 0.7 (alpha against roughness")


def test_degrees_are_recognised_in_a_parameter_and_in_the_directions(tmp_path):
    f = evaluate(brdf.OrenNayar(0.8, np.deg2rad(1.2)), AT.wi, AT.wo)["f"]
    (name,) = explain(brdf.OrenNayar(0.8, 1.2), save(tmp_path / "a.csv", AT.wi, AT.wo, f)).names
    assert name == "theirs has sigma = 0.020944, the value as degrees of 1.2"
    angles = np.stack([x for w in (AT.wi, AT.wo) for x in (np.arccos(w[:, 2]), np.arctan2(w[:, 1], w[:, 0]))], axis=-1)
    f = phong(AT.wi, AT.wo)
    for scale in (1.0, 180 / np.pi):
        path = tmp_path / "angles.csv"
        table = np.column_stack([angles * scale, f])
        np.savetxt(path, table, "%.17g", ",", header="theta_i,phi_i,theta_o,phi_o,f", comments="")
        given = read(path)
        assert compare(PHONG, given).ok == (scale == 1)
        if scale != 1:
            assert explain(PHONG, given).names == ("angles are in degrees",)


def test_the_order_of_the_channels_is_recognised_and_their_number_has_to_fit(tmp_path):
    rho = jnp.array([0.9, 0.5, 0.1])
    f = evaluate(brdf.EON(rho), AT.wi, AT.wo)["f"]
    given = save(tmp_path / "a.csv", AT.wi, AT.wo, f[:, ::-1])
    assert explain(brdf.EON(rho), given).names == ("the channels are in reverse order",)
    with pytest.raises(ValueError, match="f has 3 channels in the file and 2 in the model"):
        compare(brdf.EON(rho[:2]), given)


@pytree
class Sampled:
    """Lambert, sampled about the half vector on purpose: p(h) = cos theta_h / pi, p(wi) = p(h) / (4 wo.h)."""

    rho: Any = param("[0, 1]", spectral=True, default=0.5, doc="reflectance")

    def __call__(self, wi: Vec3, wo: Vec3) -> Any:
        return self.rho / jnp.pi + 0 * wi.z

    def pdf(self, wi: Vec3, wo: Vec3) -> Any:
        cos_h = (wi.z + wo.z) / jnp.sqrt(2 + 2 * (wi.x * wo.x + wi.y * wo.y + wi.z * wo.z))
        along = jnp.sqrt(0.5 + 0.5 * (wi.x * wo.x + wi.y * wo.y + wi.z * wo.z))
        return cos_h / jnp.pi / (4 * along)


def test_a_density_is_written_compared_and_its_missing_jacobian_recognised(tmp_path):
    model = Sampled(0.5)
    write(reference_vectors(model, 30), tmp_path / "ref.csv")
    assert "# pdf: density of wi, given wo, per solid angle" in (tmp_path / "ref.csv").read_text()
    assert [c.quantity for c in compare(model, read(tmp_path / "ref.csv"), 15).comparisons] == ["f", "pdf"]
    half = AT.wi + AT.wo
    length = np.linalg.norm(half, axis=1)
    density = half[:, 2] / length / np.pi
    along = np.sum(AT.wo * half, axis=1) / length
    f = np.full(N, 0.5 / np.pi)
    assert compare(model, save(tmp_path / "a.csv", AT.wi, AT.wo, f, pdf=density / (4 * along)), 6).ok
    lambert = reference_vectors(brdf.Lambert(0.5), 30)
    np.testing.assert_allclose(lambert.values["pdf"], lambert.wi[:, 2:] / np.pi, rtol=1e-15)
    given = save(tmp_path / "b.csv", AT.wi, AT.wo, f, pdf=density)
    assert [(c.quantity, c.failing > 300) for c in compare(model, given).comparisons] == [("f", False), ("pdf", True)]
    (name,) = explain(model, given, "pdf").names
    assert name == "it is the density of the half vector (the Jacobian 1 / (4 wo.h) is missing)"
    assert compare(brdf.OrenNayar(0.5, 0.0), given).left_out == ["pdf"]


def test_digits_out_of_their_range_are_refused():
    with pytest.raises(ValueError, match=r"digits = 17 is outside \[0, 16\]"):
        compare(PHONG, None, 17)
