"""The dashed line of the POD figure is the bound that the table states, for studies of any size."""

from __future__ import annotations

import numpy as np
import pytest

from hydrofdi.report.figures.detection.pod import bound_line, draw_pod
from hydrofdi.studies.judging import judge
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import judged
from tests.studies.populations import rising, usual

SEVEN_LEVELS = tuple(np.geomspace(0.001, 1.0, 7))


@pytest.fixture(scope="module")
def lines():
    """Judgements of made-up studies with a bound within the tested severities, and its line."""
    found = []
    for seed in range(12):
        draw = np.random.default_rng(seed)
        records = usual(healthy=500, each=int(draw.integers(30, 80)), seed=seed)
        slope, half = draw.uniform(3.0, 60.0), draw.uniform(0.03, 0.3)
        judgement = judge(records, rising(records, slope=slope, half=half, seed=seed), Rules())
        bound = judgement.smallest["q90_95"]
        if bound.source == "curve" and bound.place == "within":
            found.append((bound, bound_line(judgement.bounding, bound.severity, bound.confidence)))
    assert len(found) >= 5
    return found


def test_the_line_is_at_ninety_percent_at_q90_95(lines):
    for bound, (severities, low) in lines:
        at = np.interp(np.log(bound.severity), np.log(severities), low)
        assert at == pytest.approx(bound.probability, abs=1e-3)
        assert np.all(low[severities < bound.severity] <= bound.probability + 1e-3)


def test_the_line_rises_in_small_steps(lines):
    for _, (severities, low) in lines:
        assert np.all(np.diff(severities) > 0.0)
        assert np.diff(low).min() > -1e-3
        is_near = np.diff(np.log10(severities)) < 2e-3
        assert np.all((np.diff(low) < 0.1) | is_near)


@pytest.mark.parametrize("n_other", [45, 60])
def test_the_drawn_line_does_not_move_misses_to_larger_severities(n_other):
    detection = judged(n_healthy=500, n_other=n_other, severities=SEVEN_LEVELS)
    drawn = 0
    for axis in draw_pod(detection).axes:
        dashed, found = [line for line in axis.lines if is_bound(line)], [*filter(is_vertical, axis.lines)]
        if dashed and found:
            at = np.interp(found[0].get_xdata()[0], dashed[0].get_xdata(), dashed[0].get_ydata())
            assert at == pytest.approx(90.0, abs=0.5)
            drawn += 1
    assert drawn


def is_vertical(line):
    return len(line.get_xdata()) == 2 and line.get_xdata()[0] == line.get_xdata()[1]


def is_bound(line):
    return len(line.get_xdata()) > 10 and line.get_linestyle() != "-"
