"""Plans and reports show parameters in the units that the experiment is written in."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

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


def test_programs_read_the_same_columns_whatever_the_unit(press):
    rows = json.loads(run("report", press.directory, "--json", cwd=press.folder).stdout)["rows"]
    assert {row["bulk_modulus_MPa"] for row in rows} == {800.0, 1200.0}
    assert {row["labels"]["valve.lap"] for row in rows} == {1e-5, 2e-5}
