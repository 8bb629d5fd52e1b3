"""Bounds of a curve with one more miss: one tested level is on the rise, the next is always detected."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.detectability import detectability
from hydrofdi.studies.parts import Notes, Part
from hydrofdi.studies.rules import Rules
from tests.evaluation.repeats import holds_at_least

SEVERITIES = np.geomspace(0.001, 1.0, 7)
STEP = np.log(SEVERITIES[1] / SEVERITIES[0])
THRESHOLD = quantile_threshold(np.linspace(0.0, 1.0, 1000), 0.01, direction=Direction.RISING)


def found(outcomes, true):
    """What is found, and the remarks."""
    levels, notes = [Part(2.0 * own, at, None) for own, at in zip(outcomes, true, strict=True)], Notes()
    return detectability(levels, THRESHOLD, 0.01, Rules(), notes).smallest, " ".join(notes.remarks)


def drawn(draw, spread, n_record=60):
    """Hits of a steep curve at seven levels, their true severities, and the true q90."""
    half = np.log(SEVERITIES[3]) + draw.uniform(-0.5, 0.5) * STEP
    true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.02, (SEVERITIES.size, n_record)))
    chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / (spread * STEP))
    truth = np.exp(half + spread * STEP * ndtri(0.89 / 0.99))
    return (draw.random(chance.shape) < chance).astype(float), true, truth


@pytest.mark.parametrize("spread", [0.1, 0.2])
def test_their_bound_covers_the_truth_as_often_as_promised(spread):
    draw, covered, repeats = np.random.default_rng(11), 0, 0
    while repeats < 40:
        outcomes, true, truth = drawn(draw, spread)
        smallest, remarks = found(outcomes, true)
        bound = smallest["q90_95"]
        if bound.source == "curve" and "fewer than two tested levels" in remarks:
            repeats += 1
            covered += bound.value is None or bound.value >= truth
    assert holds_at_least(covered, repeats, 0.95)
