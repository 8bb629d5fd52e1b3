"""Recursive least squares whose prior stays: what its arithmetic keeps."""

import numpy as np

from hydrofdi.indicators.estimation.chamber_balance import COMPRESSIBILITY, N_UNKNOWN
from hydrofdi.indicators.estimation.weak_rls import N_ESTIMATE, follow_windows, new_scratch, new_state
from hydrofdi.transforms.regression import regress

ERROR = 4e-9


def equations(seed, n_window, n_chamber=2):
    """Columns, in units of the priors, with targets of known unknowns and errors."""
    draw = np.random.default_rng(seed)
    columns = draw.normal(size=(1, n_window, n_chamber, N_UNKNOWN)) * ERROR
    truth = draw.normal(size=N_UNKNOWN)
    targets = columns @ truth + ERROR * draw.normal(size=columns.shape[:3])
    return columns, targets, truth


def followed(
    columns, targets, due, memory=np.inf, deviations=None, counts=None, state=None, noise=0.0, modulus=1e-12
):
    """Estimates (n_instant, N_ESTIMATE) after so many windows."""
    deviations = np.ones(N_UNKNOWN) if deviations is None else deviations
    counts = np.ones(columns.shape[:2]) if counts is None else counts
    state = new_state(1, 1, columns.shape[2]) if state is None else state
    out = np.zeros((1, 1, len(due), N_ESTIMATE))
    follow_windows(
        columns, targets, counts, np.array(due), np.zeros((1, len(due), N_UNKNOWN)), deviations, ERROR,
        np.array([np.exp(-1.0 / memory)]), np.zeros(N_UNKNOWN), np.full((1, len(due)), noise), modulus,
        state, new_scratch(), out,
    )  # fmt: skip
    return out[0, 0]


def test_with_all_in_memory_the_estimates_are_those_of_one_regression():
    columns, targets, _ = equations(1, 400)
    found = followed(columns, targets, [400])[0]
    whole = regress(columns.transpose(0, 3, 2, 1), targets.transpose(0, 2, 1), np.ones(N_UNKNOWN), ERROR)
    np.testing.assert_allclose(found[:N_UNKNOWN], whole.values[0], rtol=1e-9)


def test_an_unknown_that_is_known_stays_and_has_no_error():
    columns, targets, _ = equations(2, 100)
    deviations = np.ones(N_UNKNOWN)
    deviations[[3, 7]] = 0.0
    found = followed(columns, targets, [100], deviations=deviations)[0]
    assert (found[[3, 7, N_UNKNOWN + 3, N_UNKNOWN + 7]] == 0.0).all()
    rest = np.delete(np.arange(N_UNKNOWN), [3, 7])
    whole = regress(
        columns.transpose(0, 3, 2, 1)[:, rest], targets.transpose(0, 2, 1), np.ones(len(rest)), ERROR
    )
    np.testing.assert_allclose(found[rest], whole.values[0], rtol=1e-9)


def test_what_is_not_excited_any_more_returns_to_its_prior():
    columns, targets, truth = equations(3, 4000)
    columns[:, 1000:, :, 4] = 0.0
    targets[:, 1000:] = columns[:, 1000:] @ truth
    at_once, late = followed(columns, targets, [1000, 4000], memory=100.0)
    assert abs(at_once[4] - truth[4]) < 0.5
    assert at_once[N_UNKNOWN + 4] < 0.2
    assert abs(late[4]) < 1e-6
    np.testing.assert_allclose(late[N_UNKNOWN + 4], 1.0, rtol=1e-6)
    np.testing.assert_allclose(np.delete(late[:N_UNKNOWN], 4), np.delete(truth, 4), atol=0.05)


def test_windows_that_do_not_count_only_let_time_pass():
    columns, targets, _ = equations(4, 60)
    counts = np.ones((1, 60))
    counts[0, 20:] = 0.0
    columns[:, 20:], targets[:, 20:] = np.nan, np.nan
    early, late = followed(columns, targets, [20, 60], counts=counts)
    np.testing.assert_array_equal(late[:N_UNKNOWN], early[:N_UNKNOWN])
    faded = followed(columns, targets, [20, 60], counts=counts, memory=10.0)
    assert (faded[1, N_UNKNOWN : 2 * N_UNKNOWN] > faded[0, N_UNKNOWN : 2 * N_UNKNOWN]).all()


def test_a_gap_is_a_status_from_then_on():
    columns, targets, _ = equations(5, 60)
    targets[0, 30, 0] = np.nan
    found = followed(columns, targets, [30, 31, 60])
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1:]).all()


def test_noise_in_the_column_of_the_bulk_modulus_is_taken_out():
    columns, targets, truth = equations(7, 40_000)
    size = 0.7 * ERROR
    noise = size * np.random.default_rng(8).normal(size=columns.shape[:3])
    shown = columns.copy()
    shown[..., COMPRESSIBILITY] += noise
    modulus = 0.1
    targets = targets - noise / modulus
    of_window = 2.0 * (size / ERROR) ** 2
    biased, found = (
        followed(shown, targets, [40_000], noise=each, modulus=modulus)[0] for each in (0.0, of_window)
    )
    left = found[COMPRESSIBILITY] - truth[COMPRESSIBILITY]
    assert abs(left) < 0.1
    assert abs(biased[COMPRESSIBILITY] - truth[COMPRESSIBILITY]) > 1.0
    overstated = followed(shown, targets, [40_000], noise=10.0 * of_window, modulus=modulus)[0]
    assert np.isfinite(overstated).all()
    assert overstated[N_UNKNOWN + COMPRESSIBILITY] > found[N_UNKNOWN + COMPRESSIBILITY]


def test_covariances_stay_positive_and_numbers_exact_over_a_million_samples():
    columns, targets, _ = equations(9, 62_500)
    state = new_state(1, 1, 2)
    long = followed(columns, targets, [62_500], memory=300.0, state=state)[0]
    fresh = followed(columns[:, -12_000:], targets[:, -12_000:], [12_000], memory=300.0)[0]
    np.testing.assert_allclose(long, fresh, rtol=1e-9)
    for kind, which in np.ndindex(2, 2):
        lower = np.tril(state.moments[0, 0, kind, which])
        assert np.linalg.eigvalsh(lower + np.tril(lower, -1).T).min() > 0.0
