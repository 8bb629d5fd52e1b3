import numpy as np
import pytest

from hydrofdi.records.batch import Channel
from tests.records.streams.plain import make_windower, windows_of

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION
V, U = Channel.PISTON_VELOCITY, Channel.INPUT_VOLTAGE
FREQUENCY, N = 100.0, 300


def _healthy():
    time = np.arange(N) / FREQUENCY
    wave = np.sin(2.0 * np.pi * time)
    return time, {P1: 5e6 + 4e6 * wave, P2: 5e6 - 4e6 * wave, X: 0.1 * wave, V: -0.1 * wave, U: 2.0 * wave}


def _fault(time, samples, channels=(P1, P2, X, V, U)):
    windower = make_windower("time", N, channels=channels, sampling_frequency=FREQUENCY)
    (window,) = windows_of(time, samples, windower)
    return window.fault


def test_a_sound_window_has_no_fault():
    assert _fault(*_healthy()) is None


@pytest.mark.parametrize(("factor", "is_said"), [(0.98, True), (0.992, False), (1.008, False), (1.02, True)])
def test_a_mean_rate_that_differs_by_more_than_a_hundredth_is_said(factor, is_said):
    time, samples = _healthy()
    fault = _fault(time / factor, samples)
    assert (fault is not None) == is_said
    if fault:
        assert (fault.kind, fault.message) == (
            "other_rate",
            f"samples come at {100 * factor:g} Hz instead of 100 Hz",
        )


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_missing_samples_of_a_needed_channel_are_said(value):
    time, samples = _healthy()
    samples[P2][[3, 299]] = value
    fault = _fault(time, samples)
    assert fault.kind == "missing"
    assert fault.message == "2 of 300 samples of chamber_2_pressure are missing or not finite"


def test_a_channel_that_is_not_there_at_all_is_said():
    time, samples = _healthy()
    del samples[X]
    assert _fault(time, samples).kind == "missing_channel"
    samples[X] = np.full(N, np.nan)
    assert _fault(time, samples).message == "piston_position is missing"


@pytest.mark.parametrize("channel", [P1, P2, V])
def test_a_pressure_or_velocity_that_never_changes_is_stuck(channel):
    time, samples = _healthy()
    samples[channel][:] = samples[channel][0]
    fault = _fault(time, samples)
    assert (fault.kind, fault.message) == ("stuck", f"{channel} never changes")


def test_a_position_that_freezes_while_the_pressures_move_is_stuck():
    time, samples = _healthy()
    samples[X][100:250] = samples[X][100]
    fault = _fault(time, samples)
    assert (fault.kind, fault.message) == (
        "stuck",
        "piston_position does not change for 1.5 s while the pressures do",
    )


@pytest.mark.parametrize("rests", [{X, U}, {U}])
def test_a_command_may_rest_and_a_position_where_the_pressures_hardly_move(rests):
    time, samples = _healthy()
    for channel in rests:
        samples[channel][:] = 1.0
    if X in rests:
        samples[P1], samples[P2] = 5e6 + 0.01 * (samples[P1] - 5e6), 5e6 + 0.01 * (samples[P2] - 5e6)
    assert _fault(time, samples) is None


def test_channels_that_the_detector_does_not_need_have_no_faults():
    time, samples = _healthy()
    samples[P2][:], samples[V][5] = 1.0, np.nan
    assert _fault(time, samples, channels=(P1, X)) is None


def test_windows_own_their_samples():
    time, samples = _healthy()
    windower = make_windower("time", 100, 50, channels=(P1, X), sampling_frequency=FREQUENCY)
    first, second, *_ = windows_of(time, samples, windower)
    for one, other in ((first.time, second.time), (first.channels[P1], second.channels[P1])):
        assert one.flags.c_contiguous
        assert not np.shares_memory(one, other)
    assert not np.shares_memory(first.time, time)


def test_a_step_leaves_its_state_and_the_windows_before_as_they_were():
    time, samples = _healthy()
    windower = make_windower("time", 20, 5, channels=(P1,), sampling_frequency=FREQUENCY)
    whole = windows_of(time, samples, windower)
    copies = [window.channels[P1].copy() for window in whole]
    samples[P1][:] = 0.0
    windows_of(time, samples, windower)
    for window, copy in zip(whole, copies, strict=True):
        np.testing.assert_array_equal(window.channels[P1], copy)
