"""A plan says that an indicator assumes another machine than the experiment simulates."""

import pytest

import hydrofdi
from hydrofdi.api.warnings import other_machines
from hydrofdi.config import load_experiment
from hydrofdi.settings.ready import ready_names

ANOTHER = "the options describe another machine: "
BASE = """\
name: base
actuator: {piston_area: &area 2099 mm²}
indicators:
  flow_balance: {piston_area: *area, supply: nominal, supply_pressure: 160 bar}
supply: {pressure: 160 bar}
"""


def warnings(folder, text):
    (folder / "base.yaml").write_text(BASE)
    (folder / "child.yaml").write_text("extends: base.yaml\nname: child\n" + text)
    return [each for each in hydrofdi.plan(folder / "child.yaml").warnings if ANOTHER in each]


def test_an_alias_that_keeps_the_value_of_the_extended_file_is_found(tmp_path):
    (warning,) = warnings(tmp_path, "actuator: {piston_area: 1800 mm²}\nsupply: {pressure: 210 bar}\n")
    assert warning.startswith("flow_balance: ")
    assert "piston_area 2099 mm², but actuator.piston_area 1800 mm²" in warning
    assert "supply_pressure 160 bar, but supply.pressure 210 bar" in warning


@pytest.mark.parametrize(
    "text",
    [
        "",
        "actuator: {piston_area: 1800 mm²}\nindicators: {flow_balance: {piston_area: 1800 mm²}}\n",
        "supply: {pressure: 210 bar}\nindicators: {flow_balance: {supply: sum}}\n",
    ],
)
def test_the_same_machine_or_an_unused_constant_needs_no_warning(tmp_path, text):
    assert not warnings(tmp_path, text)


@pytest.mark.parametrize("name", [name for name in ready_names() if "/" not in name])
def test_the_ready_experiments_agree_with_their_indicators(name):
    assert not [*other_machines(load_experiment(name), None)]
