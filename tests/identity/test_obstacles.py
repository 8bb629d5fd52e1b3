"""Where an indicator could not measure a record, the sweep stores why."""

import json
import shutil

import h5py
import numpy as np
import pytest

from hydrofdi.api.records.sources import open_source
from hydrofdi.api.stored import read_results
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.record_measures import measure_sources
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

INDICATORS = {
    "dwt": {"levels": 4},
    "ring_down": {},
    "decay": {"kind": "pressure_decay", "rest": "position"},
    "balance": {"kind": "flow_balance", "spool": "command", "supply": "sum"},
    "return": {"kind": "pressure_statistics", "channel": "return_pressure"},
}
SWEEP = f"""\
name: reasons
record: {{duration: 3 s}}
input: {{period: 1 s}}
supply: {{return_pressure: 1 MPa}}
pressure_1_sensor: {{noise: 1 kPa}}
store: {{signals: all}}
indicators: {json.dumps(INDICATORS)}
sweep:
  grid:
    input.amplitude: [0 V, 2 V]
    fluid.bulk_modulus: [551 MPa, 1e7 MPa]
"""
NO_RETURN = "has no return_pressure"


@pytest.fixture(scope="module")
def reasons(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("reasons"), SWEEP)


def measured(place):
    """What 'hydrofdi measure' says of each record, by its identity."""
    _, records = measure_sources([open_source(place)], make_indicators(INDICATORS))
    return {record.record_id: record for record in records}


def test_a_sweep_and_measuring_its_results_say_the_same_to_the_bit(reasons):
    columns, records = read_results(reasons.file).columns, measured(reasons.file)
    assert sorted(set(columns["status"])) == ["diverged", "ok"]
    for row, record_id in enumerate(columns["record_id"]):
        record = records[record_id]
        stored = {label: columns[f"{label}.obstacle"][row] for label in INDICATORS if has(columns, label)}
        assert {label: reason for label, reason in stored.items() if reason} == record.reasons
        for name, values in record.values.items():
            np.testing.assert_array_equal(columns[name][row], values, err_msg=name)
    moving = columns["input_amplitude"] > 0.0
    sound = columns["status"] == "ok"
    assert set(columns["return.obstacle"][sound]) == {NO_RETURN}
    assert set(columns["ring_down.obstacle"][sound & moving]) == {""}
    assert set(columns["balance.obstacle"][sound & moving]) == {""}, "its return pressure is an option"


def has(columns, label):
    return f"{label}.obstacle" in columns


def test_shards_tell_what_the_file_tells(reasons, tmp_path):
    folder = tmp_path / "reasons"
    shutil.copytree(reasons.directory, folder)
    (folder / reasons.file.name).unlink()
    whole, shards = read_results(reasons.file).columns, read_results(folder).columns
    for name in [name for name in whole if name.endswith(".obstacle")]:
        assert whole[name].tolist() == shards[name].tolist()


def test_a_run_that_could_not_be_measured_is_computed_again_with_its_reason(reasons):
    again = run_hydrofdi("rerun", reasons.directory, "0", cwd=reasons.folder)
    assert "the same bits" in again.stdout, again.stderr


def test_without_an_obstacle_nothing_is_stored(small_sweep):
    with h5py.File(small_sweep.file) as data:
        assert not [name for name in data if name.endswith(".obstacle")]
