"""The adaptive observer: its Lyapunov function falls, and what is excited is found."""

import numpy as np
import pytest

from estimation.matched import CYLINDER, SUPPLY, matched_signals, moving
from hydrofdi.indicators.catalogue import observers

COEFFICIENT_TRUE, MODULUS_TRUE, MODULUS_NOMINAL = 5e-9, 689e6, 551e6
FREQUENCY, INJECTION = 4000.0, 200.0


def law(leakage_time=0.3, compressibility_time=0.3, injection=INJECTION, frequency=FREQUENCY):
    """Quick ones, for short records."""
    drawn, volume = injection / MODULUS_NOMINAL, CYLINDER.volume_1
    gains = drawn * volume / (2 * 8e6 * leakage_time), drawn / (2 * volume * 20e6**2 * compressibility_time)
    return observers.AdaptationLaw(1 / frequency, injection, *gains, 1e-10, 1e-8, 1e-6)


def followed(signals, chosen):
    """States (n_time, 4) behind each sample."""
    state = np.zeros((1, observers.N_STATE))
    state[0, observers.COMPRESSIBILITY] = 1.0 / MODULUS_NOMINAL
    n_time = signals.shape[2]
    states, clear = np.empty((1, n_time, 4)), np.zeros((1, n_time), dtype=bool)
    observers.adapt(np.ascontiguousarray(signals), clear, CYLINDER, chosen, 1, state, states)
    return states[0]


def lyapunov_function(signals, states, chosen):
    """W [J], shape (n_time,)."""
    c, swept = 1.0 / MODULUS_TRUE, CYLINDER.area_1 * signals[observers.POSITION, 0]
    e1, e2 = states[:, observers.ERROR_1], states[:, observers.ERROR_2]
    of_errors = c * ((CYLINDER.volume_1 + swept) * e1**2 + (CYLINDER.volume_2 - swept) * e2**2)
    of_leakage = (COEFFICIENT_TRUE - states[:, observers.COEFFICIENT]) ** 2 / chosen.leakage_gain
    return 0.5 * (
        of_errors + of_leakage + (c - states[:, observers.COMPRESSIBILITY]) ** 2 / chosen.compressibility_gain
    )


@pytest.fixture(scope="module")
def excited():
    return matched_signals(moving, COEFFICIENT_TRUE, MODULUS_TRUE, 6.0, FREQUENCY)


@pytest.mark.parametrize(
    ("times", "injection"), [((0.3, 0.3), 200.0), ((0.05, 1.0), 50.0), ((1.5, 3.0), 200.0)]
)
def test_the_lyapunov_function_never_rises(excited, times, injection):
    """But where the spool passes its centre within an interval: a kink of the flow, which samples blunt."""
    chosen = law(*times, injection=injection)
    states = followed(excited, chosen)
    energy = lyapunov_function(excited, states, chosen)
    rises, passes = np.diff(energy) / energy[0], np.diff(np.sign(excited[observers.SPOOL, 0])) != 0
    assert rises[~passes].max() < 2e-7
    assert np.maximum(rises, 0.0).sum() < 1e-3
    assert energy[-1] < 0.9 * energy[0]
    if times == (0.3, 0.3):
        assert states[-1, observers.COEFFICIENT] == pytest.approx(COEFFICIENT_TRUE, rel=2e-3)
        assert 1.0 / states[-1, observers.COMPRESSIBILITY] == pytest.approx(MODULUS_TRUE, rel=0.01)


def test_without_excitation_leakage_is_found_and_the_fluid_is_not():
    """A valve that stands open to one side and feeds the leak: the pressures rest."""
    spool, n_time = 10e-6, 8000
    opened = CYLINDER.flow_gain * CYLINDER.area_gradient * spool
    high = SUPPLY * (opened**2 + COEFFICIENT_TRUE**2) / (opened**2 + 2.0 * COEFFICIENT_TRUE**2)
    signals = np.tile(np.array([high, SUPPLY - high, 0.01, spool, SUPPLY])[:, None, None], n_time)
    chosen = law()
    states = followed(signals, chosen)
    energy = lyapunov_function(signals, states, chosen)
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert states[-1, observers.COEFFICIENT] == pytest.approx(COEFFICIENT_TRUE, rel=0.03)
    moduli = 1.0 / states[-1000:, observers.COMPRESSIBILITY]
    assert np.ptp(moduli) < 1e-3 * MODULUS_TRUE
    assert abs(moduli[-1] - MODULUS_TRUE) > 0.1 * MODULUS_TRUE


def test_a_sealed_actuator_of_the_nominal_fluid_has_no_leakage():
    signals = matched_signals(moving, 0.0, MODULUS_NOMINAL, 2.0, FREQUENCY)
    states = followed(signals, law())
    assert np.abs(states[:, observers.COEFFICIENT]).max() < 1e-3 * COEFFICIENT_TRUE
    np.testing.assert_allclose(1.0 / states[:, observers.COMPRESSIBILITY], MODULUS_NOMINAL, rtol=1e-3)


def test_what_is_not_physical_ends_the_estimates(excited):
    chosen = law()._replace(most_coefficient=1e-9)
    states = followed(excited, chosen)
    first = int(np.flatnonzero(np.isnan(states[:, observers.COEFFICIENT]))[0])
    assert np.isnan(states[first:, observers.COEFFICIENT]).all()
    assert np.isnan(states[first:, observers.COMPRESSIBILITY]).all()
    assert np.abs(states[:first, observers.COEFFICIENT]).max() <= 1e-9


def test_a_missing_sample_ends_the_estimates_even_where_nothing_is_learned(excited):
    signals, unclear = excited[:, :, :100].copy(), np.ones((1, 100), dtype=bool)
    signals[observers.P1, 0, 60] = np.nan
    state, estimates = np.full((1, observers.N_STATE), 1.0 / MODULUS_NOMINAL), np.empty((1, 100, 4))
    observers.adapt(signals, unclear, CYLINDER, law(), 1, state, estimates)
    np.testing.assert_array_equal(np.isnan(estimates[0, :, 2:].T), np.tile(np.arange(100) >= 60, (2, 1)))
