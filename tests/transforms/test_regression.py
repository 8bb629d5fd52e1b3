import numpy as np

from hydrofdi.transforms.regression import regress


def test_the_estimates_are_those_of_numpy_and_the_condition_that_of_scaled_columns():
    draw = np.random.default_rng(1)
    columns, target = (
        draw.normal(size=(4, 3, 2, 50)) * [[[[1.0]], [[1e6]], [[1e-5]]]],
        draw.normal(size=(4, 2, 50)),
    )
    found = regress(columns, target)
    for row in range(4):
        rows = columns[row].reshape(3, -1).T
        np.testing.assert_allclose(
            found.values[row], np.linalg.lstsq(rows, target[row].ravel())[0], rtol=1e-9
        )
        scaled = rows / np.linalg.norm(rows, axis=0)
        np.testing.assert_allclose(found.condition[row], np.linalg.cond(scaled), rtol=1e-9)


def test_the_deviations_are_those_of_repeats_with_white_errors_and_with_errors_that_go_along():
    draw = np.random.default_rng(2)
    columns = np.repeat(np.cumsum(draw.normal(size=(1, 2, 1, 400)), axis=-1), 2000, axis=0)
    for weights in ([1.0], [0.5, 0.5]):
        errors = draw.normal(size=(2000, 1, 401))
        errors = sum(w * errors[..., k : k + 400] for k, w in enumerate(weights))
        found = regress(columns, 3.0 * columns[:, 0] - 2.0 * columns[:, 1] + errors)
        np.testing.assert_allclose(found.values.mean(axis=0), [3.0, -2.0], rtol=1e-2)
        ratio = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)).mean(axis=0) / found.values.std(
            axis=0
        )
        assert (np.abs(ratio - 1.0) < 0.2).all()


def test_columns_that_tell_nothing_give_no_estimate():
    columns = np.ones((3, 2, 1, 30))
    columns[0, 1], columns[1, 0] = 0.0, np.nan
    with np.errstate(all="ignore"):
        found = regress(columns, np.ones((3, 1, 30)))
    assert np.isnan(found.values[:2]).all()
    assert not np.isfinite(found.condition[2]) or found.condition[2] > 1e7


def test_with_priors_it_is_least_squares_with_an_equation_more_for_each_unknown():
    draw = np.random.default_rng(3)
    columns, target = draw.normal(size=(2, 3, 1, 20)), draw.normal(size=(2, 1, 20))
    prior, error = np.array([np.inf, 0.5, 1e-3]), 0.7
    found = regress(columns, target, prior, error)
    for row in range(2):
        rows = np.concatenate((columns[row, :, 0].T, np.diag(error / prior)))
        expected = np.linalg.lstsq(rows, np.append(target[row], np.zeros(3)))[0]
        np.testing.assert_allclose(found.values[row], expected, rtol=1e-9)


def test_an_unknown_that_nothing_moves_keeps_its_prior():
    columns = np.zeros((1, 2, 1, 30))
    columns[0, 0] = np.linspace(1.0, 2.0, 30)
    found = regress(columns, 2.0 * columns[:, 0], np.array([np.inf, 0.25]), 0.1)
    np.testing.assert_allclose(found.values, [[2.0, 0.0]], atol=1e-12)
    total, deviation = found.combined(np.array([0.0, 2.0]))
    np.testing.assert_allclose((total, deviation), ([0.0], [0.5]), atol=1e-12)


def test_equations_that_leave_much_are_weighed_down():
    draw = np.random.default_rng(4)
    columns = draw.normal(size=(3, 2, 1, 300))
    target = 2.0 * columns[:, 0] - columns[:, 1] + 0.01 * draw.normal(size=(3, 1, 300))
    target[:, 0, ::10] += 5.0
    columns[:, :, 0, ::7], target[:, 0, ::7] = 0.0, 0.0
    plain, robust = regress(columns, target), regress(columns, target, n_reweighting=4)
    assert (np.abs(robust.values - [2.0, -1.0]) < 5e-3).all()
    assert (np.abs(plain.values - [2.0, -1.0]).max(axis=1) > 5e-2).all()
    alone = regress(columns[1:2], target[1:2], n_reweighting=4)
    np.testing.assert_array_equal(alone.values[0], robust.values[1])
