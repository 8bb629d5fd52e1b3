"""Labelled records as a study: who is healthy, who fits, what is a score."""

import numpy as np

from hydrofdi.evaluation.scores import Direction, Kind
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.record_measures import Column, RecordMeasures
from hydrofdi.records import Channel
from hydrofdi.studies.measured import Labels, measured_study

P1 = (Channel.CHAMBER_1_PRESSURE,)

COLUMNS = [
    Column("ring", Output("decay", "1/s", "decay", direction=Direction.RISING), "1/s", P1),
    Column("ring", Output("parts", "1", "shares", {"part": 2}), "1", P1),
    Column("ring", Output.quality("error", "1/s", "standard error"), "1/s", P1),
    Column("never", Output("there", "1", "nothing"), "1", P1),
]


def record(number, label, group="", rejected=False):
    values = {
        "ring.decay": np.array(number),
        "ring.parts": np.array([number, -number]),
        "ring.error": np.array(9.0),
    }
    place = f"r{number}", "here", group, label
    return RecordMeasures(*place, "ok", {} if rejected else values, {}, is_rejected=rejected)


def test_scores_are_the_numbers_that_any_record_has_and_that_speak_of_the_actuator():
    measured = [
        record(1.0, "sound"),
        record(2.0, "sound"),
        record(3.0, "worn"),
        record(4.0, ""),
        record(5.0, "worn", rejected=True),
    ]
    study = measured_study(COLUMNS, measured, Labels(("sound",)))
    assert {score.name: score.values.tolist() for score in study.scores} == {
        "ring.decay": [1.0, 2.0, 3.0],
        "ring.parts[0]": [1.0, 2.0, 3.0],
        "ring.parts[1]": [-1.0, -2.0, -3.0],
    }
    assert study.scores[0].direction is Direction.RISING
    assert study.scores[0].channels == ("chamber_1_pressure",)


def test_halves_without_groups_and_groups_as_they_are():
    labels = Labels(("sound",), {"worn": 5e-6})
    alone = measured_study(
        COLUMNS, [*(record(float(n), "sound") for n in range(20)), record(99.0, "worn")], labels
    )
    sizes = {(p.name, p.kind, p.is_fit): alone.records.rows(p).size for p in alone.records.populations}
    assert sizes == {
        ("healthy (fit)", Kind.HEALTHY, True): 10,
        ("healthy", Kind.HEALTHY, False): 10,
        ("worn", Kind.FAULT, False): 1,
    }
    assert alone.records.severity.tolist() == [0.0] * 20 + [5e-6]
    grouped = [record(float(n), "sound", f"unit {n % 2}") for n in range(20)] + [
        record(99.0, "worn", "unit 0")
    ]
    records = measured_study(COLUMNS, grouped, labels).records
    assert [(p.name, p.is_fit) for p in records.populations] == [("healthy", True), ("worn", False)]
    assert records.groups[-1] == "unit 0"
    assert not any("no group has both" in remark for remark in records.remarks)
    single = [record(float(n), "sound", "unit 0") for n in range(20)] + [record(99.0, "worn", "unit 1")]
    remarks = measured_study(COLUMNS, single, labels).records.remarks
    assert "only one healthy group" in remarks[0]
    assert "no group has both" in remarks[1]
