"""The plots of the live view: the last samples, and scores against their limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from rich.text import Text

from hydrofdi.api.monitoring.lines import WindowLine
from hydrofdi.cli.monitor.live.character_plots import draw, envelope, row_of
from hydrofdi.cli.monitor.live.page import LABEL_WIDTH, Page, heading
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.cli.monitor.live.wording import duration_text, judged_noun, score_name
from hydrofdi.detectors.trained.wording import plain, score_unit
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.settings.readable import readable_unit
from hydrofdi.units import convert

_BEYOND, _NOT_JUDGED = "^", "?"
_LEGEND = f" {_BEYOND} beyond  {_NOT_JUDGED} not judged"


def signal_lines(watched: Watched, page: Page, height: int) -> list[Text]:
    """The last samples of each plotted channel, `height` lines each, under a heading."""
    span = duration_text(watched.n_tail / watched.file.sampling_frequency)
    what = "last window" if watched.n_tail == watched.file.n_sample else "last samples"
    lines = [heading(f"Signals, {what}, {span}", page)]
    for channel in watched.channels:
        lines += _signal(channel, watched.tail(channel), page, height)
    return lines


def _signal(channel: Channel, values: Array, page: Page, height: int) -> list[Text]:
    unit = readable_unit(channel.unit, float(np.nanmax(np.abs(values), initial=0.0)))
    shown = values * convert(1.0, unit) if unit != channel.unit else values
    low, high = envelope(shown, 2 * page.plot_width)
    finite = shown[np.isfinite(shown)]
    span = _span(finite)
    labels = {0: f"{channel.symbol} {_number(span[1])}", height - 1: f"{unit} {_number(span[0])}"}
    if height == 1:
        labels = {0: f"{channel.symbol} {unit}"}
    return _labelled(labels, draw(low, high, span, height, plain=page.plain))


def score_lines(watched: Watched, page: Page, height: int) -> list[Text]:
    """Scores of the last windows, or statistics of their chart, with limits and a line of marks."""
    windows = list(watched.windows)
    n_each = max(-(-len(windows) // page.plot_width), 1)
    windows = windows[-n_each * page.plot_width :]
    values, limits, title = _decisive(watched, windows)
    span = _span(np.array([*values[np.isfinite(values)], *limits]))
    padded = np.full(2 * page.plot_width, np.nan)
    low, high = padded.copy(), padded.copy()
    n_cell = -(-len(windows) // n_each)
    if windows:
        low[: 2 * n_cell], high[: 2 * n_cell] = envelope(np.repeat(values, 2), 2 * n_cell)
    drawn = draw(low, high, span, height, plain=page.plain)
    labels = {0: _number(span[1]), height - 1: _number(span[0])} if windows else {}
    for limit in limits:
        row = int(row_of(np.array([limit]), span, 4 * height)[0]) // 4
        drawn[row] = drawn[row].replace(" ", "-" if page.plain else "┄")
        labels[row] = f"limit {_number(limit)}" if len(_number(limit)) < 4 else _number(limit)
    return [heading(title, page, _LEGEND), *_labelled(labels, drawn), _marks(windows, n_each)]


def _decisive(watched: Watched, windows: Sequence[WindowLine]) -> tuple[Array, list[float], str]:
    """The numbers that decide on alarms, one for each window; their limits; and a title."""
    file = watched.file
    duration = duration_text(windows[-1].end - windows[0].start) if windows else "no"
    noun = judged_noun(file)
    span = f"last {len(windows)} {noun}s, {duration}" if windows else f"no {noun} yet"
    if windows and windows[-1].chart is not None and file.config.chart is not None:
        values = [
            np.nan if w.chart is None or w.chart.statistic is None else w.chart.statistic for w in windows
        ]
        return np.array(values), [windows[-1].chart.limit], f"{file.config.chart.chart}, {span}"
    unit = score_unit(file)
    factor = convert(1.0, unit) if unit != file.unit else 1.0
    scores = [_number_or_nan(window.verdict.score) * factor for window in windows]
    limits = [each * factor for each in (file.limits.low, file.limits.high) if each is not None]
    shown = "" if unit == "1" else f" [{unit}]"
    return np.array(scores), limits, f"{score_name(file)}{shown}, {span}"


def _number_or_nan(number: float | None) -> float:
    return np.nan if number is None else number


def _marks(windows: Sequence[WindowLine], n_each: int) -> Text:
    """A mark below each window that is beyond the limit or not judged."""
    text = Text(" " * (LABEL_WIDTH + 1))
    for start in range(0, len(windows), n_each):
        verdicts = [window.verdict for window in windows[start : start + n_each]]
        if any(verdict.alarm for verdict in verdicts):
            text.append(_BEYOND, "bold red")
        else:
            text.append(_NOT_JUDGED if any(verdict.alarm is None for verdict in verdicts) else " ")
    return text


def _span(values: Array) -> tuple[float, float]:
    """A range that contains all values, and is never empty."""
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    margin = max(0.05 * (high - low), 1e-3 * max(abs(low), abs(high))) or 1.0
    return low - margin, high + margin


def _number(value: float) -> str:
    return plain(value, 3)


def _labelled(labels: Mapping[int, str], drawn: Sequence[str]) -> list[Text]:
    return [Text(f"{labels.get(row, ''):>{LABEL_WIDTH}} {line}") for row, line in enumerate(drawn)]
