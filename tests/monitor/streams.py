"""A detector by hand, streams that it watches, and a source that gives them."""

import json
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.loop import single_monitor
from hydrofdi.monitor.machines import MachineKind
from hydrofdi.monitor.sources import StreamSource, joined
from hydrofdi.monitor.text_lines import TextLines
from hydrofdi.records import Channel
from hydrofdi.records.description import FormatConfig, RemarkLimits
from hydrofdi.records.streams import Chunk
from tests.detectors.trained.made import FREQUENCY, signals, with_chart, with_limit

P1 = Channel.CHAMBER_1_PRESSURE
N_SAMPLE = 1000
LEAK = 5.0
"""Factor of the noise of P1 that raises an alarm in each window."""


def made_detector(every=1.0, chart=None):
    """A threshold just above healthy scores of one-second windows; with a chart of this name on request."""
    file = with_limit(1.1, direction="rising", window={"duration": "1 s", "every": every})
    return file if chart is None else with_chart(file, chart)


def stream(n_window, seed=1, leaking=(), stuck=()):
    """Time and P1 of so many windows; some leak, some are stuck."""
    samples = signals(seed, n_window * N_SAMPLE)[P1]
    noise = np.random.default_rng(seed + 1).standard_normal(samples.size) * 2e4
    for number in leaking:
        at = slice(number * N_SAMPLE, (number + 1) * N_SAMPLE)
        samples[at] += LEAK * noise[at]
    for number in stuck:
        samples[number * N_SAMPLE : (number + 1) * N_SAMPLE] = 9e6
    return Chunk(np.arange(samples.size) / FREQUENCY, {P1: samples})


def part(chunk, first, stop=None):
    at = slice(first, stop)
    return Chunk(chunk.time[at], {channel: row[at] for channel, row in chunk.channels.items()})


def rearranged(chunk, places):
    """Samples in another order, some of them twice or never."""
    return Chunk(chunk.time[places], {channel: row[places] for channel, row in chunk.channels.items()})


def lines_of(watch, chunks):
    state, lines = watch.start(), []
    for chunk in chunks:
        state, more = watch.step(state, chunk)
        lines += more
    return lines + watch.end(state)[1]


class Reading(NamedTuple):
    """What a source gave, what happened, and whether it ended."""

    chunk: Chunk | None
    events: list
    is_over: bool


def reading_of(source, timeout):
    chunk = source.read(timeout)
    return Reading(chunk, [source.events.popleft() for _ in range(len(source.events))], source.is_over)


class Samples(StreamSource):
    """A source of samples in memory, in chunks of so many; it can go back."""

    may_repeat_all = True

    def __init__(self, chunk, n_at_once=700, name="made"):
        super().__init__(name)
        self._chunk, self._n_at_once, self._place = chunk, n_at_once, 0
        self.confirmed, self.is_closed = [], False

    def open(self, position):
        self._place = position.get("place", 0)

    def read(self, timeout):
        first, self._place = self._place, min(self._place + self._n_at_once, self._chunk.n_time)
        self.is_over = self._place == self._chunk.n_time
        return part(self._chunk, first, self._place)

    @property
    def position(self):
        return {"place": self._place}

    def confirm(self):
        self.confirmed.append(self._place)

    def close(self):
        self.is_closed = True


class Killed(BaseException):
    """The process ends here."""


class Kept:
    """A view that keeps what it gets, and ends the process at its n-th reading with samples."""

    def __init__(self, n_reading=0):
        self.lines, self.is_closed, self._left = [], False, n_reading

    def put(self, chunk, lines):
        self._left -= chunk is not None
        if chunk is not None and self._left == 0:
            raise Killed
        self.lines += lines

    def close(self):
        self.is_closed = True


def monitor(file, source, view=None, stop=lambda: False, **stated):
    """One life of a monitor; gives how it ended."""
    return single_monitor(MachineKind(file, MonitorConfig()), source, view, **stated).run(stop)


def live(folder, source, view=None, stop=lambda: False, file=None):
    """One life of a monitor with its state and its log in a folder."""
    files = {"state": folder / "state", "log": folder / "log.jsonl"}
    return monitor(file or made_detector(), source, view, stop, **files)


def logged(folder, without=("started", "resumed", "stopped")):
    """Lines of the log that do not tell of starts and ends."""
    records = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
    return [each for each in records if each.get("event") not in without]


def config_of(channels=None, largest=2**20, **options):
    """A configuration of a monitor; its largest line or message may be smaller than a user may state."""
    form = {key: options.pop(key) for key in [*options] if key in FormatConfig.model_fields}
    config = MonitorConfig(channels=channels or {}, format=form, **options)
    return config.model_copy(update={"limits": RemarkLimits.model_construct(payload=largest)})


def reader(position=(), needed=(), **options):
    return TextLines(config_of(**options), "the stream", dict(position), needed)


def read_in_pieces(lines, data, cuts=()):
    """All samples of bytes that come in pieces, and why the others could not be read."""
    places = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    readings = [lines.read(data[a:b]) for a, b in pairwise(places)]
    readings.append(lines.read(b"", is_end=True))
    chunk = joined([chunk for chunk in readings if chunk is not None])
    return chunk.readable, [chunk.unread[place] for place in sorted(chunk.unread)]


def samples(chunk):
    """Time and channels as lists, for comparison; NaN is None."""
    arrays = {"time": chunk.time} | {channel.symbol: values for channel, values in chunk.channels.items()}
    return {
        name: [None if np.isnan(value) else value for value in values.tolist()]
        for name, values in arrays.items()
    }
