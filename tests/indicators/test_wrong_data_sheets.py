"""Data sheets that are wrong are refused, or show in what the model-based indicators say of themselves."""

import numpy as np
import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from indicators.observed import noisy, simulated
from indicators.signals import U, measured

BLIND = {"spool": "command", "supply": "sum"}


@pytest.fixture(scope="module")
def healthy():
    """One healthy record of 8 s with sensor noise."""
    return noisy(simulated("record.duration=8 s", leaks=[0.0], moduli=[551e6]), 0, 1, seed=5)


@pytest.mark.parametrize("kind", ["weak_rls", "flow_balance", "adaptive_observer", "ekf_joint"])
@pytest.mark.parametrize(
    "option",
    [
        {"piston_area": 633},
        {"chamber_volume": "280 m^3"},
        {"bulk_modulus": "551 GPa"},
        {"supply_pressure": "17.2 GPa"},
    ],
)
def test_sizes_that_no_actuator_has_are_refused(kind, option):
    with pytest.raises(ConfigError, match="must be at most"):
        make_indicators({kind: option})


@pytest.mark.parametrize("option", ["supply_deviation", "flow_gain_deviation"])
def test_an_estimate_that_no_actuator_has_is_no_number(healthy, option):
    turned = healthy.rows([0])
    turned[U][:] *= -1.0
    values, (reason,) = measured(turned, "weak_rls", **BLIND, **{option: 1000.0})
    assert "not positive" in reason
    assert all(np.isnan(array).all() for array in values.values())


def test_every_estimate_of_the_valve_has_its_deviation(healthy):
    values, _ = measured(healthy, "weak_rls", **BLIND)
    truth = {"flow_gain": 1.0, "supply_pressure": 17.2e6, "offset": 0.0, "lap": 0.0, "clearance": 0.0}
    for name, true in truth.items():
        assert values[f"{name}_error"] > 0.0
        assert abs(values[name] - true) < 4.0 * values[f"{name}_error"], name


@pytest.mark.parametrize(("chambers", "misfit"), [("both", 1.05), (1, 2.0)])
def test_a_wrong_area_shows(healthy, chambers, misfit):
    right, _ = measured(healthy, "weak_rls", **BLIND, chambers=chambers)
    wrong, _ = measured(healthy, "weak_rls", **BLIND, chambers=chambers, piston_area="696 mm^2")
    assert right["misfit"] < 1.0
    assert right["departure"] < 1.5
    assert wrong["departure"] > 2.5
    assert wrong["misfit"] > misfit * right["misfit"]


def test_a_filter_of_the_wrong_plant_is_less_sure(healthy):
    right, _ = measured(healthy, "ekf_innovation", supply="nominal")
    wrong, _ = measured(healthy, "ekf_innovation", supply="nominal", piston_area="696 mm^2")
    assert wrong["nis"] > 1.5 > right["nis"]
    assert wrong["leakage_error"] > 1.2 * right["leakage_error"]
