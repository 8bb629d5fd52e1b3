"""With a fleet, a few windows of a machine give limits that keep their rate over its machines."""

from math import log, sqrt

import numpy as np
import pytest
from scipy.stats import norm, t

import hydrofdi
from hydrofdi.detectors.file import Fleet
from hydrofdi.detectors.limits import fleet_limits, fleet_of, posterior
from hydrofdi.errors import ConfigError, DataError, NotStatedError
from hydrofdi.evaluation.scores import Direction

MEAN, TAU, LOG, OMEGA = 5.0, 3.0, 0.2, 0.5
TRUE = Fleet(n_machine=100, mean=MEAN, mean_deviation=TAU, log_deviation=LOG, log_deviation_deviation=OMEGA)


def machines(draw, n, per_machine):
    means, deviations = draw.normal(MEAN, TAU, (n, 1)), np.exp(draw.normal(LOG, OMEGA, (n, 1)))
    return means, deviations, means + deviations * draw.standard_normal((n, per_machine))


def rates_and_cover(direction, n_own, n_repeat=200, n_fleet=100):
    """True rates of machines that are each drawn with a fleet, and how many intervals contain them."""
    rates, n_held = [], 0
    for seed in range(n_repeat):
        draw = np.random.default_rng(seed)
        scores = machines(draw, n_fleet, 6)[2]
        fleet = fleet_of(scores.ravel(), np.repeat(np.arange(n_fleet), 6))
        (((mean,),), ((deviation,),), own) = machines(draw, 1, n_own)
        limits, _ = fleet_limits(own[0], fleet, direction, 0.01, 0.95)
        below = 0.0 if limits.low is None else norm.cdf((limits.low - mean) / deviation)
        rates.append(below + (0.0 if limits.high is None else norm.sf((limits.high - mean) / deviation)))
        n_held += limits.interval[0] <= rates[-1] <= limits.interval[1]
    return np.array(rates), n_held / n_repeat


@pytest.mark.parametrize("direction", Direction)
@pytest.mark.parametrize("n_own", [1, 5])
def test_machines_of_a_fleet_keep_the_rate_and_the_interval(direction, n_own):
    rates, share = rates_and_cover(direction, n_own)
    assert share == pytest.approx(0.95, abs=3.0 * sqrt(0.95 * 0.05 / 200))
    assert rates.mean() == pytest.approx(0.01, abs=3.0 * rates.std() / sqrt(200))
    if (direction, n_own) == (Direction.RISING, 5):
        rates, share = rates_and_cover(direction, n_own, n_fleet=6)
        assert share > 0.95 - 3.0 * sqrt(0.95 * 0.05 / 200), "with few machines it is wider"
        assert rates.mean() < 0.02


def test_a_fleet_is_recovered_from_its_scores_and_fewer_than_five_machines_are_none():
    scores = machines(np.random.default_rng(0), 2000, 5)[2].ravel()
    found = fleet_of(scores, np.repeat(np.arange(2000), 5))
    assert found.mean == pytest.approx(MEAN, abs=4.0 * TAU / sqrt(2000))
    assert found.mean_deviation == pytest.approx(TAU, rel=0.07)
    assert found.log_deviation == pytest.approx(LOG, abs=0.06)
    assert found.log_deviation_deviation == pytest.approx(OMEGA, rel=0.1)
    scores, of = np.arange(20.0), np.repeat(np.arange(5), 4)
    assert fleet_of(scores, of) is not None
    assert fleet_of(scores[4:], of[4:]) is fleet_of(scores, np.arange(20)) is None


def test_of_equally_noisy_machines_the_limit_is_the_conjugate_one_of_unknown_ones_that_of_student():
    fleet = TRUE.model_copy(update={"log_deviation": log(2.0), "log_deviation_deviation": 1e-9})
    own = np.array([4.0, 9.0, 7.0])
    precision = 1.0 / TAU**2 + 3.0 / 4.0
    mean = (MEAN / TAU**2 + own.sum() / 4.0) / precision
    expected = mean + norm.isf(0.01) * sqrt(4.0 + 1.0 / precision)
    assert posterior(own, fleet).high(0.01) == pytest.approx(expected, rel=1e-6)
    nothing = {"mean": 0.0, "mean_deviation": 1e4, "log_deviation": 0.0, "log_deviation_deviation": 30.0}
    own = np.random.default_rng(1).normal(50.0, 2.0, 20)
    student = own.mean() + t.isf(0.01, 19) * own.std(ddof=1) * sqrt(1.0 + 1.0 / 20.0)
    assert posterior(own, TRUE.model_copy(update=nothing)).high(0.01) == pytest.approx(student, rel=0.01)


def test_with_many_own_windows_the_limit_is_their_own():
    own = np.random.default_rng(1).normal(MEAN + 4.0 * TAU, 0.2, 20_000)
    limits, scale = fleet_limits(own, TRUE, Direction.RISING, 0.01, 0.95)
    assert limits.high == pytest.approx(own.mean() + norm.isf(0.01) * own.std(), abs=0.01)
    assert scale.spread == pytest.approx(0.2, rel=0.02)
    assert limits.interval == pytest.approx((0.01, 0.01), rel=0.1)


def records(seed, n_machine, n_window):
    draw = np.random.default_rng(seed)
    of_machines, own = draw.standard_normal((n_machine, 1)), draw.standard_normal((n_machine, n_window))
    levels = np.repeat(85e5 + 3e4 * of_machines + 1e4 * own, 50, axis=1)
    return levels + 1e3 * draw.standard_normal(levels.shape)


OWN = records(1, 1, 5)
STATED = {"indicator": "pressure_statistics", "output": "mean", "direction": "rising", "window": "1 s"}


def train(data=OWN, **more):
    return hydrofdi.train(data, **{"sampling_frequency": 50} | more)


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    path = tmp_path_factory.mktemp("fleet") / "fleet.json"
    train(records(0, 30, 10), **STATED, out=path)
    return path


def test_training_states_both_sources_and_the_file_is_read_again(fleet, tmp_path):
    path = tmp_path / "own.json"
    with pytest.raises(NotStatedError):
        train(**STATED)
    detector = train(fleet=fleet, out=path)
    assert detector.file.limits.interval_rests_on == "fleet"
    assert "5 own windows and the fleet fleet.json, 30 machines" in detector.summary
    again = hydrofdi.Detector.load(path)
    assert again.file == detector.file
    low, high = again.file.limits.interval
    assert low < 0.01 < high
    assert bool(again.judge(OWN + 2e5, sampling_frequency=50)["beyond_limit"].all())
    assert train(fleet=fleet, false_alarm_rate="5 %").file.limits.high < detector.file.limits.high
    with pytest.raises(ConfigError, match="is not a fleet"):
        train(fleet=path)


def test_enough_own_windows_need_no_fleet_and_its_score_is_used_as_it_was_learned(fleet, tmp_path):
    detector = train(records(1, 1, 120), fleet=fleet)
    assert detector.file.limits.interval_rests_on == "windows"
    assert "fleet" not in detector.summary
    config = {"indicators": {"p": {"kind": "pressure_statistics"}},
              "score": {"kind": "largest_change", "of": ["p.mean", "p.standard_deviation"]}}  # fmt: skip
    learned = train(records(0, 30, 10), config=config, window="1 s", out=tmp_path / "fleet.json").file.score
    assert train(fleet=tmp_path / "fleet.json").file.score == learned


@pytest.mark.parametrize(("error", "words", "more"), [
    (ConfigError, "fleet: .*direction", {"direction": "falling"}),
    (ConfigError, "fleet", {"indicator": "dwt"}), (DataError, "50 Hz", {"sampling_frequency": 100}),
])  # fmt: skip
def test_other_settings_than_those_of_the_fleet_are_refused(fleet, error, words, more):
    with pytest.raises(error, match=words):
        train(fleet=fleet, **more)
