import tracemalloc
from itertools import pairwise

import numpy as np
import pytest

from hydrofdi.records import Channel
from hydrofdi.records.recording import edges
from hydrofdi.records.streams import Chunk, EvenStream
from tests.records.streams.plain import make_windower, windows_of

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION
V, U = Channel.PISTON_VELOCITY, Channel.INPUT_VOLTAGE
FREQUENCY, N = 100.0, 300


def _healthy():
    time = np.arange(N) / FREQUENCY
    wave = np.sin(2.0 * np.pi * time)
    return time, {P1: 5e6 + 4e6 * wave, P2: 5e6 - 4e6 * wave, X: 0.1 * wave, V: -0.1 * wave, U: 2.0 * wave}


def _fault(time, samples, channels=(P1, P2, X, V, U), frequency=FREQUENCY):
    windower = make_windower("time", N, channels=channels, sampling_frequency=frequency)
    (window,) = windows_of(time, samples, windower)
    return window.fault


def _all_rest(samples):
    samples[X][:] = samples[U][:] = 1.0
    samples[P1], samples[P2] = (5e6 + 0.01 * (samples[channel] - 5e6) for channel in (P1, P2))


CHANGES = {
    "sound": (lambda samples: None, None, ""),
    "inf": (lambda samples: samples[P2].put([3, 299], np.inf), "missing", "2 of 300"),
    "no channel": (lambda samples: samples.pop(X), "missing_channel", X),
    "all nan": (lambda samples: samples[X].fill(np.nan), "missing_channel", X),
    "stuck P1": (lambda samples: samples[P1].fill(5e6), "stuck", P1),
    "stuck v": (lambda samples: samples[V].fill(0.1), "stuck", V),
    "frozen x": (lambda samples: samples[X][100:250].fill(samples[X][100]), "stuck", "1.5 s"),
    "command rests": (lambda samples: samples[U].fill(1.0), None, ""),
    "all rest": (_all_rest, None, ""),
}


@pytest.mark.parametrize(("change", "kind", "part"), CHANGES.values(), ids=CHANGES)
def test_what_is_missing_or_stuck_is_said_and_rest_is_no_fault(change, kind, part):
    time, samples = _healthy()
    change(samples)
    fault = _fault(time, samples)
    assert (fault and fault.kind) == kind
    assert fault is None or part in fault.message
    assert kind is None or part not in (P1, P2) or _fault(time, samples, channels=(X,)) is None


JITTER = np.where(np.arange(N) % 20 == 10, 1.0 / FREQUENCY, 0.0)
EVEN = np.arange(N) / FREQUENCY


@pytest.mark.parametrize(("time", "kind", "frequency"), [
    (EVEN + 0.2 * JITTER, None, 100.0), (EVEN + 0.4 * JITTER, "uneven", 100.0),
    (np.round(EVEN / 6.0, 3), None, 600.0), (EVEN / 0.98, "other_rate", 100.0), (EVEN / 0.992, None, 100.0),
    (EVEN / 1.008, None, 100.0), (EVEN / 1.02, "other_rate", 100.0),
], ids=["0.2 steps", "0.4 steps", "rounded", "98 %", "99.2 %", "100.8 %", "102 %"])  # fmt: skip
def test_stamps_may_jitter_by_a_quarter_of_a_step_and_the_mean_rate_differ_by_a_hundredth(
    time, kind, frequency
):
    fault = _fault(time, _healthy()[1], frequency=frequency)
    assert (fault and fault.kind) == kind


def test_the_unit_of_a_time_in_another_one_is_asked_for():
    time, samples = _healthy()
    assert "in exceldays?" in _fault(time / 86_400.0, samples).message
    for factor, unit in ((1e3, "ms"), (1e6, "µs")):
        stream = EvenStream(FREQUENCY, (P1,))
        events = stream.step(stream.start(), Chunk(time * factor, samples))[2]
        assert f"in {unit}?" in events[-1].text


def test_windows_own_their_samples_and_a_step_leaves_those_before_as_they_were():
    time, samples = _healthy()
    windower = make_windower("time", 20, 5, channels=(P1,), sampling_frequency=FREQUENCY)
    whole = windows_of(time, samples, windower)
    assert not any(np.shares_memory(one.channels[P1], two.channels[P1]) for one, two in pairwise(whole))
    copies = [window.channels[P1].copy() for window in whole]
    samples[P1][:] = 0.0
    windows_of(time, samples, windower)
    for window, copy in zip(whole, copies, strict=True):
        np.testing.assert_array_equal(window.channels[P1], copy)


LOW, HIGH = [-1.0] * 4, [1.0] * 4


def _windows(drive, n_sample, edge="rising"):
    drive = np.asarray(drive, dtype=float)
    time = np.arange(drive.size) / 10.0
    windower = make_windower(
        "cycle", n_sample, channels=(P1,), sampling_frequency=10.0, drive=(-1.0, 1.0), edge=edge
    )
    windows = windows_of(time, {P1: np.arange(float(drive.size)), U: drive}, windower)
    return [(window.channels[P1].tolist(), window.fault and window.fault.kind) for window in windows]


@pytest.mark.parametrize(
    ("edge", "firsts"), [("rising", [4, 12]), ("falling", [8, 16]), ("both", [4, 8, 12, 16])]
)
def test_cycles_begin_at_edges_and_are_cut_to_the_window(edge, firsts):
    expected = [([float(first + n) for n in range(3)], None) for first in firsts]
    assert _windows((LOW + HIGH) * 2 + LOW, 3, edge) == expected


def test_a_cycle_that_is_too_short_is_a_window_that_cannot_be_judged():
    (first, second) = _windows([*LOW, 1.0, -1.0, *HIGH, *LOW], 8)
    assert first == ([4.0, 5.0], "short_cycle")
    assert second == ([float(n) for n in range(6, 14)], None)


def test_a_drive_that_comes_from_the_middle_or_has_noise_in_the_band_has_no_edges():
    assert _windows([0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.19, -0.19, 0.21, 1.0], 2) == []
    assert _windows([0.0, -1.0, -0.19, 0.19, np.nan, 0.21, -0.21], 2) == [([5.0, 6.0], None)]


def test_edges_of_a_drive_are_those_of_a_record_with_its_range():
    drive = np.sin(np.arange(500) / 7.0) + 0.05 * np.random.default_rng(1).normal(size=500)
    low, high = float(drive.min()), float(drive.max())
    of_drive = {"sampling_frequency": 10.0, "drive": (low, high), "edge": "both"}
    windows = windows_of(
        np.arange(500) / 10.0, {U: drive}, make_windower("cycle", 1, channels=(U,), **of_drive)
    )
    starts = [round(10.0 * window.time[0]) for window in windows]
    assert starts == edges(drive, "both")
    assert len(starts) > 10


FREQUENCY_MEMORY, N_CHUNK = 1000.0, 5_000

WINDOWINGS = {
    "sliding": {"by": "time", "n_sample": 1000, "n_every": 400},
    "apart": {"by": "time", "n_sample": 100, "n_every": 1_000_000},
    "cycles that never end": {"by": "cycle", "n_sample": 1000, "drive": (-9.0, -8.9)},
}


@pytest.mark.parametrize("windowing", WINDOWINGS.values(), ids=WINDOWINGS)
def test_memory_stays_as_it_is_over_many_samples(windowing):
    stream = EvenStream(FREQUENCY_MEMORY, (P1, U))
    windower = make_windower(**windowing, channels=(P1, U), sampling_frequency=FREQUENCY_MEMORY)
    state, held, in_use = stream.start(), windower.start(), []
    one_window = 3 * 8 * windowing["n_sample"]
    tick = np.arange(N_CHUNK) / FREQUENCY_MEMORY
    wave = np.sin(2.0 * np.pi * 0.93 * tick)
    tracemalloc.start()
    for count in range(60):
        gap = 10.0 * (count // 7)
        chunk = Chunk(gap + count * N_CHUNK / FREQUENCY_MEMORY + tick, {P1: 1e6 * wave, U: wave})
        state, pieces, _ = stream.step(state, chunk)
        for piece in pieces:
            held = windower.step(held, piece)[0]
        del chunk, pieces, piece
        for stored in (state, held):
            assert all(array.base is None for array in stored.values())
            assert sum(array.nbytes for array in stored.values()) < one_window + 200
        in_use.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert max(in_use[10:]) < min(in_use[:10]) + 2 * one_window + 20_000
