import numpy as np
import pytest

from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.cutting import edges
from tests.records.streams.plain import make_windower, windows_of

P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE
LOW, HIGH = [-1.0] * 4, [1.0] * 4


def _windows(drive, n_sample, edge="rising", time=None):
    drive = np.asarray(drive, dtype=float)
    time = np.arange(drive.size) / 10.0 if time is None else time
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


def test_a_cycle_that_did_not_end_is_no_window():
    assert _windows(LOW + HIGH, 5) == []
    assert len(_windows(LOW + HIGH, 4)) == 1


def test_a_drive_that_comes_from_the_middle_or_has_noise_in_the_band_has_no_edges():
    assert _windows([0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.19, -0.19, 0.21, 1.0], 2) == []
    assert _windows([0.0, -1.0, -0.19, 0.19, np.nan, 0.21, -0.21], 2) == [([5.0, 6.0], None)]


def test_a_gap_ends_a_cycle_without_a_window_and_the_next_edge_is_awaited():
    drive, time = np.array(LOW + HIGH * 3 + LOW + HIGH), np.arange(24) / 10.0
    time[6:] += 5.0
    assert _windows(drive, 4, time=time) == [([20.0, 21.0, 22.0, 23.0], None)]


def test_an_edge_inside_of_a_gap_is_none():
    drive, time = np.array(LOW + HIGH + LOW), np.arange(12) / 10.0
    time[4:] += 5.0
    assert _windows(drive, 2, time=time) == []


def test_edges_of_a_drive_are_those_of_a_record_with_its_range():
    drive = np.sin(np.arange(500) / 7.0) + 0.05 * np.random.default_rng(1).normal(size=500)
    low, high = float(drive.min()), float(drive.max())
    windower = make_windower(
        "cycle", 1, channels=(U,), sampling_frequency=10.0, drive=(low, high), edge="both"
    )
    starts = [
        round(10.0 * window.time[0]) for window in windows_of(np.arange(500) / 10.0, {U: drive}, windower)
    ]
    assert starts == edges(drive, "both")
    assert len(starts) > 10
