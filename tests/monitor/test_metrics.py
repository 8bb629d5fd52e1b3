import socket
import threading
import time
import urllib.request
from contextlib import ExitStack

import numpy as np
import pytest
from prometheus_client.parser import text_string_to_metric_families

from hydrofdi.detectors.trained.file import ChartLimit
from hydrofdi.detectors.trained.measuring import Verdict
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.monitor import metrics
from hydrofdi.monitor.lines import ChartReading, Condition, WindowLine
from hydrofdi.monitor.metrics import MetricsSink
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.detectors.trained.made import detector


@pytest.fixture
def sink(closing):
    chart = ChartLimit(limit=8.0, mean_time=None, interval=(1.0, None), hours=1.0)
    file = detector(limits=(None, 5.0)).model_copy(update={"chart": chart})
    return closing(MetricsSink("127.0.0.1:0", file))


def served(sink):
    """Name and labels → value, over HTTP."""
    with urllib.request.urlopen(sink.url, timeout=30) as answer:
        families = [*text_string_to_metric_families(answer.read().decode())]
    assert all(family.documentation for family in families)
    samples = [sample for family in families for sample in family.samples]
    return {(sample.name, *sample.labels.values()): sample.value for sample in samples}


def window(alarm, score=2.0, fault=None, condition=Condition.HEALTHY):
    verdict = Verdict(score, alarm, 3.0, fault)
    return WindowLine(0, 0.0, 1.0, verdict, ChartReading(1.5, 8.0, False), condition)


def test_windows_are_counted_by_what_is_said_of_them(sink):
    stuck = Issue("P1 does not move", kind="stuck")
    sink.put(None, [window(False), window(False), window(True), window(None, None, stuck, Condition.ALARM)])
    values = served(sink)
    assert values["hydrofdi_windows_judged_total", "false"] == 2
    assert values["hydrofdi_windows_judged_total", "true"] == 1
    assert values["hydrofdi_windows_not_judged_total", "stuck"] == 1
    assert [values["hydrofdi_condition", each.value] for each in Condition] == [0.0, 0.0, 1.0]
    assert values["hydrofdi_score",] == 2.0
    assert values["hydrofdi_margin",] == 3.0
    assert values["hydrofdi_chart_statistic",] == 1.5
    assert values["hydrofdi_chart_limit",] == 8.0
    assert values["hydrofdi_threshold", "high"] == 5.0
    assert ("hydrofdi_threshold", "low") not in values
    novel = Issue("P1 is unlike the healthy ones", kind="novel")
    verdicts = [Verdict(9.0, None, margin, novel) for margin in (-2.0, 1.0, -3.0)]
    sink.put(None, [WindowLine(0, 0.0, 1.0, each, None, Condition.UNKNOWN) for each in verdicts])
    values = served(sink)
    assert values["hydrofdi_windows_not_judged_total", "novel"] == 3
    assert values["hydrofdi_windows_not_judged_beyond_limit_total",] == 2
    assert values["hydrofdi_margin",] == -3.0


def test_events_are_counted_with_their_repetitions_and_without_their_ends(sink):
    gap = Event(EventKind.GAP, "a gap", count=3)
    more = Event(EventKind.GAP, "", count=2, is_silent=True)
    end = Event(EventKind.GAP, "", count=5, is_end=True)
    sink.put(None, [gap, more, end, Event(EventKind.ALARM_RAISED, "alarm")])
    values = served(sink)
    assert values["hydrofdi_events_total", "gap"] == 5
    assert values["hydrofdi_alarms_total",] == 1


def test_samples_are_counted_and_the_lag_is_that_of_the_wall_clock(sink):
    sink.put(Chunk(np.array([0.0, 0.5]), {}), [])
    values = served(sink)
    assert values["hydrofdi_samples_total",] == 2
    assert values["hydrofdi_last_sample_time_seconds",] == 0.5
    assert ("hydrofdi_lag_seconds",) not in values
    sink.put(Chunk(np.array([time.time() - 1000.0]), {}), [])
    assert 1000.0 <= served(sink)["hydrofdi_lag_seconds",] < 1100.0


def test_silent_clients_are_dropped_and_nothing_listens_after_the_end(closing, monkeypatch):
    monkeypatch.setattr(metrics, "_PATIENCE", 0.05)
    sink = MetricsSink("127.0.0.1:0", detector())
    n_thread, address = threading.active_count(), ("127.0.0.1", int(sink.url.split(":")[2].partition("/")[0]))
    with ExitStack() as stack:
        clients = [stack.enter_context(socket.create_connection(address)) for _ in range(6)]
        clients[0].sendall(b"GET /metrics HTTP/1.1\r\n")
        assert served(sink)["hydrofdi_alarms_total",] == 0
        assert threading.active_count() <= n_thread + 2
        with pytest.raises(ConfigError, match="in use"):
            MetricsSink("{}:{}".format(*address), detector())
        sink.close()
    with socket.socket() as probe:
        assert probe.connect_ex(address) != 0
    kinds = [event.kind for event in closing(MetricsSink("0.0.0.0:0", detector())).put(None, [])]
    assert kinds == ["notice", "insecure"]


@pytest.mark.parametrize("address", ["9464", "host:", ":9464", "host:99999", "a\0b:80"])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(ConfigError):
        MetricsSink(address, detector())
