"""Suggestions for unknown keys, units, choices and files."""

from collections.abc import Callable
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.selection import load_indicators
from hydrofdi.units import parse_quantity
from tests.commands import run


@pytest.mark.parametrize(
    ("text", "unit", "meant"),
    [
        ("1.2 GPA", "Pa", "'GPa'"), ("30 bars", "Pa", "'bar'"), ("5 sec", "s", "'s'"),
        ("0.1 lpm", "m^3/s", "'L/min'"),
        ("633 mm2", "m^2", "'mm²'"), ("20 mpa", "Pa", "'MPa' or 'mPa'?"), ("3 N-s/m", "N*s/m", "'N·s/m'"),
    ],
)  # fmt: skip
def test_misspelt_units_get_the_one_that_they_may_stand_for(text, unit, meant):
    with pytest.raises(ValueError, match="did you mean") as error:
        parse_quantity(text, unit)
    assert meant in str(error.value)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1 kgf/cm^2", "Pa", 98066.5), ("1 lbf/in^2", "psi", 1.0), ("1 galUS/min", "L/min", 3.785411784),
        ("1 ft", "in", 12.0), ("32 cSt", "mm^2/s", 32.0), ("2 t", "kg", 2000.0), ("1 atm", "hPa", 1013.25),
        ("1 dm^3/min", "L/min", 1.0), ("1 daN", "N", 10.0),
    ],
)  # fmt: skip
def test_units_of_the_workshop_are_exact(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("fluid.EBM", "'bulk_modulus'"), ("beta", "'bulk_modulus'"), ("bore", "π/4"),
        ("load.mass", "'actuator.mass'"), ("supplly", "'supply'"),
        ("sweep.grid.fluid.EBM", "'fluid.bulk_modulus'"),
        ("supply.freq", ""), ("a", ""), ("sweep.grid.fluid.a", ""),
    ],
)  # fmt: skip
def test_unknown_key_gets_the_key_that_it_means(key, meant):
    with pytest.raises(ConfigError) as error:
        load_experiment(settings=[f"{key}=[1]"])
    (told,) = [each.message for each in error.value.mistakes if each.message != "is missing"]
    assert meant in told
    assert ("did you mean" in told or "give" in told) == bool(meant)


def test_commands_and_choices_of_options_get_suggestions():
    assert "'online'" in run("init", "mine", "--from", "onlin", check=2).stderr
    assert "sweep" in run("sweeep", check=2).stderr


@pytest.mark.parametrize("command", ["sweep", "inspect"])
@pytest.mark.parametrize("name", ["press.png", "book.yaml", "run.csv"])
def test_file_that_is_no_text_is_refused_in_one_line(tmp_path, command, name):
    heads = {
        "press.png": b"\x89PNG\r\n\x1a\n",
        "book.yaml": b"PK\x03\x04",
        "run.csv": b"\x89HDF\r\n\x1a\n\x00",
    }
    (tmp_path / name).write_bytes(heads[name])
    refused = run(command, name, cwd=tmp_path, check=2)
    assert refused.stderr.startswith(f"hydrofdi: {name}")
    assert len(refused.stderr.splitlines()) == 1


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
