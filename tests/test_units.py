"""Plans and reports show parameters in the units that the experiment is written in."""

import contextlib
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.units import convert, parse_quantity
from tests.commands import run, run_json
from tests.conftest import sweep_in


@pytest.mark.parametrize(("text", "unit", "expected"), [
    ("551 MPa", "Pa", 551e6), ("17.2MPa", "Pa", 17.2e6), ("100 bar", "Pa", 1e7),
    ("0.12 L/min", "m^3/s", 2e-6), ("280 cm^3", "m^3", 280e-6), ("633 mm²", "m^2", 633e-6),
    ("22 µm/V", "m/V", 22e-6), ("70 %", "1", 0.7), ("50 N·s/m", "N*s/m", 50.0), ("-1e1", "V", -10.0),
    ("1 m^1.5/kg^0.5", "m^1.5/kg^0.5", 1.0), ("1 m^(3/2)/kg^(1/2)", "m^1.5/kg^0.5", 1.0),
    ("1 m³/(s·Pa)", "m^3/(s*Pa)", 1.0), ("5 Pa/√Hz", "Pa/Hz^0.5", 5.0),
    ("5 mPa/sqrt(Hz)", "Pa/Hz^0.5", 5e-3), ("5 Pa·s^0.5", "Pa/Hz^0.5", 5.0),
    ("0.4 µm/s/√Hz", "m/s/Hz^0.5", 4e-7), ("1 V", "kg*m^2/(s^3*A)", 1.0), ("1 kgf/cm^2", "Pa", 98066.5),
    ("1 lbf/in^2", "psi", 1.0), ("1 psi", "Pa", 6894.757293168361336), ("1 galUS/min", "L/min", 3.785411784),
    ("32 cSt", "mm^2/s", 32.0), ("1 atm", "hPa", 1013.25), ("160 barg", "Pa", 16e6),
    ("160 bara", "Pa", 16e6 - 101_325.0), ("1013.25 mbar(a)", "Pa", 0.0), ("500 kPa (abs)", "Pa", 398_675.0),
    ("500 kPa(g)", "Pa", 5e5), ("1 psig", "Pa", 6894.757293168361336),
])  # fmt: skip
def test_a_quantity_is_read_in_si(text, unit, expected):
    assert parse_quantity(text, unit) == expected


def test_every_spelling_of_a_quantity_gives_the_same_float():
    spellings = ["0.00012 m^3/min", "0.12 L/min", "120 mL/min", "2 mL/s", "2e-6 m³/s", "7.2 L/h"]
    assert len({parse_quantity(text, "m^3/s") for text in spellings}) == 1


@pytest.mark.parametrize(
    "text",
    ["551 bar·s", "551 kg", "3 rad", "551 MPa^2", "1 %",
     "", "MPa", "551 MPaa", "551 M Pa/", "five MPa", "1 (Pa", "1 Pa)", "1 /", "1 Pa//s", "1 ^2", "nan", "inf",
     "0x10 Pa", "1,5 MPa", "1 Pa^(1/0)", "1 Pa⁻", "1 Pa^2^2", "1 Pa^99999999999", "1 GPa^100.5",
     "1 Pa/√", "1 √√Pa", "1 √Pa^2", "1 " + "m" * 100_000, "1 " + "N·" * 50_000, "١ Pa", "1 Pa^١"],
)  # fmt: skip
def test_what_is_no_pressure_is_refused_as_a_mistake_of_the_user(text):
    with pytest.raises(ValueError):  # noqa: PT011
        parse_quantity(text, "Pa")


@given(st.text(max_size=30) | st.text("kgmsPaN√^-·*/()²³⁻0123456789.% ", max_size=24).map("1 {}".format))
def test_no_text_raises_anything_but_a_value_error(text):
    with contextlib.suppress(ValueError):
        parse_quantity(text, "Pa")


@pytest.mark.parametrize(("text", "unit", "meant"), [
    ("1.2 GPA", "Pa", "'GPa'"), ("30 bars", "Pa", "'bar'"), ("0.1 lpm", "m^3/s", "'L/min'"),
    ("633 mm2", "m^2", "'mm²'"), ("20 mpa", "Pa", "'MPa' or 'mPa'?"), ("3 N-s/m", "N*s/m", "'N·s/m'"),
])  # fmt: skip
def test_misspelt_units_get_the_one_that_they_may_stand_for(text, unit, meant):
    with pytest.raises(ValueError, match=f"did you mean {re.escape(meant)}"):
        parse_quantity(text, unit)


@given(st.floats(-1e12, 1e12), st.sampled_from(["MPa", "kPa", "bar", "psi"]))
def test_what_is_converted_comes_back_a_bare_number_as_it_is_and_what_is_no_number_too(value, unit):
    again = convert(parse_quantity(f"{value!r} {unit}", "Pa"), unit)
    assert again == pytest.approx(value, rel=1e-14, abs=1e-300)
    assert parse_quantity(repr(value), "Pa") == value
    assert math.isnan(convert(math.nan, unit))
    assert convert(math.inf, unit) == math.inf


def test_values_of_sections_axes_and_distributions_are_remembered_with_their_units(tmp_path, experiment_file):
    over = "friction.velocity_threshold: {normal: [900 um/s, 9 um/s]}, supply.pressure: {uniform: ±5 bar}"
    sample = f"sweep: {{sample: {{count: 4, over: {{{over}}}}}}}"
    units = load_experiment(experiment_file(f"name: own\nfluid: {{bulk_modulus: 1.2 GPa}}\n{sample}\n")).units
    assert units == {
        "fluid.bulk_modulus": "GPa", "friction.velocity_threshold": "um/s", "supply.pressure": "bar",
    }  # fmt: skip
    assert " µm" in run("plan", "experiment.yaml", cwd=tmp_path).stdout


def test_the_nearer_file_wins_a_setting_wins_over_it_and_stated_units_have_to_fit(tmp_path, experiment_file):
    (tmp_path / "base.yaml").write_text("fluid: {bulk_modulus: 551 MPa}\nsupply: {pressure: 17 MPa}")
    file = experiment_file("extends: base.yaml\nname: own\nfluid: {bulk_modulus: 5510 bar}")
    assert load_experiment(file).units == {"fluid.bulk_modulus": "bar", "supply.pressure": "MPa"}
    settings = ["fluid.bulk_modulus=80000 psi", "sweep.grid.valve.lap=[0.01 mm, 0.02 mm]"]
    units = load_experiment(file, settings).units
    assert units == {"fluid.bulk_modulus": "psi", "supply.pressure": "MPa", "valve.lap": "mm"}
    stated = "units: {fluid.bulk_modulus: GPa}\nfluid: {bulk_modulus: 551 MPa}"
    assert load_experiment(experiment_file(stated)).units == {"fluid.bulk_modulus": "GPa"}
    for wrong in ("fluid.bulk_modulus: L/min", "fluid.law: bar"):
        with pytest.raises(ConfigError, match=r"experiment\.yaml:2: units"):
            load_experiment(experiment_file(f"name: own\nunits: {{{wrong}}}"))


PRESS = """
name: press
fluid: {bulk_modulus: 12000 bar}
record: {duration: 2 s}
store: {signals: none}
sweep: {grid: {fluid.bulk_modulus: [8000 bar, 12000 bar], friction.velocity_threshold: [1 mm/s, 2 mm/s]}}
"""


def test_the_unit_is_no_part_of_what_a_run_is_nor_of_what_programs_read(tmp_path):
    one, other = (load_experiment({"fluid": {"bulk_modulus": text}}) for text in ("551 MPa", "5510 bar"))
    assert one.units != other.units
    assert expand_runs(one).runs[0].request == expand_runs(other).runs[0].request
    rows = run_json("report", sweep_in(tmp_path, PRESS).directory, cwd=tmp_path)["rows"]
    assert {row["bulk_modulus_MPa"] for row in rows} == {800.0, 1200.0}
    assert {row["labels"]["friction.velocity_threshold"] for row in rows} == {1e-3, 2e-3}
