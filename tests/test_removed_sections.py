"""``null`` in a file that extends another removes what is inherited."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.selection import load_indicators

BASE = """
name: press
study: {healthy: {fit: 9, test: 9}, faults: {leakage.internal_flow: [0.5 L/min], each: 2, fit: 0}}
indicators: {dwt: {levels: 3}, pressure_statistics: {}}
detection: {false_alarm_rate: 20 %}
"""


@pytest.fixture
def extending(tmp_path: Path) -> Callable[[str], Path]:
    (tmp_path / "base.yaml").write_text(BASE)

    def write(text: str) -> Path:
        file = tmp_path / "own.yaml"
        file.write_text(f"extends: base.yaml\n{text}")
        return file

    return write


def test_null_removes_an_inherited_indicator(extending) -> None:
    assert [*load_experiment(extending("indicators: {dwt: null}")).indicators] == ["pressure_statistics"]
    replaced = load_experiment(extending("indicators: {dwt: null, pressure_statistics: null, modwt: {}}"))
    assert [*replaced.indicators] == ["modwt"]


def test_null_removes_inherited_sections(extending) -> None:
    plain = load_experiment(extending("study: null\ndetection: null"))
    assert plain.study is None
    assert plain.detection == load_experiment({"name": "press"}).detection
    assert load_experiment(extending("name: own"), ["detection=null"]).detection.false_alarm_rate == 0.01


def test_null_removes_an_inherited_axis_and_nothing_else(tmp_path) -> None:
    axes = "{fluid.bulk_modulus: [551 MPa, 1 GPa], leakage.internal_flow: [0, 1 L/min]}"
    (tmp_path / "swept.yaml").write_text(f"name: base\nsweep: {{grid: {axes}}}\n")
    file = tmp_path / "mine.yaml"
    file.write_text("extends: swept.yaml\nname: mine\nsweep: {grid: {fluid.bulk_modulus: null}}\n")
    assert load_experiment(file).sweep.names == ["leakage.internal_flow"]
    file.write_text("extends: swept.yaml\nname: mine\nsweep: {grid: {supply.pressure: null}}\n")
    with pytest.raises(ConfigError, match=r"mine\.yaml:3: sweep\.grid\.supply\.pressure"):
        load_experiment(file)


def test_an_indicator_without_options_that_nobody_stated_before_is_kept(extending) -> None:
    assert "modwt" in load_experiment(extending("indicators: {modwt: }")).indicators


def test_files_of_indicators_do_the_same(tmp_path) -> None:
    (tmp_path / "base.yaml").write_text("indicators: {dwt: {levels: 3}, pressure_statistics: {}}")
    (tmp_path / "own.yaml").write_text("extends: base.yaml\nindicators: {dwt: null}")
    assert [*load_indicators(str(tmp_path / "own.yaml"))] == ["pressure_statistics"]
