"""What a watch says does not depend on chunks and restarts; it says things once, and counts them."""

import time
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from hydrofdi.cli.live_view import LiveView
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.lines import Condition, WindowLine, line_record
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.detectors.trained.made import detector, window
from tests.monitor.streams import N_SAMPLE, lines_of, made_detector, part, rearranged, stream
from tests.records.streams.plain import windows_of

FILES = {
    "side by side": made_detector(),
    "sliding": made_detector(every=0.3),
    "chart": made_detector(chart="cusum"),
}


def events_of(lines, *kinds):
    return [line for line in lines if isinstance(line, Event) and line.kind in kinds]


def windows(lines):
    return [line for line in lines if isinstance(line, WindowLine)]


def said_of(name, made):
    """Lines of a stream that a detector watches."""
    return lines_of(Detector(FILES[name]), [made])


def total(lines, kind):
    return sum(event.count for event in events_of(lines, kind) if not event.is_end)


@st.composite
def streams(draw):
    """Windows that leak or are stuck; samples that are lost, doubled, late, and without a time; a jump."""
    numbers = st.lists(st.integers(0, 24), max_size=4)
    made = stream(25, leaking=draw(numbers), stuck=draw(numbers))
    places = np.arange(made.n_time)
    for kind in draw(st.lists(st.sampled_from("ldrnj"), max_size=6)):
        at = draw(st.integers(0, places.size - 1))
        if kind == "l":
            places = np.delete(places, slice(at, at + draw(st.integers(1, 3000))))
            places = places if places.size else np.arange(10)
        elif kind == "d":
            places = np.insert(places, at, places[at], axis=0)
        elif kind == "r":
            places = np.insert(places, at, places[max(0, at - 500) : at + 1])
    made = rearranged(made, places)
    time = made.time.copy()
    for at in draw(st.lists(st.integers(0, time.size - 1), max_size=3)):
        time[at] = np.nan
    time[draw(st.integers(0, time.size)) :] += draw(st.sampled_from([0.0, 59.0, 61.0, 1e4]))
    return Chunk(time, made.channels)


def divided(chunk, sizes):
    """A chunk in parts of such sizes, again and again."""
    first, turn = 0, 0
    while first < chunk.n_time:
        yield part(chunk, first, first + sizes[turn % len(sizes)])
        first, turn = first + sizes[turn % len(sizes)], turn + 1


SIZES = st.lists(st.sampled_from([1, 2, 3, 50, 777, 1000, 5000]), min_size=2, max_size=4).filter(
    lambda sizes: sum(sizes) > 300
)


@settings(max_examples=25, deadline=None)
@given(streams(), SIZES, st.sampled_from(sorted(FILES)))
def test_lines_do_not_depend_on_chunks(made, sizes, name):
    watch = Detector(FILES[name])
    said = [lines_of(watch, chunks) for chunks in ([made], divided(made, sizes))]
    shown = [[line for line in lines if not getattr(line, "is_silent", False)] for lines in said]
    assert shown[0] == shown[1]
    assert [line.number for line in windows(said[0])] == list(range(len(windows(said[0]))))


def test_verdicts_are_those_of_the_same_windows_in_a_batch():
    for file in FILES.values():
        made = stream(20, leaking=[7, 8], stuck=[3])
        windower = file.config.window.windower(N_SAMPLE, file.channels, file.sampling_frequency, None)
        whole = windows_of(made.time, made.channels, windower)
        said = windows(lines_of(Detector(file), divided(made, [777])))
        assert [line.verdict for line in said] == Detector(file).score(whole)
        assert [(line.start, line.end) for line in said] == [(each.time[0], each.time[-1]) for each in whole]


@pytest.mark.parametrize("stuck", [range(5, 45), range(5, 45, 5)], ids=["throughout", "interrupted"])
def test_a_stuck_channel_is_said_when_it_begins_and_when_it_ends(stuck):
    lines = said_of("side by side", stream(60, stuck=stuck))
    begin, *silent, end = events_of(lines, EventKind.STUCK)
    assert len(windows(lines)) == 60
    assert (begin.time, begin.is_silent, begin.is_end) == (5.0, False, False)
    assert all(event.is_silent for event in silent)
    assert total(lines, EventKind.STUCK) == end.count == len(stuck)
    assert (end.is_end, end.time) == (True, stuck[-1] + 0.999)


def test_what_goes_on_is_said_once_a_minute_with_its_count():
    places = np.arange(130_000)
    lines = said_of("side by side", rearranged(stream(130), np.sort([*places, *places[::10]])))
    said = events_of(lines, EventKind.DUPLICATE)
    assert [event.count for event in said] == [1, 5999, 6000, 1000]
    assert [event.time for event in said[1:]] == [60.0, 120.0, 180.0]
    assert len(windows(lines)) == 130


def test_an_alarm_is_raised_once_and_cleared_after_ten_calm_windows_and_conditions_lapse():
    leaking, stuck = [20, 21, 25, 34, 47], [0, 1, *range(10, 14), *range(48, 60)]
    lines = said_of("side by side", stream(70, leaking=leaking, stuck=stuck))
    assert [line.number for line in windows(lines) if line.verdict.alarm] == leaking
    said = events_of(lines, EventKind.ALARM_RAISED, EventKind.ALARM_CLEARED)
    assert [each.time for each in said] == [20.999, 44.999, 47.999, 69.999]
    assert [each.kind is EventKind.ALARM_RAISED for each in said] == [True, False] * 2
    unknown, alarm = (
        [line.number for line in windows(lines) if line.condition is each]
        for each in (Condition.UNKNOWN, Condition.ALARM)
    )
    assert unknown == [0, 1, 57, 58, 59], "before the first, and after ten that are not judged"
    assert alarm == [*range(20, 44), *range(47, 57), *range(60, 69)]


def test_with_a_chart_its_alarms_decide():
    lines = said_of("chart", stream(60, leaking=range(30, 40)))
    first = next(line for line in windows(lines) if line.chart.alarm)
    (raised,) = events_of(lines, EventKind.ALARM_RAISED)
    assert 30 <= first.number < 40
    assert raised.time == first.end
    assert first.chart.statistic >= first.chart.limit
    assert line_record(replace(first, verdict=replace(first.verdict, alarm=False)))["alarm"] is True
    assert line_record(replace(first, chart=replace(first.chart, alarm=False)))["alarm"] is False


def test_novel_windows_whose_score_comes_to_lie_beyond_the_limit_are_said_anew():
    healthy = [window(number, 100 + number) for number in range(20)]
    file = FILES["side by side"]
    file = file.model_copy(update={"ranges": detector(ranges=healthy).ranges})
    made = stream(60, leaking=range(20, 40))
    made.channels[Channel.CHAMBER_1_PRESSURE][10_000:40_000] += 20e6
    lines = lines_of(Detector(file), [made])
    said = [event for event in events_of(lines, EventKind.NOVEL) if not event.is_silent]
    begun = [event for event in said if not event.is_end]
    assert [event.time for event in begun] == [10.0, 20.0]
    assert ["beyond its limit" in event.text for event in begun] == [False, True]
    assert [event.count for event in said if event.is_end] == [10, 20]
    assert total(lines, EventKind.NOVEL) == 30


def test_a_condition_that_is_not_of_now_is_not_shown_as_if_it_were(monkeypatch):
    file, made = FILES["side by side"], stream(11)
    console = Console(file=StringIO(), force_terminal=True, width=100, height=40, highlight=False)
    seen, watch = LiveView(file, "mqtts://broker.example/hall-2/press-1", console), Detector(file)
    state = watch.start()
    for some in divided(part(made, 0, 10_000), [1000]):
        state, lines = watch.step(state, some)
        seen._take(some, lines)
        assert sum(array.nbytes for array in state.values()) < 2 * 8 * N_SAMPLE + 1000

    def shown():
        return "\n".join(line.plain for line in seen._lines())

    seen._take(None, [Event(EventKind.DISCONNECTED, "the broker is gone; trying again")])
    text = shown()
    assert " SILENT  disconnected, no samples for" in text
    assert "last condition: healthy" in text
    assert "the broker is gone" in text
    seen._take(part(made, 10_000, 10_100), [])
    now = time.monotonic()
    for wait, badge in ((0.0, " HEALTHY "), (4.0, " HEALTHY "), (6.0, " SILENT  no samples for 6")):
        monkeypatch.setattr("hydrofdi.cli.live_view.time.monotonic", lambda w=wait: now + w)
        assert badge in shown()
    seen._take(None, [seen._windows[0], Event(EventKind.GAP, "a gap", 1.0)] * 3000)
    assert "3,010 windows judged" in shown()
    assert max(len(seen._windows), len(seen._events)) <= 1000
