"""An FMU in the place of the cylinder: same signals, failures that cost one run, and nothing run unasked."""

import json

import numpy as np
import pytest

import hydrofdi
from hydrofdi.engine import TIME_LIMIT
from hydrofdi.errors import ConfigError, HydrofdiError
from tests.commands import run, run_json
from tests.fmus.building import Recipe, build, needs_compiler
from tests.machines import LOOP

pytestmark = needs_compiler

OUTPUTS = {
    "P1": "cyl.port_a.p", "P2": "cyl.port_b.p", "x": "x", "piston_velocity": "v", "spool_position": "valve.x",
    "supply_pressure": "supply.port.p", "internal_leakage": "q_leak",
}  # fmt: skip
SHORT = {"record": {"duration": "1.2 s"}, "wavelet": {"levels": 4}, "measurement": {"pairing": "common"}}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return build(tmp_path_factory.mktemp("fmu"))


def on(file, **more):
    plant = {"fmu": str(file), "inputs": {"u": "u"}, "outputs": OUTPUTS, "leakage": {"coefficient": "seal.k"}}
    return {"plant": plant | more.pop("plant", {}), **SHORT, **more}


SIGNALS = ("P1", "P2", "x", "piston_velocity", "spool_position", "internal_leakage_flow", "input_voltage")


def assert_same_signals(own, other, tolerance=1e-9):
    for name in SIGNALS:
        size = np.abs(own[name]).max()
        assert other[name] == pytest.approx(own[name], rel=0.0, abs=tolerance * size), name


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"control": {"law": "pid"}},
        {
            "leakage": {"internal_flow": "0.1 L/min"},
            "control": {"law": "pi", "amplitude": "5 mm", "feedback": "measured"},
            "position_sensor": {"noise": "20 µm", "gain_error": 0.01},
        },
        {
            "leakage": {"internal_flow": "0.3 L/min"},
            "pressure_1_sensor": {"order": "first", "bandwidth": "80 Hz", "noise": "20 kPa"},
            "measurement": {"pairing": "common", "jitter": "0.1 ms", "anti_alias": "100 Hz"},
            "input": {"shape": "sine", "period": "0.5 s"},
        },
    ],
    ids=["open", "pid", "measured", "sensed"],
)
def test_signals_and_coefficient_are_those_of_the_own_plant(fmu, more):
    unused = LOOP if "position_sensor" in more else {}
    own, other = hydrofdi.simulate({**SHORT, **more}, **unused), hydrofdi.simulate(on(fmu, **more))
    # the areas of LOOP differ by 1e-12, and flows go with the root of a pressure difference
    assert_same_signals(own, other, 1e-5 if unused else 1e-9)
    name = "internal_leakage_coefficient"
    assert other[name] == pytest.approx(own[name], rel=1e-9)
    assert other.detail_rms == pytest.approx(own.detail_rms, rel=1e-7)


def test_units_of_the_fmu_or_stated_ones_become_si(fmu, tmp_path):
    units = (("cyl.port_a.p", "bar"), ("q_leak", "l/min"), ("x", "mm"), ("v", None), ("oil.beta", "bar"))
    other = build(tmp_path, Recipe(units=units))
    stated = {"outputs": OUTPUTS | {"piston_velocity": "v [m/s]"}, "oil.beta": "689 MPa"}
    assert_same_signals(
        hydrofdi.simulate(on(fmu, plant={"oil": {"beta": 6.89e8}})),
        hydrofdi.simulate(on(other, plant=stated)),
    )


def test_a_model_exchange_is_integrated(fmu, tmp_path):
    exchange = build(tmp_path, Recipe(kinds=("ModelExchange",)))
    asked = {"control": {"law": "pid"}}
    assert_same_signals(hydrofdi.simulate(on(fmu, **asked)), hydrofdi.simulate(on(exchange, **asked)), 5e-3)


ODD = [Recipe(defines=each) for each in (("NO_RESET",), ("FALSE_RESET",), ("ONCE", "NO_RESET"), ("CHATTY",))]


@pytest.mark.parametrize("recipe", [*ODD, Recipe(version=3)])
def test_no_run_remembers_the_one_before(fmu, recipe, tmp_path):
    grid = {"plant.oil.beta": ["551 MPa", "827 MPa", "551.1 MPa"]}
    one, two = (
        hydrofdi.sweep(on(each, name=name), grid=grid, engine="in-process", out=tmp_path / name)
        for each, name in ((fmu, "sound"), (build(tmp_path, recipe), "other"))
    )
    np.testing.assert_array_equal(one.dataset.chamber_1_pressure, two.dataset.chamber_1_pressure)


@pytest.mark.parametrize(
    ("hazard", "status", "told"),
    [
        ("crash", "killed", ""), ("fail", "plant_failed", "the solver of the plant gave up"),
        ("discard", "plant_failed", "too long"), ("nan", "plant_failed", "not finite"),
        ("hang", "timeout", ""),
    ],
)  # fmt: skip
def test_a_run_that_its_fmu_ends_is_a_row_and_the_others_finish(fmu, hazard, status, told, tmp_path):
    varied = {f"plant.hazard.{hazard}": [-1.0, "0.3 s", -1.0], "plant.oil.beta": [551e6, 6e8, 689e6]}
    file, limits = tmp_path / "failing.yaml", {"time_per_job": "12 s"}
    file.write_text(json.dumps(on(fmu, name="failing", sweep={"zip": varied}, limits=limits)))
    run("sweep", file, "--out", tmp_path / "out", "--workers", 2, check=1)
    found = hydrofdi.load(tmp_path / "out")
    assert found.statuses == {"ok": 2, status: 1}
    assert told in found.dataset.message.values[1]


def test_a_leak_of_any_size_is_solved_for_an_fmu_that_gives_little(fmu):
    little = {"outputs": {"P1": "cyl.port_a.p", "internal_leakage": "q_leak"}}
    plain, tiny = hydrofdi.calibrate(on(fmu, plant=little), flows=["0.3 L/min", "3e-9 L/min"])
    assert plain["flow"] == pytest.approx(0.3e-3 / 60.0, rel=1e-9)
    assert tiny["coefficient"] == pytest.approx(1e-8 * plain["coefficient"], rel=0.05)


@pytest.mark.parametrize(
    ("hazard", "status", "limit"), [("crash", "killed", "60 s"), ("hang", "timeout", "1 s")]
)
def test_a_crash_or_a_hang_ends_neither_python_nor_the_command(fmu, hazard, status, limit, tmp_path):
    ending = on(fmu, plant={f"hazard.{hazard}": "0.3 s"}, limits={"time_per_job": limit})
    assert hydrofdi.simulate(ending).status == status
    assert TIME_LIMIT.get() is None
    (tmp_path / "ending.yaml").write_text(json.dumps(ending))
    assert run_json("simulate", tmp_path / "ending.yaml", check=1)["status"] == status


def test_what_is_stored_is_not_computed_again_unless_the_fmu_changes(tmp_path):
    file = build(tmp_path)
    asked = {"name": "kept", "sweep": {"grid": {"plant.oil.beta": ["551 MPa", "689 MPa"]}}}
    for computed in (2, 0, 2):
        found = hydrofdi.sweep(on(file, **asked), engine="in-process", out=tmp_path / "out")
        assert found.summary.completed == computed
        if computed == 0:
            build(tmp_path, Recipe(defines=("CHATTY",)))


@pytest.mark.parametrize(
    ("plant", "key", "nearest"),
    [
        ({"inputs": {"input_voltage": "uu"}}, "plant.inputs", "'u'"),
        ({"inputs": {"input_voltage": "x"}}, "plant.inputs", "no input"),
        ({"outputs": {"P1": "cyl.port_a.q"}}, "plant.outputs", "cyl.port_a.p"),
        ({"outputs": {"P1": "x"}}, "plant.outputs", "Pa"),
        ({"outputs": {"P3": "x"}}, "plant.outputs", "P3"),
        ({"outputs": {"P2": "cyl.port_b.p"}}, "plant", "chamber_1_pressure"),
        ({"leakage": {"coefficient": "q_leak"}}, "plant", "continuous output"),
        ({"oil.bta": "551 MPa"}, "plant.oil.bta", "oil.beta"),
        ({"oil.beta": "551 mm"}, "plant.oil.beta", "mm"),
        ({"load.on": 3.5}, "plant.load.on", "bool"),
        ({"friction.law": 7}, "plant.friction.law", "threshold"),
        ({"fmu": "nowhere.fmu"}, "plant.fmu", "No such file"),
    ],
)
def test_mistakes_are_told_by_their_key_before_a_run(fmu, plant, key, nearest):
    with pytest.raises(ConfigError) as refused:
        hydrofdi.load_experiment(on(fmu, plant=plant))
    (mistake,) = refused.value.mistakes
    assert mistake.where == key
    assert nearest in mistake.message


def test_what_the_plant_does_not_know_cannot_vary(fmu):
    with pytest.raises(ConfigError, match=r"plant\.parameters"):
        hydrofdi.load_experiment(on(fmu, sweep={"grid": {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}}))
    without = {name: each for name, each in OUTPUTS.items() if name != "internal_leakage"}
    with pytest.raises(ConfigError, match="internal_coefficient"):
        hydrofdi.load_experiment(on(fmu, plant={"outputs": without}, leakage={"internal_flow": "0.1 L/min"}))


def test_an_fmu_that_cannot_run_here_is_refused_or_a_failed_row_and_one_that_needs_its_tool_is_tried(
    tmp_path,
):
    with pytest.raises(HydrofdiError, match="win64"):
        hydrofdi.load_experiment(on(build(tmp_path, Recipe(platform="win64"))))
    unlicensed = on(build(tmp_path, Recipe(defines=("NO_LICENCE",))))
    assert hydrofdi.simulate(unlicensed).status == "plant_failed"
    found = hydrofdi.check(on(build(tmp_path, Recipe(attributes=(("needsExecutionTool", "true"),)))))
    assert any("needsExecutionTool" in warning for warning in found.warnings)
    assert [mode["status"] for mode in found.modes] == ["ok"]


def test_results_never_run_the_fmu_that_they_name(fmu, tmp_path):
    file = tmp_path / "asked.yaml"
    file.write_text(json.dumps(on(fmu, name="asked")))
    run("sweep", file, "--out", tmp_path / "out", check=0)
    stored = json.loads((tmp_path / "out" / "experiment.json").read_text())["plant"]["fmu"]
    assert str(fmu) in stored
    (run_id,) = hydrofdi.load(tmp_path / "out").dataset.run_id.values
    run("rerun", tmp_path / "out", run_id, check=2)
    again = run_json("rerun", tmp_path / "out", run_id, "--config", file, check=0)
    assert again["differing"] == []
    # A results folder in which somebody writes the form of an experiment is not believed either.
    record = json.loads((tmp_path / "out" / "experiment.json").read_text())
    record["plant"]["fmu"] = stored.replace(" (sha256:", "#sha256:").removesuffix(")")
    (tmp_path / "out" / "experiment.json").write_text(json.dumps(record))
    run("rerun", tmp_path / "out", run_id, check=2)


def test_a_study_draws_parameters_of_the_fmu_and_one_of_them_is_the_fault(fmu, tmp_path):
    study = {
        "population": {"over": {"plant.oil.beta": {"uniform": "±10 %"}}},
        "healthy": {"fit": 6, "test": 4},
        "faults": {"over": {"plant.friction.viscous": ["500 N*s/m", "5 kN*s/m"]}, "fit": 0, "each": 3},
        "confusions": {"soft": {"plant.load.stiffness": "-50 %"}},
    }
    results = hydrofdi.sweep(on(fmu, name="study", study=study), out=tmp_path / "out", workers=2)
    assert results.statuses == {"ok": 20}
    viscous, beta = (results.dataset[f"plant_{name}"].values for name in ("friction_viscous", "oil_beta"))
    assert sorted(viscous) == [50.0] * 14 + [500.0] * 3 + [5000.0] * 3
    assert len(set(beta)) == 20
    run("report", tmp_path / "out", "--html", tmp_path / "page.html", check=0)
    page = (tmp_path / "page.html").read_text()
    assert "cylinder.fmu" in page
    assert "633 mm²" not in page  # the piston of the built-in plant


def test_records_of_an_fmu_have_the_channels_that_it_gives(fmu):
    found = hydrofdi.inspect(hydrofdi.simulate(on(fmu, plant={"outputs": {"P1": "cyl.port_a.p", "x": "x"}})))
    assert {each.value for each in found.ranges} == {"chamber_1_pressure", "piston_position", "input_voltage"}


def test_the_proposal_of_inspect_runs_as_it_stands(fmu, tmp_path):
    found = run_json("inspect", fmu, "--write", tmp_path / "proposed.yaml")
    beta = next(each for each in found["variables"] if each["name"] == "oil.beta")
    assert (beta["unit"], beta["start"], beta["causality"]) == ("Pa", 551e6, "parameter")
    proposed = hydrofdi.load_experiment(tmp_path / "proposed.yaml")
    assert proposed.sweep.names == ["leakage.internal_flow", "plant.oil.beta"]
    done = hydrofdi.simulate(tmp_path / "proposed.yaml", duration="1.2 s", wavelet={"levels": 4})
    assert done.status == "ok"


def test_numbers_and_units_that_could_mean_two_things_are_refused(tmp_path):
    file = build(tmp_path, Recipe(units=(("oil.beta", "bar"), ("cyl.port_a.p", "bar"))))
    asked = {"fmu": str(file), "outputs": {"P1": "cyl.port_a.p"}, "inputs": {"u": "u"}}
    for key, plant, told in (
        ("plant.outputs", {"outputs": {"P1": "cyl.port_a.p [psi]"}}, "bar"),
        ("plant.oil.beta", {"oil.beta": 5510}, "5510 bar"),
        ("plant", {"u": 3.0}, "set by"),
        ("plant", {"seal.k": 1e-10, "leakage": {"coefficient": "seal.k"}}, "internal_coefficient"),
    ):
        with pytest.raises(ConfigError) as refused:
            hydrofdi.load_experiment({"plant": asked | plant, **SHORT})
        (mistake,) = refused.value.mistakes
        assert (mistake.where, told in mistake.message) == (key, True)
    run = hydrofdi.simulate({"plant": asked | {"oil.beta": "5510 bar"}, **SHORT})
    assert run.u.max() == 2.0


def test_a_drive_in_percent_states_what_one_percent_is(fmu, tmp_path):
    percent = build(tmp_path, Recipe(units=(("u", "%"),)))
    with pytest.raises(ConfigError, match=r"\[0\.1 V\]"):
        hydrofdi.load_experiment(on(percent))
    stated = hydrofdi.simulate(on(percent, plant={"inputs": {"u": "u [0.01 V]"}}))
    assert_same_signals(hydrofdi.simulate(on(fmu)), stated)


def test_what_has_no_effect_or_is_assumed_is_said(fmu):
    little = {"outputs": {"P1": "cyl.port_a.p"}}
    asked = on(fmu, supply={"pressure": "100 bar"}, indicators=["flow_balance"], plant=little)
    warnings = " ".join(hydrofdi.check(asked).warnings)
    assert "supply.pressure" in warnings
    assert "machine of the paper" in warnings


def test_a_damaged_file_is_told_in_one_line(fmu, tmp_path):
    content = bytearray(fmu.read_bytes())
    content[len(content) // 2] ^= 255
    (tmp_path / "damaged.fmu").write_bytes(content)
    with pytest.raises(ConfigError, match="damaged"):
        hydrofdi.inspect(tmp_path / "damaged.fmu")
