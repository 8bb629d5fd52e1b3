"""``hydrofdi evaluate``: labelled files, groups, scores of several numbers, and what is refused."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored, StudyRecords
from tests.commands import run, run_json

DESCRIPTION = """\
files: "unit */*.csv*"
sampling_frequency: 500 Hz
channels: {chamber_1_pressure: "P1 [bar]"}
path: "unit {unit}/{condition} {run}"
label: "{condition}"
"""
GROUPED = DESCRIPTION + 'group: "unit {unit}"\nhealthy: sound\n'
SEVERITY = "severity: {small: 0.1 L/min, large: 0.5 L/min}\n"
RATE = ("--false-alarm-rate", "5%")


def write_record(place, name, pressure):
    place.mkdir(parents=True, exist_ok=True)
    rows = "".join(f"{50.0 + value:.6g}\n" for value in pressure)
    (place / f"{name}.csv").write_text(f"P1 [bar]\n{rows}")


def write_records(folder, n_unit, n_run, unit_spread=0.0):
    """Noise that falls with the leak; units differ by a factor of about 1 + `unit_spread`."""
    draw = np.random.default_rng(9)
    for unit in range(n_unit):
        size = 1.0 + unit_spread * draw.normal()
        for condition, factor in (("sound", 1.0), ("small", 0.93), ("large", 0.5)):
            for number in range(n_run):
                noise = factor * size * draw.normal(size=600)
                write_record(folder / f"unit {unit}", f"{condition} {number}", noise)
    (folder / "rig.yaml").write_text(GROUPED)
    return folder / "rig.yaml"


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    return write_records(tmp_path_factory.mktemp("rig"), n_unit=6, n_run=25)


def by_name(evaluation):
    return {score["indicator"]: score for score in evaluation["detection"]}


def sizes(evaluation):
    (study,) = evaluation["studies"]
    return {each["population"]: each["n"] for each in study["populations"]}


def test_labels_and_groups_become_areas_alarms_and_detections(rig):
    done = run_json("evaluate", rig, "--usual-scores", *RATE)
    assert (done["records"], done["rejected"]) == (450, 0)
    assert {"lda(P1)", "mahalanobis(P1)", "largest_change(d1 … d5)"} <= {*by_name(done)}
    assert done["studies"][0]["false_alarm_rate_set"] == 0.05
    assert done["groups"] == [f"unit {unit}" for unit in range(6)]
    assert sizes(done) == {"healthy": 150, "small": 150, "large": 150}
    kinds = {each["population"]: each["kind"] for each in done["studies"][0]["populations"]}
    assert kinds == {"healthy": "healthy", "small": "fault", "large": "fault"}
    d2 = by_name(done)["dwt.d2"]
    areas = {area["population"]: area for area in d2["auc"]}
    assert (areas["large"]["value"], areas["large"]["low"]) == (1.0, pytest.approx(0.69, abs=0.01))  # 6 units
    assert 0.7 < areas["small"]["low"] < areas["small"]["value"] < areas["small"]["high"] < 0.9
    (alarms,) = d2["false_alarms"]
    assert (alarms["population"], alarms["n"]) == ("healthy", 150)
    assert alarms["low"] < 0.05 < alarms["high"]
    detected = {each["population"]: each["detected"] for each in d2["pod"]}
    assert detected["large"] == 150 > detected["small"] > 0
    assert (d2["q90_95_L_per_min"], len(d2["healthy_against_healthy"])) == (None, 30)
    clear = {score["indicator"]: score["stands_clear"] for score in done["detection"]}
    assert clear["dwt.d1"] is True
    assert clear["dwt.a5"] is False, "approximations carry the mean, which no leak here moves"
    assert sorted(clear.values(), reverse=True) == list(clear.values()), "clear ones come first"


def test_units_that_differ_as_much_as_faults_are_the_conclusion(tmp_path):
    rig = write_records(tmp_path, n_unit=4, n_run=12, unit_spread=0.4)
    done = run_json("evaluate", rig, "--indicators", "dwt", "--false-alarm-rate", "10%")
    score = by_name(done)["dwt.d2"]
    assert score["false_alarms"][0]["alarms"] == 12, "the unit that differs most alarms at every record"
    assert score["false_alarms"][0]["high"] > 0.5
    areas = [pair["value"] for pair in score["healthy_against_healthy"]]
    assert max(areas) == 1.0 - min(areas) == 1.0
    assert {score["stands_clear"] for score in done["detection"]} == {False}
    assert done["conclusion"].startswith("only the unit or the day was detected")


def test_records_that_are_rejected_repeated_or_without_numbers_are_counted_with_exit_code_1(tmp_path):
    rig = write_records(tmp_path, n_unit=2, n_run=3)
    for number in range(3):
        shutil.copy(tmp_path / f"unit 0/sound {number}.csv", tmp_path / f"unit 1/sound {number + 9}.csv")
        write_record(tmp_path / "unit 0", f"large {number}", np.full(600, np.nan))
    (tmp_path / "unit 0/sound 8.csv.gz").write_bytes(b"no gzip")
    done = run("evaluate", rig, "--json", check=1)
    record = json.loads(done.stdout)
    assert (record["records"], record["repeated"], record["rejected"]) == (22, 3, 1)
    assert sizes(record)["healthy"] == 6
    assert record["detection"][0]["without_number"] == {"large": 3}
    assert "unit 1/sound 9.csv repeats unit 0/sound 0.csv" in done.stderr
    assert "rejected: 1 of 22 records; unit 0/sound 8.csv.gz" in done.stderr
    shutil.copy(tmp_path / "unit 0/sound 0.csv", tmp_path / "unit 0/small 9.csv")
    run("evaluate", rig, check=2)


def test_known_severities_give_the_severity_that_is_found(rig):
    graded = rig.with_name("graded.yaml")
    graded.write_text(GROUPED + SEVERITY)
    score = by_name(run_json("evaluate", graded, *RATE))["dwt.d2"]
    assert score["q90_95_L_per_min"] is None
    told = "needs 29 groups of faulty records that agree; there are 6"
    assert any(told in each for each in score["refusals"])
    graded.write_text(DESCRIPTION + "healthy: sound\n" + SEVERITY)
    assert 0.1 < by_name(run_json("evaluate", graded, *RATE))["dwt.d2"]["q90_95_L_per_min"] <= 0.5


@pytest.fixture(scope="module")
def plain(rig):
    rig.with_name("plain.yaml").write_text(DESCRIPTION)
    return rig.with_name("plain.yaml")


def test_without_groups_the_split_is_said_and_the_same_each_time(plain):
    first, second = (run_json("evaluate", plain, "--healthy", "sound", *RATE) for _ in range(2))
    assert first == second
    assert any("random halves (seed 0)" in remark for remark in first["studies"][0]["remarks"])
    assert (sizes(first)["healthy (fit)"], sizes(first)["healthy"]) == (75, 75)
    assert by_name(first)["dwt.d2"]["false_alarms"][0]["n"] == 75
    assert by_name(first)["dwt.d2"]["healthy_against_healthy"] == []


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ((), "healthy"),
        (("--healthy", "soud"), "'sound'"),
        (("--healthy", "sound", "--false-alarm-rate", "70%"), "false_alarm_rate: "),
        (("--healthy", "sound", "--confidence", "most"), "confidence: "),
    ],
)
def test_what_a_user_can_fix_is_one_line(plain, arguments, key):
    done = run("evaluate", plain, *arguments, check=2)
    assert done.stdout == ""
    assert key in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_results_of_a_sweep_are_evaluated_by_their_labels(small_sweep):
    done = run_json("evaluate", small_sweep.directory, "--healthy", "sealed, 551 MPa")
    assert [*sizes(done).values()][:3] == [1, 0, 1]
    assert all(score["threshold"] is None for score in done["detection"])


def test_of_equal_areas_the_quieter_control_comes_first():
    groups = tuple(f"unit {unit}" for unit in range(2) for _ in range(10)) + ("unit 0",) * 10
    populations = Population("healthy", Kind.HEALTHY, is_fit=True), Population("leak", Kind.FAULT)
    of_record, severity = (np.repeat([first, second], [20, 10]) for first, second in ((0, 1), (0.0, np.nan)))
    records = StudyRecords(populations, of_record, severity, groups=groups, is_labelled=True)
    scores = [
        Scored(name, np.add.outer([0.0, moved, 100.0], np.arange(10.0)).ravel(), direction=Direction.RISING)
        for name, moved in (("a_moved", 4.0), ("z_quiet", 0.5))
    ]
    for is_labelled, names in ((True, ["z_quiet", "a_moved"]), (False, ["a_moved", "z_quiet"])):
        found = detect(replace(records, is_labelled=is_labelled), scores, Rules(false_alarm_rate=0.2))
        assert [each.scored.name for each in found.judgements] == names


def test_mistakes_of_a_description_have_their_line(rig):
    wrong = rig.with_name("wrong.yaml")
    for text, told in (
        (DESCRIPTION.replace('label: "{condition}"\n', "") + "healthy: sound\n", "5: healthy:"),
        (GROUPED + "severity: {sound: 1 L/min}\n", "8: severity.sound:"),
    ):
        wrong.write_text(text)
        assert f"wrong.yaml:{told}" in run("evaluate", wrong, check=2).stderr


def test_a_file_of_indicators_may_ask_for_scores(rig, tmp_path):
    file = tmp_path / "asked.yaml"
    text = "indicators: [dwt]\nscores:\n  far: {kind: mahalanobis, of: [dwt], shrinkage: SHRINKAGE}\n"
    areas = []
    for shrinkage in ("0", "1"):
        file.write_text(text.replace("SHRINKAGE", shrinkage))
        found = by_name(run_json("evaluate", rig, "--indicators", file))
        areas.append(found["far"]["auc"][1]["value"] + found["far"]["auc"][0]["value"])
        assert "lda(P1)" not in found
    assert areas[0] != areas[1]
    for line, wrong in ((3, ("shrinkage: SHRINKAGE", "shrinkag: 1")), (2, ("scores:", "score:"))):
        file.write_text(text.replace(*wrong))
        for command in ("evaluate", "measure")[: 4 - line]:
            done = run(command, rig, "--indicators", file, check=2)
            assert re.search(rf"asked\.yaml:{line}: score.*: unknown key", done.stderr)
