"""The extended Kalman filter with the leakage among its states."""

from dataclasses import replace

import numpy as np
import pytest
from estimation.plants import simulated
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.indicators.models.ekf_joint import EkfJoint, JointOptions
from hydrofdi.records import Channel
from indicators.signals import P1, P2, U, batch

X, XV, PS = Channel.PISTON_POSITION, Channel.SPOOL_POSITION, Channel.SUPPLY_PRESSURE
LEAKS = (0.0, 0.1, 0.5)
BEHIND = {"transient": 1.0}


def noisy(signals, seed=0, noise=1.0):
    """Runs with noise of the pressures and the position."""
    draw = np.random.default_rng(seed)
    shape = signals.piston_position.shape
    return batch(
        {
            P1: signals.chamber_1_pressure + noise * 5.3e3 * draw.normal(size=shape),
            P2: signals.chamber_2_pressure + noise * 5.3e3 * draw.normal(size=shape),
            X: signals.piston_position + noise * 1e-5 * draw.normal(size=shape),
            XV: signals.spool_position,
            U: signals.input_voltage,
        }
    )


@pytest.fixture(scope="module")
def runs():
    """Nominal runs of 4 s with three leaks."""
    return noisy(simulated(["record.duration=4 s"], LEAKS))


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(1, 900), min_size=1, max_size=8), st.sampled_from(["command", "measured"]))
def test_a_stream_gives_the_estimates_of_the_record_to_the_bit(runs, lengths, spool):
    ekf = EkfJoint(JointOptions(spool=spool))
    whole = ekf.trace(runs)
    state, parts, first = ekf.start(runs), [], 0
    for length in [*lengths, runs.n_time]:
        chunk = replace(runs.window(first, first + length), start_time=first / runs.sampling_frequency)
        before = {name: array.copy() for name, array in state.items()}
        later, trace = ekf.step(state, chunk)
        for name, array in before.items():
            np.testing.assert_array_equal(state[name], array)
        state, first = later, first + chunk.n_time
        parts.append(trace)
        if first >= runs.n_time:
            break
    np.testing.assert_allclose(np.concatenate([part.time for part in parts]), whole.time, rtol=1e-12)
    for name, values in whole.values.items():
        joined = np.concatenate([part.values[name] for part in parts], axis=1)
        np.testing.assert_array_equal(joined, values, err_msg=name)
