"""A record that is too short: which key is blamed, in which file, and the least value that works."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError

BASE = "name: base\nanalysis: {discard: 1 period}\nrecord: {duration: 4 s}\nstore: {signals: none}\n"


def _refusal(file: Path, *settings: str) -> str:
    with pytest.raises(ConfigError) as refused:
        expand_runs(load_experiment(file, settings))
    return str(refused.value)


@pytest.fixture
def base(tmp_path: Path) -> Path:
    file = tmp_path / "base.yaml"
    file.write_text(BASE)
    return file


def _own(base: Path, text: str) -> Path:
    file = base.with_name("own.yaml")
    file.write_text(f"extends: base.yaml\n{text}")
    return file


@pytest.mark.parametrize(
    "text",
    [
        "record: {duration: 2 s}\n",
        "record: {duration: 0.2 s}\nanalysis: {discard: 0 s}\n",
        "wavelet: {levels: 7, phase: 3}\n",
        "input: {period: 8 s}\n",
        "sweep: {grid: {input.period: [2 s, 4 s]}}\n",
        "sweep: {grid: {record.duration: [2 s, 8 s]}}\n",
    ],
)
def test_the_least_duration_that_is_named_works_and_a_sample_less_does_not(base: Path, text: str) -> None:
    own = _own(base, text)
    found = re.search(r"set record\.duration to (\S+) s or more", _refusal(own))
    assert found
    least = float(found[1])
    key = "sweep.grid.record.duration=[{} s]" if "record.duration:" in text else "record.duration={} s"
    expand_runs(load_experiment(own, [key.format(least)]))
    assert "set record.duration to" in _refusal(own, key.format(round(least - 0.002, 6)))


def test_the_number_of_levels_that_is_named_works(base: Path) -> None:
    own = _own(base, "wavelet: {levels: 8}\n")
    found = re.search(r"or wavelet\.levels to (\d+)", _refusal(own))
    assert found
    expand_runs(load_experiment(own, [f"wavelet.levels={found[1]}"]))
    assert "wavelet.levels" in _refusal(own, f"wavelet.levels={int(found[1]) + 1}")
