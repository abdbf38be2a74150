"""The oracle table itself: recomputed at 40 digits, from the textbook, without the library."""

import importlib.resources
import json
import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

from jaxrefl.check.table import evaluators

TABLE = json.loads(importlib.resources.files("jaxrefl").joinpath("data/oracles.json").read_text("utf-8"))
BLOCKS = {
    f"{section[0]}.{key}": block for section, members in TABLE["sections"].items() for key, block in members.items()
}
WORDS = {"about", "how", "rtol", "fields", "rows", "values"}
LEFT_OUT = {  # numbers about the making of the table
    "B.table": {"real_formula_max_abs_diff"},
    "B.attenuated_tir_slope": {"fd_check"},
    "C.d3d9_fit": {"max_abs_err_at_nodes"},
    "D.dielectric": {"closed-quad", "int_closed-quad"},
    "H.series": {"recursive_equals_iterative"},
}
formulas = {}


def recomputes(*blocks):
    """Register a function of one row, the text of its columns made numbers, to the columns that it recomputes."""

    def register(formula):
        formulas.update(dict.fromkeys(blocks, formula))
        return formula

    return register


def number(text):
    try:
        return mp.mpf(text) if "/" not in text else mp.fraction(*(mp.mpf(part) for part in text.split("/")))
    except ValueError:
        return text


def single(block):
    """Numbers of a block that stand outside its rows."""
    return {**block.get("values", {}), **{name: block[name] for name in block.keys() - WORDS}}


def rows(block):
    """Rows of a block, by column; the numbers outside the rows are one more."""
    table = [dict(zip(block["fields"], row, strict=True)) for row in block.get("rows", ())]
    return [*table, single(block)] if single(block) else table


# --- the formulas, after Born & Wolf and the sources ---


def cos(degrees):
    return mp.cos(mp.radians(degrees))


def reflection(mu, index, sqrt=mp.sqrt):
    """Amplitudes (r_s, r_p) for the cosine of incidence and a real or complex relative index."""
    mu_t = sqrt(1 - (1 - mu * mu) / (index * index))
    return (mu - index * mu_t) / (mu + index * mu_t), (index * mu - mu_t) / (index * mu + mu_t)


def powers(mu, index, sqrt=mp.sqrt):
    return [abs(r) ** 2 for r in reflection(mu, index, sqrt)]


def fresnel(mu, index, sqrt=mp.sqrt):
    r_s, r_p = powers(mu, index, sqrt)
    return (r_s + r_p) / 2


def schlick(mu, f0, p=5):
    return f0 + (1 - f0) * (1 - mu) ** p


def f0(index):
    return abs((index - 1) / (index + 1)) ** 2


def average(f):
    """Cosine-weighted average over the hemisphere."""
    return mp.quad(lambda mu: 2 * f(mu) * mu, [0, 0.1, 1])


def walsh(n):
    """Average of a dielectric, n > 1 (Walsh 1926)."""
    n2, n4 = n * n, n**4
    return (
        mp.mpf(1) / 2
        + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
        + n2 * (n2 - 1) ** 2 / (n2 + 1) ** 3 * mp.log((n - 1) / (n + 1))
        - 2 * n**3 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1))
        + 8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) ** 2) * mp.log(n)
    )
