"""A detector keeps its promise on other healthy machines, finds leaks, and says where it knows nothing."""

import json
from pathlib import Path

import pytest

from tests.commands import run_hydrofdi

CONFIGS = Path(__file__).parents[3] / "configs"
MOTION = f", {CONFIGS}/motions/closed-loop.yaml"


def population(folder, name, seed, n_record, more="", study="", motion=MOTION):
    """Machines at work of which nobody knows more than the data sheet."""
    path = folder / f"{name}.yaml"
    path.write_text(
        f"""
name: {name}
extends: [{CONFIGS}/populations/unknown-plant.yaml{motion}]
record: {{duration: 4 s}}
{more}
study:
  population: {{seed: {seed}}}
  healthy: {{fit: {n_record}, test: 1, shift: 1}}
  {study}
""",
        encoding="utf-8",
    )
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("promise")


@pytest.fixture(scope="module")
def trained(folder):
    return detector(folder, population(folder, "healthy", 3, 40))


def detector(folder, healthy):
    out = folder / f"{healthy.stem}.json"
    flags = ["--indicator", "flow_balance", "--window", "2 s", "--false-alarm-rate", "5 %"]
    assert run_hydrofdi("train", healthy, *flags, "--out", out).returncode == 0
    return out


def summary(trained, source, *flags):
    ended = run_hydrofdi("detect", trained, source, "--json", *flags)
    return json.loads(ended.stdout)["summary"]


def test_other_healthy_machines_alarm_as_often_as_promised(folder, trained):
    found = summary(trained, population(folder, "others", 4, 40))
    low, high = found["alarm_share_interval"]
    promised = json.loads(trained.read_text())["limits"]["interval"]
    assert found["n_judged"] > 70
    assert low <= promised[1]
    assert promised[0] <= high
    assert found["alarm_share"] < 0.15


def test_a_leak_is_found(folder, trained):
    faults = "faults: {leakage.internal_flow: [2 L/min], each: 10, fit: 0, severity: level}"
    found = summary(trained, population(folder, "leak", 5, 1, study=faults))
    assert found["alarm_share"] > 0.7


def test_a_machine_at_another_supply_pressure_is_novel_and_no_alarm(folder, trained):
    found = summary(trained, population(folder, "weak", 8, 5, more="supply: {pressure: 12 MPa}"))
    assert found["n_alarm"] == 0
    assert found["not_judged"].keys() == {"novel"}


def test_a_large_leak_is_an_alarm_and_not_novel(folder):
    trained = detector(folder, population(folder, "open", 3, 30, motion=""))
    faults = "faults: {leakage.internal_flow: [2 L/min], each: 10, fit: 0, severity: level}"
    found = summary(trained, population(folder, "large", 5, 1, study=faults, motion=""))
    assert "novel" not in found["not_judged"]
    assert found["alarm_share"] > 0.7
