"""Input voltages, and records that leave out their start."""

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.drive import InputConfig, RecordConfig, held_text
from hydrofdi.errors import ConfigError
from hydrofdi.simulation.inputs import input_voltage, largest_voltage

RUN = RecordConfig(duration=4.0)


def _voltage(**fields: object) -> np.ndarray:
    return input_voltage(InputConfig.model_validate(fields), RUN, np.arange(RUN.n_step))


@pytest.mark.parametrize("shape", ["square", "steps", "sine", "csv"])
def test_voltage_stays_within_the_largest_and_does_not_depend_on_the_chunk(shape: str) -> None:
    file = held_text("x", "0,0.5\n0.5,-3\n4,50\n") if shape == "csv" else None
    drive = InputConfig.model_validate({"shape": shape, "period": 0.5, "amplitude": -1.5, "file": file})
    whole = input_voltage(drive, RUN, np.arange(RUN.n_step))
    largest, found = largest_voltage(drive, RUN), np.abs(whole).max()
    assert largest == {"csv": 3.0, "steps": found}.get(shape, 1.5)
    assert 0.5 < found <= largest * (1.0 + 1e-3)
    np.testing.assert_array_equal(input_voltage(drive, RUN, np.arange(12_345, 23_456)), whole[12_345:23_456])


def test_steps_hold_for_a_period_and_follow_their_seed_and_a_sine_has_one_line() -> None:
    first, again, other = (_voltage(shape="steps", period=0.25, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.any(first != other)
    np.testing.assert_array_equal(np.flatnonzero(np.diff(first)) + 1, 2500 * np.arange(1, 16))
    spectrum = np.abs(np.fft.rfft(_voltage(shape="sine", period=0.5, amplitude=2.0))) * 2.0 / RUN.n_step
    assert np.flatnonzero(spectrum > 1e-9).tolist() == [8]
    assert spectrum[8] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (["input.shape=steps", "input.period=0.10005 s"], "period"),
        (["analysis.discard=30 s"], "discard"),
        (["record.duration=2 s", "analysis.discard=1.8 s"], "discard"),
        (["analysis.discard=0.0003 periods"], "discard"),
        (["input.shape=steps", "analysis.discard=1 period"], "discard"),
    ],
)
def test_impossible_input_or_record_is_refused(settings: list[str], key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        load_experiment(settings=settings)
