"""Machines, each with its stream, its state and its lines, and the outlets to which the lines go."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TextIO, runtime_checkable

from hydrofdi.detectors.detector import NUMBER, Detector
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import Line, WindowLine, is_said, line_record
from hydrofdi.errors import HydrofdiError
from hydrofdi.monitor.configuration import FleetConfig, MonitorConfig
from hydrofdi.monitor.sources import StreamSource, needing_extra
from hydrofdi.monitor.store import StoredMachine
from hydrofdi.records.streams import Chunk, Event, EventKind

if TYPE_CHECKING:
    from hydrofdi.monitor.metrics import MetricsServer

_log = logging.getLogger(__name__)

RETRY = 60.0
"""Time after which a source that failed is tried again [s]."""


class MachineKind:
    """Machines with the same detector, which share all that is not state.

    The configuration has those channels alone that the detector reads, if it has any of them. A digest of the
    detector, except who made it, and when, tells its states from others.
    """

    def __init__(self, file: DetectorFile, config: MonitorConfig, where: str = "") -> None:
        file.require_machine(config.actuator.given, where)
        seen = {*file.channels, file.config.window.channel}
        channels = {key: channel for key, channel in config.channels.items() if key in seen}
        self.file = file
        self.config = config.model_copy(update={"channels": channels}) if channels else config
        text = file.model_dump_json(by_alias=True, exclude={"made"})
        self.detector, self.digest = Detector(file), hashlib.sha256(text.encode()).hexdigest()


SourceOf = Callable[[str, str, Callable[[MachineKind], StreamSource]], StreamSource | None]
"""Name and place of a machine, and what makes its source → this source; None if the machine is ignored."""


@dataclass
class Machine:
    """A machine, whose source need not be open.

    Attributes
    ----------
    name : str
        Empty for a single machine, whose errors end the monitor.
    row : StoredMachine
        What is stored: the state in which all its lines were delivered.
    is_due : bool
        Whether it had lines since its state was stored.
    heard : float
        When the last samples arrived, on the monotonic clock [s].
    """

    name: str
    kind: MachineKind
    source: StreamSource

    def __post_init__(self) -> None:
        self.state = self.kind.detector.start()
        self.is_due, self.is_judged = False, False
        self.heard, self._retry = time.monotonic(), 0.0
        self._said, self._position, self._n_lost = "", dict[str, object](), 0

    def begin(self, stored: StoredMachine | None) -> list[Line]:
        """Continue from a stored state. That of another detector or source is only used to go on counting."""
        name, again = self.source.name, ""
        kind, position = EventKind.STARTED, dict[str, object]()
        if stored is not None:
            number = stored.state[NUMBER]
            self.state, self.is_judged = {**self.state, NUMBER: number}, bool(number > 0)
            kind, again = EventKind.RESUMED, f" again, from window {int(number)} on"
            if other := self.difference(stored):
                again += f"; its {other} is another one, so it starts anew"
            else:
                self.state, position = stored.state, dict(stored.position)
                if not position:
                    resumed = self.kind.detector.resumed
                    self.state = resumed(self.state, may_repeat=self.source.may_repeat_all)
        self._position = position
        self.delivered()
        lines: list[Line] = [Event(kind, f"watches {name}{again}"), *self._open()]
        self.is_due = True
        return lines

    def difference(self, stored: StoredMachine) -> str:
        """What is another than that of a stored state; empty if it belongs to this machine."""
        if stored.detector != self.kind.digest:
            return "detector"
        return "" if stored.source == self.source.name else "source"

    def step(self, timeout: float) -> tuple[Chunk | None, list[Line]]:
        """The samples that arrive within `timeout` seconds, and their lines."""
        if self._retry:
            return None, self._open() if time.monotonic() >= self._retry else []
        try:
            chunk = self.source.read(timeout)
        except Exception as error:
            return None, self._failed(error)
        events = self.source.events
        happened = [events.popleft() for _ in range(len(events))]
        self._n_lost += sum(event.count for event in happened if event.kind is EventKind.DROPPED)
        lines: list[Line] = [*happened]
        if chunk is not None and chunk.n_time:
            self.heard = time.monotonic()
            lines += self._judged(chunk)
            self._position = dict(self.source.position)
        self.is_due = self.is_due or any(map(is_said, lines))
        return chunk, lines

    def end(self, *, is_final: bool) -> Sequence[Line]:
        """The last lines, also those of a stream that will not go on."""
        lines = list[Line]()
        if self._n_lost:
            text = f"{self._n_lost:,} samples or messages were lost in total"
            lines.append(Event(EventKind.DROPPED, text, None, self._n_lost, is_end=True))
        if is_final:
            self.state, more = self.kind.detector.end(self.state)
            lines += more
        return lines

    @property
    def is_over(self) -> bool:
        """Whether nothing follows, unless what failed is tried again."""
        return self.source.is_over or bool(self._retry)

    def delivered(self) -> None:
        """All lines of the present state were delivered."""
        self.row = StoredMachine(self.source.name, self.kind.digest, self._position, self.state)

    def _open(self) -> list[Line]:
        try:
            self.source.open(self._position)
        except Exception as error:
            return self._failed(error)
        self._retry = 0.0
        return []

    def _judged(self, chunk: Chunk) -> Sequence[Line]:
        """Lines of samples; samples that cannot be judged are lost, and the state is the one before them."""
        try:
            self.state, lines = self.kind.detector.step(self.state, chunk)
        except Exception as error:
            text = f"samples are lost, because judging them failed: {self._reason(error)}"
            is_silent, self._said = text == self._said, text
            return [Event(EventKind.DROPPED, text, None, chunk.n_time, is_silent)]
        self._said = ""
        self.is_judged = self.is_judged or any(
            isinstance(x, WindowLine) and x.alarm is not None for x in lines
        )
        return lines

    def _failed(self, error: Exception) -> list[Line]:
        """Close the source, and say once why."""
        self.source.close()
        self._retry = time.monotonic() + RETRY
        text = self._reason(error)
        is_silent, self._said = text == self._said, text
        self.is_due = True
        return [Event(EventKind.DISCONNECTED, text, None, is_silent=is_silent)]

    def _reason(self, error: Exception) -> str:
        """A sentence; a bug in hydrofdi also shows its traceback, once. A single machine has the error."""
        if not self.name:
            raise error
        if isinstance(error, HydrofdiError):
            return str(error)
        text = f"{type(error).__name__}: {error}"
        if text not in self._said:
            _log.error("%s: this is a bug in hydrofdi; please report it", self.name, exc_info=error)
        return text


@runtime_checkable
class View(Protocol):
    """A receiver of all samples and lines of a single machine."""

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> object:
        """Take the samples and the lines of a reading."""

    def close(self) -> None:
        """End."""


Receiver = Callable[[dict[str, Any]], None] | TextIO | View | None


class Outlets:
    """Hands lines on as JSON; in a fleet with the name of the machine, which is None for the fleet itself.

    `said` are events of the outlets themselves.
    """

    def __init__(self, config: FleetConfig, to: Receiver) -> None:
        self._view = to if isinstance(to, View) else None
        self._to = None if isinstance(to, View) else to
        self._metrics: MetricsServer | None = None
        self.said: list[Event] = []
        if config.metrics:
            with needing_extra():
                from hydrofdi.monitor.metrics import MetricsServer
            self._metrics = MetricsServer(config.metrics)
            self.said = self._metrics.said

    def put(self, machine: Machine | None, chunk: Chunk | None, lines: Sequence[Line]) -> str:
        """Hand lines on; the text of those that are said."""
        if self._metrics is not None and machine is None:
            self._metrics.count(lines)
        elif self._metrics is not None and machine is not None and (lines or chunk is not None):
            self._metrics.put(machine.name or machine.source.name, machine.kind.file, chunk, lines)
        if self._view is not None:
            self._view.put(chunk, lines)
        said = [line for line in lines if is_said(line)]
        if not said:
            return ""
        unit, name = ("1", None) if machine is None else (machine.kind.file.unit, machine.name)
        named = {} if name == "" else {"line": "", "machine": name}
        judge = {} if machine is None else {"digest": machine.kind.digest[:12]}
        records = [
            {**named, **line_record(line, unit), **(judge if isinstance(line, WindowLine) else {})}
            for line in said
        ]
        texts = [json.dumps(record, ensure_ascii=False, allow_nan=False) + "\n" for record in records]
        if callable(self._to):
            for record in records:
                self._to(record)
        elif self._to is not None:
            self._to.write("".join(texts))
            self._to.flush()
        return "".join(texts)

    def show_age(self, machine: Machine | None, age: float) -> None:
        """Show in the metrics how old the newest samples were [s]."""
        if self._metrics is not None:
            self._metrics.show_age("" if machine is None else machine.source.name, age)

    def forget(self, machine: str) -> None:
        """Serve no metrics of a machine any more."""
        if self._metrics is not None:
            self._metrics.forget(machine)

    def close(self) -> None:
        """End."""
        for outlet in (self._metrics, self._view):
            if outlet is not None:
                outlet.close()
