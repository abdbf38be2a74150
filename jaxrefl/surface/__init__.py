"""Surfaces: what a hit does to a ray. The four source documents are one row each of one protocol.

    source             surface         local             reflected                      transmitted
    PERRIN             Blend           1 - alpha         alpha                          -
    JHU                Whitted         1                 k_rg                           k_tg
    D3D9               D3D9            1 - |lambda|      lambda (1 - R) + s R           -
    LAMBERT-FRESNEL    Dielectric      0                 F                              1 - F
                       Conductor       0                 F                              -
                       Coat            1 - F             F                              -
    -                  ThinFilm        0                 R of the film                  -

A surface is a class decorated with `jaxrefl.params.pytree`, with fields made by `jaxrefl.params.param` and two methods,
``local(hit, wi) -> Local`` and ``weights(hit) -> Weights``. There is no base class: a user's own surface is a few lines
in the user's own file. Any colour parameter may be a texture.
"""

from .brdf import BRDFSurface as BRDFSurface
from .d3d9 import D3D9 as D3D9
from .film import ThinFilm as ThinFilm
from .fresnel import Coat as Coat
from .fresnel import Conductor as Conductor
from .fresnel import Dielectric as Dielectric
from .phong import Phong as Phong
from .protocol import Local as Local
from .protocol import Surface as Surface
from .protocol import Weights as Weights
from .whitted import Blend as Blend
from .whitted import Whitted as Whitted
