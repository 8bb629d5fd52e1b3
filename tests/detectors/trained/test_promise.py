"""What an alarm comes to: expected alarms, mean flow with its interval, drift, chance or not."""

import pytest

from hydrofdi.detectors.promise import consequence
from hydrofdi.detectors.verdicts import Leak
from tests.detectors.trained.made import detector

FLOW = 1e-3 / 60.0  # 1 L/min
LEAK = Leak(FLOW, 0.2 * FLOW)
AREA = {"data_sheet": {"piston_area": 2e-3}}


def numbers(leak, **more):
    return consequence(detector("flow_balance").model_copy(update=more), 100, 30, leak)


def test_an_alarm_states_the_mean_flow_with_its_interval_and_drifts_with_the_area():
    text, found = numbers(LEAK, **AREA)
    assert found["drift_mm_per_min"] == pytest.approx(FLOW / 2e-3 * 6e4) == pytest.approx(500.0)
    assert found["flow_L_per_min"] == pytest.approx(1.0)
    assert found["flow_interval_L_per_min"] == pytest.approx([0.6, 1.4])
    assert "a mean leak of 1 L/min (0.6 to 1.4), a drift of 500 mm/min" in text
    text, found = numbers(Leak(-FLOW, FLOW), **AREA)
    assert "of 0 L/min" in text
    assert found["drift_mm_per_min"] == found["flow_interval_L_per_min"][0] == 0.0
    assert numbers(LEAK, assumed=("piston_area",))[1]["drift_mm_per_min"] is None
    assert numbers(None)[1]["flow_L_per_min"] is numbers(None, **AREA)[1]["drift_mm_per_min"] is None


def test_only_what_chance_does_not_explain_is_news():
    file = detector()
    rate = file.limits.false_alarm_rate
    assert consequence(file, 1000, 1, None)[1]["false_alarms_expected"] == pytest.approx(1000 * rate)
    few, many = (consequence(file, 100, alarms, None)[1]["recommendation"] for alarms in (1, 60))
    assert few.startswith("this may be chance")
    assert many.startswith("more than chance explains")
    assert consequence(file, 100, 1, None, margin=-11.0)[1]["recommendation"] == many
