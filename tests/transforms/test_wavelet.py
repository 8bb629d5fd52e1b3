"""Wavelet transforms: details, start phases, settled and undecimated ones."""

import numpy as np
import pytest
import pywt
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import RunSpec
from hydrofdi.config.request import RunRequest
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.indicators.catalogue.wavelets import phase_rms
from hydrofdi.quality.doubts import how_records_settle, pressure_features
from hydrofdi.store.verdicts import SETTLED_CHANGE
from hydrofdi.transforms import (
    WaveletConfig,
    coefficient_rms,
    detail_rms,
    level_bands,
    n_phase,
    phase_detail_rms,
    undecimated_coefficients,
    undecimated_rms,
)

ORTHOGONAL = st.sampled_from(["db8", "db2", "haar", "coif1", "sym4"])


def _record(seed: int, n_time: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=n_time).cumsum()


@pytest.mark.parametrize(("frequency", "level"), [(180.0, 1), (45.0, 3), (11.0, 5)])
def test_a_tone_shows_in_the_level_of_its_band(frequency, level):
    rms = detail_rms(np.sin(2 * np.pi * frequency * np.arange(5000) / 500.0), WaveletConfig())
    low, high = level_bands(500.0, 5)[level - 1]
    assert low < frequency < high
    assert np.argmax(rms) == level - 1


@pytest.mark.parametrize(
    ("extension", "n_time"), [("symmetric", 1024), ("symmetric", 1023), ("periodization", 1023)]
)
def test_details_and_approximations_are_those_of_pywavelets(extension, n_time):
    records = np.stack([_record(7, n_time), _record(8, n_time)])
    rms = coefficient_rms(records, WaveletConfig(levels=5, extension=extension))
    details = pywt.wavedec(records, "db8", mode=extension, level=5)[1:]
    for level, detail in enumerate(reversed(details), 1):
        approximation = pywt.wavedec(records, "db8", mode=extension, level=level)[0]
        for found, coefficients in ((rms.detail, detail), (rms.approximation, approximation)):
            expected = np.sqrt(np.mean(coefficients**2, axis=-1))
            np.testing.assert_array_equal(found[:, level - 1], expected)


@given(st.integers(0, 2**32 - 1), st.integers(64, 700), st.integers(1, 5), ORTHOGONAL, st.integers(0, 700))
def test_energy_is_partitioned_at_any_length_wherever_a_circle_starts(seed, n_time, levels, name, shift):
    record, wavelet = _record(seed, n_time), WaveletConfig(name=name, levels=levels)
    rms = undecimated_rms(record, wavelet)
    power = np.square(rms.detail) / 2.0 ** np.arange(1, levels + 1)
    total = power.sum() + rms.approximation[-1] ** 2 / 2.0**levels
    assert total == pytest.approx(np.mean(record**2), rel=1e-10)
    details, approximations = undecimated_coefficients(record, wavelet)
    np.testing.assert_allclose(np.sqrt(np.mean(details**2, axis=-1)), rms.detail, rtol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.mean(approximations**2, axis=-1)), rms.approximation, rtol=1e-9)
    turned = undecimated_rms(np.roll(record, shift), wavelet)
    np.testing.assert_allclose(turned.detail, rms.detail, rtol=1e-9)


def test_the_mean_square_is_the_mean_over_the_start_phases_which_count_from_the_start_of_the_record():
    record, wavelet = _record(5, 32 * 40), WaveletConfig()
    details, _ = undecimated_coefficients(record, wavelet)
    phases = phase_detail_rms(details, first_sample=0)
    assert phases.shape == (32, 5)
    expected = undecimated_rms(record, wavelet).detail
    np.testing.assert_allclose(np.sqrt(np.mean(phases**2, axis=0)), expected, rtol=1e-10)
    for first in (1, 31, 70):
        np.testing.assert_array_equal(phase_detail_rms(details, first), np.roll(phases, first, axis=0))


@pytest.mark.parametrize("extension", ["symmetric", "zero", "smooth"])
def test_without_boundary_coefficients_the_extension_has_no_effect(extension):
    record = _record(9, 3000)
    symmetric = detail_rms(record, WaveletConfig(boundary="left_out"))
    other = detail_rms(record, WaveletConfig(boundary="left_out", extension=extension))
    np.testing.assert_array_equal(symmetric, other)
    assert not np.allclose(symmetric, detail_rms(record, WaveletConfig()), rtol=1e-6)


PHASES = [
    *((4501, {"extension": extension}) for extension in pywt.Modes.modes),
    *((4501, {"extension": each, "boundary": "left_out"}) for each in ("symmetric", "periodic")),
    *((9000, {"name": name, "levels": 4}) for name in ("haar", "sym5", "db20", "dmey")),
    (9000, {"levels": 1}), (9000, {"levels": 6}), *((n_time, {}) for n_time in (500, 3839, 3840, 3841, 4001)),
]  # fmt: skip


@pytest.mark.parametrize(("n_time", "options"), PHASES)
def test_each_phase_has_the_bits_of_a_transform_from_there_on(n_time, options):
    wavelet = WaveletConfig(**options)
    records = 8e6 + 1e5 * np.cumsum(np.random.default_rng(n_time).normal(size=(2, n_time)), axis=1)
    found = phase_rms(records, wavelet)
    assert found.shape == (2, n_phase(wavelet.levels), wavelet.levels)
    for phase in range(n_phase(wavelet.levels)):
        np.testing.assert_array_equal(found[:, phase], detail_rms(records[:, phase:], wavelet))


RUN = RunRequest().with_values({"record.duration": 10.0, "input.period": 1.0})
TIME = np.arange(RUN.record.n_sample) / RUN.record.sampling_frequency
WAVE = np.where(np.arange(TIME.size) % 500 < 250, 9e6, 7e6)


def _features(run, pressure, settled_from) -> dict[str, np.ndarray]:
    return pressure_features([run.parameters], RunSpec(run).analysis, pressure, settled_from)


def _job(run: RunRequest, coefficient: float, name: str = "") -> Job:
    return Job.of(RunSpec(run), name, coefficient)


def _decaying(share: float, time_constant: float) -> np.ndarray:
    return (WAVE * (1.0 + share * np.exp(-TIME / time_constant)))[None]


def test_a_periodic_record_is_settled_from_its_start_or_in_whole_periods_and_one_period_says_nothing() -> (
    None
):
    change, start = how_records_settle([RUN], WAVE[None], SETTLED_CHANGE)
    assert start == 0.0
    assert change < 1e-12
    change, start = how_records_settle([RUN], _decaying(0.5, 0.5), SETTLED_CHANGE)
    assert start % 1.0 == 0.0
    assert 0.0 < start <= 8.0
    assert change < SETTLED_CHANGE
    single = how_records_settle([RUN.with_values({"record.duration": 1.0})], WAVE[None, :500], SETTLED_CHANGE)
    assert np.isnan(single).all()


def test_settled_features_do_not_see_the_start_and_a_record_that_never_settles_has_none() -> None:
    start = _decaying(0.5, 0.2)
    late = _features(RUN, start, how_records_settle([RUN], start, SETTLED_CHANGE)[1])
    never = _features(RUN, WAVE[None], np.zeros(1))
    np.testing.assert_allclose(late["settled_detail_rms"], never["settled_detail_rms"], rtol=2e-3)
    whole = coefficient_rms(start, RUN.wavelet).detail
    assert abs(whole / never["settled_detail_rms"] - 1.0).max() > 1e-2
    change, start = how_records_settle([RUN], _decaying(0.5, 50.0), SETTLED_CHANGE)
    assert np.isnan(start)
    assert change > SETTLED_CHANGE
    features = _features(RUN, _decaying(0.5, 50.0), start)
    assert np.isnan(features["settled_detail_rms"]).all()
    assert np.isfinite(features["mean_chamber_1_pressure"]).all()


def test_records_without_a_period_are_measured_without_their_boundary() -> None:
    run = RUN.with_values({"input.shape": "steps", "analysis.discard": 1.0})
    noise = np.random.default_rng(1).normal(size=(1, run.record.n_sample))
    noise[:, :500] *= 1e6  # left out by analysis.discard
    _, start = how_records_settle([run], noise, SETTLED_CHANGE)
    features = _features(run, noise, start)
    assert np.isnan(start)
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


def test_a_phase_by_itself_is_that_of_all_phases() -> None:
    short = RUN.with_values({"record.duration": 4.0, "analysis.discard": 1.0})
    every = compute_columns([_job(short.with_values({"wavelet.phase": "all"}), 4e-9)])
    for phase in (0, 31):
        alone = compute_columns([_job(short.with_values({"wavelet.phase": phase}), 4e-9)])
        np.testing.assert_array_equal(every["phase_detail_rms"][:, phase], alone["detail_rms"])
        assert "phase_detail_rms" not in alone
    phases = every["settled_phase_detail_rms"]
    np.testing.assert_allclose(np.sqrt(np.mean(phases**2, axis=1)), every["settled_detail_rms"], rtol=1e-3)
