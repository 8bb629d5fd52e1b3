"""Windows are judged alike, alone or among others, and what forbids to judge is said in numbers."""

import numpy as np
import pytest

from hydrofdi.detectors.trained.judging import Judge
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators import indicator_names
from hydrofdi.records import Channel
from tests.detectors.trained.made import detector, window

HEALTHY = [window(number, seed) for number, seed in enumerate(range(20))]
P1 = Channel.CHAMBER_1_PRESSURE


def judged(file, *windows):
    return Judge(file).judge(windows)


@pytest.mark.parametrize("name", indicator_names())
def test_a_window_is_judged_alike_alone_and_among_others(name):
    try:
        file = detector(name, direction="both", ranges=HEALTHY[:5])
    except ConfigError as refusal:
        pytest.skip(str(refusal))
    judge = Judge(file)
    windows = [*HEALTHY[:5], window(5, fault=Issue("is missing", kind="missing"))]
    together = judge.judge(windows)
    assert together == [judge.judge([each])[0] for each in windows]
    assert judge.judge(windows[::-1]) == together[::-1]
    assert judge.judge([]) == []


def test_scores_beyond_a_limit_are_alarms_and_those_on_it_are_not():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    (verdict,) = judged(detector(limits=(None, score), scale=(0.0, 2.0)), HEALTHY[0])
    assert (verdict.alarm, verdict.margin) == (False, 0.0)
    (verdict,) = judged(detector(limits=(None, score - 6.0), scale=(0.0, 2.0)), HEALTHY[0])
    assert verdict.alarm
    assert verdict.margin == pytest.approx(-3.0)
    (verdict,) = judged(detector(limits=(score - 6.0, score + 2.0), scale=(0.0, 2.0)), HEALTHY[0])
    assert not verdict.alarm
    assert verdict.margin == pytest.approx(1.0)
    (verdict,) = judged(detector(limits=(score + 4.0, None), scale=(0.0, 2.0)), HEALTHY[0])
    assert verdict.alarm
    assert verdict.margin == pytest.approx(-2.0)


def fault_of(*windows, **more):
    (verdict,) = judged(detector(ranges=HEALTHY, **more), *windows)
    assert verdict.alarm is None
    assert (verdict.score is None) == (verdict.margin is None) == (verdict.fault.kind != "novel")
    return verdict.fault


def test_faults_of_the_window_come_first():
    stated = Issue("came at 500 Hz instead of 1000 Hz", kind="other_rate")
    assert fault_of(window(n_sample=10, fault=stated, chamber_1_pressure=None)) is stated


@pytest.mark.parametrize(("limit", "is_beyond"), [(-1e9, True), (1e9, False)])
def test_a_novel_window_says_whether_its_score_is_beyond_the_limit(limit, is_beyond):
    novel = window(chamber_1_pressure=HEALTHY[0].channels[P1] + 20e6)
    (verdict,) = judged(detector(ranges=HEALTHY, limits=(None, limit)), novel)
    assert (verdict.alarm, verdict.is_beyond) == (None, is_beyond)


def test_other_windows_of_the_same_kind_are_not_novel():
    verdicts = judged(detector(ranges=HEALTHY), *(window(0, 1000 + seed) for seed in range(200)))
    assert all(verdict.fault is None for verdict in verdicts)


def test_a_score_far_out_on_the_side_without_an_alarm_is_novel():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    spread = 1e-3 * abs(score)
    for sign in (-1.0, 1.0):
        # Healthy scores reach five spreads from the median, so scores are novel from twenty spreads on.
        for place, is_novel in ((-4.0, False), (-2.0, False), (19.9, False), (20.1, True), (1e3, True)):
            centre = score - sign * place * spread
            limit = centre - sign * 3.0 * spread
            file = detector(
                limits=(None, limit) if sign < 0.0 else (limit, None),
                scale=(centre, spread),
                scores=(centre - 5.0 * spread, centre + 5.0 * spread),
            )
            (verdict,) = judged(file, HEALTHY[0])
            assert verdict.score == score
            if is_novel:
                assert (verdict.alarm, verdict.is_beyond, verdict.fault.kind) == (None, False, "novel")
            else:
                assert (verdict.alarm, verdict.fault) == (place < -3.0, None)


def test_with_limits_on_both_sides_no_score_is_far_out_without_an_alarm():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    middle = score + 9e5
    file = detector(limits=(score - 1e3, score + 1e6), scale=(middle, 1.0), scores=(middle - 1, middle + 1))
    (verdict,) = judged(file, HEALTHY[0])
    assert (verdict.alarm, verdict.fault) == (False, None)


@pytest.mark.parametrize(
    ("kind", "changed"),
    [
        ("clipped", {"chamber_1_pressure": np.minimum(HEALTHY[0].channels[P1], 10e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1] + 20e6}),
        ("novel", {"chamber_1_pressure": 9e6 + 1e-3 * (HEALTHY[0].channels[P1] - 9e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1]
                   + 2e5 * np.random.default_rng(1).standard_normal(1000)}),
    ],
)  # fmt: skip
def test_what_forbids_to_judge_has_its_kind_and_is_no_alarm(kind, changed):
    assert fault_of(window(**changed), limits=(None, -1e9)).kind == kind
