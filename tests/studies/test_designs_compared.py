"""Designs of a study on the same actuators: what is shown, and what is not."""

import numpy as np
import pytest

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.designs import Detector, are_shown, gain
from hydrofdi.studies.judgement import Judgement
from hydrofdi.studies.records import Scored, StudyRecords

LEVELS = tuple(Population(f"{level:g}", Kind.FAULT, False, level) for level in (1.0, 2.0, 3.0))
HEALTHY = Population("healthy", Kind.HEALTHY, is_fit=True)


def design(noise, *, seed, n=100, n_fit=500, actuators=0, direction=Direction.RISING, has_threshold=True):
    """Scores of a leak, an actuator and a sensor's noise; the actuators do not change with the seed."""
    populations, sizes = (HEALTHY, *LEVELS), (n_fit, n, n, n)
    severity = np.repeat([0.0, 1.0, 2.0, 3.0], sizes)
    plant = np.random.default_rng([actuators, 0]).standard_normal(severity.size)
    scores = severity + 0.7 * plant + noise * np.random.default_rng([seed, 1]).standard_normal(severity.size)
    scores = -scores if direction is Direction.FALLING else scores
    limit = quantile_threshold(scores[:n_fit], 0.02, direction=direction) if has_threshold else None
    judgement = Judgement(Scored("score", scores), direction, limit, {}, (), None, None, {}, np.nan)
    return Detector(StudyRecords(populations, np.repeat(np.arange(4), sizes), severity), judgement)


def rate(detector):
    return np.mean(detector.judgement.threshold.outcomes(detector.faulty))


@pytest.mark.parametrize("direction", list(Direction))
def test_a_sensor_with_less_noise_is_shown_to_detect_more(direction):
    noisy, better = (design(noise, seed=1, direction=direction) for noise in (2.0, 0.2))
    found = gain(noisy, better)
    assert are_shown([found]) == (True,)
    assert found.value == pytest.approx(rate(better) - rate(noisy))
    assert 0.0 < found.low < found.value < found.high
    assert gain(better, noisy).value == pytest.approx(-found.value)


def test_equal_designs_show_a_difference_in_one_study_of_twenty():
    """Thresholds of equal designs differ, which is no gain. 10 are expected; 21 come once in 1,000."""
    shown = 0
    for seed in range(200):
        pair = (design(1.0, seed=2 * seed + k, actuators=seed) for k in (0, 1))
        shown += are_shown([gain(*pair)])[0]
    assert shown <= 20


def test_common_actuators_show_what_independent_ones_hide():
    same = gain(design(0.1, seed=1), design(0.1, seed=2))
    apart = gain(design(0.1, seed=1), design(0.1, seed=2, actuators=3))
    assert same.high - same.low < 0.5 * (apart.high - apart.low)


def test_many_comparisons_are_corrected():
    found = gain(design(0.7, seed=1), design(0.4, seed=2))
    assert 0.05 / 100 < found.p_value < 0.05
    assert are_shown([found]) == (True,)
    assert are_shown([found] * 100) == (False,) * 100
    assert are_shown([found, None]) == (True, False)


def test_lost_records_and_equal_designs_are_no_difference():
    first, second = design(0.5, seed=1), design(0.5, seed=1)
    assert (gain(first, second).value, are_shown([gain(first, second)])) == (0.0, (False,))
    second.judgement.scored.values[-20:] = np.nan
    second.judgement.scored.values[:5] = np.nan
    assert abs(gain(first, second).value) < 0.05
