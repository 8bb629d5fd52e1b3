"""Studies of measured records: their labels and groups."""

import numpy as np

import hydrofdi
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures
from hydrofdi.records import Channel
from hydrofdi.studies.reading import measured_study

P1 = (Channel.CHAMBER_1_PRESSURE,)
COLUMNS = [
    MeasuredOutput("ring", Output("decay", "1/s", "decay", direction=Direction.RISING), "1/s", P1),
    MeasuredOutput("ring", Output("parts", "1", "shares", {"part": 2}), "1", P1),
    MeasuredOutput("ring", Output.quality("error", "1/s", "standard error"), "1/s", P1),
    MeasuredOutput("never", Output("there", "1", "nothing"), "1", P1),
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
    measured = [record(float(n + 1), label) for n, label in enumerate(["sound", "sound", "worn", ""])]
    _, scores = measured_study(COLUMNS, [*measured, record(5.0, "worn", rejected=True)], ["sound"], {})
    assert {score.name: score.values.tolist() for score in scores} == {
        "ring.decay": [1.0, 2.0, 3.0],
        "ring.parts[0]": [1.0, 2.0, 3.0],
        "ring.parts[1]": [-1.0, -2.0, -3.0],
    }
    assert (scores[0].direction, scores[0].channels) == (Direction.RISING, ("chamber_1_pressure",))


def test_of_one_record_for_each_unit_it_cannot_be_told_whether_units_differ():
    noise = np.random.default_rng(1).standard_normal((6, 1000))
    noise[5] *= 9.0
    labels = {"label": ["sound"] * 5 + ["leaking"], "group": [f"unit {k}" for k in range(6)]}
    found = hydrofdi.evaluate(5e6 + 1e4 * noise, **labels, healthy="sound", sampling_frequency="1 kHz")
    assert {score["stands_clear"] for score in found.scores} == {None}
    assert found.conclusion
    (area,) = found.scores[0]["auc"]
    assert (area["value"], area["high"]) == (1.0, 1.0)
    assert area["low"] < 0.9
