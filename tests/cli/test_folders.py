"""What ``why``, ``status`` and ``collect`` say of stored runs, and identities that commands accept."""

import shutil
from pathlib import Path

import h5py
import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import seeds_of, shown_seeds
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.shard import content_digest
from tests.commands import run, run_json
from tests.conftest import sweep_in

_STUDY = {"name": "asked", "record": {"duration": "4 s"}, "store": {"signals": "none"}}
_GRID = {"leakage.internal_coefficient": [0.0, 2e-9]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("why") / "out"
    noisy = {"pressure_1_sensor": {"noise": "5 kPa"}, "measurement": {"seed": 3}}
    hydrofdi.sweep(_STUDY | noisy | {"sweep": {"grid": _GRID}}, out=out, engine="in-process")
    return out


def test_why_lists_what_changed_in_readable_units_for_what_is_to_be_computed_anew(folder):
    same = run("why", folder, "1").stdout
    assert "changed since" not in same
    file = folder.parent / "changed.yaml"
    file.write_text(
        "name: asked\nrecord: {duration: 4 s}\nstore: {signals: none}\nfluid: {bulk_modulus: 689 MPa}\n"
        "pressure_1_sensor: {noise: 5 kPa}\nmeasurement: {seed: 3}\n"
        "sweep: {grid: {leakage.internal_coefficient: [0, 2.0e-9, 3.0e-9]}}\n"
    )
    changes = run_json("why", folder, "1", "--config", file)["changes"]
    assert changes["fluid.bulk_modulus"] == [551e6, 689e6]
    assert changes["sweep.grid: leakage.internal_coefficient"] == [[0.0, 2e-9], [0.0, 2e-9, 3e-9]]
    assert set(changes) - {"baseline: fluid.bulk_modulus"} == {
        "fluid.bulk_modulus",
        "sweep.grid: leakage.internal_coefficient",
    }
    shown = run("why", folder, "1", "--config", file).stdout
    assert "551 MPa" in shown
    assert "689 MPa" in shown


def test_the_seed_of_the_noise_is_in_the_provenance_of_file_why_and_report(folder):
    assert run_json("why", folder, "0")["provenance"]["seeds"] == {"measurement.seed": 3}
    assert "seeds     measurement.seed 3" in run("why", folder, "0").stdout
    assert "measurement.seed 3" in run("report", folder, "--format", "markdown").stdout


def test_seeds_are_listed_where_they_have_an_effect_and_nowhere_else():
    assert seeds_of(load_experiment()) == {}
    settings = [
        "input={shape: steps, seed: 5}",
        "load.random_force=1 kN",
        "pressure_1_sensor.noise=5 kPa",
        "replicates={count: 2, seed: 8}",
        "sweep.union=[{grid: {load.seed: [1, 2, 3]}},"
        " {sample: {count: 4, seed: 7, over: {actuator.mass: {uniform: [10 kg, 12 kg]}}}}]",
    ]
    assert shown_seeds(seeds_of(load_experiment(None, settings))) == (
        "measurement.seed 0 … 2, input.seed 5, load.seed 1 … 3, sweep.union[2].sample.seed 7,"
        " replicates.seed 8"
    )


_KEPT = Path(__file__).parent.parent / "museum" / "format_4_physics_3" / "kept"


def test_status_says_that_an_earlier_version_stored_the_runs(tmp_path):
    folder = tmp_path / "kept"
    shutil.copytree(_KEPT, folder)
    (shard,) = (folder / "shards").iterdir()
    with h5py.File(shard, "a") as file:
        file.attrs["physics_version"] = PHYSICS_VERSION - 1
    shard.rename(shard.with_stem(content_digest(shard)))
    assert run_json("status", folder)["earlier"] == 8


def test_collect_says_what_it_built(tmp_path):
    swept = sweep_in(tmp_path, "name: built\nrecord: {duration: 2 s}\n")
    file = swept.directory / "built.h5"
    file.unlink()
    collected = run_json("collect", swept.directory)
    assert collected == {"file": str(file), "planned": 1, "missing": 0, "failed": 0}
    assert file.exists()
