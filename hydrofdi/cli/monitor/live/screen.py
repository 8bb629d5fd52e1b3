"""The live view as lines of text: state, signals, score against its limit, counts, events."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from hydrofdi.api.monitoring.lines import Condition
from hydrofdi.cli.folding import folded
from hydrofdi.cli.monitor.live.counting import counts_text, promise_text
from hydrofdi.cli.monitor.live.page import Page, heading
from hydrofdi.cli.monitor.live.panels import score_lines, signal_lines
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.cli.monitor.live.wording import (
    event_text,
    flow_text,
    reading_text,
    state_text,
)

_STYLES = {
    Condition.HEALTHY: "bold black on green",
    Condition.ALARM: "bold bright_white on red",
    Condition.UNKNOWN: "bold black on yellow",
}
_LEAST_EVENTS, _MOST_EVENTS, _MOST_SIGNAL, _MOST_SCORE = 3, 7, 6, 12


def screen_lines(watched: Watched, page: Page) -> list[Text]:
    """All lines of the view, at most as many as the page has."""
    head = [_title(watched, page), _state(watched), *_folded(reading_text(watched), page, most=2)]
    foot = [*_folded(counts_text(watched), page, most=3), *_folded(promise_text(watched.file), page, most=2)]
    free = page.height - len(head) - len(foot) - 4 - _event_height(watched, page)
    n_signal, n_score = _heights(free, len(watched.channels))
    plots = [*signal_lines(watched, page, n_signal), *score_lines(watched, page, n_score)]
    above = [*head, *plots, heading("Counts and promise", page), *foot]
    lines = [*above, *_events(watched, page, page.height - len(above))]
    return [_fitting(line, page) for line in lines[: page.height]]


def _fitting(line: Text, page: Page) -> Text:
    """A line that fits the width and the characters of the terminal."""
    if page.plain:
        line = Text(line.plain.encode("ascii", "replace").decode(), spans=line.spans)
    line.truncate(page.width)
    return line


def _heights(free: int, n_channel: int) -> tuple[int, int]:
    """Heights of the plot of a channel and of the plot of the score [lines]."""
    each = max(free // (n_channel + 2), 1)
    return min(each, _MOST_SIGNAL), min(max(free - n_channel * each, 2), _MOST_SCORE)


def _event_height(watched: Watched, page: Page) -> int:
    """Lines of the events with their heading: the newest one is shown in full."""
    newest = folded(event_text(watched.events[-1]), page.width) if watched.events else []
    return min(max(len(newest) + 1, _LEAST_EVENTS), _MOST_EVENTS)


def _title(watched: Watched, page: Page) -> Text:
    flow = flow_text(watched)
    source, room = watched.source, max(page.width - len(flow) - 2, 2)
    source = source if len(source) <= room else f"…{source[1 - room :]}"
    return Text.assemble((source, "bold"), " " * max(page.width - len(source) - len(flow), 1), flow)


def _state(watched: Watched) -> Text:
    """The condition; without present data it is unknown."""
    condition = Condition.UNKNOWN if watched.is_silent else watched.condition
    badge = "NO DATA" if watched.is_silent else condition.upper()
    return Text.assemble((f" {badge} ", _STYLES[condition]), f" {state_text(watched)}")


def _folded(text: str, page: Page, most: int) -> list[Text]:
    lines = folded(text, page.width)
    if len(lines) > most:
        lines = [*lines[: most - 1], f"{lines[most - 1][: page.width - 1]}…"]
    return [Text(line) for line in lines]


def _events(watched: Watched, page: Page, height: int) -> Sequence[Text]:
    """The last events, the newest at the bottom, and how to end the view."""
    if height < 1:
        return ()
    title = heading("Events (Ctrl-C ends)", page)
    newest = list(watched.events)[1 - height :] if height > 1 else []
    lines = [line for event in newest for line in folded(event_text(event), page.width)]
    return title, *(Text(line) for line in lines[1 - height :])
