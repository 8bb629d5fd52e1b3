"""Hints that whoever fills in a data sheet needs: the valve's range, the spring, the supply sensor."""

from __future__ import annotations

from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.api.warnings import STUDY_RULES, said
from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from tests.commands import run

FAST = {
    "record": {"duration": "4 s"},
    "control": {"law": "p", "amplitude": "20 mm", "proportional_gain": "2000 V/m", "voltage_limit": "1 V"},
}
STUDY = {"healthy": {"fit": 4, "test": 4}, "faults": {"leakage.internal_flow": [1e-6], "each": 2, "fit": 0}}


def test_a_controller_at_its_limit_for_much_of_the_record_is_told() -> None:
    (sentence,) = hydrofdi.simulate({"name": "fast", **FAST}).saturation
    assert sentence.startswith("the controller is at control.voltage_limit = 1 V in ")
    assert "set it to the range of your valve" in sentence


def test_a_calm_controller_and_an_open_loop_are_not_told() -> None:
    calm = {**FAST, "control": {**FAST["control"], "proportional_gain": "20 V/m"}}
    assert hydrofdi.simulate({"name": "calm", **calm}).saturation == []
    assert hydrofdi.simulate({"name": "open", "record": FAST["record"]}).saturation == []


def test_simulate_prints_the_saturation(tmp_path: Path) -> None:
    settings = ["control.law=p", "control.proportional_gain=2000 V/m", "control.voltage_limit=1 V"]
    options = [part for each in (*settings, "record.duration=4 s") for part in ("--set", each)]
    assert "warning: the controller is at control.voltage_limit" in run("simulate", *options).stderr


def test_a_balance_of_pressures_without_a_spring_says_that_it_needs_one() -> None:
    for given in ("0 N/m", 0):
        with pytest.raises(ConfigError, match="needs a spring load"):
            make_indicators({"one": {"kind": "pressure_balance", "load_stiffness": given}})
    make_indicators({"one": {"kind": "pressure_balance", "load_stiffness": "10 kN/m"}})


@pytest.mark.parametrize(
    ("more", "is_told"),
    [
        ({"indicators": {"flow_balance": {"spool": "command"}}}, True),
        ({"indicators": {"flow_balance": {"spool": "command", "supply": "sum"}}}, False),
        ({"indicators": {"flow_balance": {}}, "supply_sensor": {"noise": "5 kPa"}}, False),
        ({"indicators": {"dwt": {}}}, False),
    ],
)
def test_a_study_says_that_it_reads_a_supply_pressure_that_no_sensor_measures(more, is_told) -> None:
    sentences = said(STUDY_RULES, load_experiment({"name": "press", "study": STUDY, **more}), None)
    assert any("no supply_sensor is set" in each for each in sentences) == is_told


def test_a_new_file_has_the_lines_that_others_look_for(tmp_path: Path) -> None:
    run("init", "press", cwd=tmp_path, check=0)
    text = (tmp_path / "press.yaml").read_text()
    for key in ("voltage_limit: ", "proportional_gain: ", "# end_stop_position: ", "# pressure_balance:"):
        assert key in text


def test_the_commented_balance_works_as_it_stands(tmp_path: Path) -> None:
    run("init", "press", cwd=tmp_path, check=0)
    text = (tmp_path / "press.yaml").read_text()
    head, _, tail = text.partition("  # pressure_balance:")
    block, _, rest = tail.partition("\n\n")
    lines = ("  # pressure_balance:" + block).splitlines()
    shown = "\n".join(line.replace("  # ", "  ", 1) for line in lines)
    (tmp_path / "press.yaml").write_text(f"{head}{shown}\n\n{rest}")
    assert "pressure_balance" in load_experiment(tmp_path / "press.yaml").indicators
