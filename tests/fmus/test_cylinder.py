"""The FMU of the paper's cylinder, run by FMPy alone, is the cylinder of the kernel."""

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from hydrofdi.config import RunParameters
from hydrofdi.simulation.batch import simulate_batch
from tests.fmus.building import Recipe, build, needs_compiler

pytestmark = needs_compiler

COEFFICIENT = 6e-9
OUTPUTS = {
    "x": "piston_position", "v": "piston_velocity", "cyl.port_a.p": "chamber_1_pressure",
    "cyl.port_b.p": "chamber_2_pressure", "valve.x": "spool_position", "q_leak": "internal_leakage_flow",
}  # fmt: skip
BOTH = ("CoSimulation", "ModelExchange")


@pytest.mark.parametrize(
    ("recipe", "kind", "step", "tolerance"),
    [
        (Recipe(kinds=BOTH), "CoSimulation", "0.1 ms", 1e-9),
        (Recipe(version=3), "CoSimulation", "0.1 ms", 1e-9),
        # CVODE and a kernel whose own error does not matter.
        (Recipe(kinds=BOTH), "ModelExchange", "0.01 ms", 1e-5),
    ],
    ids=["2", "3", "exchange"],
)
def test_its_signals_are_those_of_the_kernel(recipe, kind, step, tolerance, tmp_path):
    run = {"fluid": {"bulk_modulus": "689 MPa"}, "record": {"duration": "4 s", "step": step}}
    own = simulate_batch([RunParameters.model_validate(run)], [COEFFICIENT])
    times, levels = np.repeat(range(5), 2)[1:-1].astype(float), np.tile([2.0, 2.0, -2.0, -2.0], 2)
    result = fmpy.simulate_fmu(
        build(tmp_path, recipe), fmi_type=kind, stop_time=4.0, output_interval=2e-3, record_events=False,
        input=np.rec.fromarrays([times, levels], names="time,u"), relative_tolerance=1e-10,
        start_values={"seal.k": COEFFICIENT, "oil.beta": 689e6}, output=[*OUTPUTS],
    )  # fmt: skip
    for name, signal in OUTPUTS.items():
        expected = getattr(own, signal)[0]
        assert result[name][:-1] == pytest.approx(expected, rel=0.0, abs=tolerance * np.abs(expected).max())


@pytest.mark.parametrize(
    "recipe",
    [
        Recipe(kinds=BOTH),
        Recipe(version=3),
        Recipe(units=(("", None),)),
        Recipe(units=(("cyl.port_a.p", "bar"), ("q_leak", "l/min"), ("x", "mm"), ("oil.T", "degC"))),
    ],
    ids=["2", "3", "no units", "other units"],
)
def test_its_description_follows_the_standard(recipe, tmp_path):
    assert validate_fmu(str(build(tmp_path, recipe))) == []
