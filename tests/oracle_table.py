"""The shipped oracle table as text, and the comparison of its numbers with formulas of 40 digits."""

import importlib.resources
import json
from fractions import Fraction

import mpmath as mp

from jaxrefl.check.table import evaluators

TABLE = json.loads(importlib.resources.files("jaxrefl").joinpath("data/oracles.json").read_text("utf-8"))
BLOCKS = {
    f"{section[0]}.{key}": block for section, members in TABLE["sections"].items() for key, block in members.items()
}
ALBEDOS = [name for name in BLOCKS if name[0] == "E" or name.startswith(("G.phong", "G.thresholds"))]
WORDS = {"about", "how", "rtol", "fields", "rows", "values"}


def single(block):
    """Numbers of a block that stand outside its rows."""
    return {**block.get("values", {}), **{name: block[name] for name in block.keys() - WORDS}}


def rows(block, part):
    """Text of each row, by column; that of the numbers outside them is one row."""
    members = BLOCKS[block]
    if part != "rows":
        return [single(members)]
    return [dict(zip(members["fields"], row, strict=True)) for row in members["rows"]]


def number(text):
    numerator, _, denominator = text.partition("/")
    try:
        return mp.mpf(numerator) / mp.mpf(denominator or 1)
    except ValueError:
        return text


class Recomputed:
    """Register of formulas; as a decorator it takes a function of a row, or of the numbers outside the rows."""

    def __init__(self, left_out):
        self.formulas, self.left_out = {}, left_out

    def __call__(self, block, part="rows"):
        def register(formula):
            self.formulas[block, part] = formula
            return formula

        return register

    def recompute(self, block, part, texts):
        """Columns of one row, from its text."""
        return self.formulas[block, part]({name: number(text) for name, text in texts.items() if text is not None})

    @mp.workdps(40)
    def compare(self, block, part):
        """Every recomputed number is that of the table."""
        for texts in rows(block, part):
            for column, value in self.recompute(block, part, texts).items():
                if texts[column] is not None:
                    oracle = number(texts[column])
                    value = (
                        mp.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mp.mpf(value)
                    )
                    error = abs(value - oracle) / (abs(oracle) or 1)
                    assert error <= BLOCKS[block]["rtol"], (texts, column, value)

    @mp.workdps(40)
    def is_complete(self, block):
        """Every column is an input, recomputed, or left out for a reason."""
        parts = [part for name, part in self.formulas if name == block]
        columns = {name for part in parts for name in self.recompute(block, part, rows(block, part)[0])}
        inputs, given = set(evaluators[block].inputs), {*BLOCKS[block].get("fields", ()), *single(BLOCKS[block])}
        left_out = self.left_out.get(block, set())
        assert columns | inputs | left_out == given
        assert not columns & left_out
