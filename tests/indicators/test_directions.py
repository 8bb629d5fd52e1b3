"""Directions: leakage moves an output as its definition says."""

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import RecordBatch
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.store.records import SIGNAL_OF_CHANNEL

LEAKS = [0.0, 1e-9, 5e-9, 1.3e-8]


@pytest.fixture(scope="module")
def square():
    nominal = load_experiment(None, ["record.duration=6 s"]).nominal_parameters
    trajectory = simulate_batch([nominal] * len(LEAKS), LEAKS)
    signals = {channel: getattr(trajectory, signal) for channel, signal in SIGNAL_OF_CHANNEL.items()}
    return RecordBatch(signals, nominal.record.sampling_frequency, tuple("abcd"), drive_period=2.0)


@pytest.mark.parametrize(
    "name",
    [
        "dwt.d2", "dwt.d3", "envelope.decay_rate", "flow_balance.leakage",
        "flow_balance.internal_coefficient", "post_step_ac.rms",
        "post_step_ac.relative", "ring_down.damping_ratio",
    ],
)  # fmt: skip
def test_a_growing_leak_moves_an_output_in_its_direction(square, name):
    label = name.partition(".")[0]
    (indicator,) = make_indicators([label]).values()
    direction = next(o.direction for o in indicator.outputs if f"{label}.{o.name}" == name)
    change = np.diff(measure(square, {label: indicator}).values[name])
    assert ({"rising": change, "falling": -change}[direction] > 0.0).all()
