"""Constants of the actuator come from one place: the plant of the experiment, or the description of files."""

import json

import numpy as np
import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.request import RunRequest, parameter_names, parameter_unit
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import indicator_kind, indicator_names
from hydrofdi.records.data_sheet import PLANT_PARAMETERS, MachineSheet, PlantConstant
from hydrofdi.settings.quantities import field_quantity
from tests.commands import run
from tests.machines import RIG, sections_of
from tests.single_rod import RATE, STROKE, data_sheet, recorded

RATIO = 0.7


def test_every_constant_of_the_plant_is_a_parameter_in_the_same_unit_with_the_same_default():
    kinds = MachineSheet, *(indicator_kind(name).Options for name in indicator_names())
    found = [
        (name, info)
        for kind in kinds
        for name, info in kind.model_fields.items()
        if any(isinstance(mark, PlantConstant) for mark in info.metadata)
    ]
    assert len({name for name, _ in found}) >= 19
    for name, info in found:
        parameter = PLANT_PARAMETERS[name]
        if parameter not in parameter_names():
            assert info.default is None
            continue
        assert field_quantity(info).unit == parameter_unit(parameter)
        assert info.default == RunRequest().value(parameter)


OF_PLANT = {
    "name": "press",
    "actuator": {"piston_area": "766 mm²", "load_stiffness": 0.0},
    "supply": {"pressure": "160 bar", "return_pressure": "5 bar"},
    "sweep": {"grid": {"supply.pressure": ["150 bar", "170 bar"]}},
}


def options_in(experiment, label="flow_balance"):
    return experiment.indicator_choice.made(experiment.wavelet)[label].options


def test_an_indicator_has_the_nominal_constants_of_the_plant_unless_it_states_its_own():
    own = {
        "flow_balance": {"supply": "nominal"}, "weak_rls": {"piston_area": "633 mm²"},
        "two": {"kind": "weak_rls", "piston_area_2": "500 mm²"},
        "end": {"kind": "weak_rls", "position_zero": "retracted", "stroke": "400 mm"},
    }  # fmt: skip
    experiment = load_experiment(OF_PLANT | {"indicators": own})
    balance = options_in(experiment)
    assert (balance.piston_area, balance.supply_pressure, balance.return_pressure) == (766e-6, 16e6, 5e5)
    assert options_in(experiment, "weak_rls").piston_area == 633e-6
    told = [each for each in hydrofdi.plan(experiment).warnings if "another machine" in each]
    assert [each.partition(":")[0] for each in told] == ["weak_rls", "two", "end"]
    assert told[1].endswith("piston_area_2 500 mm², but actuator.piston_area_2 not stated")
    single_rod = OF_PLANT["actuator"] | {"piston_area_2": "500 mm²", "stroke": "400 mm"}
    plant = OF_PLANT | {"actuator": single_rod, "indicators": {"flow_balance": {}}}
    rig = {name: section | plant.get(name, {}) for name, section in sections_of(RIG).items()}
    same = load_experiment(plant | rig)
    assert options_in(same).areas == (766e-6, 500e-6)
    assert not any("another machine" in each for each in hydrofdi.plan(same).warnings)


def test_the_identity_of_an_analysis_has_the_constants_of_the_plant():
    def identity(**sections):
        experiment = load_experiment({"name": "one", "indicators": {"flow_balance": {}}, **sections})
        return experiment.indicator_choice.identity

    assert identity() == identity(actuator={"piston_area": "633 mm²"}, friction={"viscous": "90 N·s/m"})
    assert identity() != identity(actuator={"piston_area": "634 mm²"})
    with pytest.raises(ConfigError, match="ekf_joint"):
        load_experiment({"actuator": {"mass": 2e6}, "indicators": {"ekf_joint": {}}})


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """Records of a single-rod cylinder with position zero at the retracted end, and their description."""
    monkeypatch.chdir(tmp_path)
    for name, leakage in (("healthy", 0.0), ("leaking", 0.5)):
        of = recorded(RATIO, leakage)
        columns = [*of.values(), np.full(of["piston_position"].size, 21e6)]
        columns[2] = columns[2] + STROKE / 2.0
        header = "P1 [Pa],P2 [Pa],x [m],xv [m],Ps [Pa]"
        np.savetxt(f"{name}.csv", np.column_stack(columns), "%.9g", ",", header=header, comments="")
        describe(name, name)
    return tmp_path


def describe(file, of, **more):
    sheet = data_sheet(RATIO) | {"position_zero": "retracted", "stroke": "400 mm"} | more
    label = {"label": of, "healthy": ["healthy"]}
    described = {"files": f"{of}.csv", "sampling_frequency": RATE, **label, "actuator": sheet}
    with open(f"{file}.yaml", "w") as out:
        json.dump(described, out)


@pytest.mark.parametrize("indicator", ["flow_balance", "weak_rls"])
def test_measured_records_are_judged_with_the_data_sheet_of_their_description(machine, indicator):
    table = hydrofdi.measure(["healthy.yaml", "leaking.yaml"], indicator)
    leak, error = (60e3 * table[f"{indicator}.{name}"] for name in ("leakage", "leakage_error"))
    np.testing.assert_array_less(abs(leak - [0.0, 0.5]), 3.0 * error)
    assert list(table["status"]) == ["ok", "ok"]
    assert not any("not given" in remark and "piston_area" in remark for remark in table.remarks)
    own = hydrofdi.measure("leaking.yaml", {indicator: {"piston_area": "30 cm²"}})
    assert own["status"][0] == "doubtful"
    judged = hydrofdi.evaluate(["healthy.yaml", "leaking.yaml"], indicator)
    assert not any("piston_area" in remark for remark in judged.remarks)


def test_samples_beyond_the_stroke_or_the_supply_of_the_description_are_remarked(machine):
    for key, value in (("position_zero", "extended"), ("supply_pressure", "120 bar"), ("stroke", "200 mm")):
        describe("wrong", "leaking", **{key: value})
        remarks = hydrofdi.inspect("wrong.yaml").remarked
        channel = key if key == "supply_pressure" else "piston_position"
        assert channel in remarks["out_of_range"].examples[0][1]
    assert "out_of_range" not in hydrofdi.inspect("leaking.yaml").remarks


def test_records_of_two_machines_are_not_measured_together(machine):
    describe("other", "leaking", piston_area="30 cm²")
    with pytest.raises(ConfigError, match="flow_balance"):
        hydrofdi.measure(["healthy.yaml", "other.yaml"], "flow_balance")
    assert len(hydrofdi.measure(["healthy.yaml", "other.yaml"], "pressure_statistics")) == 2


def test_a_detector_keeps_the_data_sheet_and_refuses_records_of_another_machine(machine):
    train = ("--output", "leakage", "--window", "2 s", "--false-alarm-rate", "20 %", "--out", "d.json")
    run("train", "healthy.yaml", "--indicator", "flow_balance", *train, check=0)
    options = json.loads((machine / "d.json").read_text())["config"]["options"]
    assert options["piston_area_2"] == data_sheet(RATIO)["piston_area_2"]
    assert options["position_zero"] == "retracted"
    assert all(hydrofdi.detect("d.json", "leaking.yaml")["alarm"])
    describe("other", "leaking", piston_area_2="14 cm²")
    for command in (("detect", "d.json", "other.yaml"), ("monitor", "d.json", "leaking.csv", "--config")):
        refused = run(*command, *(["other.yaml"] if command[0] == "monitor" else []), check=2).stderr
        assert "piston_area_2 = 1400 mm²" in refused
    # of what the options of the detector state themselves, only a change is another machine
    own = hydrofdi.train(
        "healthy.yaml", {"flow_balance": {"piston_area_2": "13 cm²"}}, window="2 s", false_alarm_rate="20 %",
        accept=True,
    )  # fmt: skip
    assert len(own.judge("leaking.yaml")) == 10
    with pytest.raises(ConfigError, match="piston_area_2"):
        own.judge("other.yaml")
