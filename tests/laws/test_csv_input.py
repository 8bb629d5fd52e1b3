"""Contents of a file, and the line of the mistake in it."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from hydrofdi.config import RunParameters, expand_runs, load_experiment
from hydrofdi.config.drive import InputConfig, RecordConfig, held_text
from hydrofdi.config.runs import run_identity
from hydrofdi.errors import ConfigError
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.inputs import input_voltage
from tests.conftest import Command

SQUARE = "time [ms], voltage [mV]\n0, 2000\n500, -2000\n1000, 2000\n1500, -2000\n"


def _parameters(text: str, **values: object) -> RunParameters:
    drive = {"input.shape": "csv", "input.file": held_text("drive.csv", text), "record.duration": 2.0}
    return RunParameters().with_values(drive | values)


def _folder(folder: Path, **texts: str) -> Path:
    for name, text in texts.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder


def test_rows_of_a_square_give_the_bits_of_the_square_as_voltages_and_as_positions() -> None:
    square = RunParameters().with_values({"record.duration": 2.0, "input.period": 1.0})
    runs = [_parameters(SQUARE), square, _parameters("0,1\n1,-3\n")]
    together = simulate_batch(runs, [2e-9] * 3)
    np.testing.assert_array_equal(together.input_voltage[0], together.input_voltage[1])
    for pressure, run in zip(together.chamber_1_pressure, [square, *runs[1:]], strict=True):
        np.testing.assert_array_equal(pressure, simulate_batch([run], [2e-9]).chamber_1_pressure[0])
    loop = {"control.law": "p", "control.amplitude": 10e-3}
    positions = SQUARE.replace("voltage [mV]", "position [mm]").replace("2000", "10")
    positions = _parameters(positions, **loop | {"control.amplitude": 1.0})
    ours, theirs = (simulate_batch([run], [2e-9]) for run in (positions, square.with_values(loop)))
    np.testing.assert_array_equal(ours.piston_position, theirs.piston_position)


def test_edge_between_steps_takes_effect_at_the_next_step() -> None:
    drive = InputConfig(shape="csv", file=held_text("x", "-1,0\n0.5,1\n0.60005,2\n0.70001,3\n0.70009,4\n"))
    voltage = input_voltage(drive, RecordConfig(duration=2.0), np.arange(20_000))
    assert (np.flatnonzero(np.diff(voltage)) + 1).tolist() == [5000, 6001, 7001]
    assert voltage[[0, 5000, 6000, 6001, 7000, 7001, -1]].tolist() == [0.0, 1.0, 1.0, 2.0, 2.0, 4.0, 4.0]


def test_identity_depends_on_the_contents_alone_and_a_path_starts_from_the_file_that_names_it(
    tmp_path,
) -> None:
    def identity(name: str) -> str:
        (tmp_path / "base.yaml").write_text(
            f"input: {{shape: csv, file: {name}.csv}}\nrecord: {{duration: 2 s}}"
        )
        (tmp_path / "deep" / "top.yaml").write_text("extends: ../base.yaml\n")
        return run_identity(expand_runs(load_experiment(tmp_path / "deep" / "top.yaml")).runs[0])

    by_hand = "# made by hand\n\ntime;voltage\n0;2\n0.5;-2.0\n1;2\n1.5;-2e0\n"
    (tmp_path / "deep").mkdir()
    _folder(tmp_path, a=SQUARE, b=SQUARE, c=by_hand, other=SQUARE.replace("1500", "1501"))
    assert identity("a") == identity("b") == identity("c") != identity("other")


@pytest.mark.parametrize(
    ("block", "n_run"),
    [
        ("sweep: {zip: {input.shape: [square, csv], input.file: [null, b.csv]}}", 2),
        ("ensemble: {grid: {input.file: [a.csv, b.csv]}}\nsweep: {grid: {actuator.mass: [9 kg, 11 kg]}}", 4),
        ("sweep: {grid: {input.file: [b.csv, same.csv, a.csv]}}", 2),
    ],
)
def test_files_vary_in_every_kind_of_block(tmp_path: Path, block: str, n_run: int) -> None:
    config = _folder(tmp_path, a=SQUARE, b="0,1\n", same="0,1\n") / "experiment.yaml"
    config.write_text(f"record: {{duration: 2 s}}\ninput: {{shape: csv, file: a.csv}}\n{block}\n")
    assert len(expand_runs(load_experiment(config)).runs) == n_run


@pytest.mark.parametrize(
    ("content", "number"),
    [
        (None, None), ("", None), ("time, voltage\n", None), ("0,1\n1,x\n", 2), ("0,nan\n", 1),
        ("t [s],u [V]\n0,1\n2,1\n1,1\n", 4), ("0,1\n0,1\n", 2), ("0.1,1\n", 1), ("0,5;1\n", 1),
        ("t [s],u [A]\n0,1\n", 1), ("t [s],x [mm]\n0,1\n", None), ("\0\1", None), (" " * 20_000_000, None),
    ],
    ids=[
        "missing", "empty", "header alone", "no number", "not a number", "falling", "same time", "late start",
        "decimal comma", "wrong unit", "position", "binary", "huge",
    ],
)  # fmt: skip
def test_mistake_in_a_file_is_one_line_with_its_place(tmp_path, content, number):
    config = (tmp_path if content is None else _folder(tmp_path, drive=content)) / "experiment.yaml"
    config.write_text("input: {shape: csv, file: drive.csv}\n")
    with pytest.raises(ConfigError) as caught:
        load_experiment(config)
    (line,) = str(caught.value).splitlines()
    assert "input.file" in line or "input: " in line
    assert number is None or f"{tmp_path / 'drive.csv'}:{number}: " in line
    assert len(line) < 300


@pytest.mark.parametrize(
    "settings",
    [
        ["input.shape=csv"],
        ["input.file={folder}/drive.csv"],
        ["input.shape=csv", "input.file={folder}"],
        ["input.shape=csv", "input.file={folder}/drive.csv", "control.law=p"],
        ["input.shape=csv", "input.file={folder}/drive.csv", "analysis.discard=1 period"],
    ],
)
def test_file_and_shape_have_to_fit(tmp_path: Path, settings: list[str]) -> None:
    _folder(tmp_path, drive=SQUARE)
    with pytest.raises(ConfigError) as caught:
        load_experiment(settings=[setting.format(folder=tmp_path) for setting in settings])
    assert len(str(caught.value).splitlines()) == 1


def test_results_hold_the_file_and_never_print_its_rows(tmp_path: Path, hydrofdi: Command) -> None:
    rows = "".join(f"{k * 2e-4!r},{(-1) ** (k // 2500) * 1.987654321!r}\n" for k in range(10_000))
    config = _folder(tmp_path, long=rows, short=SQUARE) / "experiment.yaml"
    config.write_text(
        "name: own\nrecord: {duration: 2 s}\ninput: {shape: csv, file: long.csv}\n"
        "sweep: {grid: {input.file: [long.csv, short.csv], leakage.internal_coefficient: [0, 1e-9]}}\n"
    )
    output = [hydrofdi("plan", config, "--json"), hydrofdi("sweep", config, "--engine", "in-process")]
    assert json.loads(output[0].stdout)["axes"]["input.file"][0].startswith("long.csv (10000 rows, ")
    for name in ("long.csv", "short.csv"):
        (tmp_path / name).unlink()
    assert hydrofdi("rerun", "results/own", "0").stdout.endswith("the same bits\n")
    output += [hydrofdi("why", "results/own", "3"), hydrofdi("report", "--html", "page.html")]
    output.append(hydrofdi("report", "--format", "csv"))
    for result in output:
        assert result.returncode == 0, result.stderr
        assert "1.987654321" not in result.stdout + result.stderr
    assert "long.csv (10000 rows, " in output[-1].stdout
    for file in ("page.html", "results/own/provenance.json"):
        assert "1.987654321" not in (tmp_path / file).read_text()
    with h5py.File(tmp_path / "results" / "own" / "own.h5") as stored:
        assert stored["input_file"].asstr()[3].startswith("short.csv (4 rows, ")
        assert np.abs(stored["input_voltage"][0]).max() == 1.987654321
        assert np.abs(stored["input_voltage"][3]).max() == 2.0
