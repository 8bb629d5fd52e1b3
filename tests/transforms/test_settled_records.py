"""From when on a record counts as settled, and what is then measured of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import RunSpec
from hydrofdi.config.request import RunRequest
from hydrofdi.execution import Job, compute_columns
from hydrofdi.execution import compute as compute_module
from hydrofdi.quality.doubts import SETTLED_CHANGE, how_records_settle
from hydrofdi.quality.measures import pressure_features
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.transforms.wavelet import coefficient_rms

RUN = RunRequest().with_values({"record.duration": 10.0, "input.period": 1.0})
TIME = np.arange(RUN.record.n_sample) / RUN.record.sampling_frequency
WAVE = np.where(np.arange(TIME.size) % 500 < 250, 9e6, 7e6)


def _features(run, pressure, settling) -> dict[str, np.ndarray]:
    start = np.nan if settling.start is None else settling.start / run.record.sampling_frequency
    return pressure_features([run.parameters], [RunSpec(run).analysis], pressure, np.array([start]))


def _job(run: RunRequest, coefficient: float, name: str = "") -> Job:
    return Job.of(RunSpec(run), name, coefficient)


def _decaying(share: float, time_constant: float) -> np.ndarray:
    return (WAVE * (1.0 + share * np.exp(-TIME / time_constant)))[None]


def test_a_periodic_record_is_settled_from_its_start() -> None:
    (settling,) = how_records_settle([RUN], WAVE[None])
    assert settling.start == 0
    assert settling.change < 1e-12


def test_a_start_that_dies_away_is_left_out_in_whole_periods() -> None:
    (settling,) = how_records_settle([RUN], _decaying(0.5, 0.5))
    assert settling.start is not None
    assert settling.start % 500 == 0
    assert 0 < settling.start <= 8 * 500
    assert settling.change < SETTLED_CHANGE


def test_a_record_that_never_settles_has_no_settled_part() -> None:
    (settling,) = how_records_settle([RUN], _decaying(0.5, 50.0))
    assert settling.start is None
    assert settling.change > SETTLED_CHANGE
    features = _features(RUN, _decaying(0.5, 50.0), settling)
    assert np.isnan(features["settled_detail_rms"]).all()
    assert np.isfinite(features["mean_chamber_1_pressure"]).all()


def test_a_single_period_says_nothing() -> None:
    run = RUN.with_values({"record.duration": 1.0})
    (settling,) = how_records_settle([run], WAVE[None, :500])
    assert np.isnan(settling.change)
    assert settling.start is None


def test_settled_features_do_not_see_the_start() -> None:
    start = _decaying(0.5, 0.2)
    (settling,) = how_records_settle([RUN], start)
    late = _features(RUN, start, settling)
    never = _features(RUN, WAVE[None], replace(settling, start=0))
    np.testing.assert_allclose(late["settled_detail_rms"], never["settled_detail_rms"], rtol=2e-3)
    whole = (coefficient_rms(record, RUN.wavelet).detail for record in (start, WAVE[None]))
    assert abs(np.divide(*whole) - 1.0).max() > 1e-2


def test_records_without_a_period_are_measured_without_their_boundary() -> None:
    run = RUN.with_values({"input.shape": "steps", "analysis.discard": 1.0})
    noise = np.random.default_rng(1).normal(size=(1, run.record.n_sample))
    noise[:, :500] *= 1e6  # left out by analysis.discard
    settlings = how_records_settle([run], noise)
    features = _features(run, noise, settlings[0])
    assert settlings[0].start is None
    np.testing.assert_allclose(features["settled_detail_rms"][0, :3], 1.0, rtol=0.05)
    np.testing.assert_allclose(features["mean_chamber_1_pressure"], noise[:, 500:].mean(axis=1))


def test_discard_is_one_window_for_all_features_as_configured() -> None:
    short = RUN.with_values({"record.duration": 4.0})
    late = short.with_values({"analysis.discard": 2.0})
    whole = compute_columns([_job(short, 1e-9)])
    part = compute_columns([_job(late, 1e-9)])
    kept = whole["chamber_1_pressure"][:, 1000:]
    assert part["mean_chamber_1_pressure"][0] == kept.mean()
    direct = coefficient_rms(kept, short.wavelet)
    np.testing.assert_array_equal(part["detail_rms"], direct.detail)
    np.testing.assert_array_equal(part["approximation_rms"], direct.approximation)
    for name in ("mean_internal_leakage_flow", "hydraulic_mode_frequency", "chamber_1_pressure_max"):
        assert part[name][0] == whole[name][0]


def test_jobs_that_differ_in_their_analysis_alone_are_simulated_once() -> None:
    short = RUN.with_values({"record.duration": 2.0, "pressure_1_sensor.noise": 1e3})
    analyses = [{}, {"wavelet.phase": 3}, {"wavelet.name": "db4"}, {"analysis.discard": 0.5}]
    jobs = [_job(short.with_values(analysis), 1e-9, str(k)) for k, analysis in enumerate(analyses)]
    jobs.append(_job(short, 2e-9, "leaky"))
    simulated = []

    def count(runs, coefficients, *, tap):
        simulated.extend(coefficients)
        return simulate_batch(runs, coefficients, tap)

    together = compute_columns(jobs, count)
    assert simulated == [1e-9, 2e-9]
    for row, job in enumerate(jobs):
        alone = compute_columns([job])
        for name in ("detail_rms", "chamber_1_pressure", "settled_detail_rms", "status"):
            np.testing.assert_array_equal(together[name][row], alone[name][0])


@pytest.mark.parametrize("phase", [0, 7, 31])
def test_a_phase_by_itself_is_that_of_all_phases(phase: int) -> None:
    short = RUN.with_values({"record.duration": 4.0, "analysis.discard": 1.0})
    every = compute_columns([_job(short.with_values({"wavelet.phase": "all"}), 4e-9)])
    alone = compute_columns([_job(short.with_values({"wavelet.phase": phase}), 4e-9)])
    np.testing.assert_array_equal(every["phase_detail_rms"][:, phase], alone["detail_rms"])
    assert compute_module.names.PHASE_DETAIL_RMS not in alone
    phases = every["settled_phase_detail_rms"]
    np.testing.assert_allclose(np.sqrt(np.mean(phases**2, axis=1)), every["settled_detail_rms"], rtol=1e-3)
