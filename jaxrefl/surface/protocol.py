"""What a surface has to offer."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, runtime_checkable

from ..geometry import Hit
from ..vec import Vec3


class Local(NamedTuple):
    """Response to one light."""

    diffuse: Any
    """(C,) radiance per unit of the light's diffuse intensity, cosine included."""
    specular: Any
    """(C,) radiance per unit of its specular intensity."""


class Weights(NamedTuple):
    """What a hit does to the throughput of a ray: everything (C,), where nothing else is said.

    A weight left at its default, the Python number 0, is known to be absent: a scene in which no surface transmits
    is traced as a chain, not as a tree.
    """

    local: Any = 1.0
    """Weight of what the surface shows: emission, ambient, diffuse and specular light."""
    reflected: Any = 0.0
    """Weight of the reflected ray."""
    transmitted: Any = 0.0
    """Weight of the refracted ray; under total reflection it is added to the reflected one."""
    emitted: Any = 0.0
    """Radiance of the surface itself."""
    ambient: Any = 0.0
    """Response to ambient intensity."""
    eta: Any = 1.0
    """() index of the inside over the outside; gives the refracted direction."""
    sigma: Any = 0.0
    """Extinction inside, 1/length, along the transmitted ray."""
    sigma_reflected: Any = 0.0
    """Extinction along the reflected ray, 1/length."""
    alpha: Any = 1.0
    """() coverage, the d_a of D3D9 (7)."""


@runtime_checkable
class Surface(Protocol):
    """Surface of the tracer. Both methods must be finite, in value and gradient, on any legal hit."""

    def local(self, hit: Hit, wi: Vec3) -> Local:
        """Response to a light in the direction ``wi``; 0 where wi is below the surface."""
        ...

    def weights(self, hit: Hit) -> Weights:
        """Weights of the local light and of the rays that go on."""
        ...


def is_absent(weight: Any) -> bool:
    """True for a weight that a surface left at its default 0."""
    return isinstance(weight, (int, float)) and weight == 0


def under(base: Weights, local: Any, reflected: Any) -> Weights:
    """Weights of a layer over a base: the layer reflects, and passes ``local`` on to everything that the base does."""
    through = {name: local * getattr(base, name) for name in ("reflected", "transmitted")}
    return base._replace(
        local=local * base.local,
        reflected=reflected if is_absent(base.reflected) else reflected + through["reflected"],
        transmitted=base.transmitted if is_absent(base.transmitted) else through["transmitted"],
    )
