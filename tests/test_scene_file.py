"""Scene files: the grammar, every kind of mistake, settings, schema, and the scenes that ship."""

import copy
import dataclasses
import itertools
import json
import math
import subprocess
import sys
import tomllib

import jax
import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from jaxrefl import scene_file
from jaxrefl.brdf import EON
from jaxrefl.files import read_table
from jaxrefl.params import Interval, parameters
from jaxrefl.scene_file import catalog, write
from jaxrefl.vec import Vec3

MINIMAL = """
[camera]
type = "Pinhole"
position = [0.0, -5.0, 1.0]

[objects.glass.shape]
type = "Sphere"
center = [0.0, 0.0, 1.0]

[objects.glass.surface]
type = "Dielectric"
eta = 1.5
"""
SHIPPED = ("d3d9", "fresnel", "jhu", "perrin")
GROUPS = {
    "shape": catalog.SHAPES,
    "surface": catalog.SURFACES,
    "light": catalog.LIGHTS,
    "camera": catalog.CAMERAS,
    "background": catalog.BACKGROUNDS,
}
REQUIRED = {
    "Sphere": {"center": [0.0, 0.0, 0.0]},
    "Plane": {"point_on": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
    "Directional": {"direction": [0.0, 0.0, -1.0]},
    "Point": {"position": [0.0, 0.0, 3.0]},
    "Spot": {"position": [0.0, 0.0, 3.0], "direction": [0.0, 0.0, -1.0]},
    "Pinhole": {"position": [0.0, -5.0, 1.0]},
    "Orthographic": {"position": [0.0, -5.0, 1.0]},
}
DECLARED = [
    (group, name, declared)
    for group, models in GROUPS.items()
    for name, cls in models.items()
    for declared in parameters(cls)
    if not declared.vector
]


def document(text=MINIMAL):
    return tomllib.loads(text)


def document_with(group, name, **keys):
    """Minimal document with one model in its place, and the path of that place."""
    table = {"type": name, **REQUIRED.get(name, {}), **keys}
    found = document()
    if group == "shape":
        found["objects"]["glass"]["shape"] = table
    elif group == "surface":
        found["objects"]["glass"]["surface"] = table
    elif group == "light":
        found["lights"] = {"one": table}
    else:
        found[group] = table
    return found


def load(tables, **options):
    return scene_file.loads(write.document_text(tables), "s.toml", **options)


def problems(text, **options):
    with pytest.raises(ValueError) as caught:
        scene_file.loads(text, "s.toml", **options)
    return str(caught.value).splitlines()


def key_of(declared):
    return f"{declared.name}_deg" if declared.unit == "rad" else declared.name


def leaves(node, path=()):
    """Numbers and lists of numbers of a document, with their paths."""
    for key, value in node.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        elif not isinstance(value, (str, bool)):
            yield (*path, key), value


def leaf_of(loaded, path):
    """Leaf of a pytree, by attributes and by the names of the dictionaries."""
    node = {"camera": loaded.camera, "render": loaded.settings}.get(path[0], loaded.scene)
    for step in path[1:] if path[0] in ("camera", "render") else path:
        step = step.removesuffix("_deg")
        node = node[step] if isinstance(node, dict) else getattr(node, step)
    return node


# The grammar


@pytest.mark.parametrize("name", SHIPPED)
def test_every_number_of_a_file_is_the_leaf_of_the_same_path(name):
    path = scene_file.example(name)
    loaded = scene_file.load(path)
    found = list(leaves(tomllib.loads(path.read_text())))
    assert len(found) > 40
    for place, value in found:
        leaf = leaf_of(loaded, place)
        leaf = leaf.to_array() if isinstance(leaf, Vec3) else leaf
        expected = np.radians(value) if place[-1].endswith("_deg") else np.asarray(value, float)
        np.testing.assert_allclose(leaf, expected, rtol=1e-6, err_msg=str(place))


def test_what_a_file_does_not_say_is_the_default_of_the_dataclass():
    loaded = scene_file.loads(MINIMAL)
    assert loaded.settings == scene_file.Settings()
    assert loaded.scene.objects["glass"].shape.radius == 1.0
    assert loaded.scene.objects["glass"].surface.sigma is None
    assert loaded.scene.lights == {}
    assert loaded.scene.background == 0.0
    assert loaded.camera.up.z == 1.0
    assert loaded.channels == 1


def test_numbers_become_arrays_of_the_default_float(float32):
    loaded = scene_file.load(scene_file.example("jhu"))
    given = [leaf for leaf in jax.tree.leaves(loaded.scene) if isinstance(leaf, jax.Array)]
    assert len(given) > 40
    assert {leaf.dtype.name for leaf in given} == {"float32"}


def test_an_integer_is_a_number_and_a_number_is_not_an_integer():
    assert scene_file.loads(MINIMAL.replace("eta = 1.5", "eta = 2")).scene.objects["glass"].surface.eta == 2.0
    assert problems(f"{MINIMAL}\n[render]\nwidth = 2.0\n") == [
        "s.toml: render.width = 2.0 is not an integer: width of the picture: an integer, in [1, 16384], pixels"
    ]


def test_one_object_holds_many_primitives():
    text = MINIMAL.replace("[0.0, 0.0, 1.0]", "[[0, 0, 1], [2, 0, 1]]", 1).replace("eta = 1.5", "eta = [1.3, 1.5]")
    item = scene_file.loads(text).scene.objects["glass"]
    np.testing.assert_array_equal(item.shape.center.x, [0, 2])
    np.testing.assert_array_equal(item.surface.eta, [1.3, 1.5])


def test_the_type_of_a_base_may_be_left_out():
    for table in ("{ k_d = 0.25 }", '{ type = "Phong", k_d = 0.25 }'):
        text = MINIMAL.replace('type = "Dielectric"\neta = 1.5', f'type = "Coat"\nbase = {table}')
        assert scene_file.loads(text).scene.objects["glass"].surface.base.k_d == 0.25


def test_switches_and_choices_stay_what_they_are():
    keys = {"sun_fresnel": True, "base": {"highlight": "mirror"}}
    surface = load(document_with("surface", "D3D9", **keys)).scene.objects["glass"].surface
    assert surface.sun_fresnel is True
    assert surface.base.highlight == "mirror"
    assert load(document_with("light", "Spot", shadows=False)).scene.lights["one"].shadows is False


def test_a_texture_stands_in_the_place_of_a_colour_and_of_the_alpha_of_d3d9():
    checker = {"type": "Checker", "even": [1.0, 0.5, 0.25], "odd": 0.0, "squares_u": 2.0}
    surface = load(document_with("surface", "D3D9", metallic=checker, alpha=checker)).scene.objects["glass"].surface
    for texture in (surface.metallic, surface.alpha):
        np.testing.assert_array_equal(texture((0.25, 0.5)), [1.0, 0.5, 0.25])
        np.testing.assert_array_equal(texture((0.75, 0.5)), [0.0, 0.0, 0.0])


# Pictures


def write_picture(path, pixels):
    Image.fromarray(np.asarray(pixels, np.uint8)).save(path)


PICTURE = MINIMAL.replace(
    'type = "Dielectric"\neta = 1.5', 'type = "Blend"\nreflectivity = { type = "Image", path = "maps/a.png" }'
)


@pytest.fixture
def maps(tmp_path):
    (tmp_path / "maps").mkdir()
    write_picture(tmp_path / "maps/a.png", [[[0, 128, 255], [255, 0, 0]]])
    (tmp_path / "s.toml").write_text(PICTURE)
    return tmp_path


def test_a_picture_is_found_beside_the_scene_file_and_made_linear(maps, monkeypatch):
    monkeypatch.chdir("/")
    pixels = scene_file.load(maps / "s.toml").scene.objects["glass"].surface.reflectivity.pixels
    np.testing.assert_allclose(pixels, [[[0, 0.21586050, 1], [1, 0, 0]]], atol=1e-7)  # IEC 61966-2-1 of 128 / 255


def test_a_linear_picture_is_taken_as_it_is(maps):
    text = PICTURE.replace('png" }', 'png", colorspace = "linear" }')
    loaded = scene_file.loads(text, folder=maps)
    pixels = loaded.scene.objects["glass"].surface.reflectivity.pixels
    np.testing.assert_allclose(pixels[0, 0], [0, 128 / 255, 1], atol=1e-7)


def test_a_picture_that_is_not_there_is_a_problem_of_its_path(maps):
    (line,) = problems(PICTURE.replace("a.png", "b.png"), folder=maps)
    assert line == 's.toml: objects.glass.surface.reflectivity.path = "maps/b.png": there is no such file'


def test_a_file_that_is_no_picture_is_a_problem_of_its_path(maps):
    (maps / "maps/a.png").write_text("hello")
    (line,) = problems(PICTURE, folder=maps)
    assert line.startswith('s.toml: objects.glass.surface.reflectivity.path = "maps/a.png": it is no picture')


def test_a_pixel_keeps_the_range_of_the_parameter_it_stands_for(maps):
    exr = pytest.importorskip("OpenEXR")
    values = np.full((2, 2), 1.5, np.float32)
    exr.File({"type": exr.scanlineimage}, {"Y": values}).write(str(maps / "maps/a.exr"))
    (line,) = problems(PICTURE.replace("a.png", "a.exr"), folder=maps)
    assert line == (
        's.toml: objects.glass.surface.reflectivity.path = "maps/a.exr" has a pixel of 1.5, which is outside [0, 1]'
    )


def test_a_colour_of_a_checker_keeps_the_range_of_the_parameter_it_stands_for():
    text = MINIMAL.replace('type = "Dielectric"\neta = 1.5', 'type = "{}"\n{} = {{ type = "Checker", even = 2.0 }}')
    assert problems(text.format("Blend", "reflectivity")) == [
        "s.toml: objects.glass.surface.reflectivity.even = 2.0 is outside [0, 1]"
    ]
    scene_file.loads(text.format("Phong", "k_d"))


# Mistakes


def edit(*lines, **replaced):
    """Minimal text with some of its lines replaced, and lines added to its last table, the surface."""
    text = MINIMAL
    for old, new in replaced.items():
        before = {
            "eta": "eta = 1.5", "surface": 'type = "Dielectric"', "center": "center = [0.0, 0.0, 1.0]",
            "position": "position = [0.0, -5.0, 1.0]", "shape": 'type = "Sphere"',
        }[old]  # fmt: skip
        assert before in text
        text = text.replace(before, new)
    return text + "\n".join(lines)


SURFACE = "objects.glass.surface"
COLOUR = "a number, a list with one for each channel, a list of such lists for each primitive"
TEXTURE = "or a table of type Checker or Image"
MISTAKES = {
    "out of range": (edit(eta="eta = -1.0"), f"{SURFACE}.eta = -1.0 is outside (0, inf)"),
    "at an open end": (edit(eta="eta = 0"), f"{SURFACE}.eta = 0 is outside (0, inf)"),
    "infinite": (edit(eta="eta = inf"), f"{SURFACE}.eta = inf is outside (0, inf)"),
    "not a number": (edit(eta="eta = nan"), f"{SURFACE}.eta = nan is outside (0, inf)"),
    "too large": (edit(eta="eta = 1e39"), f"{SURFACE}.eta = 1e+39 is too large for float32"),
    "one of several": (edit("sigma = [1, -2, 0]"), f"{SURFACE}.sigma[1] = -2 is outside [0, inf)"),
    "one in a row": (edit("sigma = [[1, 2], [-3, 0]]"), f"{SURFACE}.sigma[1][0] = -3 is outside [0, inf)"),
    "ragged": (edit("sigma = [[1], [1, 2]]"), f"{SURFACE}.sigma = [[1], [1, 2]] has rows of different lengths"),
    "empty": (
        edit("sigma = []"),
        f"{SURFACE}.sigma has 0 elements: extinction of the inside: {COLOUR} {TEXTURE}, in [0, inf), 1/length",
    ),
    "a string for a number": (
        edit(eta='eta = "high"'),
        f'{SURFACE}.eta = "high" is not a number: index of the inside over the outside: '
        "a number or a list with one for each primitive, in (0, inf)",
    ),
    "a switch for a number": (
        edit(eta="eta = true"),
        f"{SURFACE}.eta = true is not a number: index of the inside over the outside: "
        "a number or a list with one for each primitive, in (0, inf)",
    ),
    "a table for a number": (
        edit(eta="eta = {}"),
        f"{SURFACE}.eta is a table, which is not accepted: index of the inside over the outside: "
        "a number or a list with one for each primitive, in (0, inf)",
    ),
    "a spectrum for a scalar": (
        edit(eta="eta = [[1.5, 1.6]]"),
        f"{SURFACE}.eta = [[1.5, 1.6]] is not accepted: index of the inside over the outside: "
        "a number or a list with one for each primitive, in (0, inf)",
    ),
    "unknown key": (
        edit(eta="etaa = 1.5"),
        f"{SURFACE}.etaa = 1.5 is an unknown key; {SURFACE} has the keys type, eta, sigma",
    ),
    "unknown table": (
        edit("[render2]", "width = 2"),
        "render2 = {width = 2} is an unknown key; the file has the keys objects, lights, background, camera, render",
    ),
    "unknown type": (
        edit(surface='type = "Glass"'),
        f'{SURFACE}.type = "Glass" is not one of Phong, Blend, Whitted, D3D9, Dielectric, Conductor, Coat, ThinFilm, '
        "BRDF",
    ),
    "type of another place": (edit(shape='type = "Phong"'), 'objects.glass.shape.type = "Phong" is not one of Sphere, Plane'),  # noqa: E501
    "type that is no string": (edit(shape="type = [1]"), "objects.glass.shape.type = [1] is not one of Sphere, Plane"),
    "no type": (edit(shape=""), "objects.glass.shape.type is missing: Sphere, Plane"),
    "no value": (
        edit(center=""),
        "objects.glass.shape.center is missing: centre: 3 numbers or a list of 3 numbers for each primitive",
    ),
    "wrong length": (
        edit(center="center = [0, 1]"),
        "objects.glass.shape.center has 2 elements: centre: 3 numbers or a list of 3 numbers for each primitive",
    ),
    "wrong length of one": (
        edit(center="center = [[0, 0, 1], [0, 1, 2, 3]]"),
        "objects.glass.shape.center[1] has 4 elements: centre: 3 numbers or a list of 3 numbers for each primitive",
    ),
    "a number for a vector": (
        edit(position="position = 3"),
        "camera.position = 3 is not a list: eye: 3 numbers",
    ),
    "a number for a table": (
        edit("[lights]", "sun = 3"),
        "lights.sun = 3 is not a table: lights by name, each: a table of type Ambient, Directional, Point, Spot",
    ),
    "a list for a table": (
        edit("[[lights]]", 'type = "Ambient"'),
        'lights = [{type = "Ambient"}] is not a table: lights by name, each: '
        "a table of type Ambient, Directional, Point, Spot",
    ),
    "a choice": (
        edit("[render]", 'alpha = "straight"'),
        "render.alpha = \"straight\" is not 'premultiplied' or 'printed'",
    ),
    "a switch": (
        edit("[lights.sun]", 'type = "Directional"', "direction = [0, 0, -1]", "shadows = 1"),
        "lights.sun.shadows = 1 is not true or false: shadows: true or false",
    ),
    "degrees": (
        edit(position="position = [0, -5, 1]\nfield_of_view_deg = 180"),
        "camera.field_of_view_deg = 180 is outside (0, 180)",
    ),
    "radians": (
        edit(position="position = [0, -5, 1]\nfield_of_view = 0.5"),
        "camera.field_of_view = 0.5 is an unknown key; camera has the keys type, position, target, up, "
        "field_of_view_deg",
    ),
    "a name with a dot": (
        edit('[lights."a.b"]', 'type = "Ambient"'),
        'lights."a.b" is no name: letters, digits, _ and - are allowed',
    ),
    "a long value": (
        edit(f"name = {list(range(100))}"),
        f"{SURFACE}.name = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16... is an unknown key; "
        f"{SURFACE} has the keys type, eta, sigma",
    ),
    "a date": (edit("sigma = 1979-05-27"), f"{SURFACE}.sigma = 1979-05-27 is not a number: extinction of the inside: "
               f"{COLOUR} {TEXTURE}, in [0, inf), 1/length"),
    "a wrong base": (
        edit(surface='type = "Coat"', eta='base = { type = "Coat" }'),
        f"{SURFACE}.base.type = \"Coat\" is not 'Phong'",
    ),
    "per primitive where there is none": (
        edit("[lights.sky]", 'type = "Ambient"', "intensity = [[1, 2, 3]]"),
        "lights.sky.intensity = [[1, 2, 3]] is not accepted: I_a: a number or a list with one for each channel, "
        "in [0, inf)",
    ),
    "a direction of no length": (
        edit("[lights.sun]", 'type = "Directional"', "direction = [0, 0, 0]"),
        "lights.sun.direction has length 0; any other length is allowed",
    ),
    "a camera that looks nowhere": (
        edit(position="position = [1, 2, 3]\ntarget = [1, 2, 3]"),
        "camera.target is where camera.position is; the camera looks nowhere",
    ),
    "a camera without an up": (
        edit(position="position = [1, 2, 3]\nup = [0, 0, 0]"),
        "camera.up has length 0; any other length is allowed",
    ),
    "a camera that looks along its up": (
        edit(position="position = [0, 0, 3]"),
        "camera.up is parallel to the view from camera.position to camera.target",
    ),
    "channels": (
        edit("sigma = [1, 2, 3, 4]", "[lights.sky]", 'type = "Ambient"', "intensity = [1, 2, 3]"),
        "objects.glass.surface.sigma has 4 channels and lights.sky.intensity has 3; a scene has one number of channels",
    ),
    "primitives": (
        edit(center="center = [[0, 0, 1], [2, 0, 1]]", eta="eta = [1.5, 1.4, 1.3]"),
        "objects.glass.shape.center has 2 primitives and objects.glass.surface.eta has 3; an object has one number",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", MISTAKES)
def test_a_mistake_is_one_line_with_file_path_value_and_what_is_allowed(kind):
    text, line = MISTAKES[kind]
    assert problems(text) == [f"s.toml: {line}"]


def test_a_file_without_objects_or_camera_says_so():
    lines = problems("[objects]\n")
    assert lines == [
        "s.toml: objects has 0 elements: objects by name, at least one, each: a table with shape and surface",
        "s.toml: camera is missing: what looks at the scene: a table of type Pinhole, Orthographic",
    ]


def test_every_mistake_of_a_file_is_told_at_once():
    text = edit(eta="eta = -1\nfoo = 2", center="center = 1", position="position = [0, 1]\nfov = 3")
    lines = problems(text + "\n[render]\nspp = 0\n")
    assert [line.split()[1] for line in lines] == [
        "objects.glass.shape.center", "objects.glass.surface.eta", "objects.glass.surface.foo", "camera.position",
        "camera.fov", "render.spp",
    ]  # fmt: skip
    assert all(line.startswith("s.toml: ") for line in lines)


@pytest.mark.parametrize(
    ("text", "place", "source"),
    [
        ("a = 1\n[objects\n", "line 2, column 9: ", ": [objects"),
        ("a 1", "line 1, column 3: ", ": a 1"),
        ("a = 1\na = 2\nb = 3", "line 2, column 6: ", ": a = 2"),
        ("a = 1\nb = [1,\n", "line 3, at the end: ", ""),
        (f"a = {'[' * 100_000}", "nested too deeply", ""),
    ],
)
def test_a_mistake_of_toml_names_the_line(text, place, source):
    (found,) = problems(text)
    assert found.startswith(f"s.toml: {place}")
    assert found.endswith(source)
    assert "(at" not in found


def test_a_file_that_cannot_be_read_is_one_plain_line(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"# caf\xe9\n")
    for name, reason in (
        ("nothing.toml", "cannot be read: No such file or directory"),
        (".", "cannot be read: Is a directory"),
        ("latin.toml", "not UTF-8 text: byte 5"),
    ):
        with pytest.raises(ValueError, match=r".") as caught:
            scene_file.load(tmp_path / name)
        assert str(caught.value) == f"{tmp_path / name}: {reason}"


def test_a_byte_order_mark_is_no_mistake(tmp_path):
    (tmp_path / "s.toml").write_text(MINIMAL, encoding="utf-8-sig")
    assert scene_file.load(tmp_path / "s.toml").name == str(tmp_path / "s.toml")


ANYTHING = st.recursive(
    st.none().map(lambda _: []) | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["type", "even", "k_d", "path", "base", "<number>", "", "x"]) | st.text(max_size=3),
            inner | st.sampled_from(["Checker", "Image", "Phong", "Sphere"]),
            max_size=4,
        )
    ),
    max_leaves=8,
)
PLACES = [
    ("objects",), ("lights",), ("camera",), ("background",), ("render",), ("objects", "glass"), ("lights", "a"),
    ("objects", "glass", "shape"), ("objects", "glass", "surface"), ("objects", "glass", "surface", "sigma"),
    ("objects", "glass", "surface", "type"), ("objects", "glass", "shape", "center"), ("camera", "up"), ("x",),
]  # fmt: skip


@given(place=st.sampled_from(PLACES), value=ANYTHING)
@settings(max_examples=150)
def test_whatever_stands_in_a_file_it_loads_or_is_a_list_of_problems(place, value):
    found = document()
    node = found
    for step in place[:-1]:
        node = node.setdefault(step, {})
    node[place[-1]] = value
    try:
        load(found)
    except ValueError as error:
        lines = str(error).split("\ns.toml: ")
        assert lines[0].startswith("s.toml: ")
        assert all(len(line) < 700 for line in lines)


# Settings


def test_a_setting_replaces_one_value_and_leaves_the_document_alone():
    before = document()
    kept = copy.deepcopy(before)
    after = scene_file.set_values(before, ["objects.glass.surface.eta=1.33", " render.width = 32 "])
    assert before == kept
    assert after["objects"]["glass"]["surface"] == {"type": "Dielectric", "eta": 1.33}
    assert after["render"] == {"width": 32}
    assert {**after, "render": 0, "objects": 0} == {**kept, "render": 0, "objects": 0}


def test_a_setting_may_give_a_value_that_the_file_leaves_at_its_default():
    loaded = scene_file.loads(MINIMAL, settings=["objects.glass.surface.sigma=[0.1, 0.2, 0.3]"])
    np.testing.assert_allclose(loaded.scene.objects["glass"].surface.sigma, [0.1, 0.2, 0.3], rtol=1e-6)


def test_a_setting_is_toml_or_else_a_string():
    changed = scene_file.set_values(document(), ["render.alpha=printed", 'camera.type="Orthographic"'])
    assert (changed["render"]["alpha"], changed["camera"]["type"]) == ("printed", "Orthographic")


def test_a_later_setting_wins():
    assert scene_file.loads(MINIMAL, settings=["render.spp=2", "render.spp=3"]).settings.spp == 3


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("objects.glas.surface.eta=1", "objects has no 'glas', it has glass"),
        ("objects.glass.surfaces.eta=1", "objects.glass has no 'surfaces', it has shape, surface"),
        ("objects.glass.surface.etaa=1", "objects.glass.surface has no 'etaa', it has type, eta, sigma"),
        ("object.glass=1", "the file has no 'object', it has objects, lights, background, camera, render"),
        ("lights.sun.shadows=true", "lights has no 'sun', it has nothing"),
        ("camera.fov=1", "camera has no 'fov', it has type, position, target, up, field_of_view_deg"),
        ("objects.glass.surface.eta.x=1", "objects.glass.surface.eta = 1.5 is not a table"),
        ("objects.glass.surface.eta", "write path=value, such as render.width=320"),
        ("=1", "write path=value, such as render.width=320"),
    ],
)  # fmt: skip
def test_a_setting_of_what_does_not_exist_is_answered_with_what_exists(setting, message):
    with pytest.raises(ValueError) as caught:
        scene_file.set_values(document(), [setting])
    assert str(caught.value) == f"setting = {setting!r}: {message}"


def test_a_setting_is_checked_as_the_file_is():
    assert problems(MINIMAL, settings=["objects.glass.surface.eta=-2"]) == [
        "s.toml: objects.glass.surface.eta = -2 is outside (0, inf)"
    ]


# Identity


def test_the_hash_is_that_of_what_is_seen():
    same = [MINIMAL, f"# a comment\n{MINIMAL}", f"{MINIMAL}\n[render]\nwidth = 3\n"]
    assert len({scene_file.loads(text).sha256 for text in same}) == 1
    changed = scene_file.loads(MINIMAL, settings=["objects.glass.surface.eta=1.6"])
    assert changed.sha256 != scene_file.loads(MINIMAL).sha256
    assert len(changed.sha256) == 64
    assert changed.sha256 == scene_file.loads(MINIMAL.replace("1.5", "1.6")).sha256


def test_another_picture_is_another_hash(maps):
    before = scene_file.load(maps / "s.toml").sha256
    write_picture(maps / "maps/a.png", [[[0, 128, 254], [255, 0, 0]]])
    assert scene_file.load(maps / "s.toml").sha256 != before


def test_the_source_is_kept(maps):
    assert scene_file.load(maps / "s.toml").source_text == PICTURE


# Writing


def same_scene(a, b):
    assert jax.tree.structure((a.scene, a.camera)) == jax.tree.structure((b.scene, b.camera))
    for x, y in zip(jax.tree.leaves((a.scene, a.camera)), jax.tree.leaves((b.scene, b.camera)), strict=True):
        np.testing.assert_array_equal(np.asarray(x, y.dtype), y)
    assert a.settings == b.settings


@pytest.mark.parametrize("name", SHIPPED)
def test_a_scene_that_is_written_and_read_is_the_same_bit_for_bit(name, float32):
    loaded = scene_file.load(scene_file.example(name))
    same_scene(loaded, scene_file.loads(scene_file.dumps(*loaded[1:4])))


@given(st.lists(st.floats(-(2.0**99), 2.0**99, width=32), min_size=3, max_size=3), st.floats(1.0, 179.0, width=32))
@settings(max_examples=30)
def test_a_number_that_is_written_and_read_is_the_same_bit_for_bit(numbers, angle):
    with jax.enable_x64(False):
        camera = catalog.CAMERAS["Pinhole"](
            Vec3(*map(np.float32, numbers)), field_of_view=np.radians(np.float32(angle))
        )
        table = tomllib.loads(write.document_text({"camera": write.table_of(camera, "camera", catalog.CAMERAS)}))
        assert [np.float32(x) for x in table["camera"]["position"]] == [np.float32(x) for x in numbers]
        assert np.float32(np.radians(table["camera"]["field_of_view_deg"])) == camera.field_of_view


@given(
    st.dictionaries(st.text(max_size=4), st.text(max_size=8) | st.booleans() | st.integers() | st.floats(), max_size=4)
)
def test_toml_that_is_written_is_read_as_what_it_was(table):
    np.testing.assert_equal(tomllib.loads(write.document_text({"t": table} if table else {"u": 1})).get("t", {}), table)


def test_what_a_file_has_no_name_for_is_not_written(maps):
    @dataclasses.dataclass(frozen=True)
    class Velvet:
        pass

    loaded = scene_file.loads(MINIMAL)
    item = dataclasses.replace(loaded.scene.objects["glass"], surface=Velvet())
    with pytest.raises(
        ValueError, match=r"objects.glass.surface is of type Velvet, which cannot be written.*Phong, Blend"
    ):
        scene_file.dumps(dataclasses.replace(loaded.scene, objects={"glass": item}), loaded.camera)
    picture = scene_file.load(maps / "s.toml")
    with pytest.raises(ValueError, match=r"objects.glass.surface.reflectivity is of type ImageTexture"):
        scene_file.dumps(picture.scene, picture.camera)


# The schema


@pytest.fixture(scope="module")
def validator():
    schema = json.loads(json.dumps(scene_file.json_schema()))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", [*SHIPPED, "starter"])
def test_the_schema_accepts_the_shipped_scenes(name, validator):
    text = scene_file.starter() if name == "starter" else scene_file.example(name).read_text()
    validator.validate(tomllib.loads(text))


def loads_without_problem(tables):
    try:
        load(tables)
    except ValueError:
        return False
    return True


@given(which=st.sampled_from(DECLARED), data=st.data())
@settings(max_examples=150)
def test_file_schema_and_declaration_agree_on_what_is_in_range(which, data, validator):
    group, name, declared = which
    low, high = declared.interval[:2]
    if declared.unit == "rad":
        low, high = round(math.degrees(low)), round(math.degrees(high))
    ends = [x for x in (low, high, 0.0, 1.0) if math.isfinite(x)]
    value = data.draw(st.sampled_from(ends) | st.floats(-4, 4) | st.floats(-200, 200, width=16) | st.integers(-3, 3))
    interval = Interval(low, high, *declared.interval[2:])
    inside = (value > low if interval.low_open else value >= low) and (
        value < high if interval.high_open else value <= high
    )
    if inside and 0 < abs(value) < 1e-30:
        return  # in range, and 0 as a float32
    tables = document_with(group, name, **{key_of(declared): value})
    assert validator.is_valid(tables) == inside
    assert loads_without_problem(tables) == inside


def test_the_schema_shows_the_declared_ranges_defaults_units_and_meanings():
    definitions = scene_file.json_schema()["$defs"]
    for _, name, declared in DECLARED:
        shown = definitions[name]["properties"][key_of(declared)]
        number = next(form for form in shown.get("oneOf", [shown]) if form.get("type") == "number")
        if declared.unit != "rad":
            low = number.get("exclusiveMinimum" if declared.interval.low_open else "minimum", -math.inf)
            high = number.get("exclusiveMaximum" if declared.interval.high_open else "maximum", math.inf)
            assert (low, high) == declared.interval[:2], (name, declared.name)
            assert declared.unit in shown["description"]
        assert shown["description"].startswith(declared.doc)
        if isinstance(declared.default, float) and declared.unit != "rad":
            assert shown["default"] == declared.default
    assert definitions["Pinhole"]["properties"]["field_of_view_deg"]["default"] == pytest.approx(40.107, abs=1e-3)


def test_a_key_without_default_is_required_by_the_schema():
    definitions = scene_file.json_schema()["$defs"]
    assert set(definitions["Spot"]["required"]) == {"type", "position", "direction"}
    assert definitions["Dielectric"]["required"] == ["type"]


# What ships


def test_the_examples_are_listed_and_found_by_name(tmp_path):
    assert scene_file.examples() == list(SHIPPED)
    assert scene_file.find("jhu") == scene_file.example("jhu")
    with pytest.raises(
        ValueError, match="name = 'cornell' is not a shipped scene; there are d3d9, fresnel, jhu, perrin"
    ):
        scene_file.example("cornell")
    with pytest.raises(ValueError, match="scene = 'cornell' is no file and no shipped scene; there are d3d9, fresnel"):
        scene_file.find("cornell")


def test_a_file_wins_over_a_shipped_scene_of_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "jhu").write_text(MINIMAL)
    assert scene_file.load(scene_file.find("jhu")).channels == 1


def types_of(node):
    if isinstance(node, dict):
        return {node.get("type", "")} | {kind for value in node.values() for kind in types_of(value)}
    return set()


@pytest.mark.parametrize(
    ("name", "there", "absent"),
    [
        ("perrin", {"Blend", "Checker"}, {"Whitted", "D3D9", "Dielectric", "Conductor", "Coat"}),
        ("jhu", {"Phong", "Whitted", "Ambient", "Point", "Directional", "Spot"}, {"Blend", "D3D9", "Dielectric"}),
        ("d3d9", {"D3D9", "Checker"}, {"Blend", "Whitted", "Dielectric", "Conductor", "Coat"}),
        ("fresnel", {"Dielectric", "Conductor", "Coat", "Checker"}, {"Blend", "Whitted", "D3D9"}),
    ],
)
def test_each_shipped_scene_shows_the_models_of_its_document(name, there, absent):
    text = scene_file.example(name).read_text()
    kinds = types_of(tomllib.loads(text))
    assert there <= kinds
    assert not absent & kinds
    assert {"perrin": "PERRIN", "jhu": "JHU", "d3d9": "D3D9", "fresnel": "LAMBERT-FRESNEL"}[name] in text.splitlines()[
        0
    ]


def test_the_scene_of_perrin_only_blends():
    surfaces = [item.surface for item in scene_file.load(scene_file.example("perrin")).scene.objects.values()]
    assert max(float(np.max(s.reflectivity)) for s in surfaces if hasattr(s, "reflectivity")) == 1.0


def test_the_scene_of_jhu_has_a_red_sphere_with_a_white_highlight_and_a_transparent_one():
    objects = scene_file.load(scene_file.example("jhu")).scene.objects
    red = objects["red"].surface
    assert red.k_d[0] > 10 * red.k_d[1]
    assert np.ndim(red.k_s) == 0
    glass = objects["glass"].surface
    assert (float(glass.k_tg), float(glass.eta)) == pytest.approx((0.85, 1.5))


def test_the_scene_of_d3d9_has_coverage_below_one_and_both_forms_of_the_equation():
    objects = scene_file.load(scene_file.example("d3d9")).scene.objects
    assert {item.surface.sun_fresnel for item in objects.values()} == {False, True}
    assert float(objects["canopy"].surface.alpha.even) < 1
    np.testing.assert_array_equal(objects["lacquer"].surface.p, [2.0, 4.0])  # the curves of Figure 1


def test_the_metals_of_the_scene_of_fresnel_are_those_of_the_shipped_table():
    objects = scene_file.load(scene_file.example("fresnel")).scene.objects
    for name in ("gold", "copper", "aluminium"):
        rows = sorted((r for r in read_table("metals") if r["metal"] == name), key=lambda r: -float(r["wavelength_nm"]))
        np.testing.assert_allclose(objects[name].surface.eta, [float(row["n"]) for row in rows], rtol=1e-6)
        np.testing.assert_allclose(objects[name].surface.k, [float(row["k"]) for row in rows], rtol=1e-6)
    assert float(objects["glass"].surface.eta) == 1.5


def test_the_starter_loads_and_lists_every_key_of_every_model():
    text = scene_file.starter()
    loaded = scene_file.loads(text)
    assert loaded.channels == 3
    reference = text[text.index("# Every model") :]
    for group, name, declared in DECLARED:
        lines = reference[reference.index(f"# {group} {name}\n") :].splitlines()[1:]
        mine = list(itertools.takewhile(lambda line: line.startswith("#    "), lines))
        assert sum(line.split()[1] == key_of(declared) for line in mine) == 1
    assert all(line.startswith("#") for line in reference.splitlines())


def test_importing_the_package_loads_neither_pydantic_nor_the_scene_files(tmp_path):
    script = (
        "import sys, jaxrefl; print(*sorted({'pydantic', 'imageio', 'PIL', 'jaxrefl.scene_file'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr


def test_any_reflection_model_can_be_the_surface_of_an_object():
    text = scene_file.starter()
    document = tomllib.loads(text)
    name = next(iter(document["objects"]))
    document["objects"][name]["surface"] = {"type": "BRDF", "brdf": {"type": "EON", "rho": [0.8, 0.5, 0.2]}}
    loaded = scene_file.loads(write.document_text(document))
    brdf = loaded.scene.objects[name].surface.brdf
    assert type(brdf) is EON
    np.testing.assert_allclose(np.ravel(brdf.rho), [0.8, 0.5, 0.2], rtol=1e-6)
    again = scene_file.loads(scene_file.dumps(loaded.scene, loaded.camera, loaded.settings))
    assert jax.tree.structure(again.scene) == jax.tree.structure(loaded.scene)
    with pytest.raises(ValueError, match=r"surface.brdf.roughness = 1.5 is outside \[0, 1\]"):
        scene_file.loads(write.document_text(document), settings=[f"objects.{name}.surface.brdf.roughness=1.5"])
