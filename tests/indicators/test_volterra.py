"""Volterra: coefficients of records, and their distance from healthy ones in a study."""

import numpy as np
import pytest

from indicators.observed import X
from indicators.signals import P1, P2, U, batch, measured
from tests.commands import run_json
from tests.conftest import REPOSITORY, sweep_in

STUDY = """\
name: far
extends: [{preset}]
record: {{duration: 6 s}}
position_sensor: {{noise: 10 um}}
study:
  population:
    seed: 3
    over: {{fluid.bulk_modulus: {{uniform: ±10 %}}, supply.pressure: {{uniform: ±1 %}}}}
  healthy: {{fit: 40, test: 20}}
  faults: {{leakage.internal_flow: [1 L/min], each: 10}}
detection: {{false_alarm_rate: 10 %, indicators: [volterra_x_u]}}
"""


def moved(n_record=3, n_time=4000):
    """Records in which the position follows the command, by a law that differs from record to record."""
    draw = np.random.default_rng(4)
    command = np.repeat(draw.uniform(-2.0, 2.0, (n_record, n_time // 100)), 100, axis=1)
    speed = np.linspace(0.04, 0.06, n_record)[:, None] * command
    pressure = 8.6e6 + 2e6 * command + draw.normal(0.0, 1e4, command.shape)
    return batch({U: command, X: np.cumsum(speed, axis=1) / 500.0, P1: pressure, P2: 17.2e6 - pressure})


@pytest.mark.parametrize("signal", ["position_rate", "load_pressure", "pressure"])
def test_coefficients_count_in_the_scales_that_are_given(signal):
    one = measured(moved(), "volterra", signal=signal, ridge=0.0)[0]
    scales = {"input_scale": "4 V", "pressure_scale": "17.2 MPa", "rate_scale": "0.2 m/s"}
    other = measured(moved(), "volterra", signal=signal, ridge=0.0, **scales)[0]
    factors = [0.5, 1.0, 1.0, 2.0, 2.0, 2.0]
    np.testing.assert_allclose(other["coefficients"], factors * one["coefficients"], atol=1e-7)
    np.testing.assert_allclose(other["left"], 0.5 * one["left"], rtol=1e-5, atol=1e-10)


def test_a_study_judges_the_distance_from_healthy_records(tmp_path):
    study = sweep_in(tmp_path, STUDY.format(preset=REPOSITORY / "configs/detectors/volterra.yaml"))
    report = run_json("report", study.directory)
    found = {each["indicator"]: each for each in report["detection"]}
    assert found["volterra_distance"]["pod"][0]["detected"] == 10
