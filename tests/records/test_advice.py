"""What the messages advise leads to right numbers, never to a scale that nobody stated."""

from dataclasses import replace
from textwrap import dedent

import numpy as np
import pytest
from indicators.signals import simulated

import hydrofdi
from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.measuring import measure
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.defects import hum_share
from hydrofdi.records.recording import found_period
from hydrofdi.records.source import measured_source
from tests.records.measuring import (
    BOTH,
    P1,
    P2,
    POSITION,
    USUAL,
    batches,
    csv_of,
    kinds,
    one,
    plain,
    read,
    yaml_of,
)


@pytest.mark.parametrize(("text", "kind", "is_remarked"), [
    ("P1 [Bar]\n1\n2\n", "unknown_unit", False), ("P1 [torr]\n1\n2\n", "unknown_unit", True),
    ("time [s],P1 [bar]\n0,1\n0.5,2\n1,3\n", "sampling_differs", True),
    ("time [ms],P1 [bar]\n0,1\n1,2\n2,3\n", "sampling_differs", False),
])  # fmt: skip
def test_a_header_that_may_contradict_the_description_is_remarked(tmp_path, text, kind, is_remarked):
    batch = one(tmp_path, a_csv=text)
    assert (kind in kinds(batch), batch[P1][0, 0]) == (is_remarked, 1e5)
    if text.startswith("P1 [Bar]"):
        with pytest.raises(DataError, match=r"a.csv: column 'P1 \[Bar\]'"):
            batches(tmp_path, USUAL.replace("bar", "Pa"))


@pytest.mark.parametrize("text", ["time,P1 [bar]\n0,1\n1,2\n", "foo [bar]\n1\n2\n", "P1\n1\n2\n"])
def test_a_suggestion_that_is_copied_as_it_is_gives_no_numbers(tmp_path, text):
    with pytest.raises(DataError) as raised:
        plain(tmp_path, text)
    _, suggestion = str(raised.value).split("YAML file:\n")
    (tmp_path / "m.yaml").write_text(dedent(suggestion), encoding="utf-8")
    with pytest.raises((ConfigError, DataError)):
        list(measured_source(tmp_path / "m.yaml").batches())


def test_the_unit_decides_what_is_time(tmp_path):
    batch = plain(tmp_path, "T [bar],time [s],t [s],P1 [bar]\n5,0,7,1\n5,0.5,9,2\n")
    assert (batch.sampling_frequency, kinds(batch)) == (2.0, {"unused"})


@pytest.mark.parametrize(("value", "is_spike"), [(-9999, True), (1000, True), (8, False)])
def test_one_implausible_sample_is_remarked(tmp_path, value, is_spike):
    samples = [number % 7 for number in range(400)]
    samples[56] = value
    batch = one(tmp_path, a_csv="P1 [bar]\n" + "\n".join(map(str, samples)) + "\n")
    assert ("spike" in kinds(batch)) == is_spike


def test_files_of_one_set_that_differ_are_remarked(tmp_path):
    gained = yaml_of("P1: {column: P1, unit: bar, gain: 2}", sampling="time: {column: time}")
    texts = {f"{name}_csv": f"time [s],P1 [{unit}]\n0,1\n{step},2\n" for name, unit, step in
             [("a", "V", 1), ("b", "V", 1), ("c", "mV", 2)]}  # fmt: skip
    first, other = batches(tmp_path, gained, **texts)
    wanted = {"sampling_varies", "units_vary"}
    assert [wanted & kinds(*each) for each in ((first, 0), (first, 1), (other, 0))] == [set(), set(), wanted]


SAMPLES = np.random.default_rng(4).normal(0.0, 0.05, 500)


@pytest.mark.parametrize(("unit", "level", "level_2", "meant"), [
    ("Pa", 17, 8, "MPa or bar"), ("Pa", 150, 70, "bar"), ("Pa", 2500, 1200, "psi"), ("Pa", 17e3, 8e3, "kPa"),
    ("bar", 150, 80, None), ("bar", 150, 0.3, None), ("counts", 150, 80, None),
])  # fmt: skip
def test_a_column_that_is_read_as_pascal_is_remarked_with_the_likely_unit(
    tmp_path, unit, level, level_2, meant
):
    text = csv_of(("P1", level * (1 + SAMPLES)), ("P2", level_2 * (1 + SAMPLES)))
    batch = one(tmp_path, BOTH.replace("bar", unit), run_csv=text)
    found = {each.where: each.message for each in batch.remarks[0] if each.kind == "low_pressure"}
    assert found.keys() == ({P1, P2} if meant else set())
    assert meant is None or f"unit {meant}?" in found[P1]


def test_a_detector_is_not_trained_on_pressures_in_another_unit_unless_they_are_accepted():
    given = {"sampling_frequency": "1 kHz", "window": "0.5 s", "false_alarm_rate": "30 %", "output": "d2"}
    pressure = 150 * (1 + np.random.default_rng(5).normal(0.0, 0.05, 20_000))
    with pytest.raises(DataError, match="chamber_1_pressure"):
        hydrofdi.train({"P1": pressure}, "dwt", **given)
    assert hydrofdi.train({"P1": pressure}, "dwt", accept=True, **given).file.limits.false_alarm_rate == 0.3


@pytest.mark.parametrize(("signals", "expected"), [
    ({"P1": 1864e5, "P2": 150e5}, {"P1"}), ({"P1": 860e5, "P2": 86e5}, {"P1"}),
    ({"P1": 86e5, "P2": 60e5, "x": 20.0, "u": 2000.0, "xv": 0.1}, {"x", "u", "xv"}),
    ({"P1": 86e5, "P2": 60e5, "Pr": 80e6, "Ps": 160e6}, {"Pr", "Ps"}),
    ({"P1": 200e5, "P2": 100e5, "x": 0.2, "u": 5.0, "xv": 1e-4}, set()),
])  # fmt: skip
def test_channels_beyond_the_usual_sizes_are_remarked(signals, expected):
    samples = {name: size * (1 + SAMPLES) for name, size in signals.items()}
    batch = opened(**samples)
    assert {remark.where.symbol for remark in batch.remarks[0] if remark.kind == "unusual"} == expected
    assert ("unusual" in hydrofdi.inspect(samples, sampling_frequency="1 kHz").remarks) == bool(expected)


def opened(**samples):
    """The record of samples in SI, by symbols."""
    (source,) = open_records(samples, tuple(Channel), Described("500 Hz"))
    return read(source)


@pytest.mark.parametrize(("share", "name"), [(0.0, "weak_rls"), (0.4, "weak_rls"), (0.4, "flow_balance")])
def test_a_stuck_position_gives_no_leakage_and_one_that_is_coarse_or_rests_does(share, name):
    run = simulated(leaks=np.array([1e-9]), moduli=np.array([551e6]))
    p1, p2, x, u = (run[channel][0] for channel in (P1, P2, POSITION, "input_voltage"))
    stuck = np.where(np.arange(x.size) < share * x.size, x, x[int(share * x.size)])
    batch = opened(P1=p1, P2=p2, x=stuck, u=u)
    found = measure(batch, make_indicators({name: {"spool": "command"}, "dwt": {"channel": str(P1)}}))
    assert "piston_position does not change for" in found.obstacles[name][0]
    assert np.isnan(found.values[f"{name}.leakage"]).all()
    assert found.obstacles["dwt"] == (None,)
    still = {"P1": p1[0] + 1e-3 * (p1 - p1[0]), "P2": p2[0] + 1e-3 * (p2 - p2[0]), "x": np.full(x.size, 0.01)}
    for sound in (opened(P1=p1, P2=p2, x=np.round(x, 3), u=u), opened(**still, u=u)):
        assert not any(remark.is_unusable for remark in sound.remarks[0])


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_over_the_strokes_is_found_and_a_mode_that_decays_is_none(mains):
    """Rectified hum: the mains and two harmonics, an error of the frequency as in a real net."""
    rate, pressure = 500.0, np.ravel(hydrofdi.simulate(duration="6 s").P1)  # its mode is at 59.6 Hz
    time = np.arange(3000) / rate
    amplitudes = {1: 1.0, 2: 0.5, 3: 0.2}
    hum = sum(a * np.sin(2.0 * np.pi * k * (mains + 0.02) * time + k) for k, a in amplitudes.items())
    decaying = np.exp(-(time % 0.5) / 0.05) * np.sin(2.0 * np.pi * mains * (time % 0.5))
    assert hum_share(pressure, rate, mains) < 0.1 > hum_share(decaying, rate, mains)
    for samples in (np.where(time < 0.8, 0.0, hum), pressure + 5.0 * np.std(pressure) * hum):
        assert hum_share(samples, rate, mains) > 0.5


TIME, DRAWN = np.arange(20_000) / 1e3, np.random.default_rng(4)
SQUARE = np.sign(np.sin(np.pi * TIME + 0.3))


@pytest.mark.parametrize(("u", "period"), [
    (SQUARE, 2.0), (SQUARE + 0.1 * DRAWN.normal(size=TIME.size), 2.0),
    (3.0 * np.sin(2.0 * np.pi * TIME / 0.8), 0.8), (np.repeat(DRAWN.uniform(-1.0, 1.0, 40), 500), None),
    (np.repeat(DRAWN.choice([-1.0, 1.0], 40), 500), None), (DRAWN.normal(size=TIME.size), None),
    (np.sin(0.5 * np.pi * TIME**1.5), None), (SQUARE[:4000], None), (np.zeros(TIME.size), None),
    (np.where(TIME > 1.0, SQUARE, np.nan), None),
], ids=["square", "noisy", "sine", "steps", "coin", "noise", "chirp", "twice", "still", "holes"])  # fmt: skip
def test_a_period_is_found_where_u_repeats_and_a_known_one_is_kept(u, period):
    batch = RecordBatch({Channel.INPUT_VOLTAGE: u[None]}, 1e3, ("a",))
    assert found_period(batch) == period
    assert found_period(replace(batch, drive_period=5.0)) == 5.0
