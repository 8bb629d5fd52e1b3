"""The ready configurations, by name and in any folder."""

import json
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.loading import anchor_files
from hydrofdi.config.plausibility import idle_parameters, unusual_values
from hydrofdi.indicators import indicator_names, indicators_of
from hydrofdi.settings.files import read_extended, ready_copy, ready_folder, ready_names
from tests.commands import run, run_json


def contents(file):
    data = read_extended(file, "a file", lambda own, named: anchor_files(own.data, named.parent)).data
    if name := data.get("input", {}).get("file"):
        data["input"]["file"] = Path(name).resolve()
    return data


def test_the_list_has_every_configuration_which_is_planned_and_measured_in_any_folder(tmp_path):
    listed = {f"{each['name']}.yaml" for each in run_json("configs")["configs"]}
    assert listed == {file.relative_to(ready_folder()).as_posix() for file in ready_folder().rglob("*.yaml")}
    assert "Table 3: how the RMS" in run("configs", check=0).stdout
    run("plan", "delays/smoke", cwd=tmp_path, check=0)
    records = json.dumps(run_json("measure", "smoke", "--indicators", "dwt", cwd=tmp_path))
    assert "smoke" in records
    assert str(ready_folder()) not in records


def test_a_file_of_the_user_wins(tmp_path):
    (tmp_path / "smoke.yaml").write_text("name: mine\n")
    for asked in ("smoke", "smoke.yaml"):
        assert "mine" in run("plan", asked, cwd=tmp_path, check=0).stdout
    (tmp_path / "table3").mkdir()
    assert "table3" in run("plan", "table3", cwd=tmp_path, check=0).stdout


def test_files_extend_ready_ones_and_name_their_inputs(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("extends: [viscous-friction, motions/rest.yaml]\nname: mine\n")
    rest = load_experiment(ready_folder() / "motions/rest.yaml")
    assert load_experiment(file).input.file == rest.input.file
    file.write_text("input: {shape: csv, file: motions/rest.csv}\n")
    assert "\n" in str(load_experiment(file).input.file)


def test_presets_of_indicators_and_detectors_have_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert list(indicators_of("detectors/weak-rls")) == ["weak_rls_P1_P2_x_u"]
    assert not {*indicator_names()} & {*ready_names()}
    train = ("train", "delays/smoke", "--config", "monitoring/windows", "--out", "d.json", "--window", "5 s")
    run(*train, "--false-alarm-rate", "10 %", check=0)
    assert json.loads((tmp_path / "d.json").read_text())["config"]["indicators"].keys() == {"weak_rls"}


@pytest.mark.parametrize("name", ready_names())
def test_a_printed_copy_means_the_same_anywhere(name, tmp_path):
    file = tmp_path / "copy.yaml"
    file.write_text(ready_copy(name))
    assert contents(file) == contents(ready_folder() / f"{name}.yaml")


def test_an_unknown_name_gets_a_suggestion(tmp_path):
    for command, name, meant in (
        ("plan", "windows", "'monitoring/windows'"),
        ("measure", "smoek", "'smoke'"),
        ("configs", "tabel3", "'table3'"),
        ("sweep", "something-else", "'hydrofdi configs'"),
    ):
        assert meant in run(command, name, cwd=tmp_path, check=2).stderr


@pytest.mark.parametrize("template", [pytest.param("actuator", marks=pytest.mark.long), "online", "paper"])
def test_the_file_is_planned_as_it_is_and_takes_minutes_at_most(template, tmp_path):
    run("init", "mine", "--from", template, cwd=tmp_path, check=0)
    plan = run_json("plan", "mine.yaml", cwd=tmp_path)
    assert plan["experiment"] == "mine"
    assert 10 < plan["planned"] < 2000
    made = load_experiment(tmp_path / "mine.yaml")
    assert not unusual_values(made) + idle_parameters(made)
    assert not [warning for warning in plan["warnings"] if "study" in warning]


def test_a_name_that_looks_like_a_number_is_text_and_an_existing_file_stays(tmp_path):
    for name in ("2024", "null", "1e3"):
        run("init", name, cwd=tmp_path, check=0)
        assert load_experiment(tmp_path / f"{name}.yaml").name == name
    before = (tmp_path / "2024.yaml").read_text()
    assert "2024.yaml: already exists" in run("init", "2024", cwd=tmp_path, check=2).stderr
    assert (tmp_path / "2024.yaml").read_text() == before
    assert "name: " in run("init", "my press", cwd=tmp_path, check=2).stderr
