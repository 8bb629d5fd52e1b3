"""Mean run lengths for independent normal scores, against published tables and by simulation."""

from functools import partial

import numpy as np
import pytest

from hydrofdi.detectors.charts import make_chart
from hydrofdi.detectors.run_lengths.independent import (
    cusum_run_length,
    ewma_run_length,
    limit_for,
    siegmund_run_length,
)
from hydrofdi.detectors.run_lengths.simulated import simulated_run_lengths
from hydrofdi.evaluation.direction import Direction

LUCAS_AND_CROSIER = {
    4.0: {0.0: 168, 0.25: 74.2, 0.5: 26.6, 0.75: 13.3, 1.0: 8.38, 1.5: 4.75, 2.0: 3.34},
    5.0: {0.0: 465, 0.25: 139, 0.5: 38.0, 0.75: 17.0, 1.0: 10.4, 1.5: 5.75, 2.0: 4.01},
}
"""Two-sided CUSUM with k 0.5, limit → mean → run length: Technometrics 24 (1982) 199, table 1."""

LUCAS_AND_SACCUCCI = [
    (0.05, 2.615, 11.4),
    (0.1, 2.814, 10.3),
    (0.2, 2.962, 10.5),
    (0.25, 2.998, 11.1),
    (0.4, 3.054, 14.3),
]
"""λ and L with 500 scores between false alarms, run length at a mean of 1: Technometrics 32 (1990) 1."""


@pytest.mark.parametrize("limit", LUCAS_AND_CROSIER)
def test_exact_cusum_run_lengths_are_the_published_ones(limit):
    for mean, published in LUCAS_AND_CROSIER[limit].items():
        assert cusum_run_length(limit, mean=mean) == pytest.approx(published, rel=5e-3)


def test_siegmund_is_within_a_few_percent():
    """469.1 is the example of Montgomery, Introduction to Statistical Quality Control, section 9.1."""
    assert siegmund_run_length(5.0) == pytest.approx(469.1, abs=0.05)
    for mean in (0.0, 0.5, 1.0, 2.0):
        assert siegmund_run_length(5.0, mean=mean) == pytest.approx(
            cusum_run_length(5.0, mean=mean), rel=0.04
        )


@pytest.mark.parametrize(("weight", "limit", "shifted"), LUCAS_AND_SACCUCCI)
def test_exact_ewma_run_lengths_are_the_published_ones(weight, limit, shifted):
    assert ewma_run_length(limit, weight=weight) == pytest.approx(500, rel=2e-3)
    assert ewma_run_length(limit, weight=weight, mean=1.0) == pytest.approx(shifted, rel=6e-3)


@pytest.mark.parametrize("mean", [0.0, 0.5])
@pytest.mark.parametrize("direction", [Direction.BOTH, Direction.RISING, Direction.FALLING])
def test_exact_run_lengths_are_those_of_the_charts(mean, direction):
    cases = [
        ("cusum", {}, 3.0, partial(cusum_run_length, 3.0)),
        ("ewma", {"variance": "limiting"}, 2.0, partial(ewma_run_length, 2.0)),
    ]
    for name, options, limit, exact in cases:
        chart = make_chart(name, {**options, "direction": direction})
        lengths = simulated_run_lengths(chart, limit, mean=mean, n_run=2000, most=20000, seed=3)
        if lengths.max() == 20000:
            assert exact(mean=mean, direction=direction) > 5000
            continue
        error = lengths.std() / np.sqrt(lengths.size)
        assert abs(lengths.mean() - exact(mean=mean, direction=direction)) < 3.5 * error


def test_cusum_has_465_scores_between_false_alarms():
    lengths = simulated_run_lengths(make_chart("cusum"), 5.0, n_run=4000, seed=1)
    assert abs(lengths.mean() - 465.44) < 3.0 * lengths.std() / np.sqrt(lengths.size)
    assert cusum_run_length(5.0) == pytest.approx(465.44, rel=1e-4)


@pytest.mark.parametrize("wanted", [100.0, 864000.0])
def test_a_limit_has_the_run_length_that_it_was_made_for(wanted):
    for of_limit in (cusum_run_length, siegmund_run_length, ewma_run_length):
        assert of_limit(limit_for(wanted, of_limit)) == pytest.approx(wanted, rel=1e-6)


def test_a_run_length_without_a_limit_is_refused():
    with pytest.raises(ValueError, match="no limit"):
        limit_for(0.5, cusum_run_length)


def test_runs_that_are_longer_end_where_they_should():
    lengths = simulated_run_lengths(make_chart("cusum"), 1e6, n_run=3, most=300)
    np.testing.assert_array_equal(lengths, 300)
