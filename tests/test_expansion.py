import json
import os
from pathlib import Path

import pytest

from hydrofdi.config import RunParameters, expand_runs, load_experiment
from hydrofdi.config.request import RunRequest, parameter_names
from hydrofdi.config.run_table.runs import run_identity
from hydrofdi.errors import ConfigError
from hydrofdi.physics import PHYSICS_VERSION

LEAKAGE = "sweep.grid.leakage.internal_flow=[0 L/min, 0.12 L/min]"
EBM = "sweep.grid.fluid.bulk_modulus=[551 MPa, 689 MPa]"


def table_of(*settings):
    return expand_runs(load_experiment(None, settings))


def test_a_grid_is_all_combinations_with_the_last_axis_varying_fastest():
    table = table_of(LEAKAGE, EBM)
    points = [(run.parameters.leakage.internal_flow, run.parameters.fluid.bulk_modulus) for run in table.runs]
    assert points == [(None, 551e6), (None, 689e6), (2e-6, 551e6), (2e-6, 689e6)]
    assert table.n_swept == 4


def test_baselines_that_the_sweep_holds_are_not_added():
    table = table_of(LEAKAGE, EBM)
    assert table.fixed_baseline.tolist() == [0, 0, 0, 0]
    assert table.matched_baseline.tolist() == [0, 1, 0, 1]


def test_baselines_that_the_sweep_lacks_are_added_after_it():
    table = table_of(
        "sweep.grid.leakage.internal_coefficient=[1e-8]", "sweep.grid.fluid.bulk_modulus=[689 MPa]"
    )
    assert table.n_swept == 1
    fixed = table.runs[table.fixed_baseline[0]].parameters
    matched = table.runs[table.matched_baseline[0]].parameters
    assert (fixed.fluid.bulk_modulus, fixed.leakage.internal_coefficient) == (551e6, 0.0)
    assert (matched.fluid.bulk_modulus, matched.leakage.internal_coefficient) == (689e6, 0.0)
    assert len(table.runs) == 3


def test_a_leakage_flow_is_solved_at_the_baselines_bulk_modulus():
    for run in table_of(LEAKAGE, EBM).runs[2:]:
        assert run.calibration.fluid.bulk_modulus == 551e6
        assert run.calibration.leakage.internal_flow == 2e-6


def test_no_leakage_is_one_run_however_it_is_written():
    written = ["leakage.external_coefficient=0", "leakage.internal_flow=0", "leakage.internal_coefficient=0"]
    assert len({run_identity(table_of(setting).runs[0]) for setting in written}) == 1


def test_the_identity_follows_the_request_and_not_its_spelling():
    identities = {
        run_identity(table_of(*settings).runs[0])
        for settings in [["fluid.bulk_modulus=689 MPa"], ["fluid.bulk_modulus=6890 bar", "name=other"],
                         ["fluid.bulk_modulus=689e6", "store.signals=none"]]
    }  # fmt: skip
    assert len(identities) == 1
    assert run_identity(table_of().runs[0]) not in identities


@pytest.mark.parametrize(
    "setting",
    ["actuator.mass=10.3", "friction.viscous=250", "wavelet.extension=periodization", "record.duration=10 s",
     "input.amplitude=1 V", "leakage.external_coefficient=1e-13"],
)  # fmt: skip
def test_every_section_enters_the_identity(setting):
    assert run_identity(table_of(setting).runs[0]) != run_identity(table_of().runs[0])


def test_only_what_differs_from_the_defaults_enters_the_identity():
    assert RunParameters().text() == "{}"
    stated = table_of("actuator.mass=12.3", "fluid.bulk_modulus=551 MPa", "friction.viscous=60").runs[0]
    sealed = '"leakage":{"internal_coefficient":0.0}'
    assert stated.parameters.text() == '{"friction":{"viscous":60.0},' + sealed + "}"


DEFAULTS = Path(__file__).parent / "defaults.json"


def test_defaults_change_with_the_physics_version_alone():
    """Identities leave defaults out: with HYDROFDI_WRITE_GOLDEN=1 the present ones are written down."""
    present = {name: RunRequest().value(name) for name in parameter_names()}
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        known = {"physics_version": PHYSICS_VERSION, "defaults": present}
        DEFAULTS.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    known = json.loads(DEFAULTS.read_text(encoding="utf-8"))
    assert known["physics_version"] == PHYSICS_VERSION, "write the defaults of the new version down"
    changed = {name for name, value in known["defaults"].items() if present.get(name) != value}
    assert not changed, "a default that changes makes stored runs wrong: raise PHYSICS_VERSION"
    assert present.keys() == known["defaults"].keys(), "write the new parameter's default down"


def test_the_baseline_of_the_file_rules():
    table = table_of("baseline.fluid.bulk_modulus=600 MPa", "baseline.friction.viscous=60")
    fixed = table.runs[table.fixed_baseline[0]].parameters
    assert fixed.fluid.bulk_modulus == 600e6
    assert fixed.friction.viscous == 60.0


def test_an_impossible_combination_names_the_point():
    with pytest.raises(ConfigError, match=r"at record.step = 0.3 ms.*not a multiple"):
        table_of("sweep.grid.record.step=[0.1 ms, 0.3 ms]")


@pytest.mark.parametrize("chamber", [1, 2])
def test_a_sealed_piston_keeps_the_external_leakage_of_its_chambers(chamber):
    name = f"leakage.external_coefficient_{chamber}"
    table = table_of(LEAKAGE, f"sweep.grid.{name}=[0, 1e-13]")
    assert [run.parameters.value(name) for run in table.runs] == [0.0, 1e-13, 0.0, 1e-13]
    assert len({run_identity(run) for run in table.runs}) == 4
