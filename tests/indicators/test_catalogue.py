"""What every indicator keeps, read from the list of them."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import load_scores
from hydrofdi.indicators import indicator_names, indicators_of, make_indicators, measure
from hydrofdi.indicators.measuring import used_channels
from hydrofdi.records import Channel, RecordBatch
from indicators.signals import SAMPLING_FREQUENCY, assert_rows_stand_alone, ringing, simulated, square_wave

N_TIME = 2000


def all_channels(n_record=4):
    """Records with every channel, moving as those of an actuator do."""
    pressure, time = ringing(1, n_record, N_TIME), np.arange(N_TIME) / SAMPLING_FREQUENCY
    draw = np.random.default_rng(2)
    command = np.tile(square_wave(N_TIME, 500), (n_record, 1))
    position = 0.02 * np.abs(time % 2.0 - 1.0) + draw.normal(0.0, 1e-5, (n_record, N_TIME))
    other = 17e6 - pressure + draw.normal(0.0, 5e3, pressure.shape)
    velocity = np.gradient(position, axis=1) * SAMPLING_FREQUENCY
    supply, ret, warm = (np.full_like(pressure, value) for value in (17.2e6, 0.0, 310.0))
    samples = {
        "chamber_1_pressure": pressure, "chamber_2_pressure": other, "supply_pressure": supply,
        "return_pressure": ret, "piston_position": position, "piston_velocity": velocity,
        "spool_position": 2.2e-5 * command, "input_voltage": command, "oil_temperature": warm,
    }  # fmt: skip
    ids = tuple(str(row) for row in range(n_record))
    channels = {channel: samples[channel.value] for channel in Channel}
    return RecordBatch(channels, SAMPLING_FREQUENCY, ids, drive_period=2.0)


@pytest.fixture(scope="module")
def beside():
    """Unlike records, and the numbers of all indicators together."""
    records = replace(all_channels(), drive_period=None)
    records[Channel.SUPPLY_PRESSURE][:] *= 0.9
    records[Channel.INPUT_VOLTAGE][:] = np.roll(records[Channel.INPUT_VOLTAGE], 100, axis=1)
    return records, measure(records, make_indicators(indicator_names())).values


@pytest.mark.parametrize("name", indicator_names())
class TestEachIndicator:
    @pytest.fixture
    def indicator(self, name):
        return make_indicators([name])[name]

    def test_sees_the_same_whatever_else_is_measured(self, name, beside):
        records, together = beside
        alone = make_indicators([name])
        read = {each: records[each] for each in used_channels(alone)}
        for key, array in measure(replace(records, channels=read), alone).values.items():
            np.testing.assert_array_equal(array, together[key])

    def test_gives_what_it_says_and_leaves_the_records_as_they_are(self, name, indicator):
        records = all_channels()
        before = {channel: samples.copy() for channel, samples in records.channels.items()}
        values = measure(records, {name: indicator}).values
        assert values.keys() == {f"{name}.{output.name}" for output in indicator.outputs}
        for output in indicator.outputs:
            array = values[f"{name}.{output.name}"]
            assert array.shape == (records.n_record, *output.dims.values())
            assert array.dtype == np.float64
        for channel, samples in records.channels.items():
            np.testing.assert_array_equal(samples, before[channel])

    def test_sees_a_gap_in_the_record_that_has_it_and_in_no_other(self, name, indicator):
        whole, gap = all_channels(), all_channels()
        for channel in indicator.channels:
            gap.channels[channel][1, 700:] = np.nan
        one, other = (measure(records, {name: indicator}).values for records in (whole, gap))
        for key, array in one.items():
            np.testing.assert_array_equal(np.delete(array, 1, 0), np.delete(other[key], 1, 0), err_msg=key)
        assert any(np.isnan(array[1]).any() for array in other.values())

    @pytest.mark.parametrize("sample", [np.inf, 1e200])
    def test_has_no_infinite_numbers(self, name, indicator, sample):
        records = all_channels(2)
        for channel in indicator.channels:
            records.channels[channel][1, 700:900] = sample
        measures = measure(records, {name: indicator})
        assert not any(np.isinf(array).any() for array in measures.values.values())
        has_numbers = any(np.isfinite(array[1]).any() for array in measures.values.values())
        assert has_numbers or measures.obstacles[name][1]

    @pytest.mark.parametrize("n_time", [1, 3, 20, 200])
    def test_of_few_samples_gives_numbers_or_the_reason_why_not(self, name, indicator, n_time):
        measures = measure(all_channels(2).window(0, n_time), {name: indicator})
        for row, reason in enumerate(measures.obstacles[name]):
            assert reason or any(np.isfinite(array[row]).any() for array in measures.values.values())

    def test_names_a_channel_that_it_lacks(self, name, indicator):
        records = all_channels(2)
        for channel in indicator.channels:
            left = {each: samples for each, samples in records.channels.items() if each is not channel}
            reason = measure(replace(records, channels=left), {name: indicator}).obstacles[name][0]
            assert f"has no {channel.value}" in reason


SHORTEST = {
    "a4": 240, "adaptive_observer": 1550, "band_power": 500, "cross_correlation": 51, "dwt": 480,
    "ekf_innovation": 1050, "emd": 16, "modwt": 466, "post_step_ac": 625, "pressure_statistics": 2,
    "reduced_order": 1050, "sliding": 1050, "stft": 125, "vmd": 16, "volterra": 1300, "wavelet_packet": 240,
    "weak_rls": 1050,
}  # fmt: skip


@pytest.mark.parametrize(("name", "n_time"), SHORTEST.items())
def test_the_shortest_record_that_is_measured(name, n_time):
    indicators = make_indicators([name])
    refused, measured = (measure(all_channels(1).window(0, n), indicators) for n in (n_time - 1, n_time))
    assert refused.obstacles[name][0]
    assert not measured.obstacles[name][0]


WITH_OPTIONS = [
    ("a4", {"level": 2, "wavelet": "haar"}), ("dwt", {"phase": "all"}), ("modwt", {"boundary": "circle"}),
    ("modwt", {"boundary": "left_out"}), ("flow_balance", {"spool": "command", "supply": "nominal"}),
    ("flow_balance", {"chambers": 1}), ("weak_rls", {"spool": "command", "supply": "sum"}),
    ("weak_rls", {"chambers": 1, "supply": "nominal"}), ("pressure_decay", {"rest": "whole", "settling": 0}),
    ("ring_down", {"steps": "signal"}), ("envelope", {"steps": "command"}), ("vmd", {"most_iterations": 50}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "options"), [*((name, {}) for name in indicator_names()), *WITH_OPTIONS])
def test_a_record_is_measured_alike_in_any_batch_also_with_other_options(name, options):
    assert_rows_stand_alone(all_channels(), name, **options)


def test_files_of_indicators_are_combined(tmp_path):
    scores = "scores:\n  s: {kind: mahalanobis, of: [one.d1, one.d2]}\n"
    (tmp_path / "one.yaml").write_text(f"indicators:\n  one: {{kind: dwt, levels: 3}}\n{scores}")
    (tmp_path / "two.yaml").write_text("indicators: {two: {kind: modwt}}\n")
    both = tmp_path / "both.yaml"
    both.write_text("extends: [one.yaml, two.yaml]\n")
    chosen = indicators_of(str(both))
    assert {label: each.name for label, each in chosen.items()} == {"one": "dwt", "two": "modwt"}
    assert list(load_scores(str(both), chosen)) == ["s"]
    both.write_text("extends: one.yaml\nindicators: {one: {levels: 4}}\n")
    (one,) = indicators_of(str(both)).values()
    assert (one.name, one.options.levels) == ("dwt", 4)


def test_a_growing_leak_moves_outputs_in_their_direction():
    names = (
        "dwt.d2", "dwt.d3", "envelope.decay_rate", "flow_balance.leakage", "ring_down.damping_ratio",
        "flow_balance.internal_coefficient", "post_step_ac.rms", "post_step_ac.relative",
    )  # fmt: skip
    leaks = [0.0, 1e-9, 5e-9, 1.3e-8]
    records = replace(simulated("record.duration=6 s", leaks=leaks, moduli=[551e6] * 4), drive_period=2.0)
    indicators = make_indicators([*dict.fromkeys(name.partition(".")[0] for name in names)])
    values = measure(records, indicators).values
    directions = {f"{k}.{o.name}": o.direction for k, each in indicators.items() for o in each.outputs}
    for name in names:
        change = np.diff(values[name])
        assert ({"rising": change, "falling": -change}[directions[name]] > 0.0).all(), name
