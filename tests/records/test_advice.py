"""What the messages advise leads to right numbers, never to a scale that nobody stated."""

from textwrap import dedent

import numpy as np
import pytest
from indicators.signals import simulated

import hydrofdi
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.measuring import measure
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.measured.defects import hum_share
from hydrofdi.records.measured.source import measured_source
from hydrofdi.records.stuck import found_period
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


def test_another_spelling_agrees_with_its_unit_alone(tmp_path):
    batch = one(tmp_path, a_csv="P1 [Bar]\n1\n2\n")
    assert batch[P1].tolist() == [[1e5, 2e5]]
    assert "unknown_unit" not in kinds(batch)
    with pytest.raises(DataError, match="the file says Bar, the description says Pa"):
        batches(tmp_path, USUAL.replace("bar", "Pa"), a_csv="P1 [Bar]\n1\n2\n")


def test_a_scale_that_the_header_may_contradict_is_remarked(tmp_path):
    batch = one(tmp_path, a_csv="P1 [torr]\n1\n2\n")
    (text,) = [remark.message for remark in batch.remarks[0] if remark.kind == "unknown_unit"]
    assert "the header says 'torr', the description 'bar'" in text


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
    assert batch.sampling_frequency == 2.0
    assert "columns not used: T [bar], t [s]" in [remark.message for remark in batch.remarks[0]]


def test_a_sampling_frequency_against_the_column_of_time_is_remarked(tmp_path):
    assert "sampling_differs" in kinds(one(tmp_path, a_csv="time [s],P1 [bar]\n0,1\n0.5,2\n1,3\n"))
    assert "sampling_differs" not in kinds(one(tmp_path, a_csv="time [ms],P1 [bar]\n0,1\n1,2\n2,3\n"))


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


def _remarks(tmp_path, unit, level_1, level_2):
    text = csv_of(("P1", level_1 * (1 + SAMPLES)), ("P2", level_2 * (1 + SAMPLES)))
    batch = one(tmp_path, BOTH.replace("bar", unit), run_csv=text)
    return {remark.where: remark.message for remark in batch.remarks[0] if remark.kind == "low_pressure"}


@pytest.mark.parametrize(("level", "meant"), [(17, "MPa or bar"), (150, "bar"), (2500, "psi"), (17e3, "kPa")])
def test_a_column_that_is_read_as_pascal_is_remarked_with_the_likely_unit(tmp_path, level, meant):
    found = _remarks(tmp_path, "Pa", level, level / 2)
    assert found.keys() == {P1, P2}
    assert f"unit {meant}?" in found[P1]


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
        ({"P1": 1864e5, "P2": 150e5}, {"P1"}), ({"P1": 860e5, "P2": 86e5}, {"P1"}),
        ({"P1": 86e5, "P2": 60e5, "x": 20.0, "u": 2000.0, "xv": 0.1}, {"x", "u", "xv"}),
        ({"P1": 86e5, "P2": 60e5, "Pr": 80e6, "Ps": 160e6}, {"Pr", "Ps"}),
        ({"P1": 200e5, "P2": 100e5, "x": 0.2, "u": 5.0, "xv": 1e-4}, set()),
    ],
)  # fmt: skip
def test_channels_beyond_the_usual_sizes_are_remarked(signals, expected):
    samples = {name: size * (1 + SAMPLES) for name, size in signals.items()}
    (source,) = sources_of(samples, tuple(Channel), Said("1 kHz"))
    (batch,) = source.batches()
    assert {remark.where.symbol for remark in batch.remarks[0] if remark.kind == "unusual"} == expected
    assert ("unusual" in hydrofdi.inspect(samples, sampling_frequency="1 kHz").remarks) == bool(expected)


def test_normalized_pressures_are_judged_before_their_division(tmp_path):
    text = csv_of(("P1", 80 + SAMPLES), ("PS", 200 + SAMPLES))
    divided = yaml_of("P1: {column: P1, unit: bar}, Ps: {column: PS, unit: bar}", "normalize: supply")
    assert kinds(one(tmp_path, divided, run_csv=text)) == {"normalized"}


RIG = yaml_of(columns(P1="Pa", P2="Pa", x="m", u="V"), sampling="sampling_frequency: 500 Hz")


def recorded(folder, position_of=lambda x: x, pressure_of=lambda p: p):
    """A simulated record with another position and other pressures, read from a file."""
    run = simulated(leaks=np.array([1e-9]), moduli=np.array([551e6]))
    p1, p2, x, u = (run[channel][0] for channel in (P1, P2, POSITION, "input_voltage"))
    columns = ("P1", pressure_of(p1)), ("P2", pressure_of(p2)), ("x", position_of(x)), ("u", u)
    return one(folder, RIG, run_csv=csv_of(*columns))


@pytest.mark.parametrize("share", [0.0, 0.4])
@pytest.mark.parametrize("name", ["weak_rls", "flow_balance", "adaptive_observer"])
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


@pytest.fixture(scope="module", params=["2 s", "4 s"])
def pressure(request):
    """A noise-free record whose hydraulic mode is at 59.6 Hz."""
    run = hydrofdi.simulate(duration=request.param)
    (batch,) = run.record_source([Channel.CHAMBER_1_PRESSURE]).batches()
    return batch.channels[Channel.CHAMBER_1_PRESSURE][0]


def _hum(pressure, mains):
    """Rectified hum: the mains and two harmonics, an error of the frequency as in a real net."""
    time = np.arange(pressure.size) / RATE
    amplitudes = {1: 1.0, 2: 0.5, 3: 0.2}
    return sum(a * np.sin(2.0 * np.pi * k * (mains + 0.02) * time + k) for k, a in amplitudes.items())


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_over_the_strokes_is_found_and_a_mode_that_decays_is_none(pressure, mains):
    assert hum_share(pressure, RATE, mains) < 0.1
    assert hum_share(pressure + 5.0 * np.std(pressure) * _hum(pressure, mains), RATE, mains) > 0.5


def test_a_repeated_decaying_mode_at_the_very_frequency_is_not_hum():
    time = np.arange(4000) / RATE
    since = time % 0.5
    assert hum_share(np.exp(-since / 0.05) * np.sin(2.0 * np.pi * 50.0 * since), RATE, 50.0) < 0.1


def test_hum_that_clipping_hides_for_a_while_is_found():
    samples = _hum(np.zeros(3000), 60.0)
    samples[:400] = 0.0
    assert hum_share(samples, RATE, 60.0) > 0.5


def test_measuring_a_simulated_record_remarks_no_hum(pressure):
    assert hydrofdi.measure(pressure, sampling_frequency=RATE)["status"].tolist() == ["ok"]


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


@pytest.mark.parametrize("known", [None, 5.0])
@pytest.mark.parametrize("name", PERIODS)
def test_a_period_is_found_where_u_repeats_and_a_known_one_is_kept(name, known):
    u, period = PERIODS[name]
    batch = RecordBatch({Channel.INPUT_VOLTAGE: u[None]}, 1e3, ("a",), drive_period=known)
    assert found_period(batch) == (known or period)
