"""The loop of a monitor: samples of its machines in rounds, and what they gave in common transactions."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from enum import StrEnum
from pathlib import Path
from statistics import median
from typing import Any

from hydrofdi.detectors.file import load_detector
from hydrofdi.detectors.lines import Line
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.monitor.configuration import FleetConfig, Pattern
from hydrofdi.monitor.machines import Machine, MachineKind, Outlets, Receiver
from hydrofdi.monitor.opening import Sources
from hydrofdi.monitor.sources import StreamSource
from hydrofdi.monitor.store import WHOLE, StateStore, WindowLog
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.records.times import FIRST_DATE
from hydrofdi.settings.messages import time_text

_log = logging.getLogger(__name__)

PATIENCE = 0.2
"""Longest wait before the loop checks whether to stop [s]."""

BEHIND = 10.0
"""Age of the newest samples of most machines above which the monitor is behind [s]."""

STORE_EVERY = 1.0
"""Shortest time from one storing of the state of a single machine to the next [s]."""


class Ending(StrEnum):
    """Why a monitor ended."""

    OVER = "the stream is over"
    UNJUDGED = "the stream is over, and no window was judged"
    STOPPED = "it received a request to stop"
    OUTPUT_CLOSED = "its output is no longer read"


class Monitor:
    """Machines that are judged in rounds, and are stored together: those of a fleet, or a single one.

    In a round every machine judges what has arrived, and its lines go to the outlets. At most every
    `store_every` seconds, the states of machines that had lines are stored in one transaction with all lines
    that are new; then these go to the log, and the sources may discard the samples. After a crash, the log
    has each window of each machine once; other outlets may receive the last lines twice.
    """

    def __init__(
        self, config: FleetConfig, sources: Sources, on_line: Receiver, single: Machine | None = None
    ) -> None:
        if config.state and config.log and config.state.resolve() == config.log.resolve():
            raise ConfigError(f"state and log are the same file, {config.state}; choose another name for one")
        files = {path: load_detector(path) for path in {*config.detectors.values()}}
        self._kinds = {path: MachineKind(file, config, str(path)) for path, file in files.items()}
        self._config, self._sources, self._outlets = config, sources, Outlets(config, on_line)
        self._store = None
        if config.state is not None:
            self._store = StateStore(config.state, config.partition or WHOLE)
        self._log = None if config.log is None else WindowLog(config.log)
        self._single = single
        self.machines = {} if single is None else {single.name: single}
        self._refused: set[tuple[str, str]] = set()
        self._stored_at, self._is_unstored = 0.0, False
        self._age = self._oldest = 0.0

    def run(self, stop: Callable[[], bool]) -> Ending:
        """Monitor until a stop is requested, or all streams are over."""
        with ExitStack() as stack:
            stack.callback(self._outlets.close)
            if self._store is None:
                _log.info("no --state: after a restart, the monitor starts from scratch")
            else:
                stack.enter_context(self._store.opened())
            if self._log is not None:
                stack.callback(self._log.close)
                self._log.open({} if self._store is None else self._store.read_log())
            stack.callback(self._close_machines)
            stack.callback(self._sources.close)
            try:
                self._sources.open()
                if self._single is None:
                    self._say(Event(EventKind.STARTED, f"watches {', '.join(self._config.machines)}"))
                else:
                    self._begin(self._single)
                for event in self._outlets.said:
                    self._say(event)
                return self._watch(stop)
            except Exception as error:
                with suppress(StoreError):
                    self._write([machine for machine in self.machines.values() if machine.is_due])
                if isinstance(error, BrokenPipeError):
                    return Ending.OUTPUT_CLOSED
                raise

    def _begin(self, machine: Machine) -> None:
        stored = None if self._store is None else self._store.read(machine.name)
        if stored is not None and machine is self._single and (other := machine.difference(stored)):
            advice = "give another file as 'state', or remove this one to start from scratch"
            raise StoreError(f"{self._config.state}: belongs to another {other}; {advice}")
        self._deliver(machine, None, machine.begin(stored))

    def _watch(self, stop: Callable[[], bool]) -> Ending:
        while not stop():
            began, machines = time.monotonic(), self.machines
            is_busy = self._round()
            is_urgent = self._single is not None and self._sources.blocking()
            if is_urgent or began - self._stored_at >= self._config.store_every:
                self._commit()
            if self._sources.is_over and all(machine.is_over for machine in machines.values()):
                return self._end(Ending.OVER)
            while (
                not is_busy and not stop() and (left := began + self._config.interval - time.monotonic()) > 0
            ):
                time.sleep(min(left, PATIENCE))
        return self._end(Ending.STOPPED)

    def _round(self) -> bool:
        """Judge what has arrived, once; whether more may be there already. A single machine is waited for."""
        timeout = 0.0 if self._single is None else PATIENCE
        for event in self._sources.collect(self._source_of, timeout):
            if self._single is None:
                self._say(event)
            else:
                self._single.source.events.append(event)
        is_busy, ages = self._single is not None or self._sources.is_behind, list[float]()
        for machine in self.machines.values():
            chunk, lines = machine.step(timeout)
            is_busy = is_busy or (chunk is not None and machine.source.is_file)
            self._deliver(machine, chunk, lines)
            is_live = not (machine.source.is_file or machine.source.may_repeat_all)
            if is_live and chunk is not None and chunk.n_time and chunk.time[-1] > FIRST_DATE:
                ages.append(time.time() - float(chunk.time[-1]))
        if ages:
            self._note_age(median(ages))
        return is_busy

    def _note_age(self, age: float) -> None:
        """Report when the newest samples are old as they are judged, and when they no longer are."""
        self._outlets.show_age(self._single, age)
        is_behind, self._age = self._oldest > 0.0, age
        if age > BEHIND:
            self._oldest = max(age, self._oldest)
            if not is_behind:
                text = f"the newest samples are {time_text(age)} old: they come late, or the monitor is slow"
                self._say(Event(EventKind.BEHIND, text, details={"age_s": age}))
        elif is_behind and age < BEHIND / 2.0:
            text = f"caught up; the newest samples were up to {time_text(self._oldest)} old"
            self._say(Event(EventKind.BEHIND, text, is_end=True, details={"age_s": self._oldest}))
            self._oldest = 0.0

    def _source_of(
        self, name: str, place: str, new: Callable[[MachineKind], StreamSource]
    ) -> StreamSource | None:
        """The source of a machine, which is new if the machine is; None if it is ignored."""
        if self._single is not None:
            return self._single.source
        if (machine := self.machines.get(name)) is not None and machine.source.name == place:
            return machine.source
        if not self._config.owns(name) or (name, place) in self._refused:
            return None
        path = self._config.detector_of(name)
        reason = ""
        if machine is not None:
            reason = f"its name is that of {machine.source.name}"
        elif path is None:
            reason = "no pattern of 'detectors' matches its name"
        elif len(self.machines) >= self._config.most_machines:
            reason = f"there are {self._config.most_machines} machines already; raise 'most_machines'"
        if reason or path is None:
            if len(self._refused) < self._config.most_machines:
                self._refused.add((name, place))
                self._say(Event(EventKind.NOTICE, f"{place} is ignored: {reason}"))
            return None
        kind = self._kinds[path]
        self.machines[name] = machine = Machine(name, kind, new(kind))
        self._begin(machine)
        return machine.source

    def _deliver(self, machine: Machine | None, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Pass lines to the outlets, then to the state and the log, so that no line is lost."""
        text = self._outlets.put(machine, chunk, lines)
        if self._log is not None:
            self._log.take(text)
        if machine is not None:
            machine.delivered()

    def _say(self, event: Event) -> None:
        """Report an event of the fleet, or of the single machine."""
        self._deliver(self._single, None, [event])

    def _commit(self, *, is_end: bool = False) -> None:
        """Store what is new: states, then lines. Report once that this fails, and that it works again."""
        machines, blocking = [*self.machines.values()], self._sources.blocking()
        is_all = is_end or self._store is None
        idle = [machine for machine in machines if self._is_idle(machine)]
        due = [each for each in machines if is_all or each.is_due or each.source in blocking or each in idle]
        try:
            self._write(due)
        except StoreError as error:
            if not self._is_unstored:
                self._say(Event(EventKind.NOT_STORED, f"continues without storing states: {error}"))
            self._is_unstored = True
        else:
            for machine in due:
                machine.is_due = False
                machine.source.confirm()
            self._sources.acknowledge()
            if self._store is not None and not is_end:
                self._release(idle)
            if self._is_unstored:
                self._say(Event(EventKind.NOT_STORED, "stores states again", is_end=True))
            self._is_unstored = False
        self._stored_at = time.monotonic()

    def _write(self, due: Sequence[Machine]) -> None:
        if not due and (self._log is None or not self._log.has_waiting):
            return
        if self._store is not None:
            log = {} if self._log is None else self._log.position
            self._store.write({machine.name: machine.row for machine in due}, log)
        if self._log is not None:
            self._log.write()

    def _is_idle(self, machine: Machine) -> bool:
        is_kept = machine is self._single or machine.source.is_file
        return not is_kept and time.monotonic() - machine.heard > self._config.idle

    def _release(self, machines: Sequence[Machine]) -> None:
        """Forget machines that are stored and silent; they come back with their next sample."""
        for machine in machines:
            text = f"no samples for {self._config.idle:g} s; it is watched again when there are some"
            self._deliver(machine, None, [Event(EventKind.STOPPED, text)])
            del self.machines[machine.name]
            self._outlets.forget(machine.name)

    def _end(self, ending: Ending) -> Ending:
        """The last lines; if no restart will continue, the ends of episodes."""
        if ending is Ending.OVER and not any(machine.is_judged for machine in self.machines.values()):
            ending = Ending.UNJUDGED
        is_final = ending is not Ending.STOPPED or self._store is None
        for machine in self.machines.values():
            self._deliver(machine, None, machine.end(is_final=is_final))
        if self._oldest:
            text = f"ends behind: the newest samples that were judged are {time_text(self._age)} old"
            self._say(Event(EventKind.BEHIND, text, is_end=True, details={"age_s": self._age}))
        self._say(Event(EventKind.STOPPED, f"stopped: {ending}"))
        self._commit(is_end=True)
        return ending

    def _close_machines(self) -> None:
        for machine in self.machines.values():
            machine.source.close()


def single_monitor(
    kind: MachineKind, source: StreamSource, on_line: Receiver = None, detector: Path = Path(), **stated: Any
) -> Monitor:
    """The monitor of one machine, with keys of a fleet that are stated: its state, its log, its outlets.

    The path of the detector identifies the monitor to a broker.
    """
    config = FleetConfig.model_construct(
        **{"detectors": {}, "store_every": STORE_EVERY, **dict(kind.config), **stated}
    )
    patterns = [] if source.address is None else [Pattern(source.address, source.address.path)]
    sources = Sources(config, detector, patterns, is_followed=False, is_single=True)
    return Monitor(config, sources, on_line, Machine("", kind, source))
