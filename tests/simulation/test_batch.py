import numpy as np
import pytest

from hydrofdi.simulation.batch import simulate_batch

SIGNALS = (
    "input_voltage", "spool_position", "piston_position", "piston_velocity",
    "chamber_1_pressure", "chamber_2_pressure", "internal_leakage_flow",
)  # fmt: skip


def signals(trajectory, row=0):
    return np.array([getattr(trajectory, name)[row] for name in SIGNALS])


@pytest.fixture(scope="module")
def mixed(parameters):
    """33 different runs with three different drives, and their signals one by one."""
    runs = [
        parameters(
            f"fluid.bulk_modulus={400 + 13 * k} MPa", f"friction.viscous={20 + 10 * k}",
            f"input.amplitude={(1, 2, -2)[k % 3]}", f"actuator.mass={8 + 0.3 * k}",
        )
        for k in range(33)
    ]  # fmt: skip
    coefficients = [1e-9 * k for k in range(33)]
    alone = [signals(simulate_batch([run], [K_i])) for run, K_i in zip(runs, coefficients, strict=True)]
    return runs, coefficients, alone


@pytest.mark.parametrize("n_run", [5, 16, 33])
def test_a_run_has_the_same_bits_in_a_batch_of_any_size(mixed, n_run):
    runs, coefficients, alone = mixed
    batch = simulate_batch(runs[:n_run], coefficients[:n_run])
    for row in range(n_run):
        np.testing.assert_array_equal(signals(batch, row), alone[row])


def test_a_run_has_the_same_bits_in_any_lane(mixed):
    runs, coefficients, alone = mixed
    order = np.random.default_rng(1).permutation(33)
    batch = simulate_batch([runs[k] for k in order], [coefficients[k] for k in order])
    for row, k in enumerate(order):
        np.testing.assert_array_equal(signals(batch, row), alone[k])


def test_a_run_has_the_same_bits_whether_it_shares_its_spool_or_not(parameters):
    run, other = parameters(), parameters("valve.natural_frequency=150 Hz")
    shared = simulate_batch([run, run], [0.0, 1e-8])
    apart = simulate_batch([other, run, run], [0.0, 0.0, 1e-8])
    for row in (0, 1):
        np.testing.assert_array_equal(signals(shared, row), signals(apart, row + 1))


def test_a_run_that_diverges_leaves_its_neighbours_as_they_are(mixed, parameters):
    runs, coefficients, alone = mixed
    batch = simulate_batch([parameters("fluid.bulk_modulus=1e13"), *runs[:3]], [0.0, *coefficients[:3]])
    assert [outcome.status for outcome in batch.outcomes] == ["diverged", "ok", "ok", "ok"]
    for row in range(3):
        np.testing.assert_array_equal(signals(batch, row + 1), alone[row])


def test_a_longer_record_begins_with_the_shorter_one(parameters):
    short, long = (simulate_batch([parameters(f"record.duration={t} s")], [1e-8]) for t in (2, 3))
    np.testing.assert_array_equal(signals(long)[:, :1000], signals(short))


@pytest.mark.parametrize(
    ("settings", "status"),
    [
        (["fluid.bulk_modulus=1e13"], "diverged"),
        (["actuator.mass=0.1 g"], "diverged"),
        (["input.amplitude=10 V", "actuator.load_stiffness=0"], "stroke_exceeded"),
    ],
)
def test_a_run_that_goes_wrong_ends_with_a_class_and_a_sentence(parameters, settings, status):
    (outcome,) = simulate_batch([parameters(*settings)], [0.0]).outcomes
    assert outcome.status == status
    assert outcome.message
