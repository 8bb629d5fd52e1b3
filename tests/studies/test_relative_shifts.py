"""A shift may be relative to the nominal value of the actuator that it belongs to."""

from pathlib import Path

import pytest
import yaml

import hydrofdi

TEMPLATES = Path(__file__).parents[2] / "configs" / "templates"


def _shift(fluid, value, name="fluid.bulk_modulus"):
    study = {"healthy": {"fit": 1, "test": 1}, "shifts": {"other": {name: value}}}
    loaded = hydrofdi.load_experiment({"fluid": fluid, "study": study})
    return loaded.study.shifts["other"][name]


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


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("fluid.bulk_modulus", "+25 %", 1.125e9), ("fluid.bulk_modulus", "-10%", 0.81e9),
        ("fluid.bulk_modulus", "−10 %", 0.81e9), ("fluid.bulk_modulus", "1 GPa", 1e9),
        ("friction.scale", "+25 %", 1.25),
    ],
)  # fmt: skip
def test_a_share_is_taken_of_the_own_value(name, value, expected):
    assert _shift({"bulk_modulus": "900 MPa"}, value, name) == pytest.approx(expected, rel=1e-12)
