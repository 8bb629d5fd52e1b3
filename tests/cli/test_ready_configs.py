"""The ready configurations, by name and in any folder."""

import json
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.loading import anchor_input_files
from hydrofdi.indicators import indicator_names, load_indicators
from hydrofdi.settings.ready import ready_copy, ready_folder, ready_names
from hydrofdi.settings.validation import read_extended
from tests.commands import run, run_json


def contents(file):

    data = read_extended(file, "a file", lambda own, named: anchor_input_files(own.data, named.parent)).data
    if name := data.get("input", {}).get("file"):
        data["input"]["file"] = Path(name).resolve()
    return data


def test_the_list_has_every_configuration_and_what_it_is_for():
    listed = run_json("configs")["configs"]
    files = {file.relative_to(ready_folder()).as_posix() for file in ready_folder().rglob("*.yaml")}
    assert {f"{each['name']}.yaml" for each in listed} == files
    page = run("configs", check=0).stdout
    assert "delays/" in page
    assert "Table 3: how the RMS" in page


def test_a_name_is_planned_and_swept_in_any_folder(tmp_path):
    run("plan", "delays/smoke", cwd=tmp_path, check=0)
    run("sweep", "smoke", "--engine", "in-process", cwd=tmp_path, check=0)
    assert (tmp_path / "results" / "smoke" / "smoke.h5").exists()
    assert "δd3" in run("report", "--full", cwd=tmp_path, check=0).stdout


def test_a_file_of_the_user_wins(tmp_path):
    (tmp_path / "smoke.yaml").write_text("name: mine\n")
    for asked, told in (("smoke", 1), ("smoke.yaml", 0)):
        planned = run("plan", asked, cwd=tmp_path, check=0)
        assert "mine" in planned.stdout
        assert planned.stderr.count("smoke is the file smoke.yaml here, not the ready conf") == told
    (tmp_path / "table3").mkdir()
    planned = run("plan", "table3", cwd=tmp_path, check=0)
    assert "table3" in planned.stdout
    assert planned.stderr == ""


def test_files_extend_ready_ones_and_name_their_inputs(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("extends: [viscous-friction, motions/rest.yaml]\nname: mine\n")
    assert (
        load_experiment(file).input.file == load_experiment(ready_folder() / "motions/rest.yaml").input.file
    )
    file.write_text("input: {shape: csv, file: motions/rest.csv}\n")
    assert "\n" in str(load_experiment(file).input.file)


def test_presets_of_indicators_and_detectors_have_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert list(load_indicators("detectors/weak-rls")) == ["weak_rls_P1_P2_x_u"]
    assert not {*indicator_names()} & {*ready_names()}
    train = ("train", "delays/smoke", "--config", "monitoring/windows", "--out", "d.json", "--window", "5 s")
    run(*train, "--false-alarm-rate", "10 %", check=0)
    assert json.loads((tmp_path / "d.json").read_text())["config"]["indicator"] == "weak_rls"


def test_a_ready_configuration_is_a_source_of_records(tmp_path):
    records = run_json("measure", "smoke", "--indicators", "dwt", cwd=tmp_path)
    assert "smoke" in json.dumps(records)
    assert str(ready_folder()) not in json.dumps(records)


@pytest.mark.parametrize("name", ready_names())
def test_a_printed_copy_means_the_same_anywhere(name, tmp_path):
    file = tmp_path / "copy.yaml"
    file.write_text(ready_copy(name))
    assert contents(file) == contents(ready_folder() / f"{name}.yaml")


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (("sweep", "tabel3"), "did you mean 'table3'?"),
        (("plan", "windows"), "did you mean 'monitoring/windows'?"),
        (("measure", "smoek"), "did you mean 'smoke'?"),
        (("configs", "tabel3"), "did you mean 'table3'?"),
        (("sweep", "something-else"), "'hydrofdi configs' lists the ready ones"),
    ],
)
def test_an_unknown_name_gets_a_suggestion(arguments, hint, tmp_path):
    done = run(*arguments, cwd=tmp_path, check=2)
    assert hint in done.stderr
    assert len(done.stderr.splitlines()) == 1
