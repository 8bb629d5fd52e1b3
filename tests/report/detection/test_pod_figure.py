"""The POD figure shows the curve and the bound that the table is made from."""

from __future__ import annotations

import numpy as np
import pytest

from hydrofdi.report.figures import draw_figure
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import judged, report_of


@pytest.fixture(scope="module")
def pod():
    """Each drawn score with its panel."""
    detection = judged(n_healthy=200, n_other=60, severities=(0.05, 0.1, 0.2, 0.5, 1.0))
    by_name = {each.scored.name: each for each in detection.judgements}
    axes = draw_figure(report_of(detection), "pod").axes
    found = [(by_name[name], axis) for axis in axes for name in by_name if name in titled(axis)]
    assert found
    return found


def titled(axis):
    return "".join(axis.get_title(loc="left").split())


def sloped(axis, style):
    """The drawn line of many points with this style."""
    lines = [line for line in axis.lines if len(line.get_xdata()) > 10]
    return next((line for line in lines if (line.get_linestyle() == "-") == (style == "-")), None)


def test_the_drawn_bound_reaches_ninety_percent_at_q90_95(pod):
    seen = 0
    for judgement, axis in pod:
        found = judgement.smallest.get("q90_95")
        line = sloped(axis, "--")
        if found is None or found.source == "levels":
            assert line is None
        elif found.place == "within":
            at = np.interp(found.value * 6e4, line.get_xdata(), line.get_ydata())
            assert at == pytest.approx(100.0 * Rules().probability, abs=0.5)
            seen += 1
    assert seen


def test_the_drawn_curve_reaches_ninety_percent_at_q90(pod):
    seen = 0
    for judgement, axis in pod:
        found, line = judgement.smallest.get("q90"), sloped(axis, "-")
        if found is None or found.source == "levels":
            assert line is None
        elif found.place == "within":
            at = np.interp(found.value * 6e4, line.get_xdata(), line.get_ydata())
            assert at == pytest.approx(100.0 * Rules().probability, abs=1.0)
            seen += 1
    assert seen
