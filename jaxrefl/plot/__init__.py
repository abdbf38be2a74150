"""Plots of reflection curves: each function takes arrays or callables and an optional ``ax``, and returns its artists.

    from jaxrefl import plot
    with plot.style():
        ax = plot.axes()
        plot.fresnel(1.5, ax=ax)
        plot.save(ax, "glass.pdf")

Angles are drawn in degrees. The figures of this project are made with these functions and nothing else. This is the
only package that imports matplotlib, and it leaves the user's rcParams and backend alone.
"""

from .bar import shared_bar as shared_bar
from .curves import angles as angles
from .curves import cartesian as cartesian
from .curves import convergence as convergence
from .curves import error_map as error_map
from .curves import fresnel as fresnel
from .curves import polar as polar
from .diagram import arrow as arrow
from .diagram import band as band
from .diagram import canvas as canvas
from .diagram import dot as dot
from .diagram import mark as mark
from .diagram import note as note
from .diagram import points as points
from .diagram import segment as segment
from .layers import bars as bars
from .layers import categories as categories
from .layers import normals as normals
from .layers import strip as strip
from .model import albedo as albedo
from .model import furnace as furnace
from .model import image_slice as image_slice
from .model import lobe3d as lobe3d
from .picture import field as field
from .picture import picture as picture
from .rows import rows as rows
from .style import ANGLE as ANGLE
from .style import BLUE as BLUE
from .style import GREEN as GREEN
from .style import GREY as GREY
from .style import ORANGE as ORANGE
from .style import PINK as PINK
from .style import RED as RED
from .style import SKY as SKY
from .style import STYLES as STYLES
from .style import axes as axes
from .style import figure as figure
from .style import labels as labels
from .style import legend as legend
from .style import save as save
from .style import style as style
from .values import albedos as albedos
from .values import lobe_values as lobe_values
from .values import slice_values as slice_values
