"""Pictures by wavelength: against the renderer itself, one wavelength at a time, closed forms, and the rainbow."""

from pathlib import Path

import jax
import jax.numpy as jnp
import mpmath as mp
import numpy as np
import pytest
from oracle_table import BLOCKS

from jaxrefl import colour, films, fresnel, spectral
from jaxrefl.camera import Orthographic, Pinhole
from jaxrefl.dispersion import Sellmeier
from jaxrefl.geometry import Plane, Sphere
from jaxrefl.image import openexr, read_metadata, write_exr, write_npz, write_png
from jaxrefl.light import Directional
from jaxrefl.materials import material
from jaxrefl.render import render
from jaxrefl.scene import Object, Scene
from jaxrefl.spectral import (
    deflection,
    family,
    rainbow,
    render_spectral,
    spectral_scene,
)
from jaxrefl.surface import Blend, Conductor, Dielectric, Phong, ThinFilm
from jaxrefl.texture import Checker
from jaxrefl.vec import Vec3

pytestmark = pytest.mark.usefixtures("quick_compilation")
WAVES = np.array([450.0, 560.0, 700.0])
ABOVE = Pinhole(Vec3(0.0, -4.0, 3.0), Vec3(0.0, 0.0, 0.5))
OVER = Orthographic(Vec3(0.1, 0.1, 5.0), Vec3(0.1, 0.1, 0.0), Vec3(0.0, 1.0, 0.0), 0.3)
GLASS = Sellmeier(b=[1.2], c=[0.015])


def room(ball, wavelength_nm):
    shown = Checker(wavelength_nm / 1000, 0.1)
    floor = Object(Plane(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)), Phong(k_d=shown))
    lights = {"sun": Directional(Vec3(1.0, 1.0, -2.0), diffuse=1e-6 * wavelength_nm**2)}
    return Scene({"ball": Object(Sphere(Vec3(0.0, 0.0, 1.0), 1.0), ball), "floor": floor}, lights, 350 / wavelength_nm)


def gold(wavelength_nm):
    n, k = material("Au")(wavelength_nm)
    return room(Conductor(n, k), wavelength_nm)


def glass(wavelength_nm):
    return room(Dielectric(GLASS(wavelength_nm).n), wavelength_nm)


@pytest.mark.parametrize("build", [gold, glass])
def test_a_picture_by_wavelength_is_that_of_each_wavelength_alone(build, monkeypatch):
    monkeypatch.setattr(spectral.render, "CHUNK", 2)  # the last chunk is filled up
    seen = []
    image = render_spectral(
        build, ABOVE, WAVES, 12, 9, 3, spp=2, progress=lambda done, all_of_it, _: seen.append(done / all_of_it)
    )
    assert seen == ([0.5, 1.0] if build is gold else [2 / 3, 1.0])
    alone = [render(build(w), ABOVE, 12, 9, 3, spp=2) for w in WAVES]
    assert image.radiance.shape == (9, 12, 3)
    for i, one in enumerate(alone):
        np.testing.assert_allclose(image.radiance[..., i], one.radiance[..., 0], rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(image.primitive, alone[0].primitive)
    np.testing.assert_array_equal(image.depth, alone[0].depth)
    np.testing.assert_allclose(image.alpha, np.mean([one.alpha for one in alone], axis=0), rtol=1e-12)
    assert np.abs(np.diff(image.radiance, axis=-1)).max() > 0.1


def test_what_depends_on_the_wavelength_is_found_and_named():
    assert family(gold, WAVES).dispersing == ()
    assert sum(family(gold, WAVES).varying) == 5  # n, k, one colour of the board, the sun, the background
    assert family(glass, WAVES).dispersing == ("objects.ball.surface.eta",)
    with pytest.raises(ValueError, match=r"objects\.ball\.surface\.eta depends on the wavelength"):
        spectral_scene(glass, WAVES)

    assert family(jax.jit(glass), WAVES).dispersing == ("objects.ball.surface.eta",)
    assert family(jax.jit(gold), WAVES).varying == family(gold, WAVES).varying

    def growing(wavelength_nm):
        wall = Object(Sphere(Vec3(0.0, 0.0, wavelength_nm), wavelength_nm / 9), Phong())
        return Scene({"wall": wall}, {"sun": Directional(Vec3(wavelength_nm, 0.0, -1.0))})

    named = ("lights.sun.direction", "objects.wall.shape.center", "objects.wall.shape.radius")
    assert family(growing, WAVES).dispersing == named
    assert family(lambda w: Scene({"ball": Object(Sphere(Vec3(0, 0, 1)), Phong())}), WAVES).dispersing == ()


def test_spectra_of_many_primitives_keep_their_places():
    def build(wavelength_nm):
        tints = jnp.array([[0.1], [0.2], [0.3]]) * wavelength_nm / 500
        return Scene({"balls": Object(Sphere(Vec3(0.0, 0.0, jnp.arange(3.0)), 0.5), Phong(k_d=tints))})

    scene = spectral_scene(build, [500.0, 1000.0])
    np.testing.assert_allclose(scene.objects["balls"].surface.k_d, [[0.1, 0.2], [0.2, 0.4], [0.3, 0.6]], rtol=1e-14)


def test_bad_wavelengths_are_refused():
    for bad, message in (
        (550.0, r"shape \(\)"),
        ([], r"shape \(0,\)"),
        ([500.0, 400.0], "ascending"),
        ([0.0, 500.0], r"wavelength_nm = .*\(0, inf\)"),
        ([100.0, 500.0], r"outside \[203.3, 1937.*Au \(Johnson\)"),
        ([500.0, 9000.0], r"outside \[203.3, 1937.*Au \(Johnson\)"),
    ):
        with pytest.raises(ValueError, match=message):
            render_spectral(gold, ABOVE, bad, 4, 4, 1)
    with pytest.raises(ValueError, match="width = 0"):
        render_spectral(glass, ABOVE, WAVES, 0, 4, 1)
    with pytest.raises(ValueError, match=r"objects\.ball\.surface\.eta = -0.33.*\(0, inf\)"):
        render_spectral(lambda w: room(Dielectric(2 - w / 300), w), ABOVE, WAVES, 4, 4, 1)
    with pytest.raises(ValueError, match="wavelength_nm is traced"):
        jax.jit(lambda w: family(gold, w))(WAVES)
    for colour_of_three in ([0.1, 0.5, 0.9], np.array([0.1, 0.5, 0.9]), np.full((2, 3), 0.5)):
        for ball in (Phong(k_d=colour_of_three), Conductor(colour_of_three, 2.0)):
            with pytest.raises(ValueError, match=r"objects.ball.surface.(k_d|eta) has 3 channels; .* has 1"):
                family(lambda w, ball=ball: room(ball, w), WAVES)


def test_one_render_serves_every_light():
    white = render_spectral(lambda w: Scene({"d": disc(Phong(emission=1.0))}), FRONT, np.arange(400, 701, 20), 2, 2, 0)
    for light in ("D65", "A", "FL11"):
        np.testing.assert_allclose(white.rgb(light).radiance, 1.0, rtol=1e-12)
        assert np.allclose(white.xyz(light).radiance[..., 1], 1.0)
    waves = np.arange(380.0, 781.0, 5)
    image = render_spectral(lambda w: Scene({"d": disc(mirror(w))}, background=1.0), FRONT, waves, 2, 2, 1)
    exact = colour.spectrum_to_rgb(fresnel.conductor(1.0, *material("Cu")(waves)), waves, "A")
    np.testing.assert_allclose(image.rgb("A").radiance, np.broadcast_to(exact, (2, 2, 3)), rtol=1e-12)


FRONT = Orthographic(Vec3(0.0, 0.0, 5.0), Vec3(0.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), 1.0)


def disc(surface):
    return Object(Plane(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0)), surface)


def mirror(wavelength_nm):
    return Conductor(*material("Cu")(wavelength_nm))


def test_a_film_is_seen_with_its_interference_at_every_angle():
    waves, cos = np.array([450.0, 600.0]), np.cos(np.deg2rad(35.0))

    def build(wavelength_nm):
        n, k = material("Ti")(wavelength_nm)
        return Scene({"pane": disc(ThinFilm(70.0 / wavelength_nm, 2.3, 0.01, n, k))}, background=1.0)

    tilted = Orthographic(Vec3(3.0, 0.0, 3.0 / np.tan(np.deg2rad(35.0))), Vec3(0.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), 1.0)
    image = render_spectral(build, tilted, waves, 2, 2, 1)
    exact = films.film(cos, waves, 2.3 * jnp.ones(1), 0.01, 70.0, inside=material("Ti")(waves)).R
    np.testing.assert_allclose(image.radiance, np.broadcast_to(exact, (2, 2, 2)), rtol=1e-12)
    assert abs(exact[0] - exact[1]) > 0.1


def test_a_film_is_moved_toward_a_colour_by_a_jitted_slope():
    def loss(thickness):
        def build(wavelength_nm):
            return Scene({"pane": disc(ThinFilm(thickness / wavelength_nm, 2.3, 0.0, 2.0, 3.0))}, background=1.0)

        return jnp.sum((render_spectral(build, FRONT, WAVES, 1, 1, 1).rgb().radiance - 0.3) ** 2)

    def exact(thickness):
        seen = films.film(1.0, WAVES, jnp.full(1, 2.3), 0.0, thickness[None], inside=(2.0, 3.0)).R
        return jnp.sum((colour.spectrum_to_rgb(seen, WAVES) - 0.3) ** 2)

    slope = jax.jit(lambda t: jax.jvp(loss, (t,), (1.0,))[1])(60.0)
    np.testing.assert_allclose(slope, jax.grad(exact)(jnp.asarray(60.0)), rtol=1e-11)
    assert abs(slope) > 1e-4


def test_a_picture_by_wavelength_is_differentiable_in_what_build_closes_over():
    def mean(b):
        def build(wavelength_nm):
            return room(Dielectric(Sellmeier(b=[b], c=[0.015])(wavelength_nm).n), wavelength_nm / wavelength_nm * 500)

        return jnp.mean(render_spectral(build, OVER, WAVES[:2], 3, 3, 1).radiance)

    h = 1e-3
    f = [jax.jvp(mean, (1.2 + i * h,), (1.0,)) for i in (-2, -1, 0, 1, 2)]
    np.testing.assert_allclose(f[2][1], (f[0][0] - 8 * f[1][0] + 8 * f[3][0] - f[4][0]) / (12 * h), rtol=1e-7)
    assert abs(f[2][1]) > 1e-3


def test_the_cube_is_written_as_npz_spectral_exr_and_png(tmp_path):
    image = render_spectral(gold, ABOVE, WAVES, 6, 4, 1)
    write_npz(tmp_path / "cube.npz", image, metadata={"light": "D65"})
    with np.load(tmp_path / "cube.npz") as arrays:
        np.testing.assert_array_equal(arrays["radiance"], image.radiance)
        np.testing.assert_array_equal(arrays["wavelength_nm"], WAVES)
    write_exr(tmp_path / "cube.exr", image, metadata={"light": "D65"})
    assert read_metadata(tmp_path / "cube.exr")["light"] == "D65"
    with openexr().File(str(tmp_path / "cube.exr"), separate_channels=True) as file:
        assert file.header()["spectralLayoutVersion"] == "1.0"
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    for i, name in enumerate(("S0.450,000000nm", "S0.560,000000nm", "S0.700,000000nm")):
        np.testing.assert_array_equal(channels[name], np.asarray(image.radiance[..., i], np.float32))
    write_png(tmp_path / "shown.png", image.rgb("A"))
    assert Path(tmp_path / "shown.png").stat().st_size > 100
    with pytest.raises(ValueError, match=r"a picture by wavelength is no PNG; write image.rgb\(\)"):
        write_png(tmp_path / "cube.png", image)


def bow(n, reflections):
    """Radius of a bow in degrees, by Descartes: cos^2 i = (n^2 - 1) / (k (k + 2)), D = 2 (i - r) + k (pi - 2 r)."""
    n, k = mp.mpf(float(n)), reflections
    i = mp.acos(mp.sqrt((n * n - 1) / (k * (k + 2))))
    turn = 2 * (i - mp.asin(mp.sin(i) / n)) + k * (mp.pi - 2 * mp.asin(mp.sin(i) / n))
    return float(mp.degrees(abs(turn - mp.pi)))


def test_the_rainbow_of_traced_rays_is_that_of_descartes_and_moves_with_the_index_as_the_envelope_says():
    eta = jnp.append(material("water")(jnp.array([400.0, 700.0])).n, jnp.array([1.333, 1.5, 1.0001, 1.99]))
    table, tags = BLOCKS["I.rainbow"], {row[0]: row for row in BLOCKS["I.rainbow"]["rows"]}
    for k, radii in ((1, (40.5674230125941, 42.4404774652824)), (2, (53.619797161331, 50.2379123927179))):
        bows, slopes = jax.vmap(jax.value_and_grad(lambda n, k=k: rainbow(n, k).radius))(eta)
        radius = np.rad2deg(bows)
        np.testing.assert_allclose(radius, [bow(n, k) for n in eta], rtol=0, atol=1e-11)
        np.testing.assert_allclose(radius[:2], radii, rtol=0, atol=1e-11)  # water of 20 degrees C, 400 and 700 nm
        column = table["fields"].index(f"radius{k}_deg")
        np.testing.assert_allclose(radius[2:4], [float(tags[t][column]) for t in ("n=1.333", "n=1.5")], atol=1e-11)
        slope = BLOCKS["I.derivatives"]["values"][f"drainbow{k}_dn"]
        np.testing.assert_allclose(slopes[2], float(slope), rtol=1e-12)


def test_a_drop_turns_rays_as_the_angles_say():
    impact, n = np.linspace(0.05, 0.98, 40), 1.34
    i, r = np.arcsin(impact), np.arcsin(impact / n)
    for branches, k in (("TT", 0), ("TRT", 1), ("TRRT", 2)):
        turned = jax.vmap(lambda b, s=branches: deflection(b, n, s))(impact)
        np.testing.assert_allclose(turned, np.mod(2 * (i - r) + k * (np.pi - 2 * r), 2 * np.pi), rtol=1e-12)
    for bad in (0.0, 1.0):
        with pytest.raises(ValueError, match="impact"):
            deflection(bad, n)
    with pytest.raises(ValueError, match="reflections = 3"):
        rainbow(n, 3)
    with pytest.raises(ValueError, match=r"eta = 2.0 .*\(1, 2\)"):
        rainbow(2.0)
    assert np.isnan(deflection(0.5, n, "RT"))


def test_a_mirror_blend_keeps_its_weights_by_wavelength():
    def build(wavelength_nm):
        return Scene({"d": disc(Blend(Phong(emission=1.0), wavelength_nm / 1000))}, background=0.25)

    image = render_spectral(build, FRONT, WAVES, 2, 2, 1)
    np.testing.assert_allclose(image.radiance[0, 0], 1 - WAVES / 1000 + 0.25 * WAVES / 1000, rtol=1e-12)
