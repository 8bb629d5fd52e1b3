"""The table of designs: what is bought, and what is not shown to be."""

import numpy as np
import pytest

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.designs import design_records, designs_block
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.studies.rules import Rules
from tests.report.rows import rows as texts

LITRES_PER_MINUTE = 1e-3 / 60.0
P1, U = "chamber_1_pressure", "input_voltage"
DESIGNS = (
    ({"record.duration": 20.0}, 1.0),
    ({"record.duration": 5.0}, 1.0),
    ({"pressure_1_sensor.noise": 2500.0, "pressure_2_sensor.noise": 2500.0}, 0.2),
)
"""What each design sets, and the noise of its score."""


def judged(setting, noise, seed, n_fit=300, n=100):
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
    return tuple(judged(setting, noise, seed) for seed, (setting, noise) in enumerate(DESIGNS))


def rows(detections):
    (sheet,) = designs_block(detections).tables
    return sheet.columns, {row[0]: row[1:] for row in texts(sheet)}


def test_designs_are_named_by_what_they_change(detections):
    assert list(rows(detections)[1]) == [
        "record.duration = 20 s",
        "record.duration = 5 s",
        "pressure_1_sensor.noise, pressure_2_sensor.noise = 2.5 kPa",
    ]


def test_a_better_sensor_is_marked_and_an_equal_design_is_not(detections):
    headers, table = rows(detections)
    assert headers == ["Design", "P1 u", "P1", "dwt.d2"]
    first, longer, better = table.values()
    assert not any(text.endswith(("↑", "↓", "=")) for text in first)
    assert all(text.endswith(" =") for text in longer)
    assert all(text.endswith(" ↑") for text in better)


def test_plain_data_hold_the_differences(detections):
    first, longer, better = design_records(detections)
    assert [each["gain"] for each in first["detectors"]] == [None] * 3
    for each, other in zip(longer["detectors"], better["detectors"], strict=True):
        assert each["gain"]["low"] <= 0.0 <= each["gain"]["high"]
        assert (each["gain"]["is_shown"], other["gain"]["is_shown"]) == (False, True)
    assert better["design"] == DESIGNS[2][0]


def test_a_single_design_has_no_table(detections):
    assert designs_block(detections[:1]) is None
    assert design_records(detections[:1]) == []
