"""A detector by hand, streams that it watches, and a source that gives them."""

import json
import math
import time
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrofdi.detectors.lines import WindowLine
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.loop import single_monitor
from hydrofdi.monitor.machines import MachineKind
from hydrofdi.monitor.sources import StreamSource, joined
from hydrofdi.monitor.text_lines import TextLines
from hydrofdi.records import Channel
from hydrofdi.records.description import FormatConfig, RemarkLimits
from hydrofdi.records.streams import Chunk, Event
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


def rearranged(chunk, places):
    """Samples in another order, some of them twice or never."""
    return Chunk(chunk.time[places], {channel: row[places] for channel, row in chunk.channels.items()})


def part(chunk, first, stop=None):
    return rearranged(chunk, slice(first, stop))


def lines_of(watch, chunks, *, is_over=True):
    state, lines = watch.start(), []
    for chunk in chunks:
        state, more = watch.step(state, chunk)
        lines += more
    return lines + (watch.end(state)[1] if is_over else [])


def payload_of(chunk):
    """Samples as JSON: ``time`` and channels, each in SI and as an array; null if a sample is missing."""
    columns = {"time": chunk.time} | {channel.value: samples for channel, samples in chunk.channels.items()}
    numbers = {
        name: [number if math.isfinite(number) else None for number in samples.tolist()]
        for name, samples in columns.items()
    }
    return json.dumps(numbers).encode()


class Reading(NamedTuple):
    """What a source gave, what happened, and whether it ended."""

    chunk: Chunk | None
    events: list
    is_over: bool


def reading_of(source, timeout):
    chunk = source.read(timeout)
    return Reading(chunk, [source.events.popleft() for _ in range(len(source.events))], source.is_over)


class Reader:
    """What a source gave, until something is there or half a minute has passed."""

    def __init__(self, source):
        self._source, self.chunks, self.events = source, [], []

    def until(self, is_there):
        end = time.monotonic() + 30.0
        while not is_there():
            assert time.monotonic() < end, (self.times.size, self.events)
            chunk, events, _ = reading_of(self._source, 0.02)
            self.chunks += [chunk] if chunk else []
            self.events += events
        return self

    def has(self, kind, times=1):
        return self.until(lambda: len(self.said(kind)) >= times)

    def has_until(self, instant):
        return self.until(lambda: instant in self.times)

    def said(self, kind):
        return [event.text for event in self.events if event.kind is kind and not event.is_silent]

    @property
    def times(self):
        return np.concatenate([[], *(chunk.time for chunk in self.chunks)])

    def channel(self, channel):
        return np.concatenate([chunk.channels[channel] for chunk in self.chunks])


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
    """A view that keeps what it gets, and ends the process at its n-th reading with samples; `at_7` is called
    when window 7 comes."""

    def __init__(self, n_reading=0, **at):
        self.lines, self.is_closed, self._left = [], False, n_reading
        self._calls = {int(name.removeprefix("at_")): call for name, call in at.items()}

    def put(self, chunk, lines):
        self._left -= chunk is not None
        if chunk is not None and self._left == 0:
            raise Killed
        for number in numbers_of(lines):
            self._calls.get(number, lambda: None)()
        self.lines += lines

    def close(self):
        self.is_closed = True

    def events(self, kind):
        return [line for line in self.lines if isinstance(line, Event) and line.kind == kind]


def numbers_of(lines):
    return [line.number for line in lines if isinstance(line, WindowLine)]


def monitor(file, source, view=None, stop=lambda: False, **stated):
    """One life of a monitor; gives how it ended."""
    return single_monitor(MachineKind(file, MonitorConfig()), source, view, **stated).run(stop)


def logged(path, without=("started", "resumed", "stopped", "connected", "disconnected")):
    """Lines of a log that do not tell of one life alone."""
    records = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
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
