"""What exists already: files of other programs stay, and no file of a folder is ignored."""

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import pandas
import pytest
import scipy.io
import typer.main
from rich.console import Console

import hydrofdi
from hydrofdi.api.detectors.training import setting_keys
from hydrofdi.cli.app import application
from hydrofdi.cli.tables import print_table
from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import seeds_of, shown_seeds
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.report.table import Column, Table
from hydrofdi.store.shard import content_digest
from tests.commands import run, run_hydrofdi, run_json
from tests.conftest import sweep_in

SHORT = ("--set", "record.duration=2 s")
LOGGED = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(100))


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder with two single runs."""
    folder = tmp_path_factory.mktemp("runs")
    for level in (1, 2):
        leak = f"leakage.internal_flow=0.{level} L/min"
        run("simulate", *SHORT, "--set", leak, "--out", folder / f"run{level}.h5", check=0)
    return folder


@pytest.mark.parametrize(
    "words",
    [
        ("inspect", "{}"),
        ("measure", "{}"),
        ("report", "{}"),
        ("export", "{}", "--out", "exported"),
        ("train", "{}", "--direction", "rising", "--out", "detector.json"),
    ],
)
def test_a_folder_with_several_runs_is_refused_by_name(runs, tmp_path, words):
    refused = run(*(word.format(runs) for word in words), cwd=tmp_path, check=2)
    (line,) = refused.stderr.splitlines()
    assert "contains 2 files with records" in line
    assert f"name the files, such as {runs / 'run1.h5'}" in line
    assert not list(tmp_path.iterdir())


def test_a_measured_file_beside_a_run_is_not_ignored(runs, tmp_path):
    (tmp_path / "run.h5").write_bytes((runs / "run1.h5").read_bytes())
    assert run_json("inspect", tmp_path)["records"] == 1
    (tmp_path / "rig.csv").write_text(LOGGED)
    assert "contains 2 files with records" in run("inspect", tmp_path, check=2).stderr


def test_the_folder_of_a_sweep_may_contain_other_files(small_sweep, runs, tmp_path):
    folder = tmp_path / "swept"
    run("sweep", small_sweep.config, "--out", folder, check=0)
    before = run_json("measure", folder)["records"]
    (folder / "a.h5").write_bytes((runs / "run1.h5").read_bytes())
    (folder / "rig.csv").write_text(LOGGED)
    assert run_json("measure", folder)["records"] == before


def test_a_run_is_stored_over_an_earlier_run_only(runs, tmp_path):
    own, foreign = tmp_path / "run.h5", tmp_path / "rig.h5"
    own.write_bytes((runs / "run1.h5").read_bytes())
    run("simulate", *SHORT, "--out", own, check=0)
    assert own.read_bytes() != (runs / "run1.h5").read_bytes()
    before = foreign_file(foreign)
    refused = run("simulate", *SHORT, "--out", foreign, check=2).stderr
    assert "is not an experiment file of hydrofdi and was not changed; choose another name" in refused
    with pytest.raises(hydrofdi.HydrofdiError, match="was not changed"):
        hydrofdi.simulate(duration="2 s").save(foreign)
    assert foreign.read_bytes() == before


def test_a_sweep_leaves_a_foreign_file_with_its_name(tmp_path):
    config = tmp_path / "rig.yaml"
    config.write_text("name: rig\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    (tmp_path / "out").mkdir()
    before = foreign_file(tmp_path / "out" / "rig.h5")
    assert "was not changed" in run("sweep", config, "--out", tmp_path / "out", check=2).stderr
    assert (tmp_path / "out" / "rig.h5").read_bytes() == before
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["rig.h5"]


def foreign_file(path):
    """An HDF5 file of another program."""
    with h5py.File(path, "w") as file:
        file["pressure"] = np.arange(5.0)
    return path.read_bytes()


@pytest.mark.parametrize("form", ["csv", "parquet", "mat"])
def test_an_export_replaces_a_file_only_when_asked(runs, tmp_path, form):
    target = tmp_path / f"rig.{form}"
    if form == "csv":
        target.write_text(LOGGED)
    elif form == "parquet":
        pandas.DataFrame({"time [s]": [0.0, 1.0], "mine": [1.0, 2.0]}).to_parquet(target)
    else:
        scipy.io.savemat(target, {"mine": np.ones(3)})
    before = target.read_bytes()
    refused = run("export", runs / "run1.h5", "--out", target, check=2).stderr
    assert f"{target}: already exists and was not changed" in refused
    assert "overwrite" in refused
    assert len(refused.splitlines()) == 1
    assert target.read_bytes() == before
    run("export", runs / "run1.h5", "--out", target, "--overwrite", check=0)
    assert run_json("inspect", target)["records"] == 1


REFUSED = "was not changed; choose another name"
RECORDING = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(2000))


def test_measure_never_replaces_the_recording_that_it_reads(tmp_path):
    (tmp_path / "own.csv").write_text(RECORDING)
    (tmp_path / "own.yaml").write_text("files: own.csv\ntime: {column: 'time [s]'}\n")
    for source in ("own.csv", "own.yaml"):
        assert REFUSED in run("measure", source, "--out", "own.csv", cwd=tmp_path, check=2).stderr
    assert (tmp_path / "own.csv").read_text() == RECORDING


@pytest.mark.parametrize("suffix", ["csv", "json", "parquet"])
def test_measure_replaces_its_own_table_and_no_foreign_file(tmp_path, suffix):
    (tmp_path / "rig.csv").write_text(RECORDING)
    out = tmp_path / f"out.{suffix}"
    measure = ("measure", "rig.csv", "--out", out, "--indicators")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    first = out.read_bytes()
    run(*measure, "pressure_statistics", cwd=tmp_path, check=0)
    assert out.read_bytes() != first
    foreign = first[:12] + b"another file"
    out.write_bytes(foreign)
    assert f"out.{suffix}: already exists" in run(*measure, "dwt", cwd=tmp_path, check=2).stderr
    assert out.read_bytes() == foreign
    out.write_bytes(b"")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    assert out.read_bytes() == first


def test_a_report_replaces_its_own_files_and_no_foreign_one(small_sweep, tmp_path):
    report = ("report", small_sweep.directory, "--out", tmp_path)
    run(*report, check=0)
    run(*report, check=0)
    figure = tmp_path / "sensitivity.png"
    figure.unlink()
    for suffix in ("md", "csv", "json", "html", "parquet"):
        foreign = tmp_path / f"small.{suffix}"
        before = foreign.read_bytes()
        foreign.write_text("# small\n\nNotes on the press.\n")
        assert REFUSED in run(*report, check=2).stderr
        assert foreign.read_text().endswith("press.\n")
        foreign.write_bytes(before)
    assert not figure.exists()


def test_a_page_replaces_an_earlier_page_and_no_foreign_one(small_sweep, tmp_path):
    page = tmp_path / "my.html"
    run("report", small_sweep.directory, "--html", page, check=0)
    run("report", small_sweep.directory, "--html", page, check=0)
    foreign = '<!DOCTYPE html>\n<html lang="en"><title>My press</title></html>\n'
    page.write_text(foreign)
    assert REFUSED in run("report", small_sweep.directory, "--html", page, check=2).stderr
    assert page.read_text() == foreign


@pytest.mark.long
def test_the_files_of_a_study_are_replaced_by_a_second_report(tmp_path):
    run("sweep", "detectability-smoke", "--out", tmp_path / "study", "--engine", "in-process", check=0)
    for _ in range(2):
        run("report", tmp_path / "study", "--out", tmp_path / "report", check=0)


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


def test_a_plain_number_is_a_row_and_nothing_else(folder):
    (line,) = run("why", folder, "4", check=2).stderr.splitlines()
    assert "no row 4" in line
    identities = [run_json("why", folder, row)["run_id"] for row in ("0", "1")]
    assert run_json("why", folder, identities[1])["run_id"] == identities[1]


def test_the_seed_of_the_noise_is_in_the_provenance_of_file_why_and_report(folder):
    assert run_json("why", folder, "0")["provenance"]["seeds"] == {"measurement.seed": 3}
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


NUMBER = re.compile(r"[-−+]?\d[\d.,]*(?:e[-+]\d+)?%?")
SWEEP = "record: {duration: 6 s}\nsweep: {grid: {fluid.bulk_modulus: [551 MPa, 689.123 MPa]}}\n"


@pytest.mark.parametrize(
    "command",
    [("check", "experiment.yaml", "--set", "indicators=weak_rls"), ("measure", "experiment.yaml")],
    ids=" ".join,
)
def test_no_number_of_a_command_is_cut_at_60_columns(monkeypatch, experiment_file, tmp_path, command):
    experiment_file(SWEEP)
    shown = []
    for width in ("400", "60"):
        monkeypatch.setenv("COLUMNS", width)
        shown.append(run_hydrofdi(*command, cwd=tmp_path).stdout)
    wide, narrow = (Counter(NUMBER.findall(text)).keys() for text in shown)
    assert {number for number in wide - narrow if "." in number} == set()


@pytest.mark.parametrize("width", [20, 60, 200])
def test_a_parted_table_shows_every_cell_whole_under_its_header(width):
    numbers = (
        Column(f"number {n}", [f"{run}.{n}2345" for run in range(3)], title=f"number {n} [unit]")
        for n in range(9)
    )
    console = Console(width=width)
    with console.capture() as captured:
        print_table(console, Table((Column("run", ["r0", "r1", "r2"], is_text=True), *numbers)))
    text = captured.get()
    assert all(f"{run}.{column}2345" in text for run in range(3) for column in range(9))
    assert all(f"number {column}" in text for column in range(9))
    assert max(map(len, text.splitlines())) <= width


def test_texts_from_outside_do_not_act_on_the_terminal(capsys):
    print_table(Console(width=80), Table((Column("name", ["a\x1b[31mred\x07"], is_text=True),)))
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", capsys.readouterr().out)


SCRIPT = Path(sys.executable).parent / "hydrofdi"


@pytest.mark.parametrize("command", [(), ("sweep",), ("measure",)])
def test_h_is_help(command):
    short, full = (run_hydrofdi(*command, option) for option in ("-h", "--help"))
    assert short.returncode == 0
    assert short.stdout == full.stdout


@pytest.mark.skipif(not SCRIPT.exists(), reason="the command is not installed beside Python")
def test_the_shell_completes_commands():
    asked = {"_HYDROFDI_COMPLETE": "complete_bash", "COMP_WORDS": "hydrofdi sw", "COMP_CWORD": "1"}
    done = subprocess.run([SCRIPT], env=os.environ | asked, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["sweep"]
    assert not done.stderr


def test_every_plain_setting_of_a_detector_is_an_option_of_train():
    command = typer.main.get_command(application(["train"])).commands["train"]
    options = {parameter.name for parameter in command.params}
    assert setting_keys().keys() - options == {"options", "indicators", "score"}


def test_commands_stand_in_groups():
    shown = run_hydrofdi("--help").stdout
    assert not {"Start:", "Study:", "Records:", "Live:", "Look up:", "Audit:"} - {*shown.splitlines()}
