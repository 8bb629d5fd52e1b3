"""Sampling, cycles, segments, groups: which samples of a file become which record."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.records import source as sources
from hydrofdi.records.description import path_pattern
from hydrofdi.records.source import measured_source
from tests.records.measuring import (
    BOTH,
    P1,
    POSITION,
    USUAL,
    columns,
    csv_of,
    described,
    kinds,
    one,
    plain,
    yaml_of,
)

RNG = np.random.default_rng(5)
PRESSURE = 8e6
"""[Pa]; lower ones cause a remark."""


def timed(times, name="t [s]"):
    return csv_of((name, times), ("P1", np.asarray(times) * 0.5 + PRESSURE))


TIMED = yaml_of(columns(P1="Pa"), sampling="time: {column: t}")


EVEN = 0.25 + np.arange(500) / 64.0
JITTERED = EVEN + RNG.uniform(-0.2, 0.2, 500) / 64.0


@pytest.mark.parametrize(("unit", "times", "tolerance"), [
    ("s", EVEN, 1e-9), ("ms", EVEN * 1e3, 1e-9), ("min", EVEN / 60.0, 1e-9),
    ("s", np.round(EVEN, 3), 1e-4), ("s", JITTERED, 1e-3),
], ids=["s", "ms", "min", "rounded", "jitter"])  # fmt: skip
def test_a_column_of_time_gives_frequency_and_start_and_jitter_is_remarked(tmp_path, unit, times, tolerance):
    batch = one(tmp_path, TIMED, run_csv=timed(times, f"t [{unit}]"))
    assert batch.sampling_frequency == pytest.approx(64.0, rel=tolerance)
    assert batch.start_time == pytest.approx(times[0] if unit == "s" else 0.25)
    assert kinds(batch) == ({"uneven"} if times is JITTERED else set())
    np.testing.assert_array_equal(batch[P1][0], times * 0.5 + PRESSURE), "left as it is"


def test_a_gap_makes_a_record_unusable_unless_it_is_resampled(tmp_path):
    times = np.delete(np.arange(100) / 10.0, [40, 41])
    batch = one(tmp_path, TIMED, run_csv=timed(times))
    (remark,) = batch.remarks[0]
    assert (remark.kind, remark.is_unusable) == ("gap", True)
    batch = one(tmp_path, TIMED + "resample: 20 Hz\n")
    (remark,) = batch.remarks[0]
    assert (remark.kind, remark.is_unusable) == ("gap", False)
    assert batch.sampling_frequency == 20.0
    assert kinds(one(tmp_path, TIMED + "resample: 4 Hz\n")) == {"gap", "folded"}
    np.testing.assert_allclose(batch[P1][0], np.arange(199) / 20.0 * 0.5 + PRESSURE, rtol=1e-12)


@pytest.mark.parametrize(("times", "place"), [
    ([0, 1, np.nan, 2], "1 sampling"), ([-1e308, 0, 1e308, 1.7e308], "-1e+308 s"),
])  # fmt: skip
def test_times_that_are_none_make_no_record_and_a_wrong_or_second_sampling_is_refused(tmp_path, times, place):
    assert place in one(tmp_path, TIMED, run_csv=timed(times)).rejected[0].remark.message
    with pytest.raises(DataError, match="bar"):
        one(tmp_path, TIMED, run_csv=timed([0, 1, 2], "t [bar]"))
    with pytest.raises(ConfigError, match="sampling_frequency"):
        one(tmp_path, TIMED + "sampling_frequency: 1 kHz\n")
    with pytest.raises(DataError, match="sampling frequency"):
        plain(tmp_path, "t [s],P1 [bar]\n0,1\n1,2\n", 5.0)


DRIVEN = yaml_of(columns(P1="Pa", x="mm", u="V"), sampling="sampling_frequency: 100 Hz")


def driven(n_time=1000, offset=30, period=200):
    """A square wave with noise, a position that follows it, and samples that count themselves."""
    time = np.arange(n_time) - offset
    phase = np.mod(time, period)
    voltage = np.where(phase < period // 2, 2.0, -2.0) + RNG.normal(0, 0.05, n_time)
    position = np.where(phase < period // 2, phase, period - phase) + RNG.normal(0, 0.5, n_time)
    return csv_of(("P1", np.arange(n_time)), ("x", position), ("u", voltage))


def first_samples(batch):
    return batch[P1][:, 0].tolist()


@pytest.mark.parametrize(("cycles", "first"), [
    ("by: period, period: 1.004 s", [round(100.4 * n) for n in range(9)]),  # it does not drift
    ("by: edges, edge: rising", [30, 230, 430, 630]), ("by: edges, edge: falling", [130, 330, 530, 730]),
    ("by: edges, edge: both", [30, 130, 230, 330, 430, 530, 630, 730, 830]),
])  # fmt: skip
def test_cycles_of_a_period_and_from_edges_of_the_command(tmp_path, cycles, first):
    assert first_samples(one(tmp_path, DRIVEN + f"cycles: {{{cycles}}}\n", run_csv=driven())) == first


def test_cycles_begin_behind_what_is_trimmed_and_short_ones_and_files_without_any_are_listed(tmp_path):
    periodic = DRIVEN + "trim: {start: 0.3 s}\ncycles: {by: period, period: 2 s}\n"
    batch = one(tmp_path, periodic, run_csv=driven())
    assert first_samples(batch) == [30, 230, 430, 630]
    assert (batch.n_time, batch.drive_period, batch.start_time) == (200, 2.0, 0.0)
    assert batch.record_ids == ("run.csv#1", "run.csv#2", "run.csv#3", "run.csv#4")
    assert ["left_out" in kinds(batch, row) for row in range(4)] == [True, False, False, False]
    batch = one(tmp_path, DRIVEN + "cycles: {by: edges, length: 3 s}\n")
    assert [(each.record_id, each.remark.kind) for each in batch.rejected] == [
        (f"run.csv#{n}", "short") for n in range(1, 5)
    ]
    batch = one(tmp_path, DRIVEN + "cycles: {by: edges}\n", run_csv=STILL)
    assert batch.rejected[0].remark.kind == "no_cycle"


STROKES = DRIVEN.replace(
    "files:", 'path: "{unit} {run}.csv"\ngroup: "{unit}{direction}"\nlabel: "{run}"\nfiles:'
)


def stroke(way):
    """At rest to sample 50, moving to 150, then at rest."""
    position = 3.0 + way * np.clip(np.arange(400) - 50.0, 0.0, 100.0)
    return csv_of(("P1", np.arange(400)), ("x", position), ("u", np.ones(400)))


OUT, BACK, STILL = stroke(1.0), stroke(-1.0), stroke(0.0)


def strokes(folder, more="", labels=False, **texts):
    return next(measured_source(described(folder, STROKES + more, **texts)).batches(labels=labels))


def test_direction_group_and_label(tmp_path):
    texts = {"A 1_csv": OUT, "A 2_csv": BACK, "A 10_csv": STILL, "odd_csv": OUT}
    batch = strokes(tmp_path, labels=True, **texts)
    assert batch.groups == ("A+", "A-", "A0")
    assert batch.labels == ("1", "2", "10")
    assert [record.remark.kind for record in batch.rejected] == ["path"]
    assert strokes(tmp_path).labels is None


@pytest.mark.parametrize(("segment", "first", "n_time"), [
    ("{part: motion}", 53, 95), ("{part: hold}", 198, 202), ("{part: hold, length: 1 s}", 198, 100),
    ("{part: impact, length: 0.5 s}", 142, 50), ("{part: impact, before: 0, length: 1 s}", 148, 100),
])  # fmt: skip
def test_segments_of_a_stroke(tmp_path, segment, first, n_time):
    texts = {"A 1_csv": OUT, "A 2_csv": BACK}
    batch = strokes(tmp_path, f"segment: {segment}\n", **texts)
    assert (first_samples(batch), batch.n_time, batch.groups) == ([first] * 2, n_time, ("A+", "A-"))


def test_a_segment_that_is_not_there_is_a_reason(tmp_path):
    texts = {"A 1_csv": OUT, "A 2_csv": STILL}
    batch = strokes(tmp_path, "segment: {part: hold, length: 9 s}\n", labels=True, **texts)
    assert [(each.remark.kind, each.group, each.label) for each in batch.rejected] == [
        ("short", "A+", "1"), ("no_motion", "A0", "2"),
    ]  # fmt: skip
    assert [each.label for each in strokes(tmp_path, "segment: {part: motion}\n").rejected] == [""]


def test_gain_offset_and_sign_are_applied_in_the_unit(tmp_path):
    current = "{column: I, unit: bar, gain: 15.625, offset: -62.5}"
    turned = "{column: x, sign: -1, offset: 2, range: [-5 mm, 0 mm]}"
    scaled = yaml_of(f"P1: {current}, x: {turned}")
    batch = one(tmp_path, scaled, run_csv="I [mA],x [mm]\n4,1\n20,2\n12,4\n")
    np.testing.assert_allclose(batch[P1], [[0.0, 250e5, 125e5]])
    np.testing.assert_allclose(batch[POSITION], [[-3e-3, -4e-3, -6e-3]])
    (remark,) = [remark for remark in batch.remarks[0] if remark.kind == "out_of_range"]
    assert "33.33%" in remark.message


def test_defects_of_channels_are_remarked(tmp_path):
    time = np.arange(2000) / 1000.0
    noise = RNG.normal(0, 1, time.size)
    columns = {
        "sound": 100 + noise,
        "clipped": np.maximum(noise, 0.0),
        "saturated": 100 + np.minimum(noise, 0.5),
        "coarse": np.round(0.7 * noise),
        "sine": np.round(50 * np.sin(np.arange(time.size))),
        "hum": 100 + 0.3 * noise + np.sin(2 * np.pi * 50 * time),
        "stuck": np.full(time.size, 7.0),
    }
    text = csv_of(*columns.items())
    for name in columns:
        expected = {name} - {"sound", "coarse", "sine"}
        batch = one(tmp_path, USUAL.replace("column: P1", f"column: {name}"), run_csv=text)
        assert kinds(batch) == expected
        if name == "saturated":
            assert batch.remarks[0][0].message.endswith("100.5 bar")
        assert any(remark.is_unusable for remark in batch.remarks[0]) == (name == "stuck")
    moves = ("P1", PRESSURE + noise[:400]), ("x", np.full(400, 2.0)), ("u", np.arange(400) // 100 % 2)
    (remark,) = one(tmp_path, DRIVEN, run_csv=csv_of(*moves)).remarks[0]
    assert (remark.kind, remark.where, remark.is_unusable) == ("stuck", POSITION, False)


def test_pressures_that_are_divided_by_the_supply_have_no_unit(tmp_path):
    channels = "P1: {column: P1, unit: bar}, Ps: {column: PS, unit: bar}, x: {column: x, unit: counts}"
    divided = yaml_of(channels, "normalize: supply")
    noise = RNG.normal(0.0, 0.05, 500)  # pressures are judged before their division
    text = csv_of(("P1", 60 + noise), ("PS", 200 + noise), ("x", 1 + noise))
    batch = one(tmp_path, divided, run_csv=text)
    np.testing.assert_allclose(batch[P1], [(60 + noise) / np.mean(200 + noise)])
    assert [batch.unit(channel) for channel in (P1, POSITION)] == ["1", "counts"]
    assert kinds(batch) == {"normalized"}
    statistics = make_indicators(["pressure_statistics"])["pressure_statistics"]
    assert output_unit(statistics, statistics.outputs[0], batch) == "1"
    with pytest.raises(DataError, match="counts"):
        one(tmp_path, divided.replace("PS, unit: bar", "PS, unit: counts"))
    batch = one(tmp_path, divided, run_csv=csv_of(("P1", 60 + noise), ("PS", noise - 200), ("x", 1 + noise)))
    assert batch.rejected[0].remark.kind == "no_reference"


def test_a_source_of_many_files_has_batches_of_so_many_samples(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "_MOST_SAMPLES", 200_000)
    np.savez(tmp_path / "run.npz", P1=np.arange(20_000.0), P2=np.arange(20_000.0))
    source = measured_source(described(tmp_path, BOTH.replace("*.csv", "run.npz")))
    many = replace(source, files=[*source.files] * 20)
    assert [batch.n_record for batch in many.batches()] == [5] * 4


@pytest.mark.parametrize(("template", "place", "values"), [
    ("-".join(f"{{n{k}}}" for k in range(20)) + "/x.csv", "-" * 240 + ".csv", None),
    ("{a}-{b}.csv", "rig/1-2-3.csv.csv", ["1", "2-3.csv"]), ("{a}{b}-{c}", "12--3", ["1", "2", "-3"]),
])  # fmt: skip
def test_fields_of_a_path_end_where_the_next_text_begins(template, place, values):
    match = path_pattern(template).search(place)
    assert (match and list(match.groups())) == values
