"""What the tests of the figures share: a caption that says a number, a curve at an angle."""

import numpy as np


def says(caption, *numbers):
    """The caption contains each number, already rounded to the digits it prints."""
    missing = [number for number in numbers if number not in caption]
    assert not missing, f"{missing} not in: {caption}"


def at(data, key, theta):
    """Column of a figure's data nearest to an angle in degrees."""
    return data[key][..., np.argmin(np.abs(data["theta_deg"] - theta))]
