"""What a study ranks can be trained and run: its threshold and its numbers, to the bit."""

from dataclasses import replace

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import NotStatedError
from hydrofdi.report.detection.report import DetectionReport
from hydrofdi.studies.detecting import detector_settings, judge_study, winner
from tests.commands import run, run_json
from tests.studies.populations import stored

STUDY = """
name: ranked
record: {duration: 2 s}
input: {period: 0.5 s}
fluid: {temperature: 45 °C}
wavelet: {phase: 0}
pressure_1_sensor: {noise: 5 kPa}
pressure_2_sensor: {noise: 5 kPa}
store: {signals: all}
indicators: {dwt: {}, swing: {kind: pressure_statistics}, rings: {kind: ring_down}}
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 60, test: 30}
  faults: {leakage.internal_flow: [1 L/min, 3 L/min], each: 30, fit: 12}
detection:
  false_alarm_rate: 10 %
  scores:
    unusual: {kind: mahalanobis, of: [swing, dwt.d3]}
    outside: {kind: one_class, of: [swing.mean, swing.kurtosis, dwt]}
    leak: {kind: lda, of: [swing.mean, swing.kurtosis, dwt.d2]}
    odds: {kind: logistic, of: [swing.mean, swing.kurtosis, dwt.d2], seed: 3}
    calm: {kind: compensated, of: [dwt.d2, dwt.d3], by: [swing.kurtosis]}
    fall: {kind: largest_change, of: [dwt.d1, dwt.d2, dwt.d3, dwt.d4, dwt.d5]}
"""
KINDS = ["dwt.d2", "rings.damping_ratio", "unusual", "outside", "leak", "odds", "calm.dwt.d2", "fall"]


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("ranked"), STUDY)


@pytest.fixture(scope="module")
def study(data):
    return data.path.parent.parent


@pytest.fixture(scope="module")
def detection(data):
    return judge_study(data)[0]


def judged_as_in_the_study(detection, judgement, detector, records):
    """The numbers of test records, and the threshold, are those of the study."""
    limits, threshold = detector.file.limits, judgement.threshold
    for own, asked in ((limits.low, threshold.low), (limits.high, threshold.high)):
        assert own == (asked if np.isfinite(asked) else None)
    assert limits.interval == threshold.interval
    is_tested = np.array([not each.is_fit for each in detection.records.populations])
    is_tested = is_tested[detection.records.of_record]
    found, alarms = (np.array(records[name], dtype=float) for name in ("score", "alarm"))
    np.testing.assert_array_equal(found[is_tested], judgement.scored.values[is_tested])
    is_judged = is_tested & np.isfinite(alarms)
    assert is_judged.sum() > is_tested.sum() // 2
    np.testing.assert_array_equal(alarms[is_judged], threshold.outcomes(judgement.scored.values)[is_judged])


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_score_is_trained_and_run_with_the_numbers_of_the_study(
    study, data, detection, name, tmp_path
):
    (judgement,) = (each for each in detection.judgements if each.name == name)
    settings = detector_settings(data.experiment, judgement, detection.rules)
    detector = hydrofdi.train(study / "results", config=settings, out=tmp_path / "detector.json")
    again = hydrofdi.Detector.load(tmp_path / "detector.json")
    assert again.file == detector.file
    judged_as_in_the_study(detection, judgement, again, again.judge(study / "results"))


@pytest.fixture
def judged(monkeypatch):
    """Puts another judgement in the place of that of the study."""
    return lambda detection: monkeypatch.setattr(
        "hydrofdi.studies.detecting.judge_study", lambda _: (detection,)
    )


def test_the_command_that_the_report_names_trains_the_winner(study, data, detection, judged):
    (told,) = DetectionReport((detection,), data)._training.paragraphs
    arguments = told.replace(str(study) + "/", "").partition("hydrofdi ")[2].split()
    judged(detection)
    run(*arguments, cwd=study, check=0)
    detector = hydrofdi.Detector.load(study / "detector.json")
    judged_as_in_the_study(detection, winner(detection), detector, detector.judge(study / "results"))
    told = run_json(*arguments, "--sensors", "P1", cwd=study)["detector"]
    assert told["channels"] == ["chamber_1_pressure"]
    threshold = winner(detection, ["chamber_1_pressure"]).threshold
    for end in ("low", "high"):
        limit = getattr(threshold, end)
        assert told["limits"][end] == (limit if np.isfinite(limit) else None)
    best = ["--best", "--out", "other.json"]
    for wrong in (
        [*arguments, "--sensors", "P9"], [*arguments, "--sensors", "P2"], [*arguments, "--indicator", "dwt"],
        ["train", "study.yaml", *best], ["train", "results", "results", *best],
    ):  # fmt: skip
        assert len(run(*wrong, cwd=study, check=2).stderr.splitlines()) == 1


def test_without_a_winner_the_healthy_records_that_are_needed_are_named(study, detection, judged):
    judged(replace(detection, judgements=()))
    with pytest.raises(NotStatedError) as refusal:
        hydrofdi.train(study / "results", best=True)
    assert refusal.value.records_needed == detection.rules.records_for_false_alarms
