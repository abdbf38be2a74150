"""Pictures written and read: the curve of sRGB, coverage, the three formats, metadata, and textures."""

import subprocess
import sys
from typing import Any, NamedTuple

import imageio.v3 as iio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pillow

import jaxrefl
from jaxrefl import image

# Linear values of sRGB codes n / 255, from IEC 61966-2-1 with 40 digits
CODES = {0: 0.0, 10: 0.0030352698354883752, 11: 0.0033465357638991609, 128: 0.21586050011389926, 255: 1.0}


class Parts(NamedTuple):
    """A record in a record."""

    shaded: Any
    escaped: Any


class Picture(NamedTuple):
    """What a render returns."""

    radiance: Any
    alpha: Any
    depth: Any
    normal: Any
    primitive: Any
    budget: Any


def picture(channels=3, seed=0):
    random = np.random.default_rng(seed)
    shape = (3, 4)
    depth = random.uniform(1, 9, shape).astype(np.float32)
    depth[0, 0] = np.inf
    return Picture(
        random.uniform(0, 2, (*shape, channels)).astype(np.float32),
        random.uniform(0, 1, shape).astype(np.float32),
        depth,
        random.uniform(-1, 1, (*shape, 3)).astype(np.float32),
        random.integers(-1, 5, shape).astype(np.int32),
        Parts(random.uniform(0, 1, (*shape, channels)), random.uniform(0, 1, (*shape, channels))),
    )


def constant(value, alpha=1.0, channels=3):
    return picture(channels)._replace(
        radiance=np.full((3, 4, channels), value, np.float32), alpha=np.full((3, 4), alpha, np.float32)
    )


def pixels_of(path):
    with Pillow.open(path) as file:
        return file.mode, np.asarray(file)


# The curve


@pytest.mark.parametrize("code", CODES)
def test_a_code_is_the_linear_value_of_the_standard(code):
    assert float(image.decode_srgb(code / 255)) == pytest.approx(CODES[code], rel=1e-14)
    assert float(image.encode_srgb(CODES[code])) * 255 == pytest.approx(code, abs=2e-5)


@given(st.floats(0, 1))
def test_encoding_undoes_decoding(code):
    assert float(image.encode_srgb(image.decode_srgb(code))) == pytest.approx(code, abs=1e-7)


@given(st.floats(0, 1), st.floats(0, 1))
def test_the_curve_never_falls(a, b):
    low, high = sorted((a, b))
    assert image.encode_srgb(low) <= image.encode_srgb(high) + 1e-8  # the standard's two pieces meet to 1e-8


def test_what_cannot_be_shown_is_black_or_white():
    np.testing.assert_allclose(image.encode_srgb([-1.0, 7.0, np.nan, np.inf, -np.inf]), [0, 1, 0, 1, 0], rtol=1e-15)


# PNG


def test_every_8_bit_code_comes_back(tmp_path):
    codes = np.arange(256).reshape(16, 16, 1)
    shown = picture()._replace(radiance=np.repeat(image.decode_srgb(codes / 255), 3, axis=-1))
    image.write(tmp_path / "a.png", shown)
    mode, found = pixels_of(tmp_path / "a.png")
    assert mode == "RGB"
    np.testing.assert_array_equal(found, np.repeat(codes, 3, axis=-1))


def test_one_stop_doubles_the_light(tmp_path):
    for stops, value in ((0, 0.5), (1, 0.25), (-2, 2.0)):
        image.write(tmp_path / f"{stops}.png", constant(value), exposure=stops)
        assert set(pixels_of(tmp_path / f"{stops}.png")[1].flat) == {188}  # IEC 61966-2-1: 0.735357 * 255


def test_one_channel_is_grey(tmp_path):
    image.write(tmp_path / "a.png", constant(0.5, channels=1))
    mode, found = pixels_of(tmp_path / "a.png")
    assert (mode, found.shape) == ("L", (3, 4))


@pytest.mark.parametrize(("channels", "mode"), [(1, "LA"), (3, "RGBA")])
def test_coverage_is_the_last_channel_and_linear(tmp_path, channels, mode):
    image.write(tmp_path / "a.png", constant(0.25, 0.5, channels), transparent=True)
    found_mode, found = pixels_of(tmp_path / "a.png")
    assert found_mode == mode
    assert set(found[..., -1].flat) == {128}
    assert set(found[..., :-1].flat) == {188}  # 0.25 / 0.5


@given(st.floats(0, 1), st.floats(0.05, 1))
def test_a_premultiplied_picture_over_black_is_the_picture(color, alpha):
    shown = color * alpha
    codes = image.to_bytes(np.full((1, 1, 3), shown), 0.0, np.full((1, 1), alpha))[0, 0] / 255
    over_black = image.decode_srgb(codes[:3]) * codes[3]
    np.testing.assert_allclose(over_black, shown, atol=0.006)


def test_a_straight_picture_keeps_its_colour(tmp_path):
    image.write(tmp_path / "a.png", constant(0.5, 0.25), transparent=True, straight=True)
    assert pixels_of(tmp_path / "a.png")[1][0, 0].tolist() == [188, 188, 188, 64]


def test_what_is_not_covered_is_transparent_black(tmp_path):
    image.write(tmp_path / "a.png", constant(0.5, 0.0), transparent=True)
    assert not pixels_of(tmp_path / "a.png")[1].any()


def test_a_coverage_beyond_one_is_one():
    codes = image.to_bytes(np.full((1, 1, 3), 0.5), 0.0, np.full((1, 1), 1.7), straight=True)
    assert codes[0, 0].tolist() == [188, 188, 188, 255]


@pytest.mark.parametrize("channels", [2, 4, 31])
def test_a_png_of_a_spectrum_is_refused(tmp_path, channels):
    with pytest.raises(ValueError, match=rf"radiance has shape \(3, 4, {channels}\); a PNG has 1 or 3 channels"):
        image.write(tmp_path / "a.png", constant(0.5, channels=channels))
    with pytest.raises(ValueError, match=rf"a PNG has 1 or 3 channels, not {channels}; write EXR or NPZ"):
        image.format_of(tmp_path / "a.png", channels)
    assert not list(tmp_path.iterdir())


def test_equal_pictures_are_equal_files(tmp_path):
    for kind in image.FORMATS:
        for name in ("one", "two"):
            image.write(tmp_path / f"{name}.{kind}", picture(), metadata={"set": ["a=1"]})
        assert (tmp_path / f"one.{kind}").read_bytes() == (tmp_path / f"two.{kind}").read_bytes()


# EXR and NPZ


def channels_of(path):
    exr = pytest.importorskip("OpenEXR")
    with exr.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def test_an_exr_holds_radiance_coverage_depth_and_normal_as_they_are(tmp_path):
    written = picture()
    image.write(tmp_path / "a.exr", written)
    found = channels_of(tmp_path / "a.exr")
    assert set(found) == {"R", "G", "B", "A", "Z", "normal.X", "normal.Y", "normal.Z"}
    for i, name in enumerate("RGB"):
        np.testing.assert_array_equal(found[name], written.radiance[..., i])
    for i, name in enumerate("XYZ"):
        np.testing.assert_array_equal(found[f"normal.{name}"], written.normal[..., i])
    np.testing.assert_array_equal(found["A"], written.alpha)
    np.testing.assert_array_equal(found["Z"], written.depth)
    assert np.isinf(found["Z"][0, 0])
    assert {values.dtype for values in found.values()} == {np.dtype(np.float32)}


def test_half_floats_are_half_the_size_and_the_depth_stays(tmp_path):
    written = picture()._replace(radiance=np.full((3, 4, 3), 1e6, np.float32))
    image.write(tmp_path / "a.exr", written, half=True)
    found = channels_of(tmp_path / "a.exr")
    assert {name for name, values in found.items() if values.dtype == np.float32} == {"Z"}
    np.testing.assert_array_equal(found["Z"], written.depth)
    assert set(found["R"].flat) == {np.float16(65504)}  # the largest one, not infinity
    np.testing.assert_allclose(found["normal.X"], written.normal[..., 0], atol=5e-4)


@pytest.mark.parametrize(("channels", "names"), [(1, {"Y"}), (2, {"radiance.000", "radiance.001"})])
def test_an_exr_has_as_many_channels_as_the_picture(tmp_path, channels, names):
    image.write(tmp_path / "a.exr", picture(channels))
    found = channels_of(tmp_path / "a.exr")
    assert set(found) - {"A", "Z", "normal.X", "normal.Y", "normal.Z"} == names


def test_an_npz_holds_every_array_bit_for_bit(tmp_path):
    written = picture(5)
    image.write(tmp_path / "a.npz", written)
    with np.load(tmp_path / "a.npz") as found:
        assert set(found) == {
            "radiance", "alpha", "depth", "normal", "primitive", "budget.shaded", "budget.escaped", "jaxrefl",
        }  # fmt: skip
        for name in ("radiance", "alpha", "depth", "normal", "primitive"):
            assert found[name].dtype == getattr(written, name).dtype
            np.testing.assert_array_equal(found[name], getattr(written, name))
        np.testing.assert_array_equal(found["budget.shaded"], written.budget.shaded)


# Metadata


@pytest.mark.parametrize("kind", image.FORMATS)
def test_what_made_a_file_is_read_back_from_it(tmp_path, kind):
    facts = {"scene_sha256": "0" * 64, "settings": {"width": 4, "exposure": 0.5}, "set": ["objects.é.x=[1, 2]"]}
    image.write(tmp_path / f"a.{kind}", picture(), exposure=0.5, metadata=facts)
    found = image.read_metadata(tmp_path / f"a.{kind}")
    assert found.pop("version") == jaxrefl.__version__
    assert found.pop("exposure", 0.5) == 0.5
    assert found.pop("gamut", "clip") == "clip"
    assert found == facts


def test_a_png_says_that_it_is_srgb_and_who_wrote_it(tmp_path):
    image.write(tmp_path / "a.png", picture())
    with Pillow.open(tmp_path / "a.png") as file:
        assert file.info["Software"] == f"jaxrefl {jaxrefl.__version__}"
        assert file.info["srgb"] == 0


# Complete or not there


def test_an_interrupted_file_is_not_there(tmp_path, monkeypatch):
    def half(path, *_, **__):
        path.write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(iio, "imwrite", half)
    with pytest.raises(KeyboardInterrupt):
        image.write(tmp_path / "a.png", picture())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", image.FORMATS)
def test_a_file_that_fails_leaves_the_one_before(tmp_path, kind, monkeypatch):
    path = tmp_path / f"a.{kind}"
    image.write(path, picture())
    before = path.read_bytes()

    def fail(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(iio, "imwrite", fail)
    monkeypatch.setattr(np, "savez_compressed", fail)
    monkeypatch.setattr(image.openexr(), "File", fail)
    with pytest.raises(OSError, match="disk full"):
        image.write(path, picture(seed=1))
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a.jpg", "a", "png"])
def test_another_suffix_is_answered_with_those_there_are(tmp_path, name):
    with pytest.raises(ValueError, match=rf"{name}' must end in .png, .exr, .npz"):
        image.write(tmp_path / name, picture())


def test_a_missing_package_is_one_sentence_that_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(ValueError) as caught:
        image.write(tmp_path / "a.exr", picture())
    assert str(caught.value) == 'EXR files need the package OpenEXR: pip install "jaxrefl[image]"'
    with pytest.raises(ValueError, match="pip install"):
        image.format_of(tmp_path / "a.exr")
    image.write(tmp_path / "a.png", picture())


# Textures


def texture(tmp_path, pixels, name="t.png", mode=None):
    made = Pillow.fromarray(np.asarray(pixels))
    (made.convert(mode) if mode else made).save(tmp_path / name)
    return image.read_texture(tmp_path / name)


def test_a_texture_is_linear_float32(tmp_path):
    found = texture(tmp_path, np.array([[[0, 10, 11], [128, 255, 0]]], np.uint8))
    assert (found.dtype, found.shape) == (np.float32, (1, 2, 3))
    expected = [[[CODES[0], CODES[10], CODES[11]], [CODES[128], CODES[255], 0]]]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_numbers_of_a_linear_texture_are_taken_as_they_are(tmp_path):
    texture(tmp_path, np.array([[0, 51, 255]], np.uint8))
    np.testing.assert_allclose(image.read_texture(tmp_path / "t.png", "linear")[0, :, 0], [0, 0.2, 1], rtol=1e-6)


def test_the_transparency_of_a_texture_is_left_out(tmp_path):
    assert texture(tmp_path, np.full((2, 2, 4), 255, np.uint8)).shape == (2, 2, 3)
    assert texture(tmp_path, np.full((2, 2), 255, np.uint8), mode="LA").shape == (2, 2, 1)


def test_a_texture_may_have_a_palette_sixteen_bits_or_one(tmp_path):
    assert texture(tmp_path, np.full((2, 2, 3), 255, np.uint8), mode="P").tolist() == [[[1.0] * 3] * 2] * 2
    assert texture(tmp_path, np.full((2, 2), 65535, np.uint16)).tolist() == [[[1.0]] * 2] * 2
    assert texture(tmp_path, np.full((2, 2), 255, np.uint8), mode="1").tolist() == [[[1.0]] * 2] * 2


def test_a_texture_of_sixteen_bits_has_them(tmp_path):
    texture(tmp_path, np.array([[1, 257]], np.uint16))
    np.testing.assert_allclose(
        image.read_texture(tmp_path / "t.png", "linear")[0, :, 0], [1 / 65535, 1 / 255], rtol=1e-6
    )


def test_a_jpeg_is_a_texture_too(tmp_path):
    found = texture(tmp_path, np.full((8, 8, 3), 128, np.uint8), "t.jpg")
    np.testing.assert_allclose(found, CODES[128], atol=0.02)


def test_a_picture_that_was_rendered_is_a_texture(tmp_path):
    for channels in (1, 3):
        written = picture(channels)
        image.write(tmp_path / "t.exr", written)
        np.testing.assert_array_equal(image.read_texture(tmp_path / "t.exr"), written.radiance)


def test_an_exr_without_colour_is_no_texture(tmp_path):
    image.write(tmp_path / "t.exr", picture(2))
    with pytest.raises(ValueError, match=r"it has the channels .*radiance\.000.* and neither Y nor R, G, B"):
        image.read_texture(tmp_path / "t.exr")


@pytest.mark.parametrize(("name", "message"), [("t.png", "it is no picture"), ("t.exr", "it is no EXR file")])
def test_what_is_no_picture_is_said_to_be_none(tmp_path, name, message):
    (tmp_path / name).write_text("hello")
    with pytest.raises(ValueError, match=message):
        image.read_texture(tmp_path / name)


def test_a_texture_that_is_not_there_or_of_no_colour_space_is_refused(tmp_path):
    with pytest.raises(ValueError, match="there is no such file"):
        image.read_texture(tmp_path / "t.png")
    with pytest.raises(ValueError, match="colorspace = 'rec2020' must be sRGB or linear"):
        image.read_texture(tmp_path / "t.png", "rec2020")


def test_importing_the_module_loads_none_of_its_libraries(tmp_path):
    script = "import sys, jaxrefl.image; print(*sorted({'imageio', 'PIL', 'OpenEXR'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr


def test_a_colour_that_no_screen_shows_is_brought_into_the_gamut_by_the_named_method(tmp_path):
    gold = np.broadcast_to(np.array([1.059, 0.773, 0.307]), (2, 2, 3))
    grey = 0.2126390058715103 * 1.059 + 0.7151686787677560 * 0.773 + 0.0721923153607337 * 0.307
    shares = (1 - grey) / (1.059 - grey)
    for method, shown in (("clip", [1, 0.773, 0.307]), ("desaturate", grey + shares * (gold[0, 0] - grey))):
        codes = image.to_bytes(gold, gamut=method)[0, 0]
        np.testing.assert_array_equal(codes, np.rint(image.encode_srgb(np.array(shown)) * 255))
        image.write(tmp_path / "gold.png", constant(0.5), gamut=method)
        assert image.read_metadata(tmp_path / "gold.png")["gamut"] == method
    with pytest.raises(ValueError, match="gamut = 'wide' must be one of desaturate, clip"):
        image.to_bytes(gold, gamut="wide")
