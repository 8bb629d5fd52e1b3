"""Metrics of a monitor over HTTP, in the text format of Prometheus."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from ipaddress import ip_address
from typing import Any, TypeVar, cast

from prometheus_client import CollectorRegistry, Counter, Enum, Gauge, Info, start_http_server

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.lines import Condition, Line, WindowLine
from hydrofdi.errors import ConfigError
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.records.times import FIRST_DATE
from hydrofdi.store.files import reason
from hydrofdi.version import __version__

Metric = TypeVar("Metric", Counter, Gauge, Info, Enum)

_PATIENCE = 1.0
"""Longest silence of a client [s]."""


class MetricsServer:
    """Serves the metrics of one machine or of many, told apart by the label ``machine``.

    `said` are events that state its address.
    """

    def __init__(self, address: str) -> None:
        host, port = _host_and_port(address)
        self._registry = CollectorRegistry()
        self._metrics: dict[str, Counter | Gauge | Info | Enum] = {}
        self._machines: dict[str, MetricsSink] = {}
        try:
            self._server, self._thread = start_http_server(port, host, self._registry)
        except (OSError, UnicodeError) as error:
            raise ConfigError(f"metrics: {address}: {reason(error)}") from None
        # A client that is silent or breaks off ends its own thread, and nothing is said of it.
        vars(self._server)["handle_error"] = lambda *_: None
        handler: Any = self._server.RequestHandlerClass
        self._server.RequestHandlerClass = type("Handler", (handler,), {"timeout": _PATIENCE})
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self._server.server_port}/metrics"
        self.said = [Event(EventKind.NOTICE, f"metrics are served at {self.url}")]
        if not ip_address(str(self._server.server_address[0]).partition("%")[0]).is_loopback:
            text = f"everyone who reaches {self.url} can read the metrics"
            self.said.append(Event(EventKind.INSECURE, text))

    def metric(self, kind: Callable[..., Metric], name: str, text: str, *labels: str, **more: Any) -> Metric:
        """The metric of this name; made at the first call."""
        if name not in self._metrics:
            labels = ("machine", *labels)
            self._metrics[name] = kind(f"hydrofdi_{name}", text, labels, registry=self._registry, **more)
        return cast(Metric, self._metrics[name])

    def forget(self, machine: str) -> None:
        """Serve nothing of this machine any more."""
        self._machines.pop(machine, None)
        for metric in self._metrics.values():
            metric.remove_by_labels({"machine": machine})

    def put(self, machine: str, file: DetectorFile, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Count the samples and the lines of a reading of a machine."""
        if machine not in self._machines:
            self._machines[machine] = MetricsSink(self, machine, file)
        self._machines[machine].put(chunk, lines)

    def count(self, lines: Sequence[Line]) -> None:
        """Count the events of no machine."""
        for line in lines:
            if isinstance(line, Event) and not line.is_end:
                text = "Events of the fleet, each repetition counted"
                self.metric(Counter, "fleet_events", text, "kind").labels("", line.kind.value).inc(line.count)

    def show_age(self, machine: str, age: float) -> None:
        """Show how old the newest samples were [s]; a fleet has no name."""
        text = "Age of the newest samples when they were judged, median over the machines"
        self.metric(Gauge, "behind_seconds", text).labels(machine).set(age)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class MetricsSink:
    """Counts the lines of a machine, and shows its last numbers."""

    def __init__(self, server: MetricsServer, machine: str, file: DetectorFile) -> None:
        self._server, self._machine = server, machine
        self._describe(file)
        text = "Windows that were judged"
        self._judged = {
            alarm: self._own(Counter, "windows_judged", text, beyond_limit=str(alarm).lower())
            for alarm in (False, True)
        }
        text = "Windows that were not judged, with a score beyond its limit"
        self._beyond = self._own(Counter, "windows_not_judged_beyond_limit", text)
        self._alarms = self._own(Counter, "alarms", "Alarms that were raised")
        self._samples = self._own(Counter, "samples", "Samples that arrived")
        states, text = [condition.value for condition in Condition], "Condition of the actuator"
        self._condition = server.metric(Enum, "condition", text, states=states).labels(machine)
        self._score = self._gauge("score", "Score of the last window that has one, in SI", math.nan)
        text = "Distance of this score from its limit, in healthy spreads"
        self._margin = self._gauge("margin", text, math.nan)
        text = "Arrival of the last window; before the first, start of the monitor (Unix time)"
        self._window = self._gauge("last_window_timestamp_seconds", text, time.time())
        text = "Time stamp of the last sample, on the clock of the stream"
        self._sample = self._gauge("last_sample_time_seconds", text)
        self._lag: Gauge | None = None
        self._latest = math.nan

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Count the samples and the lines of a reading."""
        if chunk is not None and (readable := chunk.readable).n_time:
            self._count_samples(readable)
        for line in lines:
            if isinstance(line, WindowLine):
                self._count_window(line)
            else:
                self._count_event(line)

    def _describe(self, file: DetectorFile) -> None:
        output = file.config.output or file.score_name
        about = {"version": __version__, "indicator": file.config.indicator, "output": output}
        self._own(Info, "monitor", "Version and detector").info({**about, "unit": file.unit})
        for side, limit in (("low", file.limits.low), ("high", file.limits.high)):
            if limit is not None:
                self._own(Gauge, "threshold", "Limits of the score, in SI", side=side).set(limit)
        self._statistic: Gauge | None = None
        if file.chart is not None:
            self._gauge("chart_limit", "Limit of the control chart, in healthy spreads", file.chart.limit)
            text = "Statistic of the control chart, in healthy spreads"
            self._statistic = self._gauge("chart_statistic", text, math.nan)

    def _count_samples(self, chunk: Chunk) -> None:
        self._samples.inc(chunk.n_time)
        self._latest = latest = float(chunk.time[-1])
        self._sample.set(latest)
        if self._lag is None and latest > FIRST_DATE:
            self._lag = self._gauge("lag_seconds", "Wall clock minus the time stamp of the last sample")
            self._lag.set_function(lambda: time.time() - self._latest)

    def _count_window(self, line: WindowLine) -> None:
        verdict = line.verdict
        self._window.set(time.time())
        self._condition.state(line.condition.value)
        if verdict.alarm is None:
            kind = verdict.fault.kind if verdict.fault else "unknown"
            self._own(Counter, "windows_not_judged", "Windows that were not judged", reason=kind).inc()
            self._beyond.inc(bool(verdict.is_beyond))
        else:
            self._judged[verdict.alarm].inc()
        if verdict.score is not None:
            self._score.set(verdict.score)
            self._margin.set(math.nan if verdict.margin is None else verdict.margin)
        if self._statistic and line.chart is not None and line.chart.statistic is not None:
            self._statistic.set(line.chart.statistic)

    def _count_event(self, line: Event) -> None:
        if line.is_end:
            return
        self._own(Counter, "events", "Events, each repetition counted", kind=line.kind.value).inc(line.count)
        if line.kind is EventKind.ALARM_RAISED:
            self._alarms.inc()

    def _own(self, metric: Callable[..., Metric], name: str, text: str, **labels: str) -> Metric:
        """This machine's part of a metric."""
        whole = self._server.metric(metric, name, text, *labels)
        return whole.labels(machine=self._machine, **labels)

    def _gauge(self, name: str, text: str, value: float = 0.0) -> Gauge:
        gauge = self._own(Gauge, name, text)
        gauge.set(value)
        return gauge


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    is_port = port.isascii() and port.isdigit() and int(port) < 2**16
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        is_port = False
    if not (host and colon and is_port):
        raise ConfigError(f"metrics: {address!r} is not host:port; write, for example, 127.0.0.1:9464")
    return host.strip("[]"), int(port)
