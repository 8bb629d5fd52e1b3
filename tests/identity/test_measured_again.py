# ruff: noqa: E501
"""Stored signals measured again: what needs no simulation, and that the bits are those of one."""

import json
import shutil
from collections import Counter

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.sources import open_records
from hydrofdi.config import load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.errors import ConfigError
from hydrofdi.execution.folders import verify, why
from hydrofdi.execution.plan import plan_sweep
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.measuring import measure_sources
from hydrofdi.indicators.registry import TAKEN
from hydrofdi.indicators.selection import of_machine
from hydrofdi.store import names
from hydrofdi.store.results import read_results
from tests.commands import run_json
from tests.conftest import sweep_in

NOISY = """\
name: noisy
record: {duration: 4 s}
input: {period: 1 s}
pressure_1_sensor: {noise: 1 kPa}
store: {signals: STORED}
sweep: {grid: {leakage.internal_flow: [0.5 L/min], fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""
AGAIN = "another analysis of a stored record, measured from its stored signals"
OTHER = [
    "wavelet={name: db4, levels: 4, phase: all}",
    "analysis.discard=1 period",
    "indicators={dwt: {}, coarse: {kind: dwt, levels: 2}}",
]


def noisy(folder, signals="all", *settings):
    config = folder / "noisy.yaml"
    config.write_text(NOISY.replace("STORED", signals))
    return load_experiment(config, settings)


def swept(experiment, directory):
    return run_sweep(experiment, directory, InProcessEngine())


def contents(file):
    with h5py.File(file) as data:
        return {name: data[name][()] for name in data}


def assert_same_bits(file, expected):
    one, other = contents(file), contents(expected)
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def test_another_analysis_simulates_nothing_and_gives_the_bits_of_a_simulation(tmp_path):
    directory, plain, other = tmp_path / "noisy", noisy(tmp_path), noisy(tmp_path, "all", *OTHER)
    first = shutil.copy(swept(plain, directory).file, tmp_path / "first.h5")
    plan = plan_sweep(other, directory)
    assert (len(plan.missing), plan.n_simulated, len(plan.measurable)) == (4, 0, 4)
    assert [*map(plan.reason, plan.missing)] == 4 * [AGAIN]
    for experiment, reason in ((other, AGAIN), (noisy(tmp_path, "all", "friction.viscous=60"), "new")):
        (directory / "experiment.json").write_text(experiment.model_dump_json())
        asked = why(directory, "0")
        assert (asked.reason, asked.record_id == asked.run_id) == (reason, reason == "new")
    (directory / "experiment.json").write_text(plain.model_dump_json())
    summary = swept(other, directory)
    assert (summary.completed, summary.measured, summary.failed) == (4, 4, 0)
    swept(other, tmp_path / "anew")
    assert_same_bits(directory / "noisy.h5", tmp_path / "anew" / "noisy.h5")
    assert verify(directory)
    back = swept(plain, directory)
    assert (back.completed, back.skipped) == (0, 4)
    assert_same_bits(directory / "noisy.h5", first)
    by_workers = ("--out", directory, "--set", "wavelet.levels=3", "--workers", "2")
    assert run_json("sweep", tmp_path / "noisy.yaml", *by_workers)["measured"] == 4
    axes = ("sweep.grid.wavelet.levels=[3, 4]", "sweep.grid.analysis.discard=[0 s, 1 s]")
    plan = plan_sweep(noisy(tmp_path, "none", *axes), tmp_path / "none")
    assert len(plan.missing) == 4 * plan.n_simulated == 16


@pytest.mark.parametrize(("signals", "settings", "reason"), [
    ("none", [], "no stored signals of chamber_1_pressure"),
    ("pressures", ["indicators={dwt: {}, speed: {kind: dwt, channel: piston_velocity}}"], "no stored signals of piston_velocity"),
    ("pressures, dtype: float32", [], "stored signals in single precision"),
])  # fmt: skip
def test_where_signals_are_not_stored_the_plan_says_why_it_simulates(tmp_path, signals, settings, reason):
    swept(noisy(tmp_path, signals), tmp_path / "noisy")
    other = noisy(tmp_path, signals, "wavelet.levels=4", *settings)
    plan = plan_sweep(other, tmp_path / "noisy")
    assert plan.n_simulated == 4
    ((because, count),) = Counter(map(plan.reason, plan.missing)).items()
    assert count == 4
    assert reason in because
    assert swept(other, tmp_path / "noisy").measured == 0


def test_a_record_that_failed_is_not_simulated_again(tmp_path):
    settings = ("sweep.grid.fluid.bulk_modulus=[551 MPa, 1e7 MPa]",)
    assert swept(noisy(tmp_path, "pressures", *settings), tmp_path / "noisy").failed > 0
    other = noisy(tmp_path, "pressures", *settings, "wavelet.levels=4")
    assert plan_sweep(other, tmp_path / "noisy").n_simulated == 0
    summary = swept(other, tmp_path / "noisy")
    assert summary.measured == summary.planned
    rows = contents(summary.file)
    failed = rows["status"] != b"ok"
    assert failed.any()
    assert np.isnan(rows["dwt.d1"][failed]).all()
    assert np.isfinite(rows["dwt.d1"][~failed]).all()


@pytest.mark.parametrize(("text", "place"), [
    ("indicators: [dvt]\n", r":1: indicators.dvt: .*'dwt'"),
    ("indicators:\n  dwt: {}\n  m: {kind: modwt, levls: 3}\n", ":3: indicators.m.levls: "),
    ("indicators:\n  dwt: {levels: 99}\n", ":2: indicators.dwt.levels: "),
    ("indicators:\n  dwt: {level: 3}\n", ":2: indicators.dwt.level: "),
    ("wavelet: {levels: 3}\nindicators:\n  dwt: {levels: 4}\n", ":3: "),
    ("indicators:\n  dwt: {channel: chamber_2_pressure}\n", ":2: indicators.dwt.channel: "),
    *((f"indicators: {stated}\n", ":1: indicators") for stated in (
        "3", "null", "{}", "'dwt,,modwt'", "[dwt, {modwt: {levels: 3}}]", "[dwt, dwt]", "[dwt, all]", "{dwt: 3}",
    )),
])  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path, text, place):
    file = tmp_path / "file.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=rf"^\S*file\.yaml{place}") as error:
        load_experiment(file)
    assert "\n" not in str(error.value)


def test_labels_are_what_a_file_can_hold_and_no_names_of_its_variables() -> None:
    for label in ["a.b", "../x", "", "run", "phase", "3", "-a", "ä", "a\n", "x" * 65]:
        with pytest.raises(ConfigError):
            make_indicators({label: {"kind": "dwt"}})
    make_indicators({"fine-Label_2": {"kind": "dwt"}})
    variables = (*names.REQUESTED, *names.BY_LEVEL, *names.stored_variables("all", phases=True))
    dimensions = {names.RUN, names.TIME, names.LEVEL, names.PHASE}
    own = {names.OIL_TEMPERATURE}  # label of its mean in detectors
    assert {variable.name for variable in variables} | dimensions == TAKEN | own


INDICATORS = {
    "dwt": {"levels": 4},
    "second": {"kind": "dwt", "levels": 3, "channel": "chamber_2_pressure", "phase": "all"},
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
sweep: {{grid: {{input.amplitude: [0 V, 2 V], fluid.bulk_modulus: [551 MPa, 1e7 MPa]}}}}
"""


def test_a_sweep_its_shards_and_measuring_its_results_say_the_same_to_the_bit(tmp_path, small_sweep):
    reasons = sweep_in(tmp_path, SWEEP)
    columns = read_results(reasons.file).columns
    sources = open_records(reasons.file)
    _, measured = measure_sources(sources, of_machine(make_indicators(INDICATORS), sources))
    records = {record.record_id: record for record in measured}
    assert sorted(set(columns["status"])) == ["diverged", "ok"]
    obstacles = {
        label: columns[f"{label}.obstacle"] for label in INDICATORS if f"{label}.obstacle" in columns
    }
    for row, record_id in enumerate(columns["record_id"]):
        record = records[record_id]
        assert {label: each[row] for label, each in obstacles.items() if each[row]} == record.reasons
        for name, values in record.values.items():
            np.testing.assert_array_equal(columns[name][row], values, err_msg=name)
    moving, sound = columns["input_amplitude"] > 0.0, columns["status"] == "ok"
    assert set(obstacles["return"][sound]) == {"has no return_pressure"}
    assert set(obstacles["ring_down"][sound & moving]) == {""}
    assert set(obstacles["balance"][sound & moving]) == {""}, "its return pressure is an option"
    with xarray.open_dataset(reasons.file, engine="h5netcdf") as file:
        phases, analysis = file["second.d2_phases"], file["second.analysis_id"].attrs
        assert (phases.dims, phases.attrs["units"]) == (("run", "second.phase"), "Pa")
        assert (analysis["indicator"], analysis["version"]) == ("dwt", 1)
        assert '"levels":3' in analysis["options"]
    short, long = ({"wavelet": {"levels": 4}}, {"indicators": {"dwt": {"levels": 4}}})
    assert load_experiment(short) == load_experiment(long)
    reasons.file.unlink()
    shards = read_results(reasons.directory).columns
    for label, texts in obstacles.items():
        assert texts.tolist() == shards[f"{label}.obstacle"].tolist()
    assert run_json("rerun", reasons.directory, "0")["same_bits"]
    assert not [name for name in contents(small_sweep.file) if name.endswith(".obstacle")]
