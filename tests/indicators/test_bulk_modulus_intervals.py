"""Stated intervals of β hold the truth where no chamber volume is just the nominal one."""

from statistics import NormalDist

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.records import Channel
from hydrofdi.simulation.batch import simulate_batch
from indicators.signals import P1, P2, U, batch, measured

MODULUS, VOLUME = 551e6, 280e-6
N_RECORD = 40
MOTIONS = {
    "open loop": ["record.duration=8 s"],
    "closed loop": [
        "record.duration=20 s", "control.law=pi", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", "load.random_force=1 kN", "load.random_period=0.5 s",
    ],
}  # fmt: skip
BLIND = {
    "weak_rls": {"spool": "command", "supply": "sum"},
    "flow_balance": {"spool": "command", "supply": "sum"},
    "pressure_balance": {"supply": "sum"},
    "ekf_joint": {"supply": "nominal"},
    "ukf_joint": {"supply": "nominal"},
}
KNOWN_VALVE = {"flow_gain_deviation": 0.0, "lap_deviation": 0.0}
"""Under a square wave, flow gain and lap would take up an error of the volume."""


def machines(settings):
    """Noisy records of machines that are nominal but for chamber volumes of ±2 %."""
    draw, normal = np.random.default_rng(12), NormalDist(VOLUME, 0.02 * VOLUME)
    volumes = [normal.inv_cdf((i + 0.5) / N_RECORD) for i in range(N_RECORD)]
    signals = simulate_batch(
        [
            load_experiment(None, [f"actuator.chamber_volume={volume} m^3", *settings]).nominal_parameters
            for volume in volumes
        ],
        [0.0] * N_RECORD,
    )
    exact = {
        P1: (signals.chamber_1_pressure, 5e3),
        P2: (signals.chamber_2_pressure, 5e3),
        Channel.PISTON_POSITION: (signals.piston_position, 10e-6),
        U: (signals.input_voltage, 0.0),
    }
    return batch(
        {
            channel: samples + size * draw.normal(size=samples.shape)
            for channel, (samples, size) in exact.items()
        }
    )


@pytest.fixture(scope="module")
def records():
    return {motion: machines(settings) for motion, settings in MOTIONS.items()}


@pytest.mark.parametrize(
    ("motion", "name", "options"),
    [
        ("open loop", "weak_rls", KNOWN_VALVE),
        ("open loop", "ekf_joint", {}),
        ("closed loop", "weak_rls", {}),
        ("closed loop", "ekf_joint", {}),
    ],
)
def test_intervals_hold_the_truth_as_often_as_they_say(records, motion, name, options):
    values, _ = measured(records[motion], name, **BLIND[name], **options)
    left = values["bulk_modulus"] - MODULUS
    assert 0.9 <= (np.abs(left) < 1.96 * values["bulk_modulus_error"]).mean() <= 0.99
    assert abs(left.mean()) < 0.5 * values["bulk_modulus_error"].mean()


@pytest.mark.parametrize("name", BLIND)
def test_the_deviation_of_the_volumes_changes_that_of_the_bulk_modulus_alone(records, name):
    few = records["open loop"].rows([0, 1])
    known, usual = (
        measured(few, name, **BLIND[name], chamber_volume_deviation=share)[0] for share in (0.0, 0.02)
    )
    expected = np.hypot(known["bulk_modulus_error"], 0.02 * known["bulk_modulus"])
    np.testing.assert_allclose(usual.pop("bulk_modulus_error"), expected, rtol=1e-12)
    for output, numbers in usual.items():
        np.testing.assert_array_equal(numbers, known[output], err_msg=output)
