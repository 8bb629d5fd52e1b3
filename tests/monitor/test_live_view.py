"""The live view as text: what it says in each state."""

import time
from io import StringIO

from rich.console import Console

from hydrofdi.cli.live_view import LiveView
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.watch import Watch
from tests.monitor.streams import made_detector, part, stream

FILE, CHART = made_detector(), made_detector(chart="cusum")
LEAKING = stream(24, leaking=range(12, 24))


def console():
    return Console(file=StringIO(), force_terminal=True, width=100, height=40, highlight=False)


def view(n_window=24, file=FILE, chunk=LEAKING):
    """A view after so many windows of a stream that leaks in its second half."""
    seen, watch = LiveView(file, "mqtts://broker.example/hall-2/press-1", console()), Watch(file)
    state = watch.start()
    for first in range(0, n_window * 1000, 1000):
        some = part(chunk, first, first + 1000)
        state, lines = watch.step(state, some)
        seen._take(some, lines)
    return seen


def text_of(seen):
    return "\n".join(line.plain for line in seen._lines())


def test_health_and_alarm_are_said_in_words_with_the_instant_of_the_change():
    assert " HEALTHY  since 1.0 s" in text_of(view(10))
    for file in (FILE, CHART):
        text = text_of(view(file=file))
        assert " ALARM  since " in text
        assert "24 windows judged, 12 beyond the limit, 1 alarm\n" in text
    assert ", chart " in text


def test_a_condition_that_is_not_of_now_is_not_shown_as_if_it_were(monkeypatch):
    seen = view(10)
    seen._take(None, [Event(EventKind.DISCONNECTED, "the broker is gone; trying again")])
    text = text_of(seen)
    assert " SILENT  disconnected, no samples for" in text
    assert "last condition: healthy" in text
    assert "the broker is gone" in text
    seen._take(part(LEAKING, 10_000, 10_100), [])
    assert " HEALTHY " in text_of(seen)
    now = time.monotonic()
    for wait, badge in ((4.0, " HEALTHY "), (6.0, " SILENT  no samples for 6")):
        monkeypatch.setattr("hydrofdi.cli.live_view.time.monotonic", lambda w=wait: now + w)
        assert badge in text_of(seen)


def test_it_knows_no_more_after_a_million_windows_than_after_a_thousand():
    seen = view(1)
    for _ in range(3):
        seen._take(None, [seen._windows[0], Event(EventKind.GAP, "a gap", 1.0)] * 1000)
    assert "3,001 windows judged" in text_of(seen)
    assert max(len(seen._windows), len(seen._events)) <= 1000


def test_a_closed_view_leaves_a_summary_on_the_terminal():
    seen = view(chunk=stream(24, leaking=range(12, 20), stuck=range(20, 24)))
    seen.put(None, [Event(EventKind.GAP, "a gap", 24.0, count=2)])
    seen.close()
    text = seen._console.file.getvalue().rpartition("\x1b[?1049l")[2]
    for told in (
        "press-1, watched for",
        "20 windows judged, 8 beyond",
        "raised at 13.0 s",
        "(stuck 4)",
        "gap 2",
    ):
        assert told in text
