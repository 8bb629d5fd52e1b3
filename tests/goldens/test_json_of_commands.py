"""The JSON of every command on ready configurations, one file each. HYDROFDI_WRITE_GOLDEN=1 writes them anew.

Keys and texts are compared exactly, numbers to what other processors may change.
"""

import json
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest

from tests.commands import run
from tests.processors import same

HERE = Path(__file__).parent

FREE = {
    "bytes", "command", "cost_ms_per_record", "created", "description", "digest", "file", "file_bytes",
    "folder", "free_bytes", "git", "hydrofdi", "latency", "library_versions", "machine", "message", "missing",
    "note", "notes", "path", "predicted_file_bytes", "provenance", "reason", "remark", "remarks",
    "remedy", "seconds", "seconds_high", "seconds_low", "shard", "text", "time", "version", "versions",
    "warnings",
}  # fmt: skip
"""Keys whose values are sentences, or depend on the machine or the hour."""

RATE = ("--false-alarm-rate", "10 %")
TRAIN = ("--output", "d2", "--direction", "both", "--window", "2 s", *RATE)

COMMANDS = {
    "simulate": ("simulate",),
    "simulate-leak": ("simulate", "--set", "leakage.internal_flow=0.5 L/min", "--set", "record.duration=5 s"),
    "plan": ("plan", "table3"),
    "plan-study": ("plan", "detectability-smoke"),
    "check": ("check",),
    "calibrate": ("calibrate", "--flow", "0.12 L/min"),
    "status": ("status", "results/smoke"),
    "verify": ("verify", "results/smoke"),
    "why": ("why", "results/smoke", "1"),
    "rerun": ("rerun", "results/smoke", "1"),
    "report-smoke": ("report", "results/smoke"),
    "report-table3": ("report", "results/table3"),
    "report-study": ("report", "results/detectability-smoke"),
    "report-delays": ("report", "results/delays-smoke"),
    "measure": ("measure", "results/smoke", "--indicators", "dwt,ring_down,cross_correlation"),
    "measure-csv": ("measure", "rig.csv", "--indicators", "dwt,cross_correlation,pressure_statistics"),
    "inspect": ("inspect", "rig.csv"),
    "evaluate": ("evaluate", "healthy.yaml", "leak.yaml", *RATE, "--indicators", "dwt"),
    "detect": ("detect", "detector.json", "leak.csv"),
    "indicator": ("indicators", "ring_down"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Sweeps of ready configurations, two recordings, and a detector."""
    folder = tmp_path_factory.mktemp("goldens")
    for name in ("smoke", "table3", "detectability-smoke", "delays/smoke"):
        run("sweep", name, "--engine", "in-process", cwd=folder, check=0)
    for name, file, *about in (("healthy", "rig.csv", 1, 0.02, 60), ("leak", "leak.csv", 2, 0.03, 20)):
        _write_recording(folder / file, *about)
        (folder / f"{name}.yaml").write_text(
            f"files: {file}\nlabel: {name}\nhealthy: [healthy]\ncycles: {{by: period, period: 2 s}}\n"
        )
    run("train", "rig.csv", *TRAIN, "--out", "detector.json", cwd=folder, check=0)
    return folder


def _write_recording(path, seed, damping, seconds):
    """Two pressures that ring after each edge of a square wave, at 500 Hz, rounded as a logger does."""
    time = np.arange(seconds * 500) / 500.0
    since, sign = time % 1.0, np.where(time % 2.0 < 1.0, 1.0, -1.0)
    ring = sign * np.exp(-damping * 2.0 * math.pi * 40.0 * since) * np.sin(2.0 * math.pi * 40.0 * since)
    generator = np.random.default_rng(seed)
    ring *= np.repeat(generator.uniform(0.8, 1.2, seconds), 500)
    pressures = 85.0 + 20.0 * np.stack([ring, -ring]) + generator.normal(0.0, 0.05, (2, time.size))
    columns = np.column_stack([time, *pressures, 2.0 * sign])
    np.savetxt(path, columns, "%.4f", ",", header="time [s],P1 [bar],P2 [bar],u [V]", comments="")


@pytest.mark.parametrize("name", [*COMMANDS, "monitor", "detector"])
def test_a_command_keeps_its_json(folder, name):
    """A monitor keeps its lines, and a detector its file."""
    if name == "monitor":
        done = run("monitor", "detector.json", "leak.csv", "--no-follow", cwd=folder, check=0)
        found = [json.loads(line) for line in done.stdout.splitlines()]
    elif name == "detector":
        found = json.loads((folder / "detector.json").read_text())
    else:
        found = json.loads(run(*COMMANDS[name], "--json", cwd=folder).stdout)
    path = HERE / f"{name}.json"
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        path.write_text(json.dumps(_frozen(found), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert _frozen(found) == same(json.loads(path.read_text(encoding="utf-8")))


def _frozen(value):
    """A JSON value without what is free."""
    if isinstance(value, dict):
        return {key: None if key in FREE else _frozen(each) for key, each in value.items()}
    return [_frozen(each) for each in value] if isinstance(value, list) else value


@pytest.mark.parametrize("name", sorted(path.stem for path in HERE.glob("*.json") if path.stem != "detector"))
def test_the_page_of_json_names_every_key(name):
    golden = json.loads((HERE / f"{name}.json").read_text(encoding="utf-8"))
    lines = golden if isinstance(golden, list) else [golden, *golden.get("windows", [])]
    lines += [golden["summary"]] if name == "detect" else []
    pages = (HERE.parents[1] / "docs" / page for page in ("json.md", "monitoring-states.md"))
    page = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert {key for line in lines for key in line} - {*re.findall(r"`(\w+)(?:\[\d+\])?`", page)} == set()
