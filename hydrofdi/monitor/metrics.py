"""Metrics of a monitor over HTTP, in the text format of Prometheus."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from ipaddress import ip_address
from threading import Thread, Timer
from typing import Any
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer

from prometheus_client import CollectorRegistry, Counter, Enum, Gauge, Info, make_wsgi_app
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import Condition, Line, WindowLine
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.store.files import reason
from hydrofdi.version import __version__

_EARLIEST = 1e9
"""Stream times above this [s], an instant in 2001, are taken as seconds since 1970."""

_PATIENCE = 3.0
"""Longest time that a client gets [s]."""


class Counts:
    """Counts samples and lines of a machine in a registry of its own."""

    def __init__(self, file: DetectorFile) -> None:
        self.registry = CollectorRegistry()
        self._describe(file)
        self._judged = self._counter("windows_judged", "Windows that were judged", ["beyond_limit"])
        for known in ("false", "true"):
            self._judged.labels(known)
        self._not_judged = self._counter("windows_not_judged", "Windows that were not judged", ["reason"])
        text = "Windows that were not judged, with a score beyond its limit"
        self._beyond = self._counter("windows_not_judged_beyond_limit", text)
        self._alarms = self._counter("alarms", "Alarms that were raised")
        self._samples = self._counter("samples", "Samples that arrived")
        self._events = self._counter("events", "Events, each repetition counted", ["kind"])
        states = [condition.value for condition in Condition]
        text = "Condition of the actuator"
        self._condition = Enum("hydrofdi_condition", text, states=states, registry=self.registry)
        self._score = self._gauge("score", f"Score of the last window that has one, in {file.unit}", math.nan)
        text = "Distance of this score from its limit, in healthy spreads"
        self._margin = self._gauge("margin", text, math.nan)
        text = "Arrival of the last window; before the first, start of the monitor (Unix time)"
        self._window = self._gauge("last_window_timestamp_seconds", text, time.time())
        text = "Time stamp of the last sample, on the clock of the stream"
        self._sample = self._gauge("last_sample_time_seconds", text)
        self._lag: Gauge | None = None
        self._latest = math.nan

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Count the samples and the lines of a reading."""
        if chunk is not None and chunk.readable.n_time:
            self._count_samples(chunk.readable)
        for line in lines:
            if isinstance(line, WindowLine):
                self._count_window(line)
            else:
                self._count_event(line)
        return ()

    def _describe(self, file: DetectorFile) -> None:
        output = file.config.output or file.score_name
        Info("hydrofdi_monitor", "Version and detector", registry=self.registry).info(
            {"version": __version__, "indicator": file.config.indicator, "output": output}
        )
        text = f"Limits of the score, in {file.unit}"
        threshold = Gauge("hydrofdi_threshold", text, ["side"], registry=self.registry)
        for side, limit in (("low", file.limits.low), ("high", file.limits.high)):
            if limit is not None:
                threshold.labels(side).set(limit)
        self._statistic: Gauge | None = None
        if file.chart is not None:
            self._gauge("chart_limit", "Limit of the control chart, in healthy spreads", file.chart.limit)
            text = "Statistic of the control chart, in healthy spreads"
            self._statistic = self._gauge("chart_statistic", text, math.nan)

    def _count_samples(self, chunk: Chunk) -> None:
        self._samples.inc(chunk.n_time)
        self._latest = latest = float(chunk.time[-1])
        self._sample.set(latest)
        if self._lag is None and latest > _EARLIEST:
            self._lag = self._gauge("lag_seconds", "Wall clock minus the time stamp of the last sample")
            self._lag.set_function(lambda: time.time() - self._latest)

    def _count_window(self, line: WindowLine) -> None:
        verdict = line.verdict
        self._window.set(time.time())
        self._condition.state(line.condition.value)
        if verdict.alarm is None:
            self._not_judged.labels(verdict.fault.kind if verdict.fault else "unknown").inc()
            self._beyond.inc(bool(verdict.is_beyond))
        else:
            self._judged.labels(str(verdict.alarm).lower()).inc()
        if verdict.score is not None:
            self._score.set(verdict.score)
            self._margin.set(math.nan if verdict.margin is None else verdict.margin)
        if self._statistic and line.chart is not None and line.chart.statistic is not None:
            self._statistic.set(line.chart.statistic)

    def _count_event(self, line: Event) -> None:
        if line.is_end:
            return
        self._events.labels(line.kind.value).inc(line.count)
        if line.kind is EventKind.ALARM_RAISED:
            self._alarms.inc()

    def _counter(self, name: str, text: str, labels: Sequence[str] = ()) -> Counter:
        return Counter(f"hydrofdi_{name}", text, labels, registry=self.registry)

    def _gauge(self, name: str, text: str, value: float = 0.0) -> Gauge:
        gauge = Gauge(f"hydrofdi_{name}", text, registry=self.registry)
        gauge.set(value)
        return gauge


class MetricsServer:
    """Serves a registry; `said` has its address, until somebody takes it."""

    def __init__(self, address: str, registry: CollectorRegistry) -> None:
        host, port = _host_and_port(address)
        try:
            family, _, _, _, found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
            self._server = _Server(family, (host, port), make_wsgi_app(registry))
        except (OSError, UnicodeError) as error:
            raise ConfigError(f"metrics: {address}: {reason(error)}") from None
        self._thread = Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self._server.server_port}/metrics"
        self.said: list[Event] = [Event(EventKind.NOTICE, f"metrics are served at {self.url}")]
        if not ip_address(str(found[0]).partition("%")[0]).is_loopback:
            text = f"everyone who reaches {self.url} can read the metrics"
            self.said.append(Event(EventKind.INSECURE, text))

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class MetricsSink(Counts):
    """Counts samples and lines, and serves the counts."""

    def __init__(self, address: str, file: DetectorFile) -> None:
        super().__init__(file)
        self._server = MetricsServer(address, self.registry)
        self.url = self._server.url

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Count the samples and the lines of a reading; report the address once."""
        super().put(chunk, lines)
        said, self._server.said = self._server.said, []
        return said

    def close(self) -> None:
        """End the server."""
        self._server.close()


class FleetMetrics(Collector):
    """Counts of each machine, served with its name as the label ``machine``; events of the fleet without."""

    def __init__(self, address: str) -> None:
        self._machines: dict[str, Counts] = {}
        registry = CollectorRegistry()
        registry.register(self)
        text = "Events of the fleet, each repetition counted"
        self._events = Counter("hydrofdi_fleet_events", text, ["kind"], registry=registry)
        self._server = MetricsServer(address, registry)
        self.said, self.url = self._server.said, self._server.url

    def put(
        self, machine: str, file: DetectorFile | None, chunk: Chunk | None, lines: Sequence[Line]
    ) -> None:
        """Count samples and lines of a machine; without a detector, events of the fleet."""
        if file is not None:
            if machine not in self._machines:
                self._machines[machine] = Counts(file)
            self._machines[machine].put(chunk, lines)
        else:
            for line in lines:
                if isinstance(line, Event) and not line.is_end:
                    self._events.labels(line.kind.value).inc(line.count)

    def forget(self, machine: str) -> None:
        """Serve nothing of a machine any more."""
        self._machines.pop(machine, None)

    def collect(self) -> Iterable[Metric]:
        """The metrics of all machines, those of one name together."""
        families: dict[str, Metric] = {}
        for name, counts in [*self._machines.items()]:
            for own in counts.registry.collect():
                new = Metric(own.name, own.documentation, own.type)
                family = families.setdefault(own.name, new)
                family.samples += [
                    each._replace(labels={"machine": name} | each.labels) for each in own.samples
                ]
        return families.values()

    def close(self) -> None:
        """End the server."""
        self._server.close()


class _Server(WSGIServer):
    """Answers one client after the other: those that send nothing take no threads."""

    def __init__(self, family: int, address: tuple[str, int], application: Any) -> None:
        self.address_family = family
        super().__init__(address, _Handler)
        self.set_app(application)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that break off."""


class _Handler(WSGIRequestHandler):
    def setup(self) -> None:
        """Give the client a while."""
        super().setup()
        self._end = Timer(_PATIENCE, self._break_off)
        self._end.start()

    def finish(self) -> None:
        """The client is served."""
        self._end.cancel()
        super().finish()

    def log_message(self, *_: Any) -> None:
        """Say nothing."""

    def _break_off(self) -> None:
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    is_port = port.isascii() and port.isdigit() and int(port) < 2**16
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        is_port = False
    if not (host and colon and is_port):
        raise ConfigError(f"metrics: {address!r} is not host:port; write, for example, 127.0.0.1:9464")
    return host.strip("[]"), int(port)
