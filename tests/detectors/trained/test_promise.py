"""What an alarm comes to: expected alarms, mean flow with its interval, drift, chance or not."""

import pytest

from hydrofdi.detectors.promise import consequence
from hydrofdi.detectors.verdicts import Leak
from tests.detectors.trained.made import detector

FLOW = 1e-3 / 60.0  # 1 L/min
LEAK = Leak(FLOW, 0.2 * FLOW)


def of_flow(**more):
    return detector("flow_balance").model_copy(update=more)


def test_an_alarm_states_the_mean_flow_with_its_interval_and_drifts_with_the_area():
    found = consequence(of_flow(data_sheet={"piston_area": 2e-3, "supply_pressure": 18e6}), 100, 30, LEAK)
    assert found.drift == pytest.approx(FLOW / 2e-3)
    assert found.to_dict()["flow_L_per_min"] == pytest.approx(1.0)
    assert found.to_dict()["flow_interval_L_per_min"] == pytest.approx([0.6, 1.4])
    assert found.to_dict()["drift_mm_per_min"] == pytest.approx(500.0)
    assert "a mean leak of 1 L/min (0.6 to 1.4), a drift of 500 mm/min" in found.sentences


def test_an_interval_does_not_reach_below_zero():
    assert Leak(FLOW, FLOW).interval == (0.0, pytest.approx(3.0 * FLOW))
    assert Leak(-FLOW, 0.1 * FLOW).interval == (0.0, 0.0)
    reversed_leak = Leak(-FLOW, FLOW)
    assert "of 0 L/min" in str(reversed_leak)
    assert consequence(of_flow(data_sheet={"piston_area": 2e-3}), 100, 30, reversed_leak).drift == 0.0


def test_an_assumed_area_gives_no_drift_and_a_score_without_a_flow_no_leak():
    assert consequence(of_flow(assumed=("piston_area",)), 100, 30, LEAK).drift is None
    found = consequence(detector(), 100, 30, None)
    assert found.leak is found.drift is found.to_dict()["flow_L_per_min"] is None


def test_only_what_chance_does_not_explain_is_news():
    file = detector()
    rate = file.limits.false_alarm_rate
    assert consequence(file, 1000, 1, None).false_alarms_expected == pytest.approx(1000 * rate)
    few, many = (consequence(file, 100, alarms, None).recommendation for alarms in (1, 60))
    assert few.startswith("this may be chance")
    assert many.startswith("more than chance explains")
    assert consequence(file, 100, 1, None, margin=-11.0).recommendation == many
