"""Pictures by wavelength: scenes whose colours, or whose ways, depend on it.

def build(wavelength_nm):                        # of ONE wavelength
    n, k = material("Au")(wavelength_nm)
    return Scene({"ball": Object(Sphere(Vec3(0, 0, 1)), Conductor(n, k)), ...}, lights, background=0.5)

image = render_spectral(build, camera, np.linspace(400, 700, 31), 256, 256, n_bounces=4)
write_png(path, image.rgb("A"))                  # under a light bulb
write_exr(path, image)                           # the cube, as a spectral EXR
"""

from .build import Build as Build
from .build import family as family
from .build import spectral_scene as spectral_scene
from .drop import deflection as deflection
from .drop import rainbow as rainbow
from .render import SpectralImage as SpectralImage
from .render import render_spectral as render_spectral
from .scenes import coated_sphere as coated_sphere
from .scenes import glass_ball as glass_ball
from .scenes import metal_spheres as metal_spheres
