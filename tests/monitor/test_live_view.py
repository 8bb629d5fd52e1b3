"""The live view as text: what it says in each state, and that it fits."""

from __future__ import annotations

import time
from dataclasses import replace
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from hydrofdi.cli.monitor.live_view import LiveView, duration_text, instant_text, screen_lines, summary_lines
from hydrofdi.cli.monitor.watched import Watched
from hydrofdi.errors import Issue
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources.malformed import malformed
from hydrofdi.monitor.watch import Watch
from hydrofdi.records import Channel
from hydrofdi.settings.readable import count_text, plain
from tests.detectors.trained.made import detector
from tests.monitor.streams import made_detector, part, stream

FILE, CHART = made_detector(), made_detector(chart="cusum")
LEAKING = stream(24, leaking=range(12, 24))


def watched(n_window=24, file=FILE, chunk=LEAKING):
    """What a view knows after so many windows of a stream that leaks in its second half."""
    seen, watch = Watched(file, "mqtts://broker.example/hall-2/press-1"), Watch(file)
    state = watch.start()
    for first in range(0, n_window * 1000, 1000):
        some = part(chunk, first, first + 1000)
        state, lines = watch.step(state, some)
        seen.take(some, lines)
    return seen


def text_of(seen, width=80, height=24, *, plain=False):
    return "\n".join(line.plain for line in screen_lines(seen, width, height, is_ascii=plain))


def test_before_the_first_sample_it_waits_and_states_limit_and_promise():
    text = text_of(Watched(FILE, "standard input"))
    assert " NO DATA  waiting for samples" in text
    assert "alarm above" in text
    promise = "Promise: 1 % of healthy windows lie beyond the limit (0 to 5 %), from 99 healthy windows"
    assert promise in " ".join(text.split())


def test_estimates_are_not_called_windows():
    file = detector("weak_rls", window={"by": "estimate"})
    text = text_of(Watched(file, "standard input"))
    assert "0 estimates judged" in text
    assert "healthy estimates" in text
    assert "window" not in text


def test_health_and_alarm_are_said_in_words_with_the_instant_of_the_change():
    assert " HEALTHY  since 1.0 s" in text_of(watched(10))
    text = text_of(watched())
    assert " ALARM  since 13.0 s" in text
    assert "24 windows judged, 12 beyond the limit, 1 alarm\n" in text
    assert "13.0 s: ALARM, the score is" in text


def test_the_last_windows_are_listed_with_their_verdicts():
    text = text_of(watched(chunk=stream(24, leaking=range(12, 20), stuck=range(20, 24))), height=60)
    verdicts = ["within the limit"] * 12 + ["beyond the limit"] * 8 + ["not judged, stuck"] * 4
    assert [line.split("  ")[-1] for line in text.splitlines() if line.endswith((*verdicts,))] == verdicts
    assert "4 not judged (stuck 4)" in text


def test_a_window_that_is_not_judged_says_why_and_whether_its_score_is_beyond_the_limit():
    seen = watched()
    (last,) = list(seen.windows)[-1:]
    fault = Issue("the pressure is higher than ever", kind="novel")
    seen.take(None, [replace(last, verdict=replace(last.verdict, alarm=None, fault=fault))])
    assert ", beyond its limit; not judged, novel: the pressure is higher than ever" in text_of(seen, 120)


def test_with_a_chart_its_statistic_decides_and_is_shown():
    text = text_of(watched(file=CHART))
    assert " of 8" in text
    assert "ALARM" in text
    assert "24 windows judged, 12 beyond the limit, 1 alarm\n" in text


def test_a_condition_that_is_not_of_now_is_not_shown_as_if_it_were():
    seen = watched(10)
    seen.take(None, [Event(EventKind.DISCONNECTED, "the broker is gone; trying again")])
    text = text_of(seen)
    assert " NO DATA  disconnected, no samples for" in text
    assert "last condition: healthy" in text
    assert "the broker is gone" in text
    assert " HEALTHY " not in text
    seen.take(None, [Event(EventKind.DISCONNECTED, "nothing listens there; trying again")])
    assert "1 disconnection\n" in text_of(seen)
    seen.take(part(LEAKING, 10_000, 10_100), [])
    assert " HEALTHY " in text_of(seen)


def test_a_server_that_was_never_there_is_no_disconnection():
    seen = Watched(FILE, "-")
    seen.take(None, [Event(EventKind.DISCONNECTED, "nothing listens there; trying again")])
    assert "disconnection" not in text_of(seen)
    seen.take(None, [Event(EventKind.CONNECTED, "connected"), Event(EventKind.DISCONNECTED, "it is gone")])
    assert "1 disconnection\n" in text_of(seen)


def test_a_stream_that_falls_silent_is_no_longer_healthy(monkeypatch):
    seen, now = watched(10), time.monotonic()
    for wait, badge in ((4.0, " HEALTHY "), (6.0, " NO DATA  no samples for 6")):
        monkeypatch.setattr("hydrofdi.cli.monitor.watched.time.monotonic", lambda w=wait: now + w)
        assert badge in text_of(seen)


SEEN = [Watched(FILE, "-"), watched(1), watched(), watched(file=CHART)]


@given(st.sampled_from(SEEN), st.integers(20, 250), st.integers(4, 90), st.booleans())
def test_it_fits_every_terminal(seen, width, height, plain):
    lines = text_of(seen, width, height, plain=plain).splitlines()
    assert len(lines) <= height
    assert max(map(len, lines)) <= width


def test_without_unicode_it_is_ascii():
    assert text_of(watched(), plain=True).isascii()


def test_the_newest_event_is_told_in_full():
    seen = watched(2)
    seen.take(
        None, [Event(EventKind.DISCONNECTED, "no connection " + "to the broker " * 8 + "because it is gone")]
    )
    assert text_of(seen, 60).endswith("because it is gone")


def test_a_long_remedy_is_told_from_its_beginning_to_its_end():
    seen = watched()
    text = f"no connection: {'the certificate is not trusted; ' * 5}give it with mqtt.ca_file"
    seen.take(None, [Event(EventKind.DISCONNECTED, text)])
    for width, height in ((80, 24), (60, 20)):
        shown = text_of(seen, width, height)
        assert text in " ".join(shown.split())
        assert "windows judged" in shown


def test_lines_that_cannot_be_read_are_said_with_the_first_reason():
    seen = Watched(FILE, "press.csv")
    for text, why in (("a,b", "no number"), ("c", "too few cells")):
        seen.take(malformed("line", text, why), [])
    text = text_of(seen)
    assert " NO DATA  no sample could be read: 2 malformed\nmalformed line 'a,b': no number\n" in text
    seen.take(part(LEAKING, 0, 1000), [])
    assert "could be read" not in text_of(seen)


def test_what_goes_on_is_counted_once_and_its_end_adds_nothing():
    seen = watched(2)
    gap = Event(EventKind.GAP, "a gap", 1.0)
    seen.take(None, [gap, replace(gap, count=3, is_silent=True), replace(gap, count=4, is_end=True)])
    assert "4 gaps" in text_of(seen)


def test_it_knows_no_more_after_a_million_windows_than_after_a_thousand():
    seen = Watched(FILE, "-")
    (line,) = watched(1).windows
    for _ in range(3):
        seen.take(None, [line, Event(EventKind.GAP, "a gap", 1.0)] * 1000)
    assert seen.n_window == 3000
    assert len(seen.windows) <= 1000
    assert len(seen.events) <= 1000
    long = Watched(FILE.model_copy(update={"n_sample": 10_000_000}), "-")
    for first in range(10):
        long.take(replace(LEAKING, time=LEAKING.time + 24.0 * first), [])
    assert long.tails[Channel.CHAMBER_1_PRESSURE].size <= 100_000
    assert "Last 50 s of samples" in text_of(long)


def test_a_closed_view_leaves_a_summary_on_the_terminal():
    console = Console(file=StringIO(), force_terminal=True, width=80, height=24)
    view = LiveView(FILE, "standard input", console)
    view.put(part(LEAKING, 0, 1000), [])
    view.close()
    text = console.file.getvalue()
    assert "standard input, watched for" in text.rpartition("\x1b[?1049l")[2]


def test_the_summary_names_windows_alarms_with_their_instants_and_events():
    seen = watched(chunk=stream(24, leaking=range(12, 20), stuck=range(20, 24)))
    seen.take(None, [Event(EventKind.GAP, "a gap", 24.0, count=2), Event(EventKind.STARTED, "watches")])
    assert [*summary_lines(seen)][1:] == [
        "20 windows judged, 8 beyond the limit, 1 alarm",
        "alarms raised at 13.0 s",
        "4 not judged (stuck 4)",
        "2 gaps",
    ]
    seen.take(None, [Event(EventKind.ALARM_RAISED, "again", 30.0 + each) for each in range(1000)])
    assert "1,029.0 s; 991 before" in [*summary_lines(seen)][2]


def test_numbers_are_written_out():
    assert [plain(each, 3) for each in (19_634.0, 3.64e-5, -0.227, 12.0, 0.0)] == [
        "19600", "0.0000364", "-0.227", "12", "0",
    ]  # fmt: skip
    assert plain(1e-12, 3) == "1e-12"
    assert count_text(0.00002) == "0.00002"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0 s"), (0.25, "0.2 s"), (9.96, "10 s"), (200, "3 min 20 s"), (3600, "1 h"), (356400, "4 d 3 h")],
)
def test_durations_are_written_in_units_that_a_person_reads(seconds, text):
    assert duration_text(seconds) == text


def test_a_clock_that_counts_from_1970_is_shown_as_date_and_time():
    assert instant_text(12.34) == "12.3 s"
    assert instant_text(1.7e9).startswith("2023-11-1")
