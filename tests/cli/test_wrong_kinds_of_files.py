"""A file given in the place of another: the message names both kinds, and what helps."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.settings.file_kinds import KEYS, FileKind, other_kind
from tests.commands import run

FILES = {
    "press.yaml": "name: press\nstudy: {healthy: {fit: 9, test: 9}}\n",
    "good.yaml": "files: good_*.csv\nformat: {decimal: ','}\nchannels: {P1: p A}\n",
    "stream.yaml": "text: {decimal: ','}\nchannels: {P1: p A}\n",
    "flow.json": '{\n  "schema": "hydrofdi.detector",\n  "version": 1,\n  "channels": []\n}\n',
    "good.csv": "time [s],P1 [bar]\n0,1\n1,2\n",
    "press.png": "",
    "book.xlsx": "PK",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "press.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("report press.yaml", "not a results folder; give its results folder: results/press"),
        ("status press.yaml", "not a results folder; give its results folder: results/press"),
        ("report good.csv", "is a data file, not a results folder; 'hydrofdi inspect good.csv' reads it"),
        ("sweep good.yaml", "is a description of measured files, not an experiment file; 'hydrofdi inspect"),
        ("sweep flow.json", "is a detector file, not an experiment file; 'hydrofdi detect flow.json"),
        ("sweep good.csv", "is a data file, not an experiment file; 'hydrofdi inspect good.csv' reads it"),
        ("inspect flow.json", "is a detector file, not"),
        ("inspect stream.yaml", "is a configuration of a monitor, not"),
        ("inspect press.png", "is a picture, not a data file"),
        ("inspect book.xlsx", "is a spreadsheet, not a data file; save it as CSV"),
        ("detect good.yaml flow.json", "not a detector file; name the detector first, then the records"),
        ("detect good.csv flow.json", "is a data file, not a detector file; name the detector first"),
        ("monitor press.yaml good.csv", "not a detector file; name the detector first"),
        ("sweep press.yaml --out good.csv", "good.csv: is a file, not a folder; give another --out"),
        ("report results --html press.yaml", "press.yaml: the name of a page must end in .html"),
    ],
)  # fmt: skip
def test_a_file_in_the_place_of_another_is_named_with_its_use(folder, command, message) -> None:
    refused = run(*command.split(), cwd=folder, check=2)
    assert message in refused.stderr
    assert len(refused.stderr.splitlines()) == 1


def test_an_unknown_suffix_is_told_with_those_that_can_be_read(folder) -> None:
    (folder / "rig.log").write_text("P1 [bar]\n1\n")
    assert "hydrofdi reads .csv, .tsv" in run("inspect", "rig.log", cwd=folder, check=2).stderr


def test_a_description_becomes_a_configuration_of_a_monitor_by_what_the_message_says(folder) -> None:
    told = other_kind(Path("good.yaml"), FileKind.MONITOR)
    assert "write 'text:' for 'format:'" in told
    assert "leave the rest out" in told
    assert not other_kind(Path("stream.yaml"), FileKind.MONITOR)


@pytest.mark.parametrize("head", ["name: rig 7\ntime;P1 [bar]\n", "files: 3\nP1 [bar]\n1\n"])
def test_a_data_file_with_lines_like_keys_stays_a_data_file(folder, head) -> None:
    (folder / "rig.csv").write_text(head)
    assert not other_kind(Path("rig.csv"), FileKind.DATA)


def test_an_experiment_with_a_key_of_another_kind_is_told_the_key(folder) -> None:
    (folder / "mixed.yaml").write_text("name: mixed\nfiles: a.csv\n")
    with pytest.raises(ConfigError, match=r"mixed\.yaml:2: files: unknown key"):
        load_experiment("mixed.yaml")


def test_a_pipe_is_not_read_to_tell_its_kind(folder) -> None:
    os.mkfifo("pipe")
    assert not other_kind(Path("pipe"), FileKind.DATA)


def test_each_key_that_tells_a_kind_is_a_key_of_this_kind_alone() -> None:
    models = {
        FileKind.EXPERIMENT: ExperimentConfig,
        FileKind.MEASURED: MeasuredConfig,
        FileKind.MONITOR: MonitorConfig,
    }
    assert set(KEYS) == set(models)
    for kind, model in models.items():
        others = {key for other in models.values() if other is not model for key in other.model_fields}
        assert set(model.model_fields) >= KEYS[kind]
        assert not others & KEYS[kind]
