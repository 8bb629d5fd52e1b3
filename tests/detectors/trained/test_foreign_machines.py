"""Detectors of machines that are not the model: their sizes against the truth, and what they doubt."""

import numpy as np
import pytest

import hydrofdi
from tests.conftest import FOREIGN, needs_foreign

pytestmark = needs_foreign


def own(machine, indicator="weak_rls", rate="2 %", output=None, **options):
    settings = {"window": "10 s", "false_alarm_rate": rate, "output": output}
    source = FOREIGN / f"{machine}_history.yaml"
    return hydrofdi.train(source, {indicator: {"supply": "sum", **options}}, **settings)


@pytest.fixture(scope="module")
def gap():
    return own("gap", spool="command")


@pytest.mark.parametrize(
    ("machine", "flows"),
    [("gap", [0.171, 0.219, 1.074, 0.759, 1.068]), ("scored", [0.116, 0.167, 1.211, 0.780, 1.180])],
)
def test_an_alarm_on_a_gap_or_a_score_states_its_mean_flow(gap, machine, flows):
    detector = gap if machine == "gap" else own(machine, rate="5 %", spool="command")
    told, truth = detector.judge(FOREIGN / f"{machine}_test.yaml"), np.repeat(flows, 2) / 6e4
    assert all(told["alarm"])
    assert all(("gap" if machine == "gap" else "score") in cause for cause in told["cause"])
    flow, low, high = (np.array(told[name], dtype=float) for name in ("leak", "leak_low", "leak_high"))
    assert np.quantile(flow / truth, 0.1) > 0.7
    assert np.quantile(flow / truth, 0.9) < 1.4
    assert np.all((low < truth) & (truth < high))
    if machine == "gap":
        assert not any("compressib" in doubt or "misfit" in doubt for doubt in told["doubt"])
        doubts = gap.judge(FOREIGN / "gap_history.yaml")["doubt"].tolist()
        assert sum(doubt != "" for doubt in doubts) <= 2, "of 52 healthy windows"


def test_a_balance_without_position_trains_and_covers_possible_moduli_alone():
    detector = own("gap", "pressure_balance")
    low, high = detector.file.conditions["pressure_balance.bulk_modulus"]
    assert 0.1e9 <= low <= high <= 3e9
    assert "the data sheet does not fit" in detector.summary


def test_a_free_clearance_has_two_alarms_and_a_gap_alarms_by_the_total_flow():
    detector = own("gap", spool="command", clearance_deviation="2e-13 m^3/(s*Pa)")
    assert detector.name == "weak_rls.leakage or cross_port_leakage"
    told = detector.judge(FOREIGN / "gap_test.yaml")
    assert all(told["alarm"])
    assert all(cause.startswith("weak_rls.cross_port_leakage") for cause in told["cause"])
    assert not any(detector.judge(FOREIGN / "gap_history.yaml")["alarm"])
    assert own("gap", spool="command", output="leakage").file.config.score is None
