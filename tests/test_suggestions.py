"""Suggestions for unknown names."""

from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.request import parameter_names
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from hydrofdi.settings.computed import _COMPUTED
from hydrofdi.settings.suggestions import listed, nearest, similar
from hydrofdi.settings.synonyms import _SYNONYMS
from hydrofdi.units import parse_quantity, parse_unit
from hydrofdi.units.spellings import _MEANT
from tests.commands import run_hydrofdi

CONFIGURATION = Path(__file__).parent.parent / "docs"


def test_a_channel_is_found_by_its_words_in_another_order() -> None:
    with pytest.raises(ConfigError, match="did you mean 'chamber_1_pressure'"):
        make_indicators({"dwt": {"channel": "pressure_1"}})


@pytest.mark.parametrize(
    ("text", "unit", "meant"),
    [
        ("1.2 GPA", "Pa", "'GPa'"), ("30 bars", "Pa", "'bar'"), ("5 sec", "s", "'s'"),
        ("0.1 lpm", "m^3/s", "'L/min'"),
        ("633 mm2", "m^2", "'mm²'"), ("5 hz", "Hz", "'Hz'"), ("1 percent", "1", "'%'"),
        ("633 mm**2", "m^2", "'mm²'"), ("20 Mpa", "Pa", "'MPa'?"), ("20 MPA", "Pa", "'MPa'?"),
        ("20 mpa", "Pa", "'MPa' or 'mPa'?"), ("5 mS", "s", "'ms'?"), ("3 KG", "kg", "'kg'?"),
        ("3 ksi", "Pa", "'kpsi'"), ("60 rpm", "Hz", "'1/min'"),
        ("3 gpm", "m^3/s", "'galUS/min' or 'galUK/min'"), ("3 ltr/min", "m^3/s", "'L/min'"),
        ("3 litre/hour", "m^3/s", "'L/h'"), ("3 cc/sec", "m^3/s", "'cm³/s'"), ("3 m3/hr", "m^3/s", "'m³/h'"),
        ("3 kgf/cm2", "Pa", "'kgf/cm²'"), ("3 kp/cm2", "Pa", "'kgf/cm²'"), ("3 N/mm2", "Pa", "'N/mm²'"),
        ("2 inch", "m", "'in'"), ("20 micron", "m", "'µm'"), ("3 feet", "m", "'ft'"),
        ("3 N-s/m", "N*s/m", "'N·s/m'"), ("3 N.s/m", "N*s/m", "'N·s/m'"), ("32 cst", "m^2/s", "'cSt'"),
    ],
)  # fmt: skip
def test_a_misspelt_unit_gets_the_one_that_it_may_stand_for(text, unit, meant) -> None:
    with pytest.raises(ValueError, match="did you mean") as error:
        parse_quantity(text, unit)
    assert meant in str(error.value)


@pytest.mark.parametrize(("text", "unit"), [("5 lpm", "Pa"), ("3 furlong", "m"), ("2 bars", "m")])
def test_no_unit_of_another_dimension_is_suggested(text, unit) -> None:
    with pytest.raises(ValueError, match="unit") as error:
        parse_quantity(text, unit)
    assert "did you mean" not in str(error.value)


def test_a_decimal_comma_is_named() -> None:
    with pytest.raises(ValueError, match="write a point instead of a comma"):
        parse_quantity("3,5 bar", "Pa")


@pytest.mark.parametrize("meant", sorted({name for names in _MEANT.values() for name in names}))
def test_every_suggested_unit_exists(meant) -> None:
    assert parse_unit(meant)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1 kgf/cm^2", "Pa", 98066.5), ("1 lbf/in^2", "psi", 1.0), ("1 galUS/min", "L/min", 3.785411784),
        ("1 ft", "in", 12.0), ("32 cSt", "mm^2/s", 32.0), ("2 t", "kg", 2000.0), ("1 atm", "hPa", 1013.25),
        ("1 dm^3/min", "L/min", 1.0), ("1 daN", "N", 10.0),
    ],
)  # fmt: skip
def test_units_of_the_workshop_are_exact(text, unit, value) -> None:
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    ("section", "word", "key"),
    [
        ("fluid", "EBM", "bulk_modulus"), ("leakage", "K_i", "internal_coefficient"),
        ("record", "dt", "step"),
        ("record", "sample_rate", "sampling_frequency"), ("leakage", "leak", "internal_flow"),
        ("control", "Kp", "proportional_gain"), ("wavelet", "mother", "name"),
    ],
)  # fmt: skip
def test_a_key_under_another_name_gets_the_one_that_means_it(tmp_path, section, word, key) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(f"name: mine\n{section}: {{{word}: 1}}\n")
    with pytest.raises(ConfigError, match=f"unknown key; did you mean '{key}'"):
        load_experiment(file)


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("beta", "did you mean 'fluid.bulk_modulus'?"), ("Ps", "did you mean 'supply.pressure'?"),
        ("Pt", "did you mean 'supply.return_pressure'?"), ("Kv", "did you mean 'valve.flow_gain'?"),
        ("mass", "did you mean 'actuator.mass'?"), ("load.mass", "did you mean 'actuator.mass'?"),
        ("load.k", "did you mean 'actuator.load_stiffness'?"), ("dt", "did you mean 'record.step'?"),
        ("sample_rate", "did you mean 'record.sampling_frequency'?"),
        ("T_end", "did you mean 'record.duration'?"),
        ("fs", "'record.sampling_frequency'"), ("noise_std", "'pressure_1_sensor.noise', or that of another"),
        ("cylinder.bore", "did you mean 'actuator'?"), ("solver.step", "did you mean 'record'?"),
        ("pump.pressure", "did you mean 'supply'?"), ("sensor.noise", "did you mean 'pressure_1_sensor'?"),
        ("friction.mu", "did you mean 'coulomb' or 'viscous'?"), ("valve.deadband", "did you mean 'lap'?"),
        ("valve.gain", "did you mean 'flow_gain' or 'spool_gain'?"),
        ("valve.Kv", "did you mean 'flow_gain'?"),
        ("leakage.external", "did you mean 'external_coefficient'?"), ("input.type", "did you mean 'shape'?"),
        ("bore", "give 'actuator.piston_area' instead: the area of both chambers"),
        ("actuator.rod_diameter", "give 'actuator.piston_area' instead: the area of both chambers"),
        ("actuator.A1", "give 'actuator.piston_area' instead: the area of both chambers"),
        ("actuator.stroke", "give 'actuator.end_stop_position' instead: stroke / 2"),
        ("record.Ts", "give 'record.sampling_frequency' instead: 1 / T_s"),
        ("input.frequency", "give 'input.period' instead: 1 / frequency"),
        ("fluid.density", "give 'valve.flow_gain' instead: C_d · √(2 / density)"),
    ],
)  # fmt: skip
def test_what_an_engineer_would_write_leads_to_the_key_that_has_it(key, hint) -> None:
    with pytest.raises(ConfigError, match="unknown key") as error:
        load_experiment(settings=[f"{key}=1"])
    assert hint in str(error.value)


AXES = {
    "grid": "sweep:\n  grid:\n    {name}: [1, 2]\n",
    "zip": "sweep:\n  zip:\n    {name}: [1, 2]\n",
    "sample": "sweep:\n  sample:\n    size: 2\n    over: {{{name}: {{uniform: [1, 2]}}}}\n",
    "baseline": "baseline:\n\n\n  {name}: 1\n",
    "ensemble": "ensemble:\n  grid:\n\n    {name}: [1, 2]\n",
    "population": "study:\n  population:\n    over:\n      {name}: {{uniform: [1, 2]}}\n",
}


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("fluid.EBM", "did you mean 'fluid.bulk_modulus'?"), ("beta", "did you mean 'fluid.bulk_modulus'?"),
        ("leak", "did you mean 'leakage.internal_flow'?"), ("oil.EBM", "did you mean 'fluid.bulk_modulus'?"),
        ("cylinder.bore", "give 'actuator.piston_area' instead: the area of both chambers"),
        ("supply.Ps", "did you mean 'supply.pressure'?"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("axes", AXES)
def test_an_axis_gets_the_suggestion_of_a_key_with_its_line(tmp_path, axes, name, hint) -> None:
    text = "name: mine\n" + AXES[axes].format(name=name)
    (tmp_path / "mine.yaml").write_text(text)
    line = next(number for number, line in enumerate(text.splitlines(), 1) if name in line)
    with pytest.raises(ConfigError, match="no parameter") as error:
        load_experiment(tmp_path / "mine.yaml")
    (told,) = [str(each) for each in error.value.mistakes if "no parameter" in str(each)]
    assert f"mine.yaml:{line}: " in told
    assert f"no parameter '{name}'; {hint}" in told


def test_what_is_computed_leads_to_keys_that_exist() -> None:
    assert {dotted for dotted, _, _ in _COMPUTED} <= set(parameter_names())


def test_every_synonym_leads_to_a_key_that_exists() -> None:
    known = " ".join(path.read_text() for path in CONFIGURATION.glob("*.md"))
    missing = [key for key in _SYNONYMS if f"`{key}`" not in known]
    assert not missing


def test_an_axis_under_another_name_gets_the_one_that_means_it(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\nsweep: {grid: {fluid.EBM: [551 MPa, 1 GPa]}}\n")
    with pytest.raises(ConfigError, match=r"did you mean 'fluid\.bulk_modulus'"):
        load_experiment(file)


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("valve.frequency", "unknown key; did you mean 'natural_frequency'?"),
        ("supply.freq", "unknown key; known: pressure, return_pressure"),
        ("a", "unknown key"), ("friction.a", "unknown key; known: coulomb, breakaway"),
        ("study.a", "unknown key; known: population"), ("xy", "unknown key"), ("temp", "unknown key"),
        ("sweep.grid.fluid.a", "no parameter 'fluid.a'"),
    ],
)  # fmt: skip
def test_no_suggestion_is_far_fetched(key, hint) -> None:
    with pytest.raises(ConfigError) as error:
        load_experiment(settings=[f"{key}=[1]"])
    (told,) = [each.message for each in error.value.mistakes if each.message != "is missing"]
    assert told.startswith(hint)
    assert told.count("did you mean") == hint.count("did you mean")


def test_a_letter_is_no_keyword() -> None:
    with pytest.raises(ConfigError, match=r"^a: unknown key$"):
        hydrofdi.check(a=1)


@pytest.mark.parametrize(
    ("key", "value", "meant"),
    [
        ("friction.law", "LuGre", "lugre"), ("paper", "Maddahi2015", "maddahi2015"),
        ("wavelet.name", "DB8", "db8"), ("fluid.law", "FreeAir", "free_air"), ("control.law", "PID", "pid"),
        ("input.shape", "multi-sine", "multisine"), ("leakage.law", "laminer", "laminar"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("way", ["YAML", "setting", "keyword"])
def test_a_misspelt_choice_gets_the_one_that_it_probably_means(tmp_path, way, key, value, meant) -> None:
    section, _, name = key.rpartition(".")
    file = tmp_path / "mine.yaml"
    file.write_text(f"name: mine\n{section}: {{{name}: {value}}}" if section else f"{key}: {value}\n")
    ways = {
        "YAML": lambda: load_experiment(file),
        "setting": lambda: load_experiment(None, [f"{key}={value}"]),
        "keyword": lambda: hydrofdi.check(**{key.replace(".", "__"): value}),
    }
    with pytest.raises(ConfigError) as error:
        ways[way]()
    assert str(error.value).endswith(f"; did you mean {meant!r}?")


def test_a_value_for_a_section_names_its_key_as_the_user_writes_keys(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\nleakage: 0.2 L/min\n")
    ways = {
        "write leakage: {internal_flow: 0.2 L/min}": lambda: load_experiment(file),
        "write settings='leakage.internal_flow=0.2 L/min'": lambda: load_experiment(
            None, ["leakage=0.2 L/min"]
        ),
        "write leakage__internal_flow='0.2 L/min'": lambda: hydrofdi.simulate(leakage="0.2 L/min"),
    }
    for told, call in ways.items():
        with pytest.raises(ConfigError) as error:
            call()
        assert str(error.value).endswith(told)


def test_a_setting_is_named_once() -> None:
    with pytest.raises(ConfigError) as error:
        load_experiment(None, ["fluid.bulk_modulos=1", "fluid={beta: 1}"])
    told = str(error.value).splitlines()
    assert told[0] == "settings fluid.bulk_modulos=1: unknown key; did you mean 'bulk_modulus'?"
    assert told[1].startswith("settings fluid={beta: 1}: fluid.beta: unknown key")


@pytest.mark.parametrize(
    ("option", "hint"),
    [("onlin", "; did you mean 'online'? (see"), ("foo", "'actuator', 'paper', 'online' (see")],
)
def test_a_choice_of_the_command_line_gets_a_suggestion(option, hint) -> None:
    told = run_hydrofdi("init", "mine", "--from", option).stderr
    assert hint in told
    assert "Value error" not in told


def test_no_known_names_are_not_listed() -> None:
    assert nearest("any", []) == listed([]) == similar("any", [""]) == ""


@pytest.mark.parametrize(
    ("text", "unit", "example"),
    [
        ("0,5 %", "1", "0.5 %"),
        ("1,5 bar", "Pa", "1.5 bar"),
        ("1,200 bar", "Pa", "1.5 Pa"),
        ("1,5 %", "Pa", "1.5 Pa"),
    ],
)
def test_a_comma_is_shown_as_a_point_in_the_same_quantity(text, unit, example):
    with pytest.raises(ValueError, match=f"write a point instead of a comma, like '{example}'$"):
        parse_quantity(text, unit)
