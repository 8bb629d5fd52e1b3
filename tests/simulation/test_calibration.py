"""The search for the leakage coefficient of a flow, with flows in closed form."""

import math

import pytest

from hydrofdi.simulation.calibration import search_coefficient


def search(flow, first=0.7):
    """Solution of 1 for a flow as a function of K_i, and the number of trials."""
    trials = search_coefficient(1.0, first)
    trial, n_trial = next(trials), 1
    while True:
        try:
            trial, n_trial = trials.send(flow(trial)), n_trial + 1
        except StopIteration as end:
            return end.value, n_trial


@pytest.mark.parametrize(
    ("flow", "solution"),
    [
        (lambda k: k, 1.0),
        (lambda k: 1e-3 * k, 1e3),
        (lambda k: k / math.sqrt(1.0 + 0.25 * k * k), 1.0 / math.sqrt(0.75)),
        (lambda k: k**0.5, 1.0),
        (lambda k: 3e-4 * k**1.3, (1.0 / 3e-4) ** (1.0 / 1.3)),
        (lambda k: min(k, 0.9) + 0.1 * max(k - 0.9, 0.0), 1.9),
        (lambda k: max(2.0 * k - 1.5, 0.0), 1.25),
    ],
)
@pytest.mark.parametrize("first", [0.2, 0.7, 1.0, 5.0])
def test_a_flow_that_grows_with_the_coefficient_is_met_in_few_trials(flow, solution, first):
    found, n_trial = search(flow, first)
    assert found.coefficient == pytest.approx(solution, rel=1e-12)
    assert n_trial <= 16


@pytest.mark.parametrize("largest", [0.0, 0.5, 0.99])
def test_a_flow_out_of_reach_ends_with_the_most_that_leaks(largest):
    found, n_trial = search(lambda k: largest * k / (0.01 + k))
    assert math.isnan(found.coefficient)
    assert found.reachable_flow == pytest.approx(largest, rel=1e-3)
    assert n_trial < 20


@pytest.mark.parametrize("above", [1.5, math.nan])
def test_a_flow_that_jumps_across_the_request_has_no_solution(above):
    found, n_trial = search(lambda k: 0.9 * k if k < 1.05 else above)
    assert math.isnan(found.coefficient)
    assert (found.reachable_flow >= 1.0) == (above > 1.0)
    assert n_trial < 100


def test_trials_that_fail_only_bound_the_search():
    found, _ = search(lambda k: k if k < 1.3 else math.nan, 0.5)
    assert found.coefficient == pytest.approx(1.0, rel=1e-12)
