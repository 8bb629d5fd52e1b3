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
    columns,
    csv_of,
    kinds,
    one,
    plain,
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
    found = [
        kinds(batch, row) for batch in batches(tmp_path, gained, **texts) for row in range(batch.n_record)
    ]
    wanted = {"sampling_varies", "units_vary"}
    assert [kinds & wanted for kinds in found] == [set(), set(), wanted]


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


@pytest.mark.parametrize(
    ("signals", "expected"),
    [
        ({"P1": 1864e5, "P2": 150e5}, {"P1"}), ({"P1": 860e5, "P2": 86e5}, {"P1"}),
        ({"P1": 86e5, "P2": 60e5, "x": 20.0, "u": 2000.0, "xv": 0.1}, {"x", "u", "xv"}),
        ({"P1": 86e5, "P2": 60e5, "Pr": 80e6, "Ps": 160e6}, {"Pr", "Ps"}),
        ({"P1": 200e5, "P2": 100e5, "x": 0.2, "u": 5.0, "xv": 1e-4}, set()),
    ],
)  # fmt: skip
def test_channels_beyond_the_usual_sizes_are_remarked(signals, expected):
    samples = {name: size * (1 + SAMPLES) for name, size in signals.items()}
    (source,) = open_records(samples, tuple(Channel), Described("1 kHz"))
    (batch,) = source.batches()
    assert {remark.where.symbol for remark in batch.remarks[0] if remark.kind == "unusual"} == expected
    assert ("unusual" in hydrofdi.inspect(samples, sampling_frequency="1 kHz").remarks) == bool(expected)


RIG = yaml_of(columns(P1="Pa", P2="Pa", x="m", u="V"), sampling="sampling_frequency: 500 Hz")


def recorded(folder, position_of=lambda x: x, pressure_of=lambda p: p):
    """A simulated record with another position and other pressures, read from a file."""
    run = simulated(leaks=np.array([1e-9]), moduli=np.array([551e6]))
    p1, p2, x, u = (run[channel][0] for channel in (P1, P2, POSITION, "input_voltage"))
    columns = ("P1", pressure_of(p1)), ("P2", pressure_of(p2)), ("x", position_of(x)), ("u", u)
    return one(folder, RIG, run_csv=csv_of(*columns))


@pytest.mark.parametrize(("share", "name"), [(0.0, "weak_rls"), (0.4, "weak_rls"), (0.4, "flow_balance")])
def test_a_stuck_position_gives_no_leakage(tmp_path, share, name):
    batch = recorded(
        tmp_path, lambda x: np.where(np.arange(x.size) < share * x.size, x, x[int(share * x.size)])
    )
    found = measure(batch, make_indicators({name: {"spool": "command"}, "dwt": {"channel": str(P1)}}))
    assert "piston_position does not change for" in found.obstacles[name][0]
    assert np.isnan(found.values[f"{name}.leakage"]).all()
    assert found.obstacles["dwt"] == (None,)


def test_a_position_that_moves_or_rests_with_the_pressures_is_measured(tmp_path):
    coarse = recorded(tmp_path, lambda x: np.round(x, 3))
    held = recorded(tmp_path, lambda x: np.full(x.size, 0.01), lambda p: p[0] + 1e-3 * (p - p[0]))
    for batch in (coarse, held):
        assert not any(remark.is_unusable for remark in batch.remarks[0])


RATE = 500.0


@pytest.fixture(scope="module")
def pressure():
    """A noise-free record whose hydraulic mode is at 59.6 Hz."""
    return np.ravel(hydrofdi.simulate(duration="2 s").P1)


def _hum(pressure, mains):
    """Rectified hum: the mains and two harmonics, an error of the frequency as in a real net."""
    time = np.arange(pressure.size) / RATE
    amplitudes = {1: 1.0, 2: 0.5, 3: 0.2}
    return sum(a * np.sin(2.0 * np.pi * k * (mains + 0.02) * time + k) for k, a in amplitudes.items())


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_over_the_strokes_is_found_and_a_mode_that_decays_is_none(pressure, mains):
    time = np.arange(4000) / RATE
    decaying = np.exp(-(time % 0.5) / 0.05) * np.sin(2.0 * np.pi * mains * (time % 0.5))
    assert hum_share(pressure, RATE, mains) < 0.1 > hum_share(decaying, RATE, mains)
    clipped = np.where(np.arange(3000) < 400, 0.0, _hum(np.zeros(3000), mains))
    assert hum_share(clipped, RATE, mains) > 0.5
    assert hum_share(pressure + 5.0 * np.std(pressure) * _hum(pressure, mains), RATE, mains) > 0.5


TIME = np.arange(20_000) / 1e3
DRAWN = np.random.default_rng(4)
SQUARE = np.sign(np.sin(np.pi * TIME + 0.3))


PERIODS = {
    "square": (SQUARE, 2.0),
    "noisy": (SQUARE + 0.1 * DRAWN.normal(size=TIME.size), 2.0),
    "sine": (3.0 * np.sin(2.0 * np.pi * TIME / 0.8), 0.8),
    "steps": (np.repeat(DRAWN.uniform(-1.0, 1.0, 40), 500), None),
    "telegraph": (np.repeat(DRAWN.choice([-1.0, 1.0], 40), 500), None),
    "noise": (DRAWN.normal(size=TIME.size), None),
    "chirp": (np.sin(0.5 * np.pi * TIME**1.5), None),
    "two periods": (SQUARE[:4000], None),
    "still": (np.zeros(TIME.size), None),
    "holes": (np.where(TIME > 1.0, SQUARE, np.nan), None),
}


@pytest.mark.parametrize("name", PERIODS)
def test_a_period_is_found_where_u_repeats_and_a_known_one_is_kept(name):
    u, period = PERIODS[name]
    batch = RecordBatch({Channel.INPUT_VOLTAGE: u[None]}, 1e3, ("a",))
    assert found_period(batch) == period
    assert found_period(replace(batch, drive_period=5.0)) == 5.0
