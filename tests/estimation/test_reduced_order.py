"""The residual of the volume balance: what it is, what moves it, and how long it remembers."""

import numpy as np
import pytest

from estimation.matched import CYLINDER, matched_signals, moving
from hydrofdi.indicators.catalogue.observers import N_SUM, SPOOL, SUPPLY, Bounds, project

MODULUS, FREQUENCY, EVERY, N_BLOCK = 689e6, 1000.0, 100, 20
LEAKS = 2e-9, 8e-9
EXACT = Bounds(0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def two():
    """Signals of the smaller and of the larger leak."""
    return [matched_signals(moving, leak, MODULUS, 4.0, FREQUENCY) for leak in LEAKS]


def projected(signals, unclear=None, cylinder=CYLINDER, modulus=MODULUS, bounds=EXACT):
    """K_i and bound, each (n_instant,)."""
    n_time = signals.shape[2]
    skipped = np.zeros((1, n_time), dtype=bool) if unclear is None else unclear
    sums, blocks = np.zeros(N_SUM), np.zeros((1, N_BLOCK, N_SUM))
    estimates = np.empty((2, 1, n_time // EVERY))
    project(
        signals, skipped, cylinder, 1.0 / modulus, bounds, 1.0 / FREQUENCY, sums, blocks, EVERY, estimates
    )
    return estimates[:, 0]


ERRORS = {
    "bulk_modulus": (1e-4, {"modulus": MODULUS / 1.0001}),
    "flow_gain": (1e-4, {"cylinder": CYLINDER._replace(flow_gain=1.0001 * CYLINDER.flow_gain)}),
    "supply": (1e-4, {}),
    "offset": (1e-10, {}),
}


@pytest.mark.parametrize("name", ERRORS)
def test_the_bound_is_what_an_error_does_to_the_residual(two, name):
    """Of a small error of each parameter, by differences."""
    size, wrong = ERRORS[name]
    signals, moved = two[0], two[0].copy()
    if name == "supply":
        moved[SUPPLY] *= 1.0 + size
    if name == "offset":
        moved[SPOOL] -= size
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
    both = np.concatenate(two, axis=2)
    skipped = np.zeros((1, both.shape[2]), dtype=bool)
    skipped[0, two[0].shape[2]] = True
    joined, alone = projected(both, skipped)[0], projected(two[1])[0]
    np.testing.assert_allclose(joined[-N_BLOCK:], alone[-N_BLOCK:], rtol=1e-12)
    between = joined[two[0].shape[2] // EVERY + N_BLOCK // 2]
    assert 1.2 * LEAKS[0] < between < 0.9 * LEAKS[1]


def test_blocks_in_which_no_sample_counts_leave_the_window_as_it_was(two):
    skipped = np.zeros((1, two[0].shape[2]), dtype=bool)
    skipped[0, :500], skipped[0, 3000:3500] = True, True
    coefficient, _ = projected(two[0], skipped)
    assert np.isnan(coefficient[:5]).all()
    assert np.isfinite(coefficient[5:]).all()
    np.testing.assert_array_equal(coefficient[29:35], coefficient[29])


def test_a_missing_sample_costs_the_windows_that_hold_it(two):
    signals = two[0].copy()
    signals[0, 0, 1050] = np.nan
    lost = np.flatnonzero(np.isnan(projected(signals)[0]))
    np.testing.assert_array_equal(lost, np.arange(10, 10 + N_BLOCK))
