"""Indicators that cannot have numbers are known before anything is simulated."""

from hydrofdi.api.warnings import without_results
from hydrofdi.config import expand_runs, load_experiment


def warnings_of(*settings):
    experiment = load_experiment(settings=["record.duration=4 s", *settings])
    return [*without_results(experiment, expand_runs(experiment).runs.distinct)]


def test_a_band_above_half_of_the_sampling_frequency_is_warned_of():
    (sentence,) = warnings_of("indicators={dwt: {}, band_power: {bands: [[400 Hz, 900 Hz]]}}")
    assert sentence.startswith("band_power will have no results: ")
    assert "900 Hz" in sentence


def test_indicators_that_fit_are_not_warned_of():
    assert warnings_of("indicators=[dwt, modwt, ring_down, flow_balance]") == []
