"""The section "Why": which nuisance moves a score, in a table and in JSON."""

import json

import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction
from hydrofdi.report.detection.populations import why_block
from hydrofdi.report.detection.record import detection_records
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored
from tests.report.rows import rows
from tests.studies.made_up_nuisances import BULK, FRICTION, IDLE, study

RULES = Rules(false_alarm_rate=0.05)


def moved(**chosen):
    records, scored = study(**chosen).records()
    named = Scored(
        "ring_down.damping_ratio", scored.values, ("chamber_1_pressure",), direction=Direction.RISING
    )
    return detect(records, [named], RULES)


@pytest.fixture(scope="module")
def detection():
    return moved()


def cells(block, key):
    (sheet,) = (sheet for sheet in block.tables if sheet.key == key)
    return {row[1]: [text.replace("\N{NO-BREAK SPACE}", " ") for text in row[2:]] for row in rows(sheet)}


def test_the_table_of_nuisances_has_the_numbers_of_the_plain_data(detection):
    block = why_block(detection)
    shown = cells(block, "nuisances")
    assert set(shown) == {BULK, FRICTION, "record to record", IDLE}
    assert shown[IDLE][1:] == ["<0.01"]
    (record,) = detection_records(detection)
    found = {each["parameter"]: each for each in json.loads(json.dumps(record))["nuisances"]}
    for name in (BULK, FRICTION, IDLE):
        number = found[name]["alone"]
        assert shown[name][0].split()[0] == f"{100.0 * number['value']:.0f}"
        assert number["low"] <= number["value"] <= number["high"]
        assert found[name]["imitates"].keys() == {"place", "leakage_L_per_min"}


def test_without_leaks_there_are_shares_and_without_such_records_nothing():
    sealed, without = moved(levels=()), moved(alone=0)
    (record,) = detection_records(sealed)
    assert {each["imitates"] for each in record["nuisances"]} == {None}
    assert cells(why_block(sealed), "nuisances")[BULK][1:] == ["–"]
    (record,) = detection_records(without)
    assert (why_block(without), record["nuisances"]) == (None, [])
