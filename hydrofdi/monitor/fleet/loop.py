"""The loop of a fleet: samples of all machines in rounds, and what they gave in common transactions."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.monitor.fleet.configuration import FleetConfig
from hydrofdi.monitor.fleet.machines import Kind, Machine
from hydrofdi.monitor.fleet.outlets import Outlets
from hydrofdi.monitor.fleet.sources import Sources
from hydrofdi.monitor.fleet.store import FleetStore
from hydrofdi.monitor.lines import Line
from hydrofdi.monitor.loop import PATIENCE, Ending
from hydrofdi.monitor.sources import StreamSource
from hydrofdi.monitor.state import WindowLog
from hydrofdi.records.streams import Chunk, Event, EventKind


class Fleet:
    """Machines that appear, are judged in rounds, and are stored together.

    In a round every machine judges what has arrived, and its lines go to the outlets. At most every
    `store_every` seconds, the states of machines that had lines are stored in one transaction with all lines
    that are new; then these go to the log, and the sources may discard the samples. After a crash, the log
    has each window of each machine once; other outlets may receive the last lines twice.
    """

    def __init__(
        self, config: FleetConfig, kinds: Mapping[Path, Kind], sources: Sources, outlets: Outlets
    ) -> None:
        self._config, self._kinds, self._sources, self._outlets = config, kinds, sources, outlets
        self._store = None if config.state is None else FleetStore(config.state)
        self._log = None if config.log is None else WindowLog(config.log)
        self.machines: dict[str, Machine] = {}
        self._refused: set[tuple[str, str]] = set()
        self._stored_at, self._is_unstored = 0.0, False

    def run(self, stop: Callable[[], bool]) -> Ending:
        """Monitor until a stop is requested, or all files are over."""
        with ExitStack() as stack:
            stack.callback(self._outlets.close)
            if self._store is not None:
                stack.enter_context(self._store.opened())
            if self._log is not None:
                stack.callback(self._log.close)
                self._log.open({} if self._store is None else self._store.read_log())
            stack.callback(self._close_machines)
            stack.callback(self._sources.close)
            try:
                self._say(Event(EventKind.STARTED, f"watches {', '.join(self._config.machines)}"))
                self._sources.open()
                return self._watch(stop)
            except BrokenPipeError:
                return Ending.OUTPUT_CLOSED

    def _watch(self, stop: Callable[[], bool]) -> Ending:
        while not stop():
            began = time.monotonic()
            is_busy = self._round()
            if began - self._stored_at >= self._config.store_every:
                self._commit()
            if self._sources.is_over and all(each.is_over for each in self.machines.values()):
                return self._end(Ending.OVER)
            while (
                not is_busy and not stop() and (left := began + self._config.interval - time.monotonic()) > 0
            ):
                time.sleep(min(left, PATIENCE))
        return self._end(Ending.STOPPED)

    def _round(self) -> bool:
        """Judge what has arrived, once; whether more may be there already."""
        for event in self._sources.collect(self._source_of):
            self._say(event)
        is_busy = self._sources.is_behind
        for machine in self.machines.values():
            chunk, lines = machine.step()
            is_busy = is_busy or (chunk is not None and self._sources.is_file(machine.source))
            self._deliver(machine, chunk, lines)
        for event in self._outlets.happened():
            self._say(event)
        return is_busy

    def _source_of(self, name: str, place: str, new: Callable[[Kind], StreamSource]) -> StreamSource | None:
        """The source of a machine, which is new if the machine is; None if it is ignored."""
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
        self._deliver(machine, None, machine.begin(None if self._store is None else self._store.read(name)))
        return machine.source

    def _deliver(self, machine: Machine, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        text = self._outlets.put(machine.name, machine.kind.file, chunk, lines)
        if self._log is not None:
            self._log.take_text(text)

    def _say(self, event: Event) -> None:
        """Report an event of the fleet."""
        text = self._outlets.put("", None, None, [event])
        if self._log is not None:
            self._log.take_text(text)

    def _commit(self, *, is_end: bool = False) -> None:
        """Store what is new: states, then lines. Report once that this fails, and that it works again."""
        try:
            self._write(is_end=is_end)
        except StoreError as error:
            if not self._is_unstored:
                text = f"continues without storing states: {error}"
                self._say(Event(EventKind.NOT_STORED, text))
            self._is_unstored = True
        else:
            if self._is_unstored:
                self._say(Event(EventKind.NOT_STORED, "stores states again", is_end=True))
            self._is_unstored = False
        self._stored_at = time.monotonic()

    def _write(self, *, is_end: bool) -> None:
        machines, blocking = [*self.machines.values()], self._sources.blocking()
        is_all = is_end or self._store is None
        idle = [each for each in machines if self._is_idle(each)]
        due = [each for each in machines if is_all or each.is_due or each.source in blocking or each in idle]
        if due or (self._log is not None and self._log.has_waiting):
            if self._store is not None:
                log = {} if self._log is None else self._log.position
                self._store.write({each.name: each.row for each in due}, log)
            if self._log is not None:
                self._log.write()
        for each in due:
            each.is_due = False
            each.source.confirm()
        self._sources.acknowledge()
        if self._store is not None and not is_end:
            self._release(idle)

    def _is_idle(self, machine: Machine) -> bool:
        return time.monotonic() - machine.heard > self._config.idle and not self._sources.is_file(
            machine.source
        )

    def _release(self, machines: Sequence[Machine]) -> None:
        """Forget machines that are stored and silent; they come back with their next sample."""
        for machine in machines:
            text = f"no samples for {self._config.idle:g} s; it is watched again when there are some"
            self._deliver(machine, None, [Event(EventKind.STOPPED, text)])
            del self.machines[machine.name]
            self._outlets.forget(machine.name)

    def _end(self, ending: Ending) -> Ending:
        """The last lines; if no restart will continue, the ends of episodes."""
        if ending is Ending.OVER and not any(each.is_judged for each in self.machines.values()):
            ending = Ending.UNJUDGED
        for machine in self.machines.values():
            if ending is not Ending.STOPPED or self._store is None:
                self._deliver(machine, None, machine.end())
        self._say(Event(EventKind.STOPPED, f"stopped: {ending}"))
        self._commit(is_end=True)
        return ending

    def _close_machines(self) -> None:
        for machine in self.machines.values():
            machine.source.close()
