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
from hydrofdi.simulation.inputs import input_voltage, largest_voltage
from tests.conftest import Command

RUN = RecordConfig(duration=2.0)
SQUARE = "time [ms], voltage [mV]\n0, 2000\n500, -2000\n1000, 2000\n1500, -2000\n"


def _voltage(text: str, run: RecordConfig = RUN) -> np.ndarray:
    drive = InputConfig(shape="csv", file=held_text("drive.csv", text))
    return input_voltage(drive, run, np.arange(run.n_step))


def _parameters(text: str, **values: object) -> RunParameters:
    drive = {"input.shape": "csv", "input.file": held_text("drive.csv", text), "record.duration": 2.0}
    return RunParameters().with_values(drive | values)


def _folder(folder: Path, *names: str, text: str = SQUARE) -> Path:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _identity(file: Path) -> str:
    settings = ["input.shape=csv", f"input.file={file}", "record.duration=2 s"]
    return run_identity(expand_runs(load_experiment(settings=settings)).runs[0])


def test_rows_of_a_square_give_the_bits_of_the_square_alone_and_in_a_batch() -> None:
    square = RunParameters().with_values({"record.duration": 2.0, "input.period": 1.0})
    runs = [_parameters(SQUARE), square, _parameters("0,1\n1,-3\n")]
    together = simulate_batch(runs, [2e-9] * 3)
    np.testing.assert_array_equal(together.input_voltage[0], together.input_voltage[1])
    for pressure, run in zip(together.chamber_1_pressure, [square, *runs[1:]], strict=True):
        np.testing.assert_array_equal(pressure, simulate_batch([run], [2e-9]).chamber_1_pressure[0])


def test_edge_between_steps_takes_effect_at_the_next_step() -> None:
    voltage = _voltage("-1,0\n0.5,1\n0.60005,2\n0.70001,3\n0.70009,4\n")
    assert (np.flatnonzero(np.diff(voltage)) + 1).tolist() == [5000, 6001, 7001]
    assert voltage[[0, 5000, 6000, 6001, 7000, 7001, -1]].tolist() == [0.0, 1.0, 1.0, 2.0, 2.0, 4.0, 4.0]


@pytest.mark.parametrize("shape", ["square", "steps", "sine", "csv"])
def test_no_voltage_is_above_the_largest(shape: str) -> None:
    file = held_text("x", "0,0.5\n0.5,-3\n2,50\n") if shape == "csv" else None
    drive = InputConfig.model_validate({"shape": shape, "amplitude": -1.5, "period": 0.5, "file": file})
    largest = largest_voltage(drive, RUN)
    voltage = np.abs(input_voltage(drive, RUN, np.arange(RUN.n_step))).max()
    assert voltage <= largest * (1.0 + 1e-3)
    assert largest == {"csv": 3.0, "steps": voltage}.get(shape, 1.5)


def test_identity_depends_on_the_contents_alone(tmp_path: Path) -> None:
    _folder(tmp_path, "a.csv", "deep/b.csv")
    _folder(tmp_path, "c.csv", text="# made by hand\n\ntime;voltage\n0;2\n0.5;-2.0\n1;2\n1.5;-2e0\n")
    _folder(tmp_path, "other.csv", text=SQUARE.replace("1500", "1501"))
    same = {_identity(tmp_path / name) for name in ("a.csv", "deep/b.csv", "c.csv")}
    assert len(same) == 1
    assert _identity(tmp_path / "other.csv") not in same


def test_files_vary_in_every_kind_of_block(tmp_path: Path) -> None:
    _folder(tmp_path, "a.csv")
    _folder(tmp_path, "b.csv", text="0,1\n")
    _folder(tmp_path, "same.csv", text="0,1\n")
    config = tmp_path / "experiment.yaml"
    nominal = "record: {duration: 2 s}\ninput: {shape: csv, file: a.csv}\n"
    blocks = {
        "sweep: {zip: {input.shape: [square, csv], input.file: [null, b.csv], input.period: [1 s, 1 s]}}": 2,
        "sweep: {union: [{grid: {input.file: [b.csv]}}, {grid: {input.file: [a.csv]}}]}": 2,
        "ensemble: {grid: {input.file: [a.csv, b.csv]}}\nsweep: {grid: {actuator.mass: [10 kg, 11 kg]}}": 4,
        "sweep: {grid: {actuator.mass: [10 kg, 11 kg]}}\nbaseline: {input.file: b.csv}": 4,
        "sweep: {grid: {input.file: [b.csv, same.csv, a.csv]}}": 2,
    }
    for block, n_run in blocks.items():
        config.write_text(nominal + block + "\n")
        assert len(expand_runs(load_experiment(config)).runs) == n_run, block


def test_path_starts_from_the_file_that_names_it(tmp_path: Path) -> None:
    _folder(tmp_path, "base/drive.csv")
    (tmp_path / "base" / "base.yaml").write_text("input: {shape: csv, file: drive.csv}\n")
    (tmp_path / "top.yaml").write_text("extends: base/base.yaml\n")
    experiment = load_experiment(tmp_path / "top.yaml")
    assert experiment.input.file == held_text("drive.csv", SQUARE)


MISTAKES = {
    "missing": (None, None),
    "empty": ("", None),
    "header alone": ("time, voltage\n", None),
    "no number": ("0,1\n1,x\n", 2),
    "not a number": ("0,nan\n", 1),
    "falling": ("t [s],u [V]\n0,1\n2,1\n1,1\n", 4),
    "same time": ("0,1\n0,1\n", 2),
    "late start": ("0.1,1\n", 1),
    "decimal comma": ("0,5;1\n", 1),
    "wrong unit": ("t [s],u [A]\n0,1\n", 1),
    "position": ("t [s],x [mm]\n0,1\n", None),
    "binary": (b"\x00\xff\x00\x01", None),
    "huge": (b" " * 20_000_000, None),
}


@pytest.mark.parametrize(("content", "number"), MISTAKES.values(), ids=MISTAKES)
def test_mistake_in_a_file_is_one_line_with_its_place(tmp_path, content, number):
    file, config = tmp_path / "drive.csv", tmp_path / "experiment.yaml"
    config.write_text("input: {shape: csv, file: drive.csv}\n")
    if content is not None:
        file.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(ConfigError) as caught:
        load_experiment(config)
    (line,) = str(caught.value).splitlines()
    assert "input.file" in line or "input: " in line
    assert number is None or f"{file}:{number}: " in line
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
    _folder(tmp_path, "drive.csv")
    with pytest.raises(ConfigError) as caught:
        load_experiment(settings=[setting.format(folder=tmp_path) for setting in settings])
    assert len(str(caught.value).splitlines()) == 1


def test_results_hold_the_file_and_never_print_its_rows(tmp_path: Path, hydrofdi: Command) -> None:
    rows = "".join(f"{k * 2e-4!r},{(-1) ** (k // 2500) * 1.987654321!r}\n" for k in range(10_000))
    _folder(tmp_path, "long.csv", text=rows)
    _folder(tmp_path, "short.csv")
    config = tmp_path / "experiment.yaml"
    config.write_text(
        "name: own\nrecord: {duration: 2 s}\ninput: {shape: csv, file: long.csv}\n"
        "sweep: {grid: {input.file: [long.csv, short.csv], leakage.internal_coefficient: [0, 1e-9]}}\n"
    )
    output = [hydrofdi("plan", config), hydrofdi("plan", config, "--json")]
    assert json.loads(output[1].stdout)["axes"]["input.file"][0].startswith("long.csv (10000 rows, ")
    swept = hydrofdi("sweep", config, "--engine", "in-process")
    assert swept.returncode == 0, swept.stderr
    output.append(swept)
    for name in ("long.csv", "short.csv"):
        (tmp_path / name).unlink()
    assert hydrofdi("rerun", "results/own", "0").stdout.endswith("the same bits\n")
    output += [hydrofdi("why", "results/own", "3"), hydrofdi("why", "results/own", "3", "--json")]
    output += [hydrofdi("report", "--html", "page.html"), hydrofdi("report", "--format", "csv")]
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


POSITIONS = "time [ms], position [mm]\n0, 10\n500, -10\n1000, 10\n1500, -10\n"
CLOSED = {"control.law": "p", "control.amplitude": 10e-3}


def test_positions_are_the_reference_of_a_controller() -> None:
    square = RunParameters().with_values(CLOSED | {"record.duration": 2.0, "input.period": 1.0})
    ours = simulate_batch([_parameters(POSITIONS, **CLOSED | {"control.amplitude": 1.0})], [2e-9])
    built_in = simulate_batch([square], [2e-9])
    np.testing.assert_array_equal(ours.piston_position, built_in.piston_position)
