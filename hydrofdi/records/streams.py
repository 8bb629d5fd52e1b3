"""Streams: samples are joined and checked as they come, and cut into windows; none depends on the chunks."""

from __future__ import annotations

import math
import zlib
from abc import ABC, abstractmethod
from bisect import bisect_left, insort
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import Issue
from hydrofdi.records import Array, Channel
from hydrofdi.records.defects import fault_of
from hydrofdi.records.recording import Direction, drive_edges
from hydrofdi.records.times import other_unit

_FARTHEST = 1e11
"""Largest distance of a time stamp from zero [s]: about 3,000 years."""
_GAP = 1.501
"""Longest step that is not a gap [sampling periods]: 3/2 even if stamps are rounded."""
_STEPS = 10
"""Number of successive gaps that mean another rate."""
_PATIENCE, _FEWEST = 60.0, 10
"""The clock was set back if all samples are earlier for this duration [s], and for this number of samples."""
_QUIET = 60.001
"""Time without a kind of event after which it is reported again [s]."""
_KINDS = ("gap", "rate_changed", "duplicate", "time_ran_back", "set_back", "malformed")
_NONE = np.zeros(2, dtype=np.int64)


class EventKind(StrEnum):
    """Kinds of events."""

    STARTED = "started"
    RESUMED = "resumed"
    STOPPED = "stopped"
    ALARM_RAISED = "alarm_raised"
    ALARM_CLEARED = "alarm_cleared"
    GAP = "gap"
    DUPLICATE = "duplicate"
    TIME_RAN_BACK = "time_ran_back"
    RATE_CHANGED = "rate_changed"
    MISSING_SAMPLES = "missing_samples"
    STUCK = "stuck"
    CLIPPED = "clipped"
    NOVEL = "novel"
    MISSING_CHANNEL = "missing_channel"
    NOT_JUDGED = "not_judged"
    MALFORMED = "malformed"
    DROPPED = "dropped"
    NOTICE = "notice"
    CONNECTED = "connected"
    DISCONNECTED = "disconnected"
    NOT_STORED = "not_stored"
    BEHIND = "behind"
    INSECURE = "insecure"


@dataclass
class Event:
    """Something that happened to the stream, the source or the machine.

    Attributes
    ----------
    time : float or None
        Instant on the clock of the stream [s].
    count : int
        Number of occurrences. What continues is reported once when it begins; later events are silent. The
        counts of one kind, without ends of episodes, add up to all occurrences.
    is_end : bool
        Whether it ends an episode; `count` is then the count of the whole episode.
    details : mapping of str to (float, str or None)
        What an alarm comes to.
    """

    kind: EventKind
    text: str
    time: float | None = None
    count: int = 1
    is_silent: bool = False
    is_end: bool = False
    details: Mapping[str, Any] = field(default_factory=dict)


class EvenStream:
    """Checks a stream sample by sample; the results do not depend on the chunks. Other channels are ignored.

    It drops samples that are not later than the last accepted one, or have no time stamp within 1e11 s of
    zero. A step of more than 1.5 periods is a gap; smaller irregularities are tolerated. A minute of only
    earlier samples means that the clock was set back; the stream then begins anew.
    """

    def __init__(self, sampling_frequency: float, channels: Sequence[Channel]) -> None:
        self.channels = tuple(channels)
        self._period = 1.0 / sampling_frequency
        self._patience = max(_FEWEST, round(_PATIENCE * sampling_frequency))

    def start(self) -> State:
        """The state before the first sample: its size never changes.

        To recognise a stream that is sent again, it has a checksum of the first samples of this run, and of
        the previous run, each with the number of its samples.
        """
        false, none = np.array(False), np.array(0)
        return {
            "last": np.array(-np.inf), "n_earlier": none, "n_gap": none, "is_silent": false,
            "said": np.full(len(_KINDS), np.nan), "may_repeat": false, "begin": _NONE, "begin_before": _NONE,
        }  # fmt: skip

    def resumed(self, state: State, *, may_repeat: bool = True) -> State:
        """A stored state that continues: samples that are sent again are not reported.

        If the whole stream may repeat, of any length, it is recognised by its first minute; otherwise a
        minute of earlier samples means that the clock was set back.
        """
        is_whole = state["begin"][1] == self._patience
        return {
            **state, "begin": _NONE, "begin_before": state["begin" if is_whole else "begin_before"],
            "n_earlier": np.array(0), "is_silent": np.array(True), "may_repeat": np.array(may_repeat),
        }  # fmt: skip

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Chunk], list[Event]]:
        """The state after a chunk, the accepted samples, and an event for each kind of defect."""
        if not chunk.n_time:
            return state, [], []
        state = {**state, "begin": self._beginning(state, chunk)}
        if not self._is_sound(state, chunk.time):
            return self._checked(state, chunk)
        kept = {name: state[name] for name in ("said", "begin", "begin_before")}
        after = {**self.start(), **kept, "last": np.array(chunk.time[-1])}
        is_first = bool(state["last"] == -np.inf)
        return after, [Chunk(chunk.time, chunk.of(self.channels), begins_anew=is_first)], []

    def _beginning(self, state: State, chunk: Chunk) -> Array:
        """Checksum and number of the first samples after a chunk."""
        checksum, n_before = state["begin"].tolist()
        if n_before == self._patience:
            return state["begin"]
        some = slice(self._patience - n_before)
        samples = np.column_stack([row[some] for row in (chunk.time, *chunk.of(self.channels).values())])
        return np.array([zlib.crc32(samples.tobytes(), checksum), n_before + len(samples)])

    def _is_sound(self, state: State, time: Array) -> bool:
        """Whether a chunk continues without any irregularity, as nearly all chunks do."""
        longest, last = _GAP * self._period, float(state["last"])
        follows = time[0] >= -_FARTHEST if last == -np.inf else 0.0 < float(time[0]) - last <= longest
        if not follows or not np.all(time[1:] > time[:-1]):
            return False
        return bool(time[-1] <= _FARTHEST and (time[1:] - time[:-1]).max(initial=0.0) <= longest)

    def _checked(self, state: State, chunk: Chunk) -> tuple[State, list[Chunk], list[Event]]:
        last, n_earlier, n_gap = float(state["last"]), int(state["n_earlier"]), int(state["n_gap"])
        is_silent, may_repeat = bool(state["is_silent"]), bool(state["may_repeat"])
        is_again = state["begin"][1] == self._patience and np.all(state["begin"] == state["begin_before"])
        comes_again = may_repeat and bool(is_again)
        accepted, anew = list[int](), list[int]()
        reports = _Reports(state["said"].tolist())
        stamps = np.where(np.abs(chunk.time) <= _FARTHEST, chunk.time, -np.inf)
        for index, stamp in enumerate(stamps.tolist()):
            kind = ""
            if stamp == -np.inf:
                kind = "malformed"
            elif stamp == last:
                kind = "duplicate"
            elif stamp < last:
                n_earlier += not comes_again
                kind = "time_ran_back" if n_earlier < self._patience else "set_back"
            if kind in ("", "set_back"):
                is_gap = stamp - last > _GAP * self._period
                n_gap = n_gap + 1 if is_gap and last > -np.inf else 0
                kind = kind or ("rate_changed" if n_gap >= _STEPS else "gap" if n_gap else "")
                if is_gap or kind == "set_back":
                    anew.append(len(accepted))
                accepted.append(index)
            if kind and (not is_silent or accepted or (kind == "malformed" and not may_repeat)):
                reports.add(kind, stamp, last, chunk.unread.get(index) or self._text(kind, stamp, last))
            if accepted and accepted[-1] == index:
                last, n_earlier, comes_again = stamp, 0, False
        after = {
            **state, "last": last, "n_earlier": n_earlier, "n_gap": n_gap, "said": reports.said,
            "is_silent": is_silent and not accepted, "may_repeat": may_repeat and not accepted,
        }  # fmt: skip
        pieces = self._pieces(chunk, accepted, anew)
        return {name: np.array(value) for name, value in after.items()}, pieces, reports.events

    def _text(self, kind: str, stamp: float, before: float) -> str:
        """A sentence about an occurrence, from its instant and the last accepted instant before it [s]."""
        now, then = _seconds(stamp), _seconds(before)
        match kind:
            case "gap":
                return f"no samples for {_seconds(stamp - before)} after {then}"
            case "rate_changed":
                step = stamp - before
                text = f"samples come every {step:.4g} s instead of every {self._period:.4g} s"
                return text + other_unit(step, self._period)
            case "duplicate":
                return f"a second sample at {now} was dropped"
            case "time_ran_back":
                return f"a sample at {now} came after one at {then} and was dropped"
            case "set_back":
                return f"the clock was set back from {then}; the stream restarts at {now}"
        where = f"after {then} " if np.isfinite(before) else ""
        return (
            f"a sample {where}has no time stamp within 1e11 s of zero and was dropped; has the time a unit?"
        )

    def _pieces(self, chunk: Chunk, accepted: Sequence[int], anew: Sequence[int]) -> list[Chunk]:
        """The accepted samples of a chunk; those at `anew` do not continue the sample before."""
        rows = {channel: row[accepted] for channel, row in chunk.of(self.channels).items()}
        whole = Chunk(chunk.time[accepted], rows)
        bounds = sorted({*anew, 0, len(accepted)})
        return [replace(whole.part(start, end), begins_anew=start in anew) for start, end in pairwise(bounds)]


class _Reports:
    """Events of a chunk, and the last instant of each kind."""

    def __init__(self, said: list[float]) -> None:
        self.said, self.events = said, list[Event]()
        self._latest: dict[str, Event] = {}

    def add(self, kind: str, stamp: float, before: float, text: str) -> None:
        """Count an occurrence, or begin an event with it."""
        row, instant = _KINDS.index(kind), max(before, stamp)
        said, self.said[row] = self.said[row], instant
        goes_on = kind != "set_back" and (abs(instant - said) <= _QUIET or instant == said)
        if goes_on and kind in self._latest:
            self._latest[kind].count += 1
            return
        time = instant if np.isfinite(instant) else None
        name = EventKind.TIME_RAN_BACK if kind == "set_back" else EventKind(kind)
        self._latest[kind] = Event(name, text, time, is_silent=goes_on)
        self.events.append(self._latest[kind])


def _seconds(time: float) -> str:
    """An instant or a duration to the microsecond."""
    return f"{time:.6f}".rstrip("0").rstrip(".") + " s"


State = Mapping[str, NDArray[Any]]
"""All that a stream needs from one chunk to the next: arrays, so that it can be stored."""


@dataclass(frozen=True)
class Chunk:
    """Samples of a stream: as they came, neither checked nor evenly spaced, perhaps a single one or none;
    after `EvenStream`, accepted samples with all requested channels and without a gap.

    Instants are on the clock of the source [s], channels in SI, NaN if a sample is missing. `unread` has why
    samples could not be read, by position; their instant is NaN. `begins_anew` tells of accepted samples
    whether they are the first, or follow a gap or a clock change.
    """

    time: Array
    channels: Mapping[Channel, Array]
    unread: Mapping[int, str] = field(default_factory=dict)
    begins_anew: bool = False

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return int(self.time.size)

    def of(self, channels: Sequence[Channel]) -> dict[Channel, Array]:
        """Samples of channels; NaN of those that the chunk lacks."""
        missing = np.full(self.n_time, np.nan)
        return {channel: self.channels.get(channel, missing) for channel in channels}

    def part(self, first: int, stop: int) -> Chunk:
        """The samples from `first` to before `stop`."""
        rows = {channel: row[first:stop] for channel, row in self.channels.items()}
        unread = {index - first: text for index, text in self.unread.items() if first <= index < stop}
        return Chunk(self.time[first:stop], rows, unread, self.begins_anew and first == 0)

    @property
    def readable(self) -> Chunk:
        """The samples with an instant."""
        is_readable = np.isfinite(self.time)
        if is_readable.all():
            return self
        return Chunk(self.time[is_readable], {name: row[is_readable] for name, row in self.channels.items()})


_WAIT, _MOST = 2.0, 4096
"""How long [s], and with how many later ones, a sample waits for a channel that sends nothing more."""
_stamp = itemgetter(0)


class Joining:
    """Joins samples within half a sampling period that have different channels; others stay as they are.

    A sample without a channel is complete as soon as this channel has a later value. The results do not
    depend on the chunks.
    """

    def __init__(self, sampling_frequency: float, channels: Sequence[Channel]) -> None:
        self._channels, self._tolerance = tuple(channels), 0.501 / sampling_frequency

    def start(self) -> State:
        """The state before the first sample: samples that wait, and the latest instant of each channel."""
        return {
            "rows": np.empty((0, 1 + len(self._channels))),
            "latest": np.full(len(self._channels), -np.inf),
        }

    def step(self, state: State, chunk: Chunk, *, is_end: bool = False) -> tuple[State, Chunk]:
        """The state after a chunk, and the samples that are complete, at the end of a stream all of them."""
        rows = np.column_stack([chunk.time, *chunk.of(self._channels).values()])
        if not state["rows"].size and not np.isnan(rows).any():
            if not chunk.n_time:
                return state, chunk
            return {**state, "latest": np.full(len(self._channels), chunk.time[-1])}, chunk
        waiting, latest = state["rows"].tolist(), state["latest"].tolist()
        ready, unread = list[list[float]](), dict[int, str]()
        for index, row in enumerate(rows.tolist()):
            if not math.isfinite(row[0]):
                unread |= {len(ready): chunk.unread[index]} if index in chunk.unread else {}
                ready.append(row)
                continue
            present = [n for n, value in enumerate(row[1:], 1) if not math.isnan(value)]
            for n in present:
                latest[n - 1] = row[0]
            if (fitting := self._fitting(waiting, row[0], present)) is not None:
                for n in present:
                    fitting[n] = row[n]
            else:
                insort(waiting, row, key=_stamp)
            n_ready = 0
            while n_ready < len(waiting) and self._is_ready(waiting, n_ready, latest):
                n_ready += 1
            ready += waiting[:n_ready]
            del waiting[:n_ready]
        if is_end:
            ready, waiting = ready + waiting, []
        time, *columns = np.array(ready).reshape(-1, rows.shape[1]).T.copy()
        held = np.array(waiting).reshape(-1, rows.shape[1])
        joined = Chunk(time, dict(zip(self._channels, columns, strict=True)), unread)
        return {"rows": held, "latest": np.array(latest)}, joined

    def _fitting(self, waiting: Sequence[list[float]], time: float, present: list[int]) -> list[float] | None:
        """The nearest of the waiting samples that lacks the channels of another one."""
        index, candidates = bisect_left(waiting, time - self._tolerance, key=_stamp), list[list[float]]()
        while index < len(waiting) and waiting[index][0] <= time + self._tolerance:
            candidates += [waiting[index]] if all(math.isnan(waiting[index][n]) for n in present) else []
            index += 1
        return min(candidates, key=lambda other: abs(other[0] - time), default=None)

    def _is_ready(self, waiting: Sequence[list[float]], index: int, latest: Sequence[float]) -> bool:
        time, *values = waiting[index]
        if waiting[-1][0] - time > _WAIT or len(waiting) - index > _MOST:
            return True
        return all(
            not math.isnan(value) or newest > time + self._tolerance
            for value, newest in zip(values, latest, strict=True)
        )


@dataclass(frozen=True)
class Window:
    """Consecutive samples of a stream, without a gap: instants as the source stated them [s], channels in SI.

    Numbers begin at 0, in the order of the ends, and continue after gaps and restarts. A fault is why it
    cannot be judged.
    """

    number: int
    time: Array
    channels: Mapping[Channel, Array]
    fault: Issue | None = None


class Windower(ABC):
    """Cuts pieces into windows, which do not depend on the ends of pieces. Windows begin anew after a gap."""

    def __init__(self, n_sample: int, channels: Sequence[Channel], sampling_frequency: float) -> None:
        self.n_sample = n_sample
        self.needs = self.channels = tuple(channels)
        self.sampling_frequency = sampling_frequency

    @abstractmethod
    def start(self) -> State:
        """The state before the first sample."""

    @abstractmethod
    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""

    def _rows(self, state: State, piece: Chunk) -> Array:
        """The held samples followed by those of a piece; the rows are time and channels."""
        held = self._nothing_held() if piece.begins_anew else state["held"]
        new = [piece.time, *(piece.channels[channel] for channel in self.channels)]
        rows = np.empty((len(held), held.shape[1] + piece.n_time))
        rows[:, : held.shape[1]] = held
        for row, samples in zip(rows, new, strict=True):
            row[held.shape[1] :] = samples
        return rows

    def _nothing_held(self) -> Array:
        return np.empty((1 + len(self.channels), 0))

    def _windows(self, rows: Array, spans: Sequence[tuple[int, int]], number: int) -> Iterator[Window]:
        """Windows with copies of their samples, numbered from `number` on."""
        for count, (first, stop) in enumerate(spans):
            time, *samples = own = rows[:, first:stop].copy()
            fault = fault_of(time, own[1:], self.channels, self.n_sample, self.sampling_frequency)
            yield Window(number + count, time, dict(zip(self.channels, samples, strict=True)), fault)


class TimeWindower(Windower):
    """Windows at equal distances of `n_every` samples: adjacent, overlapping, or apart."""

    def __init__(
        self, n_sample: int, n_every: int, channels: Sequence[Channel], sampling_frequency: float
    ) -> None:
        super().__init__(n_sample, channels, sampling_frequency)
        self.n_every = n_every

    def start(self) -> State:
        """The state before the first sample."""
        return {"held": self._nothing_held(), "n_ahead": np.array(0), "number": np.array(0)}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""
        rows, number = self._rows(state, piece), int(state["number"])
        first = 0 if piece.begins_anew else int(state["n_ahead"])
        starts = range(first, rows.shape[1] - self.n_sample + 1, self.n_every)
        windows = list(self._windows(rows, [(start, start + self.n_sample) for start in starts], number))
        due = first + len(starts) * self.n_every
        held = {
            "held": rows[:, due:].copy() if due else rows,
            "n_ahead": np.array(max(0, due - rows.shape[1])),
            "number": np.array(number + len(windows)),
        }
        return held, windows


class CycleWindower(Windower):
    """A window from each edge of the drive on; the rest of a longer cycle is ignored.

    A shorter cycle ends at the next edge and becomes a window with the fault ``short_cycle``. Pieces contain
    the channel of the drive, whose lowest and highest value are stated; windows only if it is among
    `channels`.
    """

    def __init__(
        self,
        n_sample: int,
        channels: Sequence[Channel],
        sampling_frequency: float,
        drive_channel: Channel,
        drive: tuple[float, float],
        edge: Direction = "rising",
    ) -> None:
        super().__init__(n_sample, channels, sampling_frequency)
        self.needs = tuple(dict.fromkeys((*self.channels, drive_channel)))
        self.drive_channel, self.drive, self.edge = drive_channel, drive, edge

    def start(self) -> State:
        """The state before the first sample."""
        none = np.array(0)
        return {"held": self._nothing_held(), "is_open": np.array(False), "side": none, "number": none}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""
        side, is_open = (0, False) if piece.begins_anew else (int(state["side"]), bool(state["is_open"]))
        rows, number = self._rows(state, piece), int(state["number"])
        n_held = rows.shape[1] - piece.n_time
        edges, side = drive_edges(piece.channels[self.drive_channel], self.drive, self.edge, side)
        firsts = ([0] if is_open else []) + [n_held + int(edge) for edge in edges]
        spans = [
            (first, min(first + self.n_sample, following))
            for first, following in pairwise([*firsts, rows.shape[1]])
        ]
        is_open = bool(spans) and spans[-1][1] - spans[-1][0] < self.n_sample
        held = rows[:, spans.pop()[0] :].copy() if is_open else self._nothing_held()
        windows = list(self._windows(rows, spans, number))
        counts = {"is_open": is_open, "side": side, "number": number + len(windows)}
        return {"held": held, **{name: np.array(count) for name, count in counts.items()}}, windows
