"""A shift may be relative to the nominal value of the actuator that it belongs to."""

import re
from pathlib import Path

import pytest
import yaml

import hydrofdi

TEMPLATES = Path(__file__).parents[2] / "configs" / "templates"


def _shift(fluid, value, name="fluid.bulk_modulus"):
    study = {"healthy": {"fit": 1, "test": 1}, "shifts": {"other": {name: value}}}
    loaded = hydrofdi.load_experiment({"fluid": fluid, "study": study})
    return loaded.study.shifts["other"][name]


@pytest.mark.parametrize(
    ("value", "expected"), [("+25 %", 1.125e9), ("-10%", 0.81e9), ("−10 %", 0.81e9), ("1 GPa", 1e9)]
)
def test_a_share_is_taken_of_the_own_bulk_modulus(value, expected):
    assert _shift({"bulk_modulus": "900 MPa"}, value) == pytest.approx(expected, rel=1e-12)


def test_a_share_of_a_number_without_unit_is_relative_as_well():
    assert _shift({}, "+25 %", "friction.scale") == 1.25


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("fluid.bulk_modulus", "+x %", "study.shifts.other.fluid.bulk_modulus: "),
        ("fluid.bulk_modulus", "+0 %", "+0 % changes nothing"),
        ("fluid.bulk_modulus", "-100 %", "must be greater than 0; found 0"),
        ("supply.return_pressure", "+5 %", "supply.return_pressure has 0; state the value itself"),
        ("control.law", "+5 %", "control.law has no number; state the value itself"),
        ("fluid.bulk_modulos", "+5 %", "no parameter 'fluid.bulk_modulos'; did you mean"),
    ],
)
def test_a_share_of_nothing_is_refused_with_its_place(name, value, message):
    with pytest.raises(hydrofdi.HydrofdiError, match=re.escape(message)):
        _shift({}, value, name)


@pytest.mark.parametrize("template", ["actuator.yaml", "online.yaml"])
@pytest.mark.parametrize("own", ["551 MPa", "900 MPa", "1.4 GPa"])
def test_the_stiffer_oil_of_a_template_is_stiffer_than_any_of_its_population(template, own, tmp_path):
    text = (TEMPLATES / template).read_text().replace("&bulk_modulus 551 MPa", f"&bulk_modulus {own}")
    assert own in yaml.safe_load(text)["fluid"]["bulk_modulus"]
    file = tmp_path / template
    file.write_text(text)
    study = hydrofdi.load_experiment(file).study
    _, highest = study.population.over["fluid.bulk_modulus"]["uniform"]
    assert study.shifts["stiffer"]["fluid.bulk_modulus"] > highest
