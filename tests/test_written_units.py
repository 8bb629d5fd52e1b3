"""Plans and reports show parameters in the units that the experiment is written in."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

import hydrofdi
from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError
from tests.commands import run
from tests.conftest import sweep_in

PRESS = """
name: press
fluid: {bulk_modulus: 12000 bar}
supply: {pressure: 21e6}
record: {duration: 4 s}
baseline: {fluid.bulk_modulus: 12000 bar}
sweep:
  grid:
    fluid.bulk_modulus: [8000 bar, 12000 bar]
    valve.lap: [0.01 mm, 0.02 mm]
    leakage.internal_flow: [0 L/min, 300 cm^3/min]
"""


@pytest.fixture(scope="module")
def press(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    return sweep_in(tmp_path_factory.mktemp("press"), PRESS)


def written(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        (folder / f"{name}.yaml").write_text(text)
    return folder / f"{[*files][-1]}.yaml"


SAMPLED = """
name: own
fluid: {bulk_modulus: 1.2 GPa}
sweep:
  sample: {count: 4, seed: 1, over: {valve.lap: {normal: [0 um, 2 um]}, supply.pressure: {uniform: ±5 bar}}}
"""


def test_values_of_sections_axes_and_distributions_are_remembered_with_their_units(tmp_path):
    assert load_experiment(written(tmp_path, own=SAMPLED)).units == {
        "fluid.bulk_modulus": "GPa",
        "valve.lap": "um",
        "supply.pressure": "bar",
    }
    assert "valve.lap [µm]" in run("plan", "own.yaml", cwd=tmp_path).stdout


def test_the_nearer_file_wins_and_a_setting_wins_over_it(tmp_path):
    file = written(
        tmp_path,
        base="name: base\nfluid: {bulk_modulus: 551 MPa}\nsupply: {pressure: 17 MPa}",
        own="extends: base.yaml\nname: own\nfluid: {bulk_modulus: 5510 bar}",
    )
    assert load_experiment(file).units == {"fluid.bulk_modulus": "bar", "supply.pressure": "MPa"}
    settings = ["fluid.bulk_modulus=80000 psi", "sweep.grid.valve.lap=[0.01 mm, 0.02 mm]"]
    units = load_experiment(file, settings).units
    assert units == {"fluid.bulk_modulus": "psi", "supply.pressure": "MPa", "valve.lap": "mm"}


def test_units_can_be_stated_and_have_to_fit(tmp_path):
    stated = "units: {fluid.bulk_modulus: GPa}\nfluid: {bulk_modulus: 551 MPa}"
    assert load_experiment(written(tmp_path, own=stated)).units == {"fluid.bulk_modulus": "GPa"}
    for wrong, message in (
        ("{fluid.bulk_modulus: L/min}", "must be convertible to Pa"),
        ("{fluid.law: bar}", "fluid.law: is not a parameter with a unit"),
    ):
        with pytest.raises(ConfigError, match=message):
            load_experiment(written(tmp_path, own=f"name: own\nunits: {wrong}"))


def test_the_unit_is_no_part_of_what_a_run_is():
    one, other = (load_experiment({"fluid": {"bulk_modulus": text}}) for text in ("551 MPa", "5510 bar"))
    assert one.units != other.units
    assert expand_runs(one).runs[0].request == expand_runs(other).runs[0].request


def test_plan_and_report_speak_in_the_units_of_the_file(press):
    plan = run("plan", press.config, cwd=press.folder).stdout
    assert "fluid.bulk_modulus [bar]: 2 values from 8000 to 12000" in plan
    assert "valve.lap [mm]: 2 values from 0.01 to 0.02" in plan
    assert "MPa" not in plan
    assert "µm" not in plan
    text = run("report", press.directory, "--full", cwd=press.folder).stdout
    assert "Fixed baseline: sealed, EBM 12000 bar" in text
    assert "valve.lap [mm]" in text
    assert "EBM [MPa]" not in text
    assert "[µm]" not in text


STUDY = """
name: study
record: {duration: 4 s}
supply: {pressure: 160 bar}
store: {signals: none}
study:
  population: {over: {supply.pressure: {uniform: ±5 %}}}
  healthy: {fit: 4, test: 4}
  faults: {leakage.internal_flow: [1 L/min], each: 2}
"""


def test_the_report_of_a_study_has_the_units_of_its_file(tmp_path):
    study = sweep_in(tmp_path, STUDY)
    text = run("report", study.directory, "--full", cwd=tmp_path).stdout
    assert "152 … 168 bar" in text
    assert "MPa" not in text.partition("Configuration")[0].replace("at 8 MPa", "").replace("551 MPa", "")


def test_programs_read_the_same_columns_whatever_the_unit(press):
    rows = json.loads(run("report", press.directory, "--json", cwd=press.folder).stdout)["rows"]
    assert {row["bulk_modulus_MPa"] for row in rows} == {800.0, 1200.0}
    assert {row["labels"]["valve.lap"] for row in rows} == {1e-5, 2e-5}


def test_a_figure_has_the_units_of_the_file(press):
    picture = press.folder / "responses.svg"
    run("report", press.directory, "--figure", picture, cwd=press.folder)
    figure = hydrofdi.load(press.directory).plot("responses")
    labels = {axis.get_xlabel() for axis in figure.axes}
    assert any("bar" in label for label in labels), labels
    assert not any("MPa" in label for label in labels), labels


def test_python_speaks_in_the_units_of_its_arguments():
    run = hydrofdi.simulate(bulk_modulus="0.689 GPa", duration="2 s")
    assert repr(run).startswith("EBM 0.689 GPa, sealed")
    assert hydrofdi.plan({"name": "own", "sweep": {"grid": {"supply.pressure": ["100 bar"]}}}).units == {
        "supply.pressure": "bar"
    }


def test_a_unit_that_reports_would_ignore_is_refused(tmp_path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("name: own\nunits: {leakage.internal_flow: mL/min}\n")
    with pytest.raises(
        ConfigError, match=r"own\.yaml:2: units: leakage\.internal_flow: is always shown in L/min"
    ):
        load_experiment(str(path))
    path.write_text("name: own\nunits: {leakage.internal_flow: l/min}\n")
    assert load_experiment(str(path)).units
