import socket
import time
import urllib.request
from contextlib import ExitStack

import numpy as np
import pytest
from prometheus_client.openmetrics.parser import text_string_to_metric_families as open_metrics
from prometheus_client.parser import text_string_to_metric_families

from hydrofdi.detectors.lines import ChartReading, Condition, WindowLine
from hydrofdi.detectors.verdicts import Verdict
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.monitor.metrics import MetricsServer
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.detectors.trained.made import detector, with_chart

FILE = with_chart(detector(limits=(None, 5.0)))
PRESS = "mqtt://host/press"


@pytest.fixture
def server(closing):
    return closing(MetricsServer("127.0.0.1:0"))


def read(server, accepted="text/plain", parsed=text_string_to_metric_families):
    """Families over HTTP, in a format."""
    request = urllib.request.Request(server.url, headers={"Accept": accepted})
    with urllib.request.urlopen(request, timeout=30) as answer:
        return [*parsed(answer.read().decode())]


def served(server, machine=PRESS):
    """Name and labels of a machine → value; both formats say the same."""
    readings = []
    for families in (read(server), read(server, "application/openmetrics-text; version=1.0.0", open_metrics)):
        assert all(family.documentation for family in families)
        samples = [sample for family in families for sample in family.samples]
        own = [(sample.name, dict(sample.labels), sample.value) for sample in samples]
        own = [each for each in own if each[1].pop("machine") == machine and "_created" not in each[0]]
        readings.append({(name, *labels.values()): value for name, labels, value in own})
    assert readings[0].keys() == readings[1].keys()
    return readings[1]


def window(alarm, score=2.0, fault=None, condition=Condition.HEALTHY):
    verdict = Verdict(score, alarm, 3.0, fault)
    return WindowLine(0, 0.0, 1.0, verdict, ChartReading(1.5, 8.0, False), condition)


def test_windows_are_counted_by_what_is_said_of_them(server):
    stuck = Issue("P1 does not move", kind="stuck")
    server.put(
        PRESS,
        FILE,
        None,
        [window(False), window(False), window(True), window(None, None, stuck, Condition.ALARM)],
    )
    values = served(server)
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
    server.put(
        PRESS, FILE, None, [WindowLine(0, 0.0, 1.0, each, None, Condition.UNKNOWN) for each in verdicts]
    )
    values = served(server)
    assert values["hydrofdi_windows_not_judged_total", "novel"] == 3
    assert values["hydrofdi_windows_not_judged_beyond_limit_total",] == 2
    assert values["hydrofdi_margin",] == -3.0


def test_events_are_counted_with_their_repetitions_and_without_their_ends(server):
    gap = Event(EventKind.GAP, "a gap", count=3)
    more = Event(EventKind.GAP, "", count=2, is_silent=True)
    end = Event(EventKind.GAP, "", count=5, is_end=True)
    server.put(PRESS, FILE, None, [gap, more, end, Event(EventKind.ALARM_RAISED, "alarm")])
    values = served(server)
    assert values["hydrofdi_events_total", "gap"] == 5
    assert values["hydrofdi_alarms_total",] == 1


def test_machines_that_share_a_server_are_told_apart_and_one_that_goes_leaves_nothing(server):
    other = 'a "b"\\c'
    server.put(PRESS, FILE, None, [window(True)])
    server.put(other, detector(), None, [window(False, score=7.0), Event(EventKind.GAP, "a gap")])
    assert served(server)["hydrofdi_score",] == 2.0
    values = served(server, other)
    assert values["hydrofdi_score",] == 7.0
    assert values["hydrofdi_windows_judged_total", "true"] == 0
    assert not any(name.startswith("hydrofdi_chart") for name, *_ in values)
    server.forget(other)
    assert not served(server, other)
    assert served(server)["hydrofdi_windows_judged_total", "true"] == 1


def test_samples_are_counted_and_the_lag_is_that_of_the_wall_clock(server):
    server.put(PRESS, FILE, Chunk(np.array([0.0, 0.5]), {}), [])
    values = served(server)
    assert values["hydrofdi_samples_total",] == 2
    assert values["hydrofdi_last_sample_time_seconds",] == 0.5
    assert ("hydrofdi_lag_seconds",) not in values
    server.put(PRESS, FILE, Chunk(np.array([time.time() - 1000.0]), {}), [])
    assert 1000.0 <= served(server)["hydrofdi_lag_seconds",] < 1100.0


def test_silent_clients_delay_no_others_and_nothing_listens_after_the_end(closing):
    server = MetricsServer("127.0.0.1:0")
    server.put(PRESS, FILE, None, [])
    address = "127.0.0.1", int(server.url.split(":")[2].partition("/")[0])
    with ExitStack() as stack:
        clients = [stack.enter_context(socket.create_connection(address, timeout=30)) for _ in range(20)]
        clients[0].sendall(b"GET /metrics HTTP/1.1\r\n")
        assert served(server)["hydrofdi_alarms_total",] == 0
        assert not any(client.recv(1) for client in clients[1:])
        with pytest.raises(ConfigError, match="in use"):
            MetricsServer("{}:{}".format(*address))
        server.close()
    with socket.socket() as probe:
        assert probe.connect_ex(address) != 0
    kinds = [event.kind for event in closing(MetricsServer("0.0.0.0:0")).said]
    assert kinds == ["notice", "insecure"]


@pytest.mark.parametrize("address", ["9464", "host:", ":9464", "host:99999", "a\0b:80"])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(ConfigError):
        MetricsServer(address)
