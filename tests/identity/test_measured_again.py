"""Stored signals measured again: what needs no simulation, and that the bits are those of one."""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.folders import verify, why
from hydrofdi.api.plan import plan_sweep
from hydrofdi.api.records.sources import open_source
from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.execution import InProcessEngine
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.indicators.record_measures import measure_sources
from hydrofdi.indicators.selection import TAKEN
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.store.index import read_index
from hydrofdi.store.layout import names
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

NOISY = """\
name: noisy
record: {duration: 4 s}
input: {period: 1 s}
pressure_1_sensor: {noise: 1 kPa}
store: {signals: STORED}
sweep:
  grid:
    leakage.internal_flow: [0.5 L/min]
    fluid.bulk_modulus: [551 MPa, 827 MPa]
"""
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


def assert_same_bits(one, other):
    assert one.keys() == other.keys()
    for name, values in one.items():
        is_float = values.dtype.kind == "f"
        assert np.array_equal(values, other[name], equal_nan=is_float), name


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A folder with the records of the default analysis."""
    folder = tmp_path_factory.mktemp("first")
    swept(noisy(folder), folder / "noisy")
    return folder


def copied(first, tmp_path):
    shutil.copytree(first / "noisy", tmp_path / "noisy")
    return tmp_path / "noisy"


def test_another_analysis_simulates_nothing_and_gives_the_bits_of_a_simulation(first, tmp_path):
    directory = copied(first, tmp_path)
    other = noisy(tmp_path, "all", *OTHER)
    plan = plan_sweep(other, directory)
    assert (len(plan.missing), plan.n_simulated, len(plan.measurable)) == (4, 0, 4)
    assert plan.reasons() == {"another analysis of a stored record, measured from its stored signals": 4}
    summary = swept(other, directory)
    assert (summary.completed, summary.measured, summary.failed) == (4, 4, 0)
    swept(other, tmp_path / "anew")
    assert_same_bits(contents(directory / "noisy.h5"), contents(tmp_path / "anew" / "noisy.h5"))
    assert verify(directory)


def test_what_was_measured_before_is_stored_still(first, tmp_path):
    directory = copied(first, tmp_path)
    swept(noisy(tmp_path, "all", *OTHER), directory)
    back = swept(noisy(tmp_path), directory)
    assert (back.completed, back.skipped) == (0, 4)
    assert_same_bits(contents(directory / "noisy.h5"), contents(first / "noisy" / "noisy.h5"))


def test_why_tells_what_is_not_stored(first, tmp_path):
    directory = copied(first, tmp_path)
    (directory / "experiment.json").write_text(noisy(tmp_path, "all", *OTHER).model_dump_json())
    again = why(directory, "0")
    assert again.reason == "another analysis of a stored record, measured from its stored signals"
    assert again.record_id != again.run_id
    other_plant = noisy(tmp_path, "all", "friction.viscous=60")
    (directory / "experiment.json").write_text(other_plant.model_dump_json())
    assert why(directory, "0").reason == "new"


@pytest.mark.parametrize(
    ("signals", "settings", "reason"),
    [
        ("none", [], "no stored signals of chamber_1_pressure"),
        (
            "pressures",
            ["indicators={dwt: {}, speed: {kind: dwt, channel: piston_velocity}}"],
            "no stored signals of piston_velocity",
        ),
        ("pressures, dtype: float32", [], "stored signals in single precision"),
    ],
)
def test_where_signals_are_not_stored_the_plan_says_why_it_simulates(tmp_path, signals, settings, reason):
    swept(noisy(tmp_path, signals), tmp_path / "noisy")
    other = noisy(tmp_path, signals, "wavelet.levels=4", *settings)
    plan = plan_sweep(other, tmp_path / "noisy")
    assert plan.n_simulated == 4
    ((because, count),) = plan.reasons().items()
    assert count == 4
    assert reason in because
    assert swept(other, tmp_path / "noisy").measured == 0


def test_runs_that_differ_in_their_analysis_share_their_records(tmp_path):
    analyses = ("sweep.grid.wavelet.levels=[3, 4]", "sweep.grid.analysis.discard=[0 s, 1 s]")
    experiment = noisy(tmp_path, "none", *analyses)
    plan = plan_sweep(experiment, tmp_path / "noisy")
    assert len(plan.missing) == 4 * plan.n_simulated == 16
    swept(experiment, tmp_path / "noisy")
    index = read_index(tmp_path / "noisy")
    assert (len(index.runs), len(index.records)) == (16, 4)


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


def test_workers_measure_stored_signals_as_well(first, tmp_path, hydrofdi):
    copied(first, tmp_path)
    config = tmp_path / "noisy.yaml"
    config.write_text(NOISY.replace("STORED", "all"))
    result = hydrofdi(
        "sweep", config, "--out", "noisy", "--set", "wavelet.levels=3", "--workers", "2", "--json"
    )
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["measured"] == 4


SEVERAL = """\
name: several
record: {duration: 2 s}
indicators:
  dwt: {levels: 3}
  second: {kind: dwt, levels: 4, channel: chamber_2_pressure, phase: all}
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("several"), SEVERAL)


def test_every_output_is_a_labelled_variable(several):
    with xarray.open_dataset(several.file, engine="h5netcdf") as runs:
        assert runs["second.d4"].dims == ("run",)
        assert runs["second.d2_phases"].dims == ("run", "second.phase")
        assert runs["second.d2_phases"].attrs["units"] == "Pa"
        assert "details of level 2" in runs["second.d2_phases"].attrs["long_name"]
        assert runs["second.analysis_id"].attrs["indicator"] == "dwt"
        assert runs["second.analysis_id"].attrs["version"] == 1
        assert '"levels":4' in runs["second.analysis_id"].attrs["options"]


def test_outputs_are_what_the_indicators_measure_of_the_stored_signals(several):
    with h5py.File(several.file) as file:
        channels = {
            channel: file[channel.value][:]
            for channel in (Channel("chamber_1_pressure"), Channel("chamber_2_pressure"))
        }
        batch = RecordBatch(channels, 500.0, tuple(file["run_id"].asstr()[:]))
        options = {
            "dwt": {"levels": 3},
            "second": {"kind": "dwt", "levels": 4, "channel": "chamber_2_pressure", "phase": "all"},
        }
        for name, values in measure(batch, make_indicators(options)).values.items():
            np.testing.assert_array_equal(file[name], values)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("indicators: [dvt]\n", r":1: indicators.dvt: there is no indicator 'dvt'; did you mean 'dwt'"),
        ("indicators:\n  dwt: {}\n  m: {kind: modwt, levls: 3}\n", r":3: indicators.m.levls: unknown key"),
        ("indicators:\n  dwt: {levels: 99}\n", r":2: indicators.dwt.levels: must be at most 20"),
        ("indicators:\n  dwt: {level: 3}\n", r":2: indicators.dwt.level: unknown key"),
        ("wavelet: {levels: 3}\nindicators:\n  dwt: {levels: 4}\n", r":3: .*says 3; give it once"),
        ("indicators:\n  dwt: {channel: chamber_2_pressure}\n", r":2: indicators.dwt.channel: the label"),
    ],
)  # fmt: skip
def test_a_mistake_has_its_line(tmp_path, text, expected):
    file = tmp_path / "file.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=expected):
        load_experiment(file)


def test_the_options_of_dwt_are_those_of_the_wavelet(tmp_path):
    short, long = tmp_path / "short.yaml", tmp_path / "long.yaml"
    short.write_text("wavelet: {levels: 3, name: db4}\n")
    long.write_text("indicators: {dwt: {levels: 3, name: db4}}\n")
    assert load_experiment(short) == load_experiment(long)


def loaded(folder: Path, indicators: str) -> ExperimentConfig:
    file = folder / "file.yaml"
    file.write_text(f"name: chosen\nindicators: {indicators}\n")
    return load_experiment(file)


@pytest.mark.parametrize(
    "text",
    [
        "true", "3", "null", "[]", "{}", '"*"', "'dwt,,modwt'", "[dwt, {modwt: {levels: 3}}]", "[dwt, 3]",
        "[dwt, dwt]", "[dwt, all]", "{rod: {}}", "{dwt: 3}",
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path: Path, text: str) -> None:
    with pytest.raises(ConfigError) as error:
        loaded(tmp_path, text)
    (line,) = str(error.value).splitlines()
    assert line.startswith(f"{tmp_path}/file.yaml:2: indicators")


@pytest.mark.parametrize(
    "label",
    ["a.b/c d", "../x", "", "dwt.d1", "<b>", "run", "phase", "3", "-a", "ä", "a\n", "x" * 65],
)
def test_a_label_that_a_file_cannot_hold_is_a_mistake(label: str) -> None:
    with pytest.raises(ConfigError) as error:
        make_indicators({label: {"kind": "dwt"}})
    assert len(error.value.mistakes) == 1
    make_indicators({"fine-Label_2": {"kind": "dwt"}})


def test_no_label_is_the_name_of_a_variable_of_a_file() -> None:
    variables = (
        *names.REQUESTED,
        names.REPLICATED,
        *names.BY_LEVEL,
        *names.stored_variables("all", phases=True),
    )
    dimensions = {names.RUN, names.TIME, names.LEVEL, names.PHASE}
    assert {variable.name for variable in variables} | dimensions == TAKEN


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
