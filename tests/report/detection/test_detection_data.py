"""Plain data of a judged study, and the table of its designs."""

import csv
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.report.detection.answer import answer_block
from hydrofdi.report.detection.record import designs_block
from hydrofdi.report.detection.wording import best_with_sensors, sensors
from hydrofdi.report.page import render_json
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.tables.table import Table
from tests.report.detection.made_up import (
    LITRES_PER_MINUTE,
    P1,
    P2,
    U,
    judged,
    made_up_records,
    made_up_score,
    made_up_scores,
    report_of,
)
from tests.report.rows import rows


@pytest.fixture(scope="module")
def record(detection):
    return json.loads(render_json(report_of(detection)))


def test_what_is_not_found_is_null_and_says_on_which_side_it_lies(record, detection):
    by_name = {one["indicator"]: one for one in record["detection"]}
    assert by_name["dwt.d2"]["q90_95_L_per_min"] is None
    assert by_name["dwt.d2"]["q90_95_place"] == "above"
    first = by_name["flow_balance.leakage_coefficient"]
    bound = detection.judgements[0].smallest["q90_95"].severity
    assert first["q90_95_L_per_min"] == pytest.approx(bound / LITRES_PER_MINUTE)
    assert first["q90_95_place"] == "within"


def test_of_too_few_records_alarms_are_counted_and_no_rate_is_stated(record):
    worn = {part["population"]: part for part in record["detection"][0]["false_alarms"]}["worn friction"]
    assert [worn[key] for key in ("rate", "low", "high")] == [None] * 3
    assert worn["n"] == 60


def nothing(records):
    return [made_up_score(records, "empty.score", gain=0.0, missing=1.0)]


@pytest.mark.parametrize(
    "chosen",
    [
        {"scores": nothing},
        {"n_healthy": 10, "n_other": 3},
        {"severities": (), "shifts": (), "confusions": ()},
    ],
)
def test_a_study_that_carries_nothing_has_no_nan(chosen):
    report = report_of(judged(**chosen))
    record = json.loads(render_json(report))
    assert record == report.record()
    assert all(one["q90_95_L_per_min"] is None for one in record["detection"])
    assert "nan" not in Table.of(report.columns()).to_csv().lower()


def test_csv_holds_one_line_per_score_and_tested_population_with_the_numbers_of_json(record, detection):
    lines = list(csv.DictReader(io.StringIO(Table.of(report_of(detection).columns()).to_csv())))
    tested = [each for each in detection.records.populations if not each.is_fit]
    assert len(lines) == len(tested) * len(detection.judgements)
    for one in record["detection"]:
        own = {line["population"]: line for line in lines if line["indicator"] == one["indicator"]}
        for part in one["false_alarms"]:
            line = own[part["population"]]
            assert [line["alarms"], line["n"]] == [str(part["alarms"]), str(part["n"])]
            assert line["rate"] == ("" if part["rate"] is None else str(part["rate"]))
        faults = [line for line in own.values() if line["kind"] == Kind.FAULT]
        assert [float(line["auc"]) for line in faults] == [part["value"] for part in one["auc"]]
        found = next(iter(own.values()))["q90_95_L_per_min"]
        assert found == ("" if one["q90_95_L_per_min"] is None else str(one["q90_95_L_per_min"]))
        of_all = next(iter(own.values()))["q90_95_of_all_L_per_min"]
        assert of_all == str(one["q90_95_of_all_L_per_min"] or "")
    assert any(line["q90_95_of_all_L_per_min"] for line in lines)


DESIGNS = (
    ({"record.duration": 20.0}, 1.0),
    ({"record.duration": 5.0}, 1.0),
    ({"pressure_1_sensor.noise": 2500.0, "pressure_2_sensor.noise": 2500.0}, 0.2),
)
"""What each design sets, and the noise of its score."""


def design_judged(setting, noise, seed, n_fit=300, n=100):
    """Scores of the same actuators whose noise differs from design to design."""
    levels = (0.01, 0.1, 1.0)
    populations = (
        Population("healthy", Kind.HEALTHY, is_fit=True),
        Population("healthy", Kind.HEALTHY),
        *(Population(f"{level:g} L/min", Kind.FAULT, severity=level * LITRES_PER_MINUTE) for level in levels),
    )
    sizes = (n_fit, 150, *[n] * 3)
    leak = np.repeat([0.0, 0.0, *levels], sizes)
    drawn = np.random.default_rng([seed, 9])
    plant = 0.3 * np.random.default_rng(4).standard_normal(leak.size)
    rise = 2.0 * np.log10(np.maximum(leak, 1e-3) / 1e-3)
    scores = [
        Scored(
            name,
            gain * rise + plant + noise * drawn.standard_normal(leak.size),
            channels,
            direction=Direction.RISING,
        )
        for name, gain, channels in (("pressure_balance.leakage", 1.0, (P1, U)), ("dwt.d2", 0.5, (P1,)))
    ]
    of_record = np.repeat(np.arange(5), sizes)
    records = StudyRecords(populations, of_record, leak * LITRES_PER_MINUTE, design=setting)
    return detect(records, scores, Rules(false_alarm_rate=0.02))


@pytest.fixture(scope="module")
def detections():
    return tuple(design_judged(setting, noise, seed) for seed, (setting, noise) in enumerate(DESIGNS))


def shown(detections):
    (sheet,) = designs_block(detections).tables
    return sheet.columns, {row[0]: row[1:] for row in rows(sheet)}


def test_designs_have_their_bounds_side_by_side(detections):
    headers, table = shown(detections)
    assert headers == ["Design", "P1 u", "P1", "dwt.d2"]
    first, _, better = ([float(text.strip("≤ °")) for text in row[:1]] for row in table.values())
    assert better < first
    assert designs_block(detections[:1]) is None


def test_severities_without_a_flow_keep_their_unit():
    records = replace(made_up_records(), severity_unit="mm")
    report = report_of(detect(records, made_up_scores(records), Rules()))
    one = report.record()["detection"][0]
    assert one["q90_95"] == pytest.approx(report.detections[0].judgements[0].smallest["q90_95"].severity)
    assert not [key for key in one if key.endswith("L_per_min")]
    assert all(math.isfinite(part["severity"]) for part in one["pod"])


def test_a_score_that_does_not_keep_its_rate_is_no_answer(detection):
    """Kurtosis finds less than all others with P1, and alarms in every shift."""
    kurtosis = next(each for each in detection.judgements if each.scored.name.endswith("kurtosis"))
    assert not kurtosis.keeps_its_rate
    assert "kurtosis" not in str(rows(answer_block(detection).tables[0]))


def hopeless(records):
    return [made_up_score(records, "noise", gain=0.0, channels=(P1, U))]


@pytest.mark.parametrize(("scores", "is_offered"), [(made_up_scores, True), (hopeless, False)])
def test_training_is_offered_where_something_is_found(made_up, scores, is_offered):
    report = replace(report_of(judged(scores=scores)), data=made_up)
    assert (report._training is not None) == is_offered


@pytest.mark.parametrize("n_healthy", [400, 20])
def test_every_set_of_sensors_has_a_row(n_healthy):
    detection = judged(n_healthy=n_healthy)
    (sheet,) = answer_block(detection).tables
    assert {row[0] for row in rows(sheet)} == {sensors(each) for each in detection.judgements}
    ranks = [
        next(rank for rank, each in enumerate(detection.judgements) if row[1].startswith(each.scored.name))
        for row in rows(sheet)
    ]
    best = ranks[: len({sensors(each) for each in detection.judgements})]
    assert best == sorted(best)


def good_and_worse(records):
    return [
        made_up_score(records, "good", gain=200.0, seed=5, channels=(P1,)),
        made_up_score(records, "worse", gain=3.0, seed=4, channels=(P1, P2, U)),
    ]


def test_more_sensors_never_find_less():
    detection = judged(good_and_worse)
    assert {each.scored.name for each in best_with_sensors(detection).values()} == {"good"}
    (sheet,) = answer_block(detection).tables
    assert [row[1] for row in rows(sheet)] == ["good"]
