"""Plain data of a judged study, its answer, what moves healthy scores, and its designs."""

import csv
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind
from hydrofdi.report.detection.record import detection_records
from hydrofdi.report.detection.sections import answer_block, designs_block, why_block
from hydrofdi.report.detection.wording import best_with_sensors, sensors
from hydrofdi.report.page import render_json
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored
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
from tests.studies.made_up_nuisances import BULK, FRICTION, IDLE, study


def test_csv_holds_one_line_per_score_and_tested_population_with_the_numbers_of_json(detection):
    """What is not found is null and says on which side it lies; of too few records alarms are counted."""
    report = report_of(detection)
    lines = list(csv.DictReader(io.StringIO(Table.of(report.columns()).to_csv())))
    tested = [each for each in detection.records.populations if not each.is_fit]
    assert len(lines) == len(tested) * len(detection.judgements)
    record = json.loads(render_json(report))["detection"]
    for one in record:
        own = {line["population"]: line for line in lines if line["indicator"] == one["indicator"]}
        for part in one["false_alarms"]:
            told = [str(part[key]) if part[key] is not None else "" for key in ("alarms", "n", "rate")]
            assert [own[part["population"]][key] for key in ("alarms", "n", "rate")] == told
        faults = [line for line in own.values() if line["kind"] == Kind.FAULT]
        assert [float(line["auc"]) for line in faults] == [part["value"] for part in one["auc"]]
        for key in ("q90_95_L_per_min", "q90_95_of_all_L_per_min"):
            assert next(iter(own.values()))[key] == ("" if one[key] is None else str(one[key]))
    assert any(line["q90_95_of_all_L_per_min"] for line in lines)
    by_name = {one["indicator"]: one for one in record}
    assert (by_name["dwt.d2"]["q90_95_L_per_min"], by_name["dwt.d2"]["q90_95_place"]) == (None, "above")
    first, bound = by_name["flow_balance.leakage_coefficient"], detection.judgements[0].bound
    assert first["q90_95_L_per_min"] == pytest.approx(bound.severity / LITRES_PER_MINUTE)
    assert first["q90_95_place"] == "within"
    worn = {part["population"]: part for part in record[0]["false_alarms"]}["worn friction"]
    assert [worn[key] for key in ("rate", "low", "high", "n")] == [None, None, None, 60]


@pytest.mark.parametrize(
    "chosen",
    [
        {"scores": lambda records: [made_up_score(records, "empty.score", gain=0.0, missing=1.0)]},
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


def test_designs_have_their_bounds_side_by_side():
    def design(noise, seed, setting):
        """Scores of the same actuators; the noise differs from design to design."""
        records = replace(made_up_records(severities=(0.01, 0.1, 1.0)), design=setting)
        plant = 0.3 * np.random.default_rng(4).standard_normal(records.severity.size)
        rise = 2.0 * np.log10(np.maximum(records.severity / LITRES_PER_MINUTE, 1e-3) / 1e-3)
        drawn = np.random.default_rng([seed, 9]).standard_normal((2, rise.size))
        scores = [
            Scored(name, gain * rise + plant + noise * own, channels, direction=Direction.RISING)
            for own, name, gain, channels in zip(
                drawn, ("pressure_balance.leakage", "dwt.d2"), (1.0, 0.5), ((P1, U), (P1,)), strict=True
            )
        ]
        return detect(records, scores, Rules(false_alarm_rate=0.02))

    settings = {"record.duration": 20.0}, {"record.duration": 5.0}, {"pressure_1_sensor.noise": 2500.0}
    detections = [design(*each) for each in zip((1.0, 1.0, 0.2), range(3), settings, strict=True)]
    (sheet,) = designs_block(detections).tables
    assert sheet.columns == ["Design", "P1 u", "P1", "dwt.d2"]
    first, _, better = (float(row[1].strip("≤ °")) for row in rows(sheet))
    assert better < first
    assert designs_block(detections[:1]) is None


def test_severities_without_a_flow_keep_their_unit():
    records = replace(made_up_records(), severity_unit="mm")
    report = report_of(detect(records, made_up_scores(records), Rules()))
    one = report.record()["detection"][0]
    assert one["q90_95"] == pytest.approx(report.detections[0].judgements[0].bound.severity)
    assert not [key for key in one if key.endswith("L_per_min")]
    assert all(math.isfinite(part["severity"]) for part in one["pod"])


def test_a_score_that_does_not_keep_its_rate_is_no_answer(detection):
    """Kurtosis finds less than all others with P1, and alarms in every shift."""
    kurtosis = next(each for each in detection.judgements if each.name.endswith("kurtosis"))
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
    sets = {sensors(each) for each in detection.judgements}
    shown = rows(answer_block(detection).tables[0])
    assert {row[0] for row in shown} == sets
    names = [each.name for each in detection.judgements]
    best = [next(rank for rank, name in enumerate(names) if row[1].startswith(name)) for row in shown]
    assert best[: len(sets)] == sorted(best[: len(sets)])


def test_more_sensors_never_find_less():
    detection = judged(
        lambda records: [
            made_up_score(records, "good", gain=200.0, seed=5, channels=(P1,)),
            made_up_score(records, "worse", gain=3.0, seed=4, channels=(P1, P2, U)),
        ]
    )
    assert {each.name for each in best_with_sensors(detection).values()} == {"good"}
    assert [row[1] for row in rows(answer_block(detection).tables[0])] == ["good"]


def moved(**chosen):
    """What moves a score: a table by nuisance, and plain data."""
    records, scored = study(**chosen)
    detection = detect(records, [replace(scored, direction=Direction.RISING)], Rules(false_alarm_rate=0.05))
    ((one,), block) = detection_records(detection), why_block(detection)
    if block is None:
        return None, one["nuisances"]
    texts = {row[1]: [text.replace("\N{NO-BREAK SPACE}", " ") for text in row[2:]]
             for row in rows(block.tables[0])}  # fmt: skip
    return texts, {each["parameter"]: each for each in one["nuisances"]}


def test_the_table_of_nuisances_has_the_numbers_of_the_plain_data():
    shown, found = moved()
    assert set(shown) == {BULK, FRICTION, "record to record", IDLE}
    assert shown[IDLE][1:] == ["<0.01"]
    for name in (BULK, FRICTION, IDLE):
        number = found[name]["alone"]
        assert shown[name][0].split()[0] == f"{100.0 * number['value']:.0f}"
        assert number["low"] <= number["value"] <= number["high"]
        assert found[name]["imitates"].keys() == {"place", "leakage_L_per_min"}


def test_without_leaks_there_are_shares_and_without_such_records_nothing():
    shown, found = moved(levels=())
    assert {each["imitates"] for each in found.values()} == {None}
    assert shown[BULK][1:] == ["–"]
    assert moved(alone=0) == (None, [])
