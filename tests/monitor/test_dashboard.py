"""Dashboard and alert rules ask for metrics and labels that a monitor exposes."""

import json
import re
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from hydrofdi.errors import Issue
from hydrofdi.monitor.metrics import MetricsServer
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.monitor.test_metrics import FILE, read, window

DEPLOY = Path(__file__).parent.parent.parent / "docs" / "deploy"
RULES = DEPLOY / "prometheus-rules.yaml"
DASHBOARD = json.loads((DEPLOY / "grafana-dashboard.json").read_text())
BY_PROMETHEUS = {"up": set()}
OF_PROMETHEUS = {"job", "instance"}


@pytest.fixture(scope="module")
def exposed():
    """Metric → its labels, of a monitor that has shown everything."""
    server = MetricsServer("127.0.0.1:0")
    lines = [
        window(True),
        window(None, None, Issue("no motion", kind="stuck")),
        Event(EventKind.GAP, "a gap"),
    ]
    server.put("press", FILE, Chunk(np.array([time.time()]), {}), lines)
    families = read(server)
    server.close()
    return {sample.name: {*sample.labels} for family in families for sample in family.samples}


def rules():
    (group,) = yaml.safe_load(RULES.read_text())["groups"]
    return {rule["alert"]: rule for rule in group["rules"]}


def expressions():
    yield from (rule["expr"] for rule in rules().values())
    yield from (target["expr"] for panel in DASHBOARD["panels"] for target in panel["targets"])
    for variable in DASHBOARD["templating"]["list"]:
        if variable["type"] == "query":
            yield re.sub(r"label_values\((\w+), (\w+)\)", r"sum by (\2) (\1)", variable["query"]["query"])


@pytest.mark.parametrize("expression", list(expressions()))
def test_what_dashboard_and_rules_ask_for_is_exposed(expression, exposed):
    known = exposed | BY_PROMETHEUS
    asked = re.findall(r"\b(up|hydrofdi_\w+)\b(?!=)(?:\{(.*?)\})?", expression)
    assert asked
    grouped = {
        label.strip() for found in re.findall(r"by \((.*?)\)", expression) for label in found.split(",")
    }
    for name, selected in asked:
        assert name in known
        labels = {*re.findall(r"(\w+)(?:=~|=|!=)", selected)} | grouped
        assert labels <= known[name] | OF_PROMETHEUS


def test_the_dashboard_chooses_machines_and_fills_every_panel():
    assert {each["name"] for each in DASHBOARD["templating"]["list"]} == {"datasource", "machine"}
    for panel in DASHBOARD["panels"]:
        assert panel["targets"]
        for target in panel["targets"]:
            assert "$machine" in target["expr"] or "up{" in target["expr"]
    places = [tuple(panel["gridPos"][key] for key in "xy") for panel in DASHBOARD["panels"]]
    assert len({*places}) == len(places)


def test_rules_say_how_serious_they_are_and_what_happened():
    for rule in rules().values():
        assert rule["labels"]["severity"] in ("critical", "warning")
        assert {"summary", "description"} == rule["annotations"].keys()
    text = json.dumps([*rules().values()])
    for sign in ("condition", "not_judged", "last_window", "lag_seconds", "up{"):
        assert sign in text
    if promtool := shutil.which("promtool"):
        subprocess.run([promtool, "check", "rules", RULES], check=True, capture_output=True)
