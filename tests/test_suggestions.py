"""Suggestions for unknown names."""

from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from hydrofdi.settings.synonyms import _SYNONYMS
from hydrofdi.units import parse_quantity

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


def test_every_synonym_leads_to_a_key_that_exists() -> None:
    known = " ".join(path.read_text() for path in CONFIGURATION.glob("*.md"))
    missing = [key for key in _SYNONYMS if f"`{key}`" not in known]
    assert not missing


def test_an_axis_under_another_name_gets_the_one_that_means_it(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\nsweep: {grid: {fluid.EBM: [551 MPa, 1 GPa]}}\n")
    with pytest.raises(ConfigError, match=r"did you mean 'fluid\.bulk_modulus'"):
        load_experiment(file)
