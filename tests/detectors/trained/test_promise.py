"""What an alarm comes to: expected alarms, flow at rated pressure, drift, and whether chance explains it."""

import pytest

from hydrofdi.detectors.trained.promise import consequence
from tests.detectors.trained.made import detector

FLOW = 0.4e-3 / 60.0


def of_flow(output="leakage", **more):
    return detector("flow_balance", output=output).model_copy(update=more)


def test_a_flow_grows_with_the_root_of_the_rated_pressure_and_drifts_with_the_area():
    sheet = {"piston_area": 2e-3, "supply_pressure": 18e6}
    found = consequence(of_flow(data_sheet=sheet), 100, 30, FLOW)
    assert found.flow == pytest.approx(1.5 * FLOW)  # 18 MPa instead of 8 MPa
    assert found.drift == pytest.approx(1.5 * FLOW / 2e-3)
    assert found.to_dict()["flow_L_per_min"] == pytest.approx(0.6)
    assert found.to_dict()["drift_mm_per_min"] == pytest.approx(300.0)
    assert "0.6 L/min at 18 MPa, a drift of 300 mm/min" in found.sentences


def test_a_mean_flow_is_that_of_no_pressure_and_an_assumed_area_gives_no_drift():
    found = consequence(of_flow("mean_leakage", assumed=("piston_area",)), 100, 30, FLOW)
    assert found.flow == FLOW
    assert found.pressure_difference is found.drift is None


def test_a_score_that_is_no_flow_has_none():
    found = consequence(detector(), 100, 30, 2e5)
    assert found.flow is found.drift is None


def test_only_what_chance_does_not_explain_is_news():
    file = detector()
    rate = file.limits.false_alarm_rate
    assert consequence(file, 1000, 1, None).false_alarms_expected == pytest.approx(1000 * rate)
    few, many = (consequence(file, 100, alarms, None).recommendation for alarms in (1, 60))
    assert few.startswith("this may be chance")
    assert many.startswith("more than chance explains")
    assert consequence(file, 100, 1, None, margin=-11.0).recommendation == many
    assert "doubtful" in consequence(file, 100, 60, None, doubt="it leaks air").recommendation
