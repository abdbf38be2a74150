"""Reflection models: pure functions f(wi, wo) in 1/sr, cosine not included, in the local frame (z is the normal).

A model is a frozen dataclass with fields made by `jaxrefl.params.param`, registered as a pytree, with one method
``__call__(wi, wo) -> (C,)``. There is no base class: a user's own model is a few lines in the user's own file.
"""

from .lambert import Lambert as Lambert
from .protocol import BRDF as BRDF
