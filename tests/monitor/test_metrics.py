"""Metrics over HTTP; dashboard and alert rules ask for those that a monitor exposes."""

import json
import re
import shutil
import socket
import subprocess
import time
import urllib.request
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
import yaml
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
GAP = Event(EventKind.GAP, "a gap", count=3)
STUCK = Issue("P1 does not move", kind="stuck")


@pytest.fixture
def server(closing):
    return closing(MetricsServer("127.0.0.1:0"))


def read(server, accepted="text/plain", parsed=text_string_to_metric_families):
    """Samples over HTTP, in a format."""
    request = urllib.request.Request(server.url, headers={"Accept": accepted})
    with urllib.request.urlopen(request, timeout=30) as answer:
        families = [*parsed(answer.read().decode())]
    assert all(family.documentation for family in families)
    return [sample for family in families for sample in family.samples]


def served(server, machine=PRESS):
    """Name and labels of a machine → value; both formats say the same."""
    readings = []
    for samples in (read(server), read(server, "application/openmetrics-text; version=1.0.0", open_metrics)):
        own = [(sample.name, dict(sample.labels), sample.value) for sample in samples]
        own = [each for each in own if each[1].pop("machine") == machine and "_created" not in each[0]]
        readings.append(
            {(name.removeprefix("hydrofdi_"), *labels.values()): value for name, labels, value in own}
        )
    assert readings[0].keys() == readings[1].keys()
    return readings[1]


def window(alarm, score=2.0, fault=None, condition=Condition.HEALTHY, margin=3.0):
    verdict = Verdict(score, alarm, margin, fault)
    return WindowLine(0, 0.0, 1.0, verdict, ChartReading(1.5, 8.0, False), condition)


def test_windows_events_and_samples_are_counted_by_what_is_said_of_them(server):
    """Events with their repetitions and without their ends; the lag is that of the wall clock."""
    lines = [window(False), window(False), window(True), window(None, None, STUCK, Condition.ALARM)]
    more = Event(EventKind.GAP, "", count=2, is_silent=True)
    end = Event(EventKind.GAP, "", count=5, is_end=True)
    lines += [GAP, more, end, Event(EventKind.ALARM_RAISED, "alarm")]
    server.put(PRESS, FILE, Chunk(np.array([0.0, 0.5]), {}), lines)
    values = served(server)
    expected = {
        ("windows_judged_total", "false"): 2, ("windows_judged_total", "true"): 1,
        ("windows_not_judged_total", "stuck"): 1, ("events_total", "gap"): 5, ("alarms_total",): 1,
        ("score",): 2.0, ("margin",): 3.0, ("chart_statistic",): 1.5, ("chart_limit",): 8.0,
        ("threshold", "high"): 5.0, ("samples_total",): 2, ("last_sample_time_seconds",): 0.5,
        **{("condition", each.value): float(each is Condition.ALARM) for each in Condition},
    }  # fmt: skip
    assert {key: values[key] for key in expected} == expected
    assert not {("threshold", "low"), ("lag_seconds",)} & {*values}
    novel = Issue("P1 is unlike the healthy ones", kind="novel")
    lines = [window(None, 9.0, novel, margin=margin) for margin in (-2.0, 1.0, -3.0)]
    server.put(PRESS, FILE, Chunk(np.array([time.time() - 1000.0]), {}), lines)
    values = served(server)
    assert values["windows_not_judged_total", "novel"] == 3
    assert values["windows_not_judged_beyond_limit_total",] == 2
    assert values["margin",] == -3.0
    assert 1000.0 <= values["lag_seconds",] < 1100.0


def test_machines_that_share_a_server_are_told_apart_and_one_that_goes_leaves_nothing(server):
    other = 'a "b"\\c'
    server.put(PRESS, FILE, None, [window(True)])
    server.put(other, detector(), None, [window(False, score=7.0), GAP])
    assert served(server)["score",] == 2.0
    values = served(server, other)
    assert values["score",] == 7.0
    assert values["windows_judged_total", "true"] == 0
    assert not any(name.startswith("chart") for name, *_ in values)
    server.forget(other)
    assert not served(server, other)
    assert served(server)["windows_judged_total", "true"] == 1


def test_silent_clients_delay_no_others_and_nothing_listens_after_the_end(closing):
    server = MetricsServer("127.0.0.1:0")
    server.put(PRESS, FILE, None, [])
    address = "127.0.0.1", int(server.url.split(":")[2].partition("/")[0])
    with ExitStack() as stack:
        clients = [stack.enter_context(socket.create_connection(address, timeout=30)) for _ in range(20)]
        clients[0].sendall(b"GET /metrics HTTP/1.1\r\n")
        assert served(server)["alarms_total",] == 0
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


DEPLOY = Path(__file__).parents[2] / "docs" / "deploy"
RULES = DEPLOY / "prometheus-rules.yaml"


def test_what_dashboard_and_rules_ask_for_is_exposed(server):
    (group,) = yaml.safe_load(RULES.read_text())["groups"]
    dashboard = json.loads((DEPLOY / "grafana-dashboard.json").read_text())
    asked = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    assert all("$machine" in expression or "up{" in expression for expression in asked)
    asked += [rule["expr"] for rule in group["rules"]]
    for variable in dashboard["templating"]["list"]:
        if variable["type"] == "query":
            query = variable["query"]["query"]
            asked.append(re.sub(r"label_values\((\w+), (\w+)\)", r"sum by (\2) (\1)", query))
    server.put(
        PRESS, FILE, Chunk(np.array([time.time()]), {}), [window(True), window(None, None, STUCK), GAP]
    )
    known = {sample.name: {*sample.labels} for sample in read(server)} | {"up": set()}
    for expression in asked:
        found = re.findall(r"\b(up|hydrofdi_\w+)\b(?!=)(?:\{(.*?)\})?", expression)
        grouped = {*re.findall(r"\w+", " ".join(re.findall(r"by \((.*?)\)", expression)))}
        assert found
        for name, selected in found:
            assert grouped | {*re.findall(r"(\w+)(?:=~|=|!=)", selected)} <= known[name] | {"job", "instance"}
    for sign in ("condition", "not_judged", "last_window", "lag_seconds", "up{"):
        assert sign in json.dumps(group)
    if promtool := shutil.which("promtool"):
        subprocess.run([promtool, "check", "rules", RULES], check=True, capture_output=True)
