"""``hydrofdi inspect`` and ``hydrofdi indicators``, and what commands say of an experiment."""

import matplotlib.image
import numpy as np
import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import RULES, idle_parameters, study_mistakes, unusual_values
from hydrofdi.config.request import parameter_names
from tests.commands import run, run_json


def test_rejected_records_are_counted_with_their_reason(one_failed, tmp_path):
    found = run_json("inspect", one_failed.directory, check=1)
    assert (found["records"], found["rejected"]) == (2, 1)
    diverged = found["findings"]["diverged"]
    (example,) = diverged["examples"]
    assert (diverged["rejects"], diverged["records"]) == (True, 1)
    assert "grew without bound" in example["text"]
    assert "diverged (rejected)" in run("inspect", one_failed.directory, check=1).stdout
    run("inspect", one_failed.directory, "--record", example["record_id"], check=2)
    for sources in ((one_failed.directory,), (one_failed.file, one_failed.config)):
        refused = run("inspect", *sources, "--write", tmp_path / "new.yaml", check=2).stderr
        assert refused.startswith("hydrofdi: write: ")


def test_a_description_is_written_from_the_headers(tmp_path):
    rows = "".join(f"{k / 500},{50 + k % 7},{k % 11}\n" for k in range(600))
    (tmp_path / "rig.csv").write_text(f"Logger: a\nof 2026\ntime [s],P1 [bar],Weg [mm]\n{rows}")
    mine = tmp_path / "sub" / "mine.yaml"
    mine.parent.mkdir()
    found = run_json("inspect", tmp_path / "rig.csv", "--write", mine)
    assert found["channels"].keys() == {"chamber_1_pressure", "piston_position"}
    assert run_json("inspect", mine) == found
    assert "other columns" not in mine.read_text()
    for source, file in ((tmp_path / "rig.csv", mine), (mine, tmp_path / "other.yaml")):
        run("inspect", source, "--write", file, check=2)
    (tmp_path / "foreign.csv").write_text("Zeit;DA;DB\n" + rows.replace(",", ";").replace(".", ","))
    foreign = tmp_path / "foreign.yaml"
    assert str(foreign) in run("inspect", tmp_path / "foreign.csv", "--write", foreign, check=2).stderr
    assert "other columns" in foreign.read_text()


def test_defects_of_a_plain_file_are_named_and_a_record_is_drawn_by_name(tmp_path):
    pressure = np.clip(50 + 20 * np.random.default_rng(1).normal(size=600), 40, 1000)
    lines = [f"{value:.6g},2.5" for value in pressure.tolist()]
    (tmp_path / "rig.csv").write_text("p1 [bar],u [V]\n" + "\n".join(lines) + "\n")
    (tmp_path / "two.csv").write_text("p1 [bar],u [V],x [mm]\n1,,1\n,2,2\n3,4,4\n5,5,3\n2,1,5\n")
    look = ("inspect", tmp_path / "rig.csv", tmp_path / "two.csv", "--sampling-frequency", "200 Hz")
    found = run_json(*look)
    assert (found["records"], found["findings"].keys()) == (2, {"clipped", "stuck", "missing"})
    assert "input_voltage" in found["findings"]["stuck"]["examples"][0]["text"]
    (example,) = found["findings"]["missing"]["examples"]
    assert all(name in example["text"] for name in ("chamber_1_pressure", "input_voltage"))
    channel = found["channels"]["chamber_1_pressure"]
    assert (channel["min"], channel["records"]) == (pytest.approx(1e5), 2)
    for number, chosen in enumerate(((), ("--record", "two"))):
        run(*look, *chosen, "--figure", tmp_path / f"{number}.png", check=0)
    first, second = (matplotlib.image.imread(tmp_path / f"{number}.png")[..., :3] for number in (0, 1))
    assert (second.min(axis=2) < 0.5).mean() > 0.005
    assert first.shape != second.shape or (first != second).any()


STRANGE = [
    ["fluid.bulk_modulus=551"], ["baseline.fluid.bulk_modulus=551"],
    ["ensemble.grid.fluid.bulk_modulus=[551, 551 MPa]"], ["sweep.zip.fluid.bulk_modulus=[551, 689]"],
    ["sweep.union=[{grid: {fluid.bulk_modulus: [551]}}]"],
    ["sweep.sample.over.fluid.bulk_modulus={uniform: [551, 1e9]}", "sweep.sample.count=2"],
    ["input.amplitude=-2000"], ["friction.breakaway=150"], ["fluid.bulk_modulus=12.000 bar"],
    ["valve.damping_ratio=0.001"], ["valve.lap=-1e-12"], ["fluid.free_air=5"],
    ["pressure_1_sensor.noise=0.02"], ["position_sensor.bias=-20"],
    ["sweep.grid.voltage_sensor.highest=[10 V, 1 MV]"],
    ["velocity_sensor={order: first, bandwidth: 10 MHz}"],
]  # fmt: skip
USUAL = [
    ["sweep.sample.over.fluid.bulk_modulus={normal: [551e6, 1e7]}", "sweep.sample.count=2"],
    ["leakage.internal_flow=0"], ["input.amplitude=-2"], ["analysis.discard=1 period"],
    ["sweep.zip.friction.coulomb=[100, 300]", "sweep.zip.friction.breakaway=[100, 300]"],
]  # fmt: skip


def test_every_stated_value_counts_if_it_is_unusual():
    for settings in STRANGE:
        (sentence,) = unusual_values(load_experiment(settings=settings), with_sweep=True)
        assert sentence.partition(" = ")[0].rpartition(".")[2] in settings[0]
    for settings in USUAL:
        assert not unusual_values(load_experiment(settings=settings), with_sweep=True)


STIFFNESS = "friction.bristle_stiffness"


@pytest.mark.parametrize(
    ("settings", "names"),
    [
        ([f"{STIFFNESS}=1e6", "friction.law=smooth"], [STIFFNESS]),
        ([f"{STIFFNESS}=1e6", "sweep.grid.friction.law=[threshold, lugre]"], []),
        ([f"{STIFFNESS}=1e6", "sweep.union=[{grid: {friction.law: [lugre]}}]"], []),
        (["control.proportional_gain=1"], ["control.proportional_gain"]),
        (["control.integral_gain=1", "control.law=pi"], []),
        (["control.proportional_gain=1", "baseline.control.law=p"], []),
        (["input.amplitude=1", "control.law=p"], ["input.amplitude"]),
        (["load.seed=1", "ensemble.sample={count: 2, over: {load.random_force: {uniform: [0, 10]}}}"], []),
        (["leakage.onset_duration=2", "leakage.onset=step"], ["leakage.onset_duration"]),
        (["pressure_1_sensor.noise_bandwidth=1e3", "sweep.grid.pressure_1_sensor.noise=[0, 1e3]"], []),
        (["supply_sensor={order: first, bandwidth: 100, damping_ratio: 1}"], ["supply_sensor.damping_ratio"]),
    ],
)  # fmt: skip
def test_a_parameter_has_an_effect_in_some_run_or_is_reported(settings, names):
    sentences = idle_parameters(load_experiment(settings=settings))
    assert [sentence.partition(" ")[0] for sentence in sentences] == names
    assert {name for option, _, others in RULES for name in (option, *others)} <= set(parameter_names())


def test_simulate_prints_the_saturation():
    calm = ("control.law=p", "control.proportional_gain=20 V/m", "control.voltage_limit=1 V")
    assert not hydrofdi.simulate(load_experiment(settings=["record.duration=4 s", *calm])).warnings
    settings = (calm[0], "control.proportional_gain=2000 V/m", calm[2], "record.duration=4 s")
    options = [part for each in settings for part in ("--set", each)]
    assert "warning: the controller is at control.voltage_limit" in run("simulate", *options).stderr


@pytest.mark.parametrize(
    ("more", "is_told"),
    [
        ({"indicators": {"flow_balance": {"spool": "command"}}}, True),
        ({"indicators": {"flow_balance": {"spool": "command", "supply": "sum"}}}, False),
        ({"indicators": {"flow_balance": {}}, "supply_sensor": {"noise": "5 kPa"}}, False),
        ({"indicators": {"dwt": {}}}, False),
    ],
)
def test_a_study_says_that_it_reads_a_supply_pressure_that_no_sensor_measures(more, is_told):
    faults = {"leakage.internal_flow": [1e-6], "each": 2, "fit": 0}
    study = {"healthy": {"fit": 4, "test": 4}, "faults": faults}
    sentences = study_mistakes(load_experiment({"name": "press", "study": study, **more}))
    assert any("no supply_sensor is set" in each for each in sentences) == is_told


@pytest.mark.parametrize("command", ["plan", "check", "sweep"])
def test_commands_warn_of_values_parameters_and_sampling_once(hydrofdi, experiment_file, command):
    config = experiment_file(
        "record: {duration: 2 s}\nmeasurement: {anti_alias: 400 Hz}\n"
        "sweep: {zip: {actuator.mass: [12.3, 1230000], fluid.free_air: [0.005, 0.05]}}\n"
    )
    result = hydrofdi(command, config)
    said = [line for line in (result.stdout + result.stderr).splitlines() if line.startswith("warning")]
    assert sum(" fluid.free_air " in line for line in said) == 1
    in_table = sum(line.startswith("actuator.mass ") for line in result.stdout.splitlines())
    assert sum(" actuator.mass " in line for line in said) + in_table == 1
    assert in_table == (command == "check")
    assert any("measurement.anti_alias" in line for line in said) == (command != "sweep")
