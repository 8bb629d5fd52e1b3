"""Suggestions for unknown keys, units, choices and files."""

import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import listed, nearest, similar
from hydrofdi.units import parse_quantity
from tests.commands import run


@pytest.mark.parametrize(
    ("text", "unit", "meant"),
    [
        ("1.2 GPA", "Pa", "'GPa'"), ("30 bars", "Pa", "'bar'"), ("5 sec", "s", "'s'"),
        ("0.1 lpm", "m^3/s", "'L/min'"),
        ("633 mm2", "m^2", "'mm²'"), ("20 Mpa", "Pa", "'MPa'?"), ("20 mpa", "Pa", "'MPa' or 'mPa'?"),
        ("3 gpm", "m^3/s", "'galUS/min' or 'galUK/min'"), ("3 cc/sec", "m^3/s", "'cm³/s'"),
        ("3 kp/cm2", "Pa", "'kgf/cm²'"), ("3 N-s/m", "N*s/m", "'N·s/m'"), ("32 cst", "m^2/s", "'cSt'"),
    ],
)  # fmt: skip
def test_misspelt_units_get_the_one_that_they_may_stand_for(text, unit, meant):
    with pytest.raises(ValueError, match="did you mean") as error:
        parse_quantity(text, unit)
    assert meant in str(error.value)


@pytest.mark.parametrize(
    ("text", "unit"), [("5 lpm", "Pa"), ("3 furlong", "m"), ("2 bars", "m"), ("2 }{0}", "m")]
)
def test_no_unit_of_another_dimension_is_suggested(text, unit):
    with pytest.raises(ValueError, match="unit") as error:
        parse_quantity(text, unit)
    assert "did you mean" not in str(error.value)


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
    ("text", "unit", "example"),
    [
        ("0,5 %", "1", "0.5 %"),
        ("1,5 bar", "Pa", "1.5 bar"),
        ("1,200 bar", "Pa", "1.5 Pa"),
        ("1,5 %", "Pa", "1.5 Pa"),
    ],
)
def test_decimal_comma_is_shown_as_a_point_in_the_same_quantity(text, unit, example):
    with pytest.raises(ValueError, match=f"'{example}'$"):
        parse_quantity(text, unit)


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("fluid.bulk_modulsu", "'bulk_modulus'"), ("fluid.EBM", "'bulk_modulus'"),
        ("beta", "'bulk_modulus'"),
        ("leakage.K_i", "'internal_coefficient'"), ("record.dt", "'step'"),
        ("record.fs", "'sampling_frequency'"),
        ("valve.frequency", "'natural_frequency'"), ("load.mass", "'actuator.mass'"), ("bore", "π/4"),
        ("record.bulk_modulus", "'fluid.bulk_modulus'"), ("supplly", "'supply'"),
        ("actuator.rod_diameter", "π/4"),
        ("sweep.grid.fluid.EBM", "'fluid.bulk_modulus'"), ("sweep.grid.beta", "'fluid.bulk_modulus'"),
        ("supply.freq", ""), ("a", ""), ("friction.a", ""), ("xy", ""), ("sweep.grid.fluid.a", ""),
    ],
)  # fmt: skip
def test_unknown_key_gets_the_key_that_it_means(key, meant):
    with pytest.raises(ConfigError) as error:
        load_experiment(settings=[f"{key}=[1]"])
    (told,) = [each.message for each in error.value.mistakes if each.message != "is missing"]
    assert meant in told
    assert ("did you mean" in told or "give" in told) == bool(meant)


def test_axis_of_an_unknown_parameter_has_its_line(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nsweep:\n  grid:\n    fluid.EBM: [1, 2]\n")
    with pytest.raises(ConfigError, match=r"'fluid\.bulk_modulus'") as error:
        load_experiment(tmp_path / "mine.yaml")
    assert error.value.mistakes[0].origin.endswith("mine.yaml:4")


@pytest.mark.parametrize(
    ("key", "value", "meant"),
    [
        ("friction.law", "LuGre", "lugre"), ("wavelet.name", "DB8", "db8"),
        ("fluid.law", "FreeAir", "free_air"),
        ("input.shape", "multi-sine", "multisine"), ("leakage.law", "laminer", "laminar"),
    ],
)  # fmt: skip
def test_misspelt_choice_gets_the_one_that_it_means(key, value, meant):
    for way in (
        lambda: load_experiment(None, [f"{key}={value}"]),
        lambda: hydrofdi.check(**{key.replace(".", "__"): value}),
    ):
        with pytest.raises(ConfigError) as error:
            way()
        assert str(error.value).endswith(f"; did you mean {meant!r}?")


def test_commands_and_choices_of_options_get_suggestions():
    assert "'online'" in run("init", "mine", "--from", "onlin", check=2).stderr
    assert "sweep" in run("sweeep", check=2).stderr


def test_no_known_names_are_not_listed():
    assert nearest("any", []) == listed([]) == similar("any", [""]) == ""


@pytest.mark.parametrize(("value", "found"), [("-21 MPa", "-21 MPa"), ("-21000000", "-21"), ("nan", "nan")])
def test_number_out_of_range_is_shown_as_it_is_written(value, found):
    with pytest.raises(ConfigError) as error:
        load_experiment(settings=[f"supply.pressure={value}"])
    assert found in error.value.mistakes[0].message
    assert error.value.mistakes[0].where == "supply.pressure"


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
