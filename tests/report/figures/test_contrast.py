"""Colours that can be read on each other."""

import matplotlib
import numpy as np
import pytest

from hydrofdi.report.figures.contrast import contrast, text_on
from hydrofdi.report.figures.style import COLORS, LINES, MARKERS, PAPER, ordered_color, series

DARK = "#16161a"
"""The ground of the page in the dark."""


def test_contrast_is_that_of_the_guidelines():
    assert contrast("white", "black") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.478, abs=1e-3)


@pytest.mark.parametrize("scale", ["PuOr_r", "viridis", "plasma", "gray"])
def test_text_on_every_colour_of_a_scale_has_enough_contrast(scale):
    for color in matplotlib.colormaps[scale](np.linspace(0.0, 1.0, 256)):
        assert contrast(text_on(color), color) >= 4.5


@pytest.mark.parametrize("ground", [PAPER, DARK])
def test_every_series_can_be_seen_on_both_grounds(ground):
    for color in (*COLORS, *(ordered_color(place, 40) for place in range(40))):
        assert contrast(color, ground) >= 3.0


def test_eight_series_differ_in_colour_in_line_and_in_marker():
    assert [len({str(each) for each in looks}) for looks in (COLORS, LINES, MARKERS)] == [8, 8, 8]
    many = [series(place, 12) for place in range(12)]
    assert len({(str(each["color"]), str(each["linestyle"])) for each in many}) == 12
