"""``hydrofdi evaluate``: labelled files, groups, scores of several numbers, and what is refused."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from hydrofdi.detectors.rules import Rules, make_score
from hydrofdi.evaluation.rates import area_under_curve
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored, StudyRecords
from tests.commands import run, run_json
from tests.conftest import REPOSITORY, VTNSI, needs_vtnsi

ASKED = "--indicators", "dwt", "--false-alarm-rate", "10%"

DESCRIPTION = """\
files: "unit */*.csv*"
sampling_frequency: 500 Hz
channels: {chamber_1_pressure: "P1 [bar]"}
path: "unit {unit}/{condition} {run}"
label: "{condition}"
"""

GROUPED = DESCRIPTION + 'group: "unit {unit}"\nhealthy: sound\n'


def write_records(folder, n_unit=6, n_run=25, unit_spread=0.0):
    """Noise that falls with the leak; units differ by a factor of about 1 + `unit_spread`."""
    draw = np.random.default_rng(9)
    for unit in range(n_unit):
        size = 1.0 + unit_spread * draw.normal()
        for condition, factor in (("sound", 1.0), ("small", 0.93), ("large", 0.5)):
            place = folder / f"unit {unit}"
            place.mkdir(parents=True, exist_ok=True)
            for number in range(n_run):
                pressure = 50.0 + factor * size * draw.normal(size=600)
                rows = "".join(f"{value:.6g}\n" for value in pressure)
                (place / f"{condition} {number}.csv").write_text(f"P1 [bar]\n{rows}")


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rig")
    write_records(folder)
    (folder / "rig.yaml").write_text(GROUPED)
    severities = "severity: {small: 0.1 L/min, large: 0.5 L/min}\n"
    (folder / "graded.yaml").write_text(GROUPED + severities)
    return folder


@pytest.fixture(scope="module")
def small_rig(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rig")
    write_records(folder, n_unit=4, n_run=12)
    (folder / "rig.yaml").write_text(GROUPED)
    (folder / "plain.yaml").write_text(DESCRIPTION)
    return folder


def by_name(evaluation):
    return {score["indicator"]: score for score in evaluation["detection"]}


def sizes(evaluation):
    (study,) = evaluation["studies"]
    return {each["population"]: each["n"] for each in study["populations"]}


def test_labels_and_groups_become_areas_alarms_and_detections(rig):
    done = run_json("evaluate", rig / "rig.yaml", "--false-alarm-rate", "5%")
    assert (done["records"], done["rejected"]) == (450, 0)
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
    assert d2["q90_95_L_per_min"] is None
    assert len(d2["healthy_against_healthy"]) == 30


def test_units_that_differ_as_much_as_faults_are_the_conclusion(small_rig, tmp_path):
    write_records(tmp_path, n_unit=4, n_run=12, unit_spread=0.4)
    (tmp_path / "rig.yaml").write_text(GROUPED)
    asked = "evaluate", tmp_path / "rig.yaml", *ASKED
    done = run_json(*asked)
    score = by_name(done)["dwt.d2"]
    assert score["false_alarms"][0]["alarms"] == 12, "the unit that differs most alarms at every record"
    assert score["false_alarms"][0]["high"] > 0.5
    areas = [pair["value"] for pair in score["healthy_against_healthy"]]
    assert max(areas) == 1.0 - min(areas) == 1.0
    assert {score["stands_clear"] for score in done["detection"]} == {False}
    assert done["conclusion"].startswith("only the unit or the day was detected")

    done = run_json("evaluate", small_rig / "rig.yaml", *ASKED)
    clear = {score["indicator"]: score["stands_clear"] for score in done["detection"]}
    assert clear["dwt.d1"] is True
    assert clear["dwt.a5"] is False, "approximations carry the mean, which no leak here moves"
    assert sorted(clear.values(), reverse=True) == list(clear.values()), "clear ones come first"


def test_records_that_are_rejected_repeated_or_without_numbers_are_counted_with_exit_code_1(tmp_path):
    write_records(tmp_path, n_unit=2, n_run=3)
    (tmp_path / "rig.yaml").write_text(GROUPED)
    for number in range(3):
        shutil.copy(tmp_path / f"unit 0/sound {number}.csv", tmp_path / f"unit 1/sound {number + 9}.csv")
        (tmp_path / f"unit 0/large {number}.csv").write_text("P1 [bar]\n" + "nan\n" * 600)
    (tmp_path / "unit 0/sound 8.csv.gz").write_bytes(b"no gzip")
    done = run("evaluate", tmp_path / "rig.yaml", "--json", check=1)
    record = json.loads(done.stdout)
    assert (record["records"], record["repeated"], record["rejected"]) == (22, 3, 1)
    assert sizes(record)["healthy"] == 6
    assert record["detection"][0]["without_number"] == {"large": 3}
    assert "unit 1/sound 9.csv repeats unit 0/sound 0.csv" in done.stderr
    assert "rejected: 1 of 22 records; unit 0/sound 8.csv.gz" in done.stderr
    shutil.copy(tmp_path / "unit 0/sound 0.csv", tmp_path / "unit 0/small 9.csv")
    run("evaluate", tmp_path / "rig.yaml", check=2)


def test_known_severities_give_the_severity_that_is_found(rig):
    score = by_name(run_json("evaluate", rig / "graded.yaml", "--false-alarm-rate", "5%"))["dwt.d2"]
    assert score["q90_95_L_per_min"] is None
    assert any(
        "needs 29 groups of faulty records that agree; there are 6" in each for each in score["refusals"]
    )
    text = (rig / "graded.yaml").read_text().replace('group: "unit {unit}"\n', "")
    (rig / "ungrouped.yaml").write_text(text)
    score = by_name(run_json("evaluate", rig / "ungrouped.yaml", "--false-alarm-rate", "5%"))["dwt.d2"]
    assert 0.1 < score["q90_95_L_per_min"] <= 0.5


def test_without_groups_the_split_is_said_and_the_same_each_time(small_rig):
    arguments = "evaluate", small_rig / "plain.yaml", "--healthy", "sound", "--false-alarm-rate", "5%"
    first, second = run_json(*arguments), run_json(*arguments)
    assert first == second
    assert any("random halves (seed 0)" in remark for remark in first["studies"][0]["remarks"])
    assert (sizes(first)["healthy (fit)"], sizes(first)["healthy"]) == (24, 24)
    assert by_name(first)["dwt.d2"]["false_alarms"][0]["n"] == 24
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
def test_what_a_user_can_fix_is_one_line(small_rig, arguments, key):
    done = run("evaluate", small_rig / "plain.yaml", *arguments, check=2)
    assert done.stdout == ""
    assert key in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_results_of_a_sweep_are_evaluated_by_their_labels(tmp_path):
    (tmp_path / "leaks.yaml").write_text(
        "name: leaks\nrecord: {duration: 2 s}\nstore: {signals: pressures}\n"
        "sweep: {grid: {leakage.internal_flow: [0 L/min, 1 L/min]}}\n"
    )
    run("sweep", "leaks.yaml", "--engine", "in-process", cwd=tmp_path, check=0)
    done = run_json("evaluate", "results/leaks", "--healthy", "sealed, 551 MPa", cwd=tmp_path)
    assert [*sizes(done).values()] == [1, 0, 1]
    assert all(score["threshold"] is None for score in done["detection"])


@needs_vtnsi
def test_the_vtnsi_records_carry_no_rate(tmp_path):
    (tmp_path / "vtnsi").symlink_to(VTNSI)
    shutil.copy(REPOSITORY / "configs" / "measured" / "vtnsi.yaml", tmp_path)
    done = run_json("evaluate", tmp_path / "vtnsi.yaml")
    assert sizes(done) == {"healthy": 40, "Leak": 30}
    remarks = done["studies"][0]["remarks"]
    assert any("no group has both healthy and faulty records" in remark for remark in remarks)
    for score in done["detection"]:
        assert score["threshold"] is None
        assert any("healthy records, not 40" in refusal for refusal in score["refusals"])
        (area,) = score["auc"]
        assert area["low"] < 0.5, "no area is told from chance over six groups"
        assert max(pair["value"] for pair in score["healthy_against_healthy"]) > area["value"]


def test_detections_are_held_back_if_no_healthy_group_could_be_tested(tmp_path):
    write_records(tmp_path, n_unit=2, n_run=12)
    (tmp_path / "rig.yaml").write_text(GROUPED + "severity: {small: 0.1 L/min, large: 0.5 L/min}\n")
    score = by_name(run_json("evaluate", tmp_path / "rig.yaml", "--false-alarm-rate", "5%"))["dwt.d2"]
    assert score["threshold"]["n"] == 24
    assert score["false_alarms"] == score["pod"] == []
    assert score["q90_95_L_per_min"] is None
    assert any("no healthy record was tested" in each for each in score["refusals"])


def test_of_equal_areas_the_quieter_control_comes_first():
    groups = tuple(f"unit {unit}" for unit in range(2) for _ in range(10)) + ("unit 0",) * 10
    healthy, leaking = Population("healthy", Kind.HEALTHY, is_fit=True), Population("leak", Kind.FAULT)
    of_record = np.repeat([0, 1], [20, 10])
    severity = np.repeat([0.0, np.nan], [20, 10])
    records = StudyRecords((healthy, leaking), of_record, severity, groups=groups, is_labelled=True)
    ramp = np.arange(10.0)
    moved = np.concatenate([ramp, ramp + 4.0, ramp + 100.0])
    quiet = np.concatenate([ramp, ramp + 0.5, ramp + 100.0])
    scores = [Scored(name, values, direction=Direction.RISING) for name, values in
              (("a_moved", moved), ("z_quiet", quiet))]  # fmt: skip
    rules = Rules(false_alarm_rate=0.2)
    found = [each.scored.name for each in detect(records, scores, rules).judgements]
    assert found == ["z_quiet", "a_moved"]
    found = detect(replace(records, is_labelled=False), scores, rules).judgements
    assert [each.scored.name for each in found] == ["a_moved", "z_quiet"]


def test_mistakes_of_a_description_have_their_line(rig):
    text = DESCRIPTION.replace('label: "{condition}"\n', "") + "healthy: sound\n"
    (rig / "unlabelled.yaml").write_text(text)
    done = run("evaluate", rig / "unlabelled.yaml", check=2)
    assert "unlabelled.yaml:5: healthy:" in done.stderr
    (rig / "both.yaml").write_text(GROUPED + "severity: {sound: 1 L/min}\n")
    assert "both.yaml:8: severity.sound:" in run("evaluate", rig / "both.yaml", check=2).stderr


USUAL = ("--usual-scores", "--false-alarm-rate", "5%")


def write_units(folder, conditions, n_run=20):
    """Records of units with a sound of their own, whatever their condition; each unit has one condition."""
    draw = np.random.default_rng(4)
    for unit, condition in enumerate(conditions):
        place = folder / f"unit {unit}"
        place.mkdir()
        sound = draw.normal(size=40) * 0.8 ** np.arange(40)
        for number in range(n_run):
            pressure = 50.0 + lfilter(sound, [1.0], draw.normal(size=600))
            rows = "".join(f"{value:.6g}\n" for value in pressure)
            (place / f"{condition} {number}.csv").write_text(f"P1 [bar]\n{rows}")
    (folder / "rig.yaml").write_text(GROUPED)


@pytest.fixture(scope="module")
def confounded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("confounded")
    write_units(folder, ["sound", "worn"] * 4)
    return folder


def test_a_score_does_not_find_the_units_that_it_was_not_shown(confounded):
    records = run_json("measure", confounded / "rig.yaml")["records"]
    values = np.array([[*record["values"].values()] for record in records], dtype=float)
    is_worn = np.array([record["label"] == "worn" for record in records])
    recognised = make_score("lda").fit(values, is_worn).score(values)
    trap = area_under_curve(recognised[~is_worn], recognised[is_worn])
    found = by_name(run_json("evaluate", confounded / "rig.yaml", *USUAL))
    (honest,) = found["lda(P1)"]["auc"]
    assert trap.low > 0.8, "scored by the model that saw them, the units are told apart"
    assert honest["low"] < 0.5, "nothing but the unit was ever there"
    assert honest["value"] < trap.value - 0.2
    assert {"mahalanobis(P1)", "largest_change(d1 … d5)"} <= set(found)


def test_a_file_of_indicators_may_ask_for_scores(confounded, tmp_path):
    file = tmp_path / "asked.yaml"
    text = "indicators: [dwt]\nscores:\n  far: {kind: mahalanobis, of: [dwt], shrinkage: SHRINKAGE}\n"
    areas = []
    for shrinkage in ("0", "1"):
        file.write_text(text.replace("SHRINKAGE", shrinkage))
        found = by_name(run_json("evaluate", confounded / "rig.yaml", "--indicators", file))
        areas.append(found["far"]["auc"][0]["value"])
        assert "lda(P1)" not in found
    assert areas[0] != areas[1]
    for line, wrong in ((3, ("shrinkage: SHRINKAGE", "shrinkag: 1")), (2, ("scores:", "score:"))):
        file.write_text(text.replace(*wrong))
        for command in ("evaluate", "measure")[: 4 - line]:
            done = run(command, confounded / "rig.yaml", "--indicators", file, check=2)
            assert re.search(rf"asked\.yaml:{line}: score.*: unknown key", done.stderr)
