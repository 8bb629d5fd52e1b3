"""Observers of an actuator that is known to the last digit: its energy falls, residuals are its leak."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydrofdi.indicators.catalogue import observers
from hydrofdi.indicators.catalogue.observers import COEFFICIENT, COMPRESSIBILITY, SPOOL, SUPPLY, Bounds
from hydrofdi.physics.cylinder import chamber_pressure_rates, internal_leakage_flow

CYLINDER = observers.Cylinder(633e-6, 633e-6, 280e-6, 280e-6, 0.0292, 20.75e-3, 0.0)
LEAK, MODULUS, NOMINAL = 5e-9, 689e6, 551e6
RATE, INJECTION, EVERY, N_BLOCK = 4000.0, 200.0, 100, 20


def matched_signals(leak, modulus, duration, frequency):
    """Signals (5, 1, n_time) of the very equations that observers hold, of a piston without mass."""

    def spool(time):
        return 20e-6 * np.sin(2 * np.pi * 0.7 * time) + 15e-6 * np.sin(2 * np.pi * 4.3 * time + 1.0)

    def rates(time, state):
        p1, p2, x = state
        q1, q2 = observers.nominal_flows(spool(time), p1, p2, 17.2e6, CYLINDER)
        speed = (CYLINDER.area_1 * (p1 - p2) - 150e3 * x) / 5e4
        swept, lost = CYLINDER.area_1 * speed, internal_leakage_flow(p1 - p2, leak)
        net = q1 - swept - lost, swept + lost - q2
        return *chamber_pressure_rates(x, *net, modulus, 280e-6, 280e-6, 633e-6, 633e-6), speed

    time = np.arange(round(duration * frequency)) / frequency
    start, accurate = (9e6, 8e6, 0.0), {"rtol": 1e-9, "atol": 1e-6, "max_step": 5e-3}
    p1, p2, x = solve_ivp(rates, (0.0, time[-1]), start, "RK45", time, **accurate).y
    return np.stack([p1, p2, x, spool(time), 17.2e6 + 0.0 * time])[:, None]


def law(leakage_time=0.3, compressibility_time=0.3, injection=INJECTION):
    """Quick ones, for short records."""
    drawn, volume = injection / NOMINAL, CYLINDER.volume_1
    gains = drawn * volume / (2 * 8e6 * leakage_time), drawn / (2 * volume * 20e6**2 * compressibility_time)
    return observers.AdaptationLaw(1 / RATE, injection, *gains, 1e-10, 1e-8, 1e-6)


def adapted(signals, chosen, unclear=False):
    """States (n_time, 4) behind each sample."""
    n_time = signals.shape[2]
    state, states = np.zeros((1, observers.N_STATE)), np.empty((1, n_time, 4))
    state[0, COMPRESSIBILITY] = 1.0 / NOMINAL
    unclear = np.full((1, n_time), unclear)
    observers.adapt(np.ascontiguousarray(signals), unclear, CYLINDER, chosen, 1, state, states)
    return states[0]


def lyapunov_function(signals, states, chosen):
    """W [J], shape (n_time,)."""
    c, swept = 1.0 / MODULUS, CYLINDER.area_1 * signals[observers.POSITION, 0]
    e1, e2 = states[:, observers.ERROR_1], states[:, observers.ERROR_2]
    of_errors = c * ((CYLINDER.volume_1 + swept) * e1**2 + (CYLINDER.volume_2 - swept) * e2**2)
    of_leakage = (LEAK - states[:, COEFFICIENT]) ** 2 / chosen.leakage_gain
    return 0.5 * (
        of_errors + of_leakage + (c - states[:, COMPRESSIBILITY]) ** 2 / chosen.compressibility_gain
    )


@pytest.fixture(scope="module")
def excited():
    return matched_signals(LEAK, MODULUS, 6.0, RATE)


@pytest.mark.parametrize(
    ("times", "injection"), [((0.3, 0.3), 200.0), ((0.05, 1.0), 50.0), ((1.5, 3.0), 200.0)]
)
def test_the_lyapunov_function_never_rises(excited, times, injection):
    """But where the spool passes its centre within an interval: a kink of the flow, which samples blunt."""
    chosen = law(*times, injection)
    states = adapted(excited, chosen)
    energy = lyapunov_function(excited, states, chosen)
    rises, passes = np.diff(energy) / energy[0], np.diff(np.sign(excited[SPOOL, 0])) != 0
    assert rises[~passes].max() < 2e-7
    assert np.maximum(rises, 0.0).sum() < 1e-3
    assert energy[-1] < 0.9 * energy[0]
    if times == (0.3, 0.3):
        assert states[-1, COEFFICIENT] == pytest.approx(LEAK, rel=2e-3)
        assert 1.0 / states[-1, COMPRESSIBILITY] == pytest.approx(MODULUS, rel=0.01)


def test_what_is_not_physical_or_missing_ends_the_estimates_even_where_nothing_is_learned(excited):
    states = adapted(excited, law()._replace(most_coefficient=1e-9))
    first = int(np.flatnonzero(np.isnan(states[:, COEFFICIENT]))[0])
    assert np.isnan(states[first:, [COEFFICIENT, COMPRESSIBILITY]]).all()
    assert np.abs(states[:first, COEFFICIENT]).max() <= 1e-9
    signals = excited[:, :, :100].copy()
    signals[observers.P1, 0, 60] = np.nan
    lost = np.isnan(adapted(signals, law(), unclear=True)[:, 2:].T)
    np.testing.assert_array_equal(lost, np.tile(np.arange(100) >= 60, (2, 1)))


EXACT = Bounds(0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def two():
    """Signals of a smaller and of a larger leak."""
    return [matched_signals(leak, MODULUS, 4.0, 1000.0) for leak in (2e-9, 8e-9)]


def projected(signals, skipped=(), cylinder=CYLINDER, modulus=MODULUS, bounds=EXACT):
    """K_i and bound of the residual, each (n_instant,)."""
    unclear = np.zeros((1, signals.shape[2]), dtype=bool)
    for samples in skipped:
        unclear[0, samples] = True
    sums, blocks = np.zeros(observers.N_SUM), np.zeros((1, N_BLOCK, observers.N_SUM))
    estimates, wide = np.empty((2, 1, signals.shape[2] // EVERY)), (bounds, 1e-3, sums, blocks, EVERY)
    observers.project(signals, unclear, cylinder, 1.0 / modulus, *wide, estimates)
    return estimates[:, 0]


@pytest.mark.parametrize(
    ("name", "size", "wrong"),
    [
        ("bulk_modulus", 1e-4, {"modulus": MODULUS / 1.0001}),
        ("flow_gain", 1e-4, {"cylinder": CYLINDER._replace(flow_gain=1.0001 * CYLINDER.flow_gain)}),
        ("supply", 1e-4, {}), ("offset", 1e-10, {}),
    ],
)  # fmt: skip
def test_the_bound_is_what_an_error_does_to_the_residual(two, name, size, wrong):
    """Of a small error of each parameter, by differences."""
    signals, moved = two[0], two[0].copy()
    moved[SUPPLY] *= 1.0 + size * (name == "supply")
    moved[SPOOL] -= size * (name == "offset")
    _, bound = projected(signals, bounds=EXACT._replace(**{name: size}))
    change = projected(moved, **wrong)[0] - projected(signals)[0]
    np.testing.assert_allclose(np.abs(change[N_BLOCK:]), bound[N_BLOCK:], rtol=0.02, atol=1e-14)
    assert bound.max() > 1e-13


def test_bounds_add_up(two):
    every = Bounds(0.2, 0.03, 0.05, 0.4e-6)
    alone = (EXACT._replace(**{name: size}) for name, size in every._asdict().items())
    total = sum(projected(two[0], bounds=bounds)[1] for bounds in alone)
    np.testing.assert_allclose(projected(two[0], bounds=every)[1], total, rtol=1e-12)


def test_a_window_forgets_what_was_before_it(two):
    """But for the sample at which the second record begins."""
    joined, _ = projected(np.concatenate(two, axis=2), [4000])
    np.testing.assert_allclose(joined[-N_BLOCK:], projected(two[1])[0][-N_BLOCK:], rtol=1e-12)
    assert 1.2 * 2e-9 < joined[4000 // EVERY + N_BLOCK // 2] < 0.9 * 8e-9


def test_blocks_in_which_no_sample_counts_leave_the_window_and_a_missing_sample_costs_it(two):
    coefficient, _ = projected(two[0], [slice(500), slice(3000, 3500)])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(coefficient)), np.arange(5))
    np.testing.assert_array_equal(coefficient[29:35], coefficient[29])
    signals = two[0].copy()
    signals[0, 0, 1050] = np.nan
    lost = np.flatnonzero(np.isnan(projected(signals)[0]))
    np.testing.assert_array_equal(lost, np.arange(10, 10 + N_BLOCK))
