"""Metrics of a monitor over HTTP, in the text format of Prometheus."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from ipaddress import ip_address
from typing import Any

from prometheus_client import CollectorRegistry, Metric, start_http_server
from prometheus_client.core import CounterMetricFamily as Counter
from prometheus_client.core import GaugeMetricFamily as Gauge
from prometheus_client.core import InfoMetricFamily as Info
from prometheus_client.core import StateSetMetricFamily as StateSet
from prometheus_client.registry import Collector

from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import Condition, Line, WindowLine
from hydrofdi.errors import ConfigError
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.records.times import FIRST_DATE
from hydrofdi.store.files import reason
from hydrofdi.version import __version__

_PATIENCE = 1.0
"""Longest silence of a client [s]."""

_METRICS: dict[str, tuple[Any, ...]] = {
    "monitor": (Info, "Version and detector"),
    "threshold": (Gauge, "Limits of the score, in SI", "side"),
    "chart_limit": (Gauge, "Limit of the control chart, in healthy spreads"),
    "chart_statistic": (Gauge, "Statistic of the control chart, in healthy spreads"),
    "windows_judged": (Counter, "Windows that were judged", "beyond_limit"),
    "windows_not_judged": (Counter, "Windows that were not judged", "reason"),
    "windows_not_judged_beyond_limit": (
        Counter, "Windows that were not judged, with a score beyond its limit",
    ),
    "alarms": (Counter, "Alarms that were raised"),
    "samples": (Counter, "Samples that arrived"),
    "events": (Counter, "Events, each repetition counted", "kind"),
    "fleet_events": (Counter, "Events of the fleet, each repetition counted", "kind"),
    "condition": (StateSet, "Condition of the actuator"),
    "score": (Gauge, "Score of the last window that has one, in SI"),
    "margin": (Gauge, "Distance of this score from its limit, in healthy spreads"),
    "last_window_timestamp_seconds": (
        Gauge, "Arrival of the last window; before the first, start of the monitor (Unix time)",
    ),
    "last_sample_time_seconds": (Gauge, "Time stamp of the last sample, on the clock of the stream"),
    "lag_seconds": (Gauge, "Wall clock minus the time stamp of the last sample"),
    "behind_seconds": (Gauge, "Age of the newest samples when they were judged, median over the machines"),
}  # fmt: skip
"""Name → its kind, what it is, and labels beside ``machine``."""

Values = defaultdict[tuple[str, ...], Any]
"""Name and labels → value, of one machine."""


class MetricsServer(Collector):
    """Serves the metrics of one machine or of many, told apart by the label ``machine``; a fleet has no name.

    `said` are events that state its address.
    """

    def __init__(self, address: str) -> None:
        host, port = _host_and_port(address)
        registry = CollectorRegistry()
        registry.register(self)
        self._machines: dict[str, Values] = {}
        try:
            self._server, self._thread = start_http_server(port, host, registry)
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

    def collect(self) -> Iterator[Metric]:
        """The metrics of all machines now."""
        families = {
            name: kind(f"hydrofdi_{name}", text, labels=("machine", *labels))
            for name, (kind, text, *labels) in _METRICS.items()
        }
        # Copies, as the thread of the monitor goes on counting.
        for machine, values in [*self._machines.items()]:
            for (name, *labels), value in [*values.items()]:
                families[name].add_metric((machine, *labels), value)
            if (latest := values.get(("last_sample_time_seconds",), 0.0)) > FIRST_DATE:
                families["lag_seconds"].add_metric((machine,), time.time() - latest)
        return (family for family in families.values() if family.samples)

    def put(self, machine: str, file: DetectorFile, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Count the samples and the lines of a reading of a machine."""
        if machine not in self._machines:
            self._machines[machine] = _begun(file)
        values = self._machines[machine]
        if chunk is not None and (readable := chunk.readable).n_time:
            values["samples",] += readable.n_time
            values["last_sample_time_seconds",] = float(readable.time[-1])
        for line in lines:
            if isinstance(line, WindowLine):
                _count_window(values, line)
            elif not line.is_end:
                values["events", line.kind.value] += line.count
                values["alarms",] += line.kind is EventKind.ALARM_RAISED

    def count(self, lines: Sequence[Line]) -> None:
        """Count the events of no machine."""
        values = self._machines.setdefault("", defaultdict(float))
        for line in lines:
            if isinstance(line, Event) and not line.is_end:
                values["fleet_events", line.kind.value] += line.count

    def show_age(self, machine: str, age: float) -> None:
        """Show how old the newest samples were [s]."""
        self._machines[machine]["behind_seconds",] = age

    def forget(self, machine: str) -> None:
        """Serve nothing of this machine any more."""
        self._machines.pop(machine, None)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def _begun(file: DetectorFile) -> Values:
    """What is shown of a machine before its first window."""
    output = file.config.output or file.score_name
    about = {"version": __version__, "indicator": file.config.indicator, "output": output, "unit": file.unit}
    values: Values = defaultdict(float, {("monitor",): about})
    counters = ("windows_judged", "false"), ("windows_judged", "true"), ("windows_not_judged_beyond_limit",)
    values |= dict.fromkeys((*counters, ("alarms",), ("samples",), ("last_sample_time_seconds",)), 0.0)
    values |= {("score",): math.nan, ("margin",): math.nan, ("condition",): _states(Condition.UNKNOWN)}
    values["last_window_timestamp_seconds",] = time.time()
    limits = {"low": file.limits.low, "high": file.limits.high}
    values |= {("threshold", side): limit for side, limit in limits.items() if limit is not None}
    if file.chart is not None:
        values |= {("chart_limit",): file.chart.limit, ("chart_statistic",): math.nan}
    return values


def _states(condition: Condition) -> dict[str, bool]:
    return {each.value: each is condition for each in Condition}


def _count_window(values: Values, line: WindowLine) -> None:
    verdict = line.verdict
    values["last_window_timestamp_seconds",] = time.time()
    values["condition",] = _states(line.condition)
    if verdict.alarm is None:
        values["windows_not_judged", verdict.fault.kind if verdict.fault else "unknown"] += 1
        values["windows_not_judged_beyond_limit",] += bool(verdict.is_beyond)
    else:
        values["windows_judged", str(verdict.alarm).lower()] += 1
    if verdict.score is not None:
        values["score",] = verdict.score
        values["margin",] = math.nan if verdict.margin is None else verdict.margin
    if ("chart_statistic",) in values and line.chart is not None and line.chart.statistic is not None:
        values["chart_statistic",] = line.chart.statistic


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    is_port = port.isascii() and port.isdigit() and int(port) < 2**16
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        is_port = False
    if not (host and colon and is_port):
        raise ConfigError(f"metrics: {address!r} is not host:port; write, for example, 127.0.0.1:9464")
    return host.strip("[]"), int(port)
