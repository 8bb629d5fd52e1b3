"""Draws follow their distributions, stay within their limits, and depend on each other as the file says."""
# ruff: noqa: E501

import math

import numpy as np
import pytest
from scipy import stats

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError

COUNT = 4096
METHODS = ["sobol", "lhs", "random"]


def drawn(over, *, method="sobol", seed=1, more="", count=COUNT):
    """The drawn values, parameter by parameter."""
    sample = f"sweep.sample={{method: {method}, count: {count}, seed: {seed}, over: {over}{more}}}"
    runs = expand_runs(load_experiment(None, [sample])).runs[:count]
    names = load_experiment(None, [sample]).sweep.names
    return [np.array(runs.values(name)) for name in names]


LAWS = {
    "uniform: [40, 60]": stats.uniform(40, 20),
    "loguniform: [1, 100]": stats.loguniform(1, 100),
    "normal: [50, 5]": stats.norm(50, 5),
    "truncated_normal: [50, 20, 45, 90]": stats.truncnorm(-0.25, 2.0, loc=50, scale=20),
    "truncated_normal: [5, 1, 50, 60]": stats.truncnorm(45, 55, loc=5, scale=1),
    "lognormal: [50, 1.5]": stats.lognorm(math.log(1.5), scale=50),
    "triangular: [10, 20, 60]": stats.triang(0.2, loc=10, scale=50),
    "triangular: [10, 10, 60]": stats.triang(0.0, loc=10, scale=50),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", LAWS)
def test_draws_follow_their_distribution(law, method):
    (values,) = drawn(f"{{friction.viscous: {{{law}}}}}", method=method)
    distance = stats.kstest(values, LAWS[law].cdf).statistic
    assert distance < (2.0 / math.sqrt(COUNT) if method == "random" else 2.0 / COUNT)


@pytest.mark.parametrize("method", METHODS)
def test_limited_draws_stay_within_their_limits(method):
    over = "{friction.viscous: {truncated_normal: [50, 1 kN·s/m, 45, 60]}, actuator.mass: {triangular: [9, 9, 9.1]}}"
    viscous, mass = drawn(over, method=method)
    assert (viscous.min(), viscous.max()) == pytest.approx((45, 60), abs=0.1)
    assert viscous.min() >= 45
    assert viscous.max() <= 60
    assert mass.min() >= 9
    assert mass.max() <= 9.1


def test_deviations_have_the_unit_of_the_parameter_and_factors_have_none():
    (values,) = drawn("{fluid.bulk_modulus: {truncated_normal: [600 MPa, 20 MPa, 0.5 GPa, 0.7 GPa]}}")
    assert values.std() == pytest.approx(20e6, rel=0.01)
    (values,) = drawn("{fluid.bulk_modulus: {lognormal: [600 MPa, 1.1]}}")
    assert np.median(values) == pytest.approx(600e6, rel=1e-3)
    assert np.quantile(values, 0.8413) / 600e6 == pytest.approx(1.1, rel=1e-3)


OVER = (
    "{friction.viscous: {lognormal: [50, 1.5]}, actuator.mass: {uniform: [9, 15]},"
    " fluid.bulk_modulus: {triangular: [500 MPa, 551 MPa, 900 MPa]}}"
)
CORRELATED = (
    ", correlation: {parameters: [fluid.bulk_modulus, friction.viscous], matrix: [[1, -0.6], [-0.6, 1]]}"
)


@pytest.mark.parametrize("method", METHODS)
def test_correlated_draws_have_the_rank_correlation_of_the_gaussian_copula(method):
    viscous, mass, modulus = drawn(OVER, method=method, more=CORRELATED)
    expected = 6.0 / math.pi * math.asin(-0.6 / 2.0)
    assert stats.spearmanr(viscous, modulus).statistic == pytest.approx(expected, abs=0.03)
    assert stats.spearmanr(viscous, mass).statistic == pytest.approx(0.0, abs=0.05)
    assert stats.spearmanr(modulus, mass).statistic == pytest.approx(0.0, abs=0.05)


def test_correlated_draws_keep_their_distributions_and_leave_the_others_alone():
    viscous, mass, modulus = drawn(OVER, more=CORRELATED)
    assert np.array_equal(mass, drawn(OVER)[1])
    assert stats.kstest(viscous, stats.lognorm(math.log(1.5), scale=50).cdf).statistic < 0.01
    assert stats.kstest(modulus, stats.triang(51 / 400, loc=500e6, scale=400e6).cdf).statistic < 0.01


def test_normal_draws_are_correlated_as_the_matrix_says():
    over = "{friction.viscous: {normal: [50, 2]}, actuator.mass: {normal: [12, 1]}, friction.coulomb: {normal: [200, 9]}}"
    names = "friction.viscous, actuator.mass, friction.coulomb"
    matrix = [[1, 0.5, -0.3], [0.5, 1, 0.2], [-0.3, 0.2, 1]]
    values = drawn(over, more=f", correlation: {{parameters: [{names}], matrix: {matrix}}}")
    np.testing.assert_allclose(np.corrcoef(values), matrix, atol=0.02)


MISTAKES = [
    ("{friction.viscous: {truncated_normal: [50, 1]}}", ""),
    ("{friction.viscous: {truncated_normal: [50, 0, 1, 2]}}", ""),
    ("{friction.viscous: {truncated_normal: [50, 1, 2, 1]}}", ""),
    ("{friction.viscous: {lognormal: [50, 1]}}", ""),
    ("{friction.viscous: {lognormal: [50, 2 kg]}}", ""),
    ("{friction.viscous: {triangular: [1, 3, 2]}}", ""),
    ("{friction.viscous: {trianglar: [1, 2, 3]}}", ""),
    (OVER, "[friction.viscous], matrix: [[1]]"),
    (OVER, "[friction.viscous, friction.viscous], matrix: [[1, 0], [0, 1]]"),
    (OVER, "[friction.viscous, actuator.mass], matrix: [[1, 0.2]]"),
    (OVER, "[friction.viscous, actuator.mass], matrix: [[1, 0.2], [0.1, 1]]"),
    (OVER, "[friction.viscous, actuator.mass], matrix: [[2, 0.2], [0.2, 1]]"),
    (OVER, "[friction.viscous, actuator.mass], matrix: [[1, 1], [1, 1]]"),
    (OVER, "[friction.viscous, actuator.mass], matrix: [[1, .nan], [.nan, 1]]"),
    (OVER, "[friction.viscous, actuator.mas], matrix: [[1, 0], [0, 1]]"),
]


@pytest.mark.parametrize(("over", "correlation"), MISTAKES)
def test_mistaken_distributions_and_correlations_are_reported(over, correlation):
    more = f", correlation: {{parameters: {correlation}}}" if correlation else ""
    with pytest.raises(ConfigError, match="correlation" if correlation else "viscous"):
        drawn(over, more=more)
