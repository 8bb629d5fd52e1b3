"""Where lines go: standard output, a function, a live view, topics, and metrics with labels."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Protocol, TextIO, runtime_checkable

from hydrofdi.detectors.trained.lines import Line, WindowLine, is_said, line_record
from hydrofdi.monitor.configuration import FleetConfig, topic_address
from hydrofdi.monitor.machines import Machine
from hydrofdi.monitor.sources import needing_extra
from hydrofdi.records.streams import Chunk, Event

if TYPE_CHECKING:
    from hydrofdi.monitor.metrics import MetricsServer, MetricsSink
    from hydrofdi.monitor.mqtt import MqttSink


@runtime_checkable
class View(Protocol):
    """A receiver of all samples and lines of a single machine."""

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> object:
        """Take the samples and the lines of a reading."""

    def close(self) -> None:
        """End."""


Receiver = Callable[[dict[str, Any]], None] | TextIO | View | None


class Outlets:
    """Hands lines on as JSON; in a fleet with the name of the machine, which is None for the fleet itself."""

    def __init__(self, config: FleetConfig, to: Receiver) -> None:
        self._view = to if isinstance(to, View) else None
        self._to = None if isinstance(to, View) else to
        self._metrics: MetricsServer | None = None
        self._counted: dict[str, MetricsSink] = {}
        self._sinks: list[MqttSink] = []
        self._events = list[Event]()
        self._stack = ExitStack()
        with needing_extra(), ExitStack() as stack:
            if self._view is not None:
                stack.callback(self._view.close)
            if config.metrics:
                from hydrofdi.monitor.metrics import MetricsServer

                self._metrics = MetricsServer(config.metrics)
                stack.callback(self._metrics.close)
                self._events += self._metrics.said
            for text in config.events:
                from hydrofdi.monitor.mqtt import MqttSink

                self._sinks.append(MqttSink(topic_address(text), config.mqtt))
                stack.callback(self._sinks[-1].close)
            self._stack = stack.pop_all()

    def put(self, machine: Machine | None, chunk: Chunk | None, lines: Sequence[Line]) -> str:
        """Hand lines on; the text of those that are said."""
        if self._metrics is not None and (lines or chunk is not None):
            self._count(self._metrics, machine, chunk, lines)
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
        for sink in self._sinks:
            wanted = [text for line, text in zip(said, texts, strict=True) if sink.wants(line)]
            self._events += sink.send_all(wanted)
        if callable(self._to):
            for record in records:
                self._to(record)
        elif self._to is not None:
            self._to.write("".join(texts))
            self._to.flush()
        return "".join(texts)

    def _count(
        self, server: MetricsServer, machine: Machine | None, chunk: Chunk | None, lines: Sequence[Line]
    ) -> None:
        if machine is None:
            server.count(lines)
            return
        name = machine.name or machine.source.name
        if name not in self._counted:
            from hydrofdi.monitor.metrics import MetricsSink

            self._counted[name] = MetricsSink(server, name, machine.kind.file)
        self._counted[name].put(chunk, lines)

    def show_age(self, machine: Machine | None, age: float) -> None:
        """Show in the metrics how old the newest samples were [s]."""
        if self._metrics is not None:
            self._metrics.show_age("" if machine is None else machine.source.name, age)

    def happened(self) -> list[Event]:
        """Events of the outlets themselves."""
        for sink in self._sinks:
            self._events += sink.send_all(())
        events, self._events = self._events, []
        return events

    def forget(self, machine: str) -> None:
        """Serve no metrics of a machine any more."""
        if machine in self._counted:
            self._counted.pop(machine).close()

    def close(self) -> None:
        """Write and send what is left, and end."""
        self._stack.close()
