"""The constant of a data sheet that is wrong is named where it alone explains the misfit."""

import pytest

from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.estimation.whole_record import likeliest_wrong, sentence
from indicators.signals import simulated
from tests.machines import LOOP, settings_of


@pytest.fixture(scope="module")
def healthy():
    """Two machines with valves that are not quite nominal, in closed loop."""
    return simulated(
        *settings_of(LOOP), "record.duration=10 s", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", "valve.lap=0.5 um", "valve.lap_leakage=1e-13 m^3/(s*Pa)", leaks=[0.0, 0.0],
        moduli=[500e6, 600e6],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "truth"),
    [
        ({}, None),
        ({"piston_area": "950 mm²"}, 633e-6),
        ({"flow_gain": 0.0205}, 0.0292),
        ({"area_gradient": "31 mm"}, 0.0195),
        ({"supply": "nominal", "supply_pressure": "25 MPa"}, 17.2e6),
    ],
)
def test_a_wrong_constant_is_named_with_the_value_that_fits(healthy, wrong, truth):
    options = make_indicators({"weak_rls": {"spool": "command", **wrong}})["weak_rls"].options
    found, name = likeliest_wrong(options, healthy), next(reversed(wrong), "")
    if not wrong:
        assert not found
    else:
        value = {each.name: each.value for each in found}[name.replace("area_gradient", "flow_gain")]
        assert value == pytest.approx(truth, rel=0.15)
        assert name in sentence(options, found)
