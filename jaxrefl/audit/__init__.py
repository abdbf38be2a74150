"""Audit of a reflection model: does it conserve energy, is it reciprocal, is it positive, finite, sampled as it says?

    from jaxrefl.audit import audit
    print(audit(OrenNayar(rho=1.0)))

Every property is a row with a verdict, a number, and where it is worst. For a model of one's own, written in JAX as
f(wi, wo), in a class or not; a numpy function comes through `from_numpy`, and has no gradients to look at.
"""

from ..brdf.function import from_numpy as from_numpy
from .battery import PROPERTIES as PROPERTIES
from .battery import assert_valid as assert_valid
from .battery import audit as audit
from .compare import Comparison as Comparison
from .compare import Difference as Difference
from .compare import compare as compare
from .profile import Profile as Profile
from .profile import profile as profile
from .report import SCHEMA as SCHEMA
from .report import VERDICTS as VERDICTS
from .report import Curve as Curve
from .report import Report as Report
from .report import Row as Row
