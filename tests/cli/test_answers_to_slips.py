"""Slips with a short answer: shares without percent, limits with units, places that cannot be written."""

from __future__ import annotations

from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.errors import StoreError
from hydrofdi.store.folder.lock import file_lock
from tests.commands import run

CSV = "time [s],P1 [bar]\n" + "".join(f"{k / 100},{50 + k % 7}\n" for k in range(1000))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    file = tmp_path / "rig.csv"
    file.write_text(CSV)
    return file


@pytest.mark.parametrize("rate", ["1", "2"])
@pytest.mark.parametrize("words", [("evaluate",), ("train", "--out", "d.json")])
def test_a_rate_without_percent_is_answered_with_percent(recording: Path, words, rate: str) -> None:
    command, *others = words
    refused = run(command, recording, *others, "--false-alarm-rate", rate, cwd=recording.parent, check=2)
    assert f"write '{rate} %' if it is in percent" in refused.stderr


def test_python_and_yaml_answer_alike(recording: Path) -> None:
    for config in ({"false_alarm_rate": 1}, {"false_alarm_rate": "1"}):
        with pytest.raises(hydrofdi.HydrofdiError, match="write '1 %' if it is in percent"):
            hydrofdi.train(recording, config=config)


def test_a_rate_in_bar_is_no_share(recording: Path) -> None:
    refused = run("evaluate", recording, "--false-alarm-rate", "1 bar", check=2)
    assert "has the wrong unit; it must be a number or a percentage" in refused.stderr


def test_a_limit_has_the_unit_of_the_value(recording: Path) -> None:
    refused = run("train", recording, "--window", "0 s", "--out", "d.json", cwd=recording.parent, check=2)
    assert "window: must be at least 1e-09 s; found 0 s" in refused.stderr


def test_the_state_that_cannot_be_locked_is_named(tmp_path: Path) -> None:
    (tmp_path / ".press.state.lock").mkdir()
    with (
        pytest.raises(StoreError, match=r"press\.state\.lock: cannot be written"),
        file_lock(tmp_path / ".press.state.lock", "in use"),
    ):
        pass


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs a folder that even root cannot write")
def test_init_says_that_the_file_cannot_be_written() -> None:
    refused = run("init", "press", cwd=Path("/proc"), check=2)
    assert "press.yaml: cannot be written: " in refused.stderr
