"""The numbers of a row do not contradict each other, whatever they come from."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.detectability import detectability
from hydrofdi.studies.parts import Notes, Part
from hydrofdi.studies.rules import Rules

SEVERITIES = np.geomspace(0.005, 0.32, 7)
THRESHOLD = quantile_threshold(np.linspace(0.0, 1.0, 1000), 0.01, direction=Direction.RISING)


def rows(n_repeat, n_record=40, n_group=None):
    """What is found of curves of many places and slopes, at seven levels."""
    draw = np.random.default_rng(7)
    groups = None if n_group is None else [f"unit {k % n_group}" for k in range(n_record)]
    for _ in range(n_repeat):
        half, slope = draw.uniform(-5.0, -1.5), draw.uniform(0.02, 0.9)
        true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.015, (SEVERITIES.size, n_record)))
        chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / slope)
        outcomes = (draw.random(chance.shape) < chance).astype(float)
        levels = [Part(2.0 * own, severity, groups) for own, severity in zip(outcomes, true, strict=True)]
        yield detectability(levels, THRESHOLD, 0.01, Rules(n_tried=20), Notes()).smallest


@pytest.mark.parametrize("n_group", [None, 40])
def test_no_bound_is_below_the_estimates_beside_it(n_group):
    sources = set()
    for found in rows(150, n_group=n_group):
        names = [name for name in ("q50", "q90", "q90_95", "q90_95_of_all") if name in found]
        severities = [math.inf if found[name].value is None else found[name].value for name in names]
        assert severities == sorted(severities), found
        sources |= {(found["q90"].source, found["q90_95"].source)} if "q90_95" in found else set()
    assert len(sources) > 1
