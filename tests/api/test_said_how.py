"""Wrong first attempts, answered with how it is done."""

import pytest

import hydrofdi
from tests.commands import run

AXIS = ["0.5 GPa"]


@pytest.mark.parametrize(
    ("sweep", "sentence"),
    [
        ({"fluid.bulk_modulus": AXIS}, "sweep.fluid.bulk_modulus: put it under sweep.grid"),
        ({"fluid": {"bulk_modulus": AXIS}}, "sweep.fluid: put dotted parameters such as 'fluid."),
        ({"bulk_modulus": AXIS}, "parameters such as 'fluid.bulk_modulus' under sweep.grid"),
        ({"union": [{"fluid.bulk_modulus": AXIS}]}, "put it under sweep.union[0].grid"),
        ({"gird": {"fluid.bulk_modulus": AXIS}}, "sweep.gird: unknown key; did you mean 'grid'?"),
    ],
)
def test_a_parameter_beside_the_grid_of_a_sweep_belongs_in_it(sweep, sentence):
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        hydrofdi.plan({"name": "x", "sweep": sweep})
    assert sentence in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_a_file_says_it_with_its_line(tmp_path):
    (tmp_path / "x.yaml").write_text("name: x\nsweep:\n  fluid.bulk_modulus: [0.5 GPa]\n")
    told = run("plan", "x.yaml", cwd=tmp_path, check=2).stderr
    assert told == "hydrofdi: x.yaml:3: sweep.fluid.bulk_modulus: put it under sweep.grid\n"


def test_a_flow_in_the_place_of_the_file_of_calibrate_names_its_option(tmp_path):
    with pytest.raises(hydrofdi.HydrofdiError, match="is a leakage flow"):
        hydrofdi.calibrate("0.2 L/min")
    told = run("calibrate", "200 mL/min", cwd=tmp_path, check=2).stderr
    assert "--flow" in told
    assert "no such file" in run("calibrate", "rig.yaml", cwd=tmp_path, check=2).stderr


def test_a_detector_of_a_path_names_load():
    with pytest.raises(hydrofdi.HydrofdiError, match=r"hydrofdi\.Detector\.load\('d\.json'\)"):
        hydrofdi.Detector("d.json")
