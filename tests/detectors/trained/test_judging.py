"""Windows are judged alike, alone or among others, and what forbids to judge is said in numbers."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hydrofdi
from hydrofdi.detectors.rules import make_chart
from hydrofdi.detectors.trained.configuration import DetectorConfig, Feature, feature_of
from hydrofdi.detectors.trained.detector import Detector
from hydrofdi.detectors.trained.file import Made
from hydrofdi.detectors.trained.lines import WindowLine
from hydrofdi.detectors.trained.measuring import Estimator, records_of
from hydrofdi.detectors.trained.training import train
from hydrofdi.detectors.trained.verdicts import Verdict, channel_facts, findings, learned_range
from hydrofdi.errors import Issue
from hydrofdi.indicators import indicator_kind, indicator_names
from hydrofdi.indicators.recursive import RecursiveIndicator, Trace
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.streams import Chunk
from tests.detectors.trained.healthy import Records
from tests.detectors.trained.made import FREQUENCY, detector, pressure, signals, window, with_chart, written

HEALTHY = [window(number, seed) for number, seed in enumerate(range(20))]
P1 = Channel.CHAMBER_1_PRESSURE


def judged(file, *windows):
    return Detector(file).score(windows)


@pytest.mark.parametrize("name", indicator_names())
def test_a_window_is_judged_alike_alone_and_among_others(name):
    number = {"output": "coefficients[5]"} if name == "volterra" else {}  # its other outputs are arrays
    file = detector(name, direction="both", ranges=HEALTHY[:5], **number)
    trained = Detector(file)
    windows = [*HEALTHY[:5], window(5, fault=Issue("is missing", kind="missing"))]
    together = trained.score(windows)
    assert together == [trained.score([each])[0] for each in windows]
    assert trained.score(windows[::-1]) == together[::-1]
    assert trained.score([]) == []


@pytest.mark.parametrize(
    ("below", "above", "margin"), [(None, 0.0, 0.0), (None, -6.0, -3.0), (6.0, 2.0, 1.0), (-4.0, None, -2.0)]
)
def test_scores_beyond_a_limit_are_alarms_and_those_on_it_are_not(below, above, margin):
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    limits = None if below is None else score - below, None if above is None else score + above
    (verdict,) = judged(detector(limits=limits, scale=(0.0, 2.0)), HEALTHY[0])
    assert (verdict.alarm, verdict.margin) == (margin < 0.0, pytest.approx(margin))


def fault_of(*windows, **more):
    (verdict,) = judged(detector(ranges=HEALTHY, **more), *windows)
    assert verdict.alarm is None
    assert (verdict.score is None) == (verdict.margin is None) == (verdict.fault.kind != "novel")
    return verdict.fault


def test_faults_of_the_window_come_first():
    stated = Issue("came at 500 Hz instead of 1000 Hz", kind="other_rate")
    assert fault_of(window(n_sample=10, fault=stated, chamber_1_pressure=None)) is stated


def test_a_novel_window_says_whether_its_score_is_beyond_the_limit_and_usual_ones_are_not_novel():
    novel = window(chamber_1_pressure=HEALTHY[0].channels[P1] + 20e6)
    usual = [window(0, 1000 + seed) for seed in range(200)]
    for limit, is_beyond in ((-1e9, True), (1e9, False)):
        verdict, *others = judged(detector(ranges=HEALTHY, limits=(None, limit)), novel, *usual)
        assert (verdict.alarm, verdict.is_beyond) == (None, is_beyond)
        assert all(other.fault is None for other in others)


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
        ("stuck", {"chamber_1_pressure": np.full(1000, 9e6)}),
        ("stuck", {"chamber_1_pressure": np.repeat(HEALTHY[0].channels[P1][::2], 2)}),
        ("clipped", {"chamber_1_pressure": np.minimum(HEALTHY[0].channels[P1], 10e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1] + 20e6}),
        ("novel", {"chamber_1_pressure": 9e6 + 1e-3 * (HEALTHY[0].channels[P1] - 9e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1]
                   + 2e5 * np.random.default_rng(1).standard_normal(1000)}),
    ],
)  # fmt: skip
def test_what_forbids_to_judge_has_its_kind_and_is_no_alarm(kind, changed):
    assert fault_of(window(**changed), limits=(None, -1e9)).kind == kind


def test_a_channel_that_is_constant_in_healthy_windows_may_be():
    constant = {"chamber_1_pressure": np.full(1000, 9e6)}
    (verdict,) = judged(
        detector(ranges=[window(number, **constant) for number in range(5)]), window(**constant)
    )
    assert verdict.fault is None


SCORES = 10.0 + 2.0 * np.random.default_rng(5).standard_normal(60) + np.repeat([0.0, 3.0], 30)
OPTIONS = {"direction": "rising"}


def charted(direction="rising", limit=6.0):
    bound = {"rising": (None, 1e9), "falling": (-1e9, None)}[direction]
    file = detector(limits=bound, scale=(10.0, 2.0), direction=direction)
    return with_chart(file, limit=limit, **OPTIONS)


def readings(file, verdicts):
    detector, state, found = Detector(file), {"memory": np.zeros((1, 2))}, []
    for verdict in verdicts:
        state, reading = detector._reading(state, verdict)
        found.append(reading)
    return found


def judged_charting(scores):
    return [Verdict(score, False, 1.0) for score in scores.tolist()]


@pytest.mark.parametrize(("direction", "scores"), [("rising", SCORES), ("falling", 20.0 - SCORES)])
def test_it_is_the_chart_of_standardised_scores(direction, scores):
    found = readings(charted(direction), judged_charting(scores))
    expected = make_chart("cusum", OPTIONS).follow((SCORES - 10.0)[None] / 2.0, 6.0)[0]
    np.testing.assert_array_equal([reading.statistic for reading in found], expected)
    assert [reading.alarm for reading in found] == (expected >= 6.0).tolist()
    assert any(reading.alarm for reading in found[30:])
    assert not any(reading.alarm for reading in found[:30])


def test_what_is_not_judged_passes_it_by():
    novel = Verdict(1e6, None, None, Issue("is novel", kind="novel"))
    lost = Verdict(None, None, None, Issue("is missing", kind="missing"))
    mixed = [each for verdict in judged_charting(SCORES) for each in (novel, verdict, lost)]
    found = readings(charted(), mixed)
    assert found[1::3] == readings(charted(), judged_charting(SCORES))
    assert all(reading.statistic is None and not reading.alarm for reading in found[::3] + found[2::3])


def test_healthy_records_of_a_day_set_up_a_chart_unless_none_is_wanted():
    means = np.random.default_rng(5).standard_normal((20, 5))
    number = {"indicator": "pressure_statistics", "output": "mean", "direction": "both"}
    for frequency, stated, has_chart in (
        (0.004, {}, True),
        (0.004, {"chart": None}, False),
        (4.0, {}, False),
    ):
        window = {"window": {"duration": 4.0 / frequency}}
        config = DetectorConfig.model_validate({**number, **window, "false_alarm_rate": 0.1, **stated})
        records = Records(means, sampling_frequency=frequency)
        file = train(records, config, ["records"], Made(hydrofdi="1", time="now"))
        assert (file.chart is not None) is has_chart
        assert file.config.chart is None or file.config.chart.false_alarm_every == 86400.0


NAMES = [name for name in indicator_names() if issubclass(indicator_kind(name), RecursiveIndicator)]
FOLLOWED = {"interval": 0.05, "transient": 0.2}
SLIDING = {"of": "dwt", "output": "d2", "window": 0.1}
N_SAMPLE = 1000
CUTS = st.lists(st.integers(1, N_SAMPLE - 1), max_size=5).map(lambda cuts: sorted({0, *cuts, N_SAMPLE}))


def follower_of(name="weak_rls", **options):
    more = {"options": FOLLOWED | options, "direction": "both", "window": {"by": "estimate"}}
    return Detector(detector(name, limits=(-1e300, 1e300), **more))


def piece(first=0, stop=N_SAMPLE, begins_anew=None, lost=(), start=0.0):
    """Samples of a stream; those at the places `lost` have no P1."""
    rows = {channel: samples.copy() for channel, samples in signals(3).items()}
    rows[Channel.CHAMBER_1_PRESSURE][list(lost)] = np.nan
    time = start + np.arange(N_SAMPLE) / FREQUENCY
    part = {channel: samples[first:stop] for channel, samples in rows.items()}
    return Chunk(time[first:stop], part, begins_anew=first == 0 if begins_anew is None else begins_anew)


def followed(follower, *pieces):
    state, instants, verdicts = follower.start(), [], []
    for each in pieces:
        state, found = follower.step(state, each)
        lines = [line for line in found if isinstance(line, WindowLine)]
        instants += [line.end for line in lines]
        verdicts += [line.verdict for line in lines]
    return instants, verdicts


class Forgetful(indicator_kind("sliding")):
    """A sliding number that is lost for good from an instant on, as that of a filter which diverged."""

    lost_from = 0.5

    def step(self, state, chunk):
        after, trace = super().step(state, chunk)
        values = {name: np.where(trace.time >= self.lost_from, np.nan, v) for name, v in trace.values.items()}
        return after, Trace(trace.time, values)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=8, deadline=None)
@given(cuts=CUTS, lost=st.sets(st.integers(0, N_SAMPLE - 1), max_size=3))
def test_verdicts_do_not_depend_on_the_pieces(name, cuts, lost):
    follower = follower_of(name)
    pieces = [piece(first, stop, lost=lost) for first, stop in pairwise(cuts)]
    assert followed(follower, *pieces) == followed(follower, piece(lost=lost))


@pytest.mark.parametrize("name", NAMES)
def test_estimates_are_those_of_the_record_after_the_transient(name):
    feature = feature_of(detector(name, options=FOLLOWED, direction="both", window={"by": "estimate"}).config)
    channels = tuple(sorted(feature.indicator.channels))
    estimator = Estimator(feature, channels, FREQUENCY)
    _, found = estimator.step(estimator.start(), piece())
    trace = feature.indicator.trace(records_of([window(seed=3)], channels, FREQUENCY)).since(0.2 - 1e-9)
    scores, times = [each.numbers[0] for _, each in found], [piece().time[place] for place, _ in found]
    np.testing.assert_array_equal(scores, trace.values[feature.described.name][0])
    assert all(np.isfinite(each.numbers[0]) == (each.fault is None) for _, each in found)
    np.testing.assert_allclose(times, trace.time, rtol=0, atol=1e-12)
    assert times[0] >= 0.2 - 1e-9


def test_it_begins_anew_behind_a_gap():
    follower = follower_of()
    once = followed(follower, piece())
    again = followed(follower, piece(0, 700), piece(begins_anew=True, start=50.0))
    assert again[1][-len(once[1]) :] == once[1]
    np.testing.assert_allclose(again[0][-len(once[0]) :], np.array(once[0]) + 50.0, atol=1e-9)


def test_missing_samples_are_said_once_and_the_estimates_begin_anew_behind_them():
    instants, verdicts = followed(follower_of(), piece(lost=range(400, 420)))
    (place,) = (place for place, verdict in enumerate(verdicts) if verdict.fault is not None)
    assert verdicts[place].fault.kind == "missing"
    assert "chamber_1_pressure" in verdicts[place].fault.message
    assert instants[place] == 0.4
    assert instants[place + 1] == pytest.approx(0.42 + 0.2, abs=0.05)
    alone = followed(follower_of(), piece(420, begins_anew=True))[1]
    assert verdicts[place + 1 :] == alone


def test_an_indicator_that_lost_its_score_for_good_begins_anew_and_says_so():
    options = SLIDING | {"interval": 0.01, "transient": 0.1, "window": 0.1}
    made = Forgetful(Forgetful.Options.model_validate(options))
    feature = Feature(
        {made.name: made}, {f"{made.name}.{made.estimates[0].name}": (made.name, made.estimates[0], ())}
    )
    estimator = Estimator(feature, tuple(feature.indicator.channels), FREQUENCY)

    def estimates(*cuts):
        state, found = estimator.start(), []
        for first, stop in pairwise([0, *cuts, N_SAMPLE]):
            part = piece(first, stop)
            state, more = estimator.step(state, part)
            found += [(part.time[at], each.fault, each.fault or each.numbers[0]) for at, each in more]
        return found

    found = estimates()
    said = [(time, fault.message) for time, fault, _ in found if fault is not None]
    assert said[0] == (pytest.approx(0.509), "sliding.d2 has had no value for 0.01 s")
    assert said[9] == (
        pytest.approx(0.599),
        "sliding.d2 has had no value for 0.1 s; it restarts and gives no score for 0.1 s",
    )
    assert said[10:] == []
    assert next(time for time, _, _ in found if time > 0.6) == pytest.approx(0.709)
    assert estimates(123, 509, 510, 599, 600, 601) == found


def test_an_indicator_without_a_score_yet_is_waited_for():
    options = SLIDING | {"interval": 0.01, "transient": 0.0, "window": 0.7}
    _, verdicts = followed(follower_of("sliding", **options), piece())
    faults = [verdict.fault for verdict in verdicts if verdict.fault is not None]
    assert len(faults) == 69
    assert not any("restarts" in fault.message for fault in faults)
    assert verdicts[-1].alarm is False


def test_its_state_is_arrays_and_stays_as_it_was():
    follower = follower_of("ekf_joint")
    state, _ = follower.step(follower.start(), piece(0, 500))
    before = {name: np.array(array) for name, array in state.items()}
    first = follower.step(state, piece(500, begins_anew=False))
    assert all(array.dtype != object for array in before.values())
    for name, array in before.items():
        np.testing.assert_array_equal(state[name], array)
    assert follower.step(before, piece(500, begins_anew=False))[1] == first[1]


def healthy_ranges(channels):
    """What ten seconds of such a stream teach, looked at second by second."""
    rows = signals(3, 10 * N_SAMPLE)
    return {each: learned_range(each, [channel_facts(rows[each].reshape(10, -1))]) for each in channels}


UNSOUND = {
    "stuck": lambda p: np.full(p.size, p[0]),
    "clipped": lambda p: np.minimum(p, 9.5e6),
    "novel": lambda p: p + 20e6,
    "held": lambda p: p[np.arange(p.size) // 10 * 10],
    "interpolated": lambda p: np.interp(np.arange(p.size), np.arange(p.size)[::10], p[::10]),
}
CLOCKS = {
    "slower": lambda time: time[0] + 1.1 * (time - time[0]),
    "jittering": lambda time: time + 0.4 * np.sin(0.3 * np.arange(time.size)) / FREQUENCY,
}


@pytest.mark.parametrize("name", ["held", "interpolated"])
def test_the_true_rate_of_a_slow_channel_is_named(name):
    records = RecordBatch({P1: UNSOUND[name](signals(3, N_SAMPLE)[P1])[None]}, FREQUENCY, ("a",))
    (found,) = findings(records, healthy_ranges([P1]))
    assert (found.kind, f"{FREQUENCY / 10:g} Hz" in found.message) == ("stuck", True)


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ("stuck", "stuck"), ("clipped", "clipped"), ("novel", "novel"), ("slower", "other_rate"),
        ("held", "stuck"), ("jittering", "uneven"),
    ],
)  # fmt: skip
def test_estimates_of_unsound_samples_are_not_judged(change, kind):
    file = follower_of("sliding", **SLIDING).file
    follower = Detector(file.model_copy(update={"ranges": healthy_ranges(file.channels)}))
    time, rows = np.arange(6 * N_SAMPLE) / FREQUENCY, signals(3, 6 * N_SAMPLE)
    for samples, changes in ((time, CLOCKS), (rows[P1], UNSOUND)):
        samples[3000:] = changes.get(change, np.array)(samples[3000:])
    whole = Chunk(time, rows, begins_anew=True)
    instants, verdicts = followed(follower, whole)
    before = [verdict.fault for time, verdict in zip(instants, verdicts, strict=True) if time < 3.0]
    after = [verdict for time, verdict in zip(instants, verdicts, strict=True) if time > 4.1]
    assert len(before) > 50
    assert not any(before)
    assert {verdict.fault.kind for verdict in after} == {kind}
    assert all(verdict.alarm is None for verdict in verdicts if verdict.fault)
    parts = [whole.part(first, stop) for first, stop in pairwise([0, 1, 999, 3001, 3500, 3501, 6000])]
    assert followed(follower, *parts) == (instants, verdicts)


def test_windows_that_touch_no_gap_are_judged(tmp_path):
    healthy = written(tmp_path / "healthy.csv", pressure(60))
    detector = hydrofdi.train(healthy, window="1 s", output="d2", direction="rising", false_alarm_rate="5 %")
    lines = written(tmp_path / "gap.csv", pressure(6)).read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "gap.csv").write_text("".join(lines[:2301] + lines[2501:]), encoding="utf-8")  # 2.3 to 2.5 s
    told = detector.judge(tmp_path / "gap.csv")
    assert told["start"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert told["fault"].tolist() == ["", "", "missing", "", "", ""]
