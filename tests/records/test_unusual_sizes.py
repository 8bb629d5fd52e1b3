"""Channels whose sizes are unusual: the unit is probably wrong."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import DataError
from hydrofdi.records import Channel
from tests.records.measuring import P1, P2, csv_of, kinds, one

SAMPLES = np.random.default_rng(4).normal(0.0, 0.05, 500)

TWO_CHAMBERS = """\
files: "*.csv"
sampling_frequency: 1 kHz
channels: {chamber_1_pressure: {column: P1, unit: UNIT}, chamber_2_pressure: {column: P2, unit: UNIT}}
"""


def _remarks(tmp_path, unit, level_1, level_2):
    text = csv_of(("P1", level_1 * (1 + SAMPLES)), ("P2", level_2 * (1 + SAMPLES)))
    batch = one(tmp_path, TWO_CHAMBERS.replace("UNIT", unit), run_csv=text)
    return {remark.where: remark.message for remark in batch.remarks[0] if remark.kind == "low_pressure"}


@pytest.mark.parametrize(("level", "meant"), [(17, "MPa or bar"), (150, "bar"), (2500, "psi"), (17e3, "kPa")])
def test_a_column_that_is_read_as_pascal_is_remarked_with_the_likely_unit(tmp_path, level, meant):
    found = _remarks(tmp_path, "Pa", level, level / 2)
    assert found.keys() == {P1, P2}
    assert found[P1].endswith(f"Pa; is the unit {meant}? Hydraulic pressures exceed 0.1 MPa")


@pytest.mark.parametrize(("unit", "level_2"), [("bar", 80), ("bar", 0.3), ("counts", 80)])
def test_no_remark_on_plausible_pressures_a_chamber_at_tank_pressure_or_counts(tmp_path, unit, level_2):
    assert not _remarks(tmp_path, unit, 150, level_2)


def test_an_array_in_bar_is_remarked():
    table = hydrofdi.measure({"P1": 150 * (1 + SAMPLES)}, "dwt", sampling_frequency="1 kHz")
    assert table["status"].tolist() == ["low_pressure"]


def test_a_detector_is_not_trained_on_pressures_in_another_unit_unless_they_are_accepted():
    given = {"sampling_frequency": "1 kHz", "window": "0.5 s", "false_alarm_rate": "30 %", "output": "d2"}
    pressure = 150 * (1 + np.random.default_rng(5).normal(0.0, 0.05, 20_000))
    with pytest.raises(DataError, match="chamber_1_pressure"):
        hydrofdi.train({"P1": pressure}, "dwt", **given)
    assert hydrofdi.train({"P1": pressure}, "dwt", accept=True, **given).false_alarm_rate == 0.3


@pytest.mark.parametrize(
    ("signals", "expected"),
    [
        ({"P1": 1864e5, "P2": 150e5}, {P1}),
        ({"P1": 860e5, "P2": 86e5}, {P1}),
        (
            {"P1": 86e5, "P2": 60e5, "x": 20.0, "u": 2000.0, "xv": 0.1},
            {Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE, Channel.SPOOL_POSITION},
        ),
        (
            {"P1": 86e5, "P2": 60e5, "Pr": 80e6, "Ps": 160e6},
            {Channel.RETURN_PRESSURE, Channel.SUPPLY_PRESSURE},
        ),
        ({"P1": 200e5, "P2": 100e5, "x": 0.2, "u": 5.0, "xv": 1e-4}, set()),
    ],
)
def test_channels_beyond_the_usual_sizes_are_remarked(signals, expected):
    samples = {name: size * (1 + SAMPLES) for name, size in signals.items()}
    (source,) = sources_of(samples, tuple(Channel), Said("1 kHz"))
    (batch,) = source.batches()
    assert {remark.where for remark in batch.remarks[0] if remark.kind == "unusual"} == expected
    assert ("unusual" in hydrofdi.inspect(samples, sampling_frequency="1 kHz").remarks) == bool(expected)


def test_normalized_pressures_are_judged_before_their_division(tmp_path):
    text = csv_of(("P1", 80 + SAMPLES), ("PS", 200 + SAMPLES))
    description = """\
files: "*.csv"
sampling_frequency: 1 kHz
channels: {chamber_1_pressure: {column: P1, unit: bar}, supply_pressure: {column: PS, unit: bar}}
normalize: supply
"""
    assert kinds(one(tmp_path, description, run_csv=text)) == {"normalized"}
