"""Sensors lag before they are sampled: at every step of the solver, not from sample to sample."""

from functools import partial

import numpy as np
import pytest

from hydrofdi.config import RunSpec, load_experiment
from hydrofdi.execution import compute
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.simulation import batch
from hydrofdi.simulation.sensing import CHANNELS, CLOCK, Clocks, random_generator, sampling_instants
from tests import machines
from tests.machines import RIG, settings_of
from tests.second_solver import simulate_with_solver

LONG = "record.duration=2 s"
WARMING = ("fluid.temperature=45 °C", "fluid.temperature_drift=1 K/s")
SHORT = (*settings_of(RIG), LONG, "input.period=0.5 s", *WARMING)
DROOP = "supply.droop_resistance=2e10"
LAGS = tuple(f"{channel.section}={{order: second, bandwidth: 150 Hz}}" for channel in CHANNELS)
LOOP = settings_of(machines.LOOP)
NOISY = ("position_sensor.noise=20 µm", "position_sensor.bias=0.1 mm", "position_sensor.gain_error=0.01")


def run_with(*settings):
    return load_experiment(None, settings).nominal_parameters


def columns_of(*runs):
    return compute_columns([Job.of(RunSpec(run), "run", 2e-9) for run in runs])


@pytest.mark.parametrize(("order", "gain"), [("first", 1 / 37**0.5), ("second", 1 / 35.96)])
def test_what_is_above_half_the_sampling_frequency_is_weakened_before_it_is_folded(order, gain):
    """600 Hz folds to 100 Hz, where a lag of 100 Hz would let pass 0.7 of it."""
    run = run_with(*SHORT, "input={shape: sine, period: 1/600 s}".replace("1/600", f"{1 / 600}"))
    lagging = run.with_values({"voltage_sensor.order": order, "voltage_sensor.bandwidth": 100.0})
    voltage, shown = columns_of(run, lagging)["input_voltage"][:, 100:]
    assert np.std(shown) == pytest.approx(gain * np.std(voltage), rel=0.03)


@pytest.mark.parametrize("loop", [(), LOOP], ids=["open", "closed"])
def test_bits_depend_neither_on_stretches_nor_on_chunks_nor_on_neighbours(loop, monkeypatch):
    kinds = (LAGS, (), LAGS[:1], (*LAGS, "measurement.jitter=0.2 ms"), (DROOP, *LAGS, *NOISY))
    runs = [run_with(*SHORT, "record.duration=1 s", *loop, *kind) for kind in kinds] * 8
    together = columns_of(*runs)
    assert set(together["status"]) == {"ok"}
    monkeypatch.setattr(batch, "_STRETCH_STEPS", 37)
    monkeypatch.setattr(batch, "_CHUNK_STEPS", 1260)
    for position in range(len(kinds)):
        alone = columns_of(runs[position])
        for channel in CHANNELS:
            np.testing.assert_array_equal(
                together[channel.signal][position :: len(kinds)], np.repeat(alone[channel.signal], 8, axis=0)
            )


@pytest.mark.parametrize(
    ("loop", "step", "noise"), [((), "0.02 ms", ()), (LOOP, "0.05 ms", NOISY)], ids=["open", "closed"]
)
def test_second_solvers_follow_the_lags_as_the_kernel_does(loop, step, noise, monkeypatch):
    short = "record.duration=0.5 s", f"record.step={step}", "input.period=0.25 s", "wavelet.levels=3"
    run = run_with(*settings_of(RIG), *short, *WARMING, *loop, *LAGS, *noise)
    ours = columns_of(run)
    monkeypatch.setattr(compute, "simulate_batch", partial(simulate_with_solver, solver="lsoda"))
    theirs = columns_of(run)
    for channel in CHANNELS:
        size = np.abs(ours[channel.signal]).max()
        np.testing.assert_allclose(theirs[channel.signal], ours[channel.signal], atol=1e-4 * size)
    np.testing.assert_allclose(theirs["detail_rms"], ours["detail_rms"], rtol=1e-3)


def test_jitter_samples_what_is_between_the_samples():
    """A voltage of 220 Hz, which no spline through samples at 500 Hz knows."""
    run = run_with(*SHORT, f"input={{shape: sine, period: {1 / 220} s}}", "measurement.jitter=0.2 ms")
    run = run.with_values({"voltage_sensor.order": "first", "voltage_sensor.bandwidth": 1e6})
    columns = columns_of(run)
    instants = sampling_instants(columns["time"], 2e-4, random_generator(run, CLOCK))
    expected = run.input.amplitude * np.sin(2.0 * np.pi * 220.0 * instants)
    np.testing.assert_allclose(columns["input_voltage"][0], expected, atol=2e-3)


@pytest.mark.parametrize("cuts", [[], [3, 4, 5, 500], list(range(1, 1000))])
def test_jittered_clocks_are_exact_for_cubics_and_all_else_samples_at_its_time(cuts):
    record = run_with(
        "record.duration=1 s", "record.sampling_frequency=100 Hz", "record.step=1 ms", "wavelet.levels=1"
    ).record
    steps = np.arange(record.n_step)
    cubic = (steps / 100.0 - 4.0) ** 3
    nominal = np.arange(record.n_sample) / record.sampling_frequency
    instants = sampling_instants(nominal, 2.5e-3, np.random.default_rng(6))
    samples = np.zeros((2, record.n_sample))
    clocks = Clocks(record, np.stack([np.zeros(record.n_sample), instants - nominal]))
    for stretch in np.split(steps, cuts):
        clocks.sample(np.stack([cubic[stretch], cubic[stretch]], axis=1), stretch[0], samples)
    np.testing.assert_array_equal(samples[0], cubic[::10])
    np.testing.assert_allclose(samples[1], (instants * 10.0 - 4.0) ** 3, atol=1e-9)


@pytest.mark.parametrize("order", [2, 4])
def test_gain_at_the_corner_is_3_db_down_and_the_phase_an_eighth_of_a_turn_per_pole(order):
    """Of the input voltage, from its second second."""
    sine = run_with(LONG, "input={shape: sine, period: 10 ms}", "record.step=0.02 ms")
    filtered = sine.with_values({"measurement.anti_alias": 100.0, "measurement.anti_alias_order": order})
    columns = columns_of(sine, filtered)
    turns = np.exp(-2j * np.pi * 100.0 * columns["time"][500:])
    true, shown = (np.mean(voltage[500:] * turns) for voltage in columns["input_voltage"])
    gain = shown / true
    assert 20.0 * np.log10(abs(gain)) == pytest.approx(-3.01, abs=0.01)
    assert np.angle(gain * np.exp(0.25j * np.pi * order), deg=True) == pytest.approx(0.0, abs=0.5)


def test_all_channels_pass_the_same_filter():
    """What is at rest is shown to the bit, what jumps is smoothed."""
    still = run_with(LONG, WARMING[0], "input.amplitude=0")
    moving = run_with(*settings_of(RIG), LONG, WARMING[0], DROOP)
    filtered = [run.with_values({"measurement.anti_alias": 50.0}) for run in (still, moving)]
    columns = columns_of(still, filtered[0], moving, filtered[1])
    for channel in CHANNELS:
        rows = columns[channel.signal]
        np.testing.assert_array_equal(rows[0], rows[1])
        jumps = [np.abs(np.diff(row, 2)).max() for row in rows]
        assert jumps[3] < jumps[2] or channel.signal == "oil_temperature", channel


def test_delayed_channel_is_that_much_older_than_the_others():
    """By a whole sample it is shifted; in between it shows the signal of the solver."""
    sine = "input={shape: sine, period: 10 ms}"
    late = run_with(LONG, sine, "pressure_1_sensor.delay=2 ms", "voltage_sensor.delay=0.73 ms")
    columns, plain = columns_of(late), columns_of(run_with(LONG, sine))
    np.testing.assert_allclose(
        columns["chamber_1_pressure"][0, 1:], plain["chamber_1_pressure"][0, :-1], rtol=1e-12
    )
    np.testing.assert_array_equal(columns["chamber_2_pressure"], plain["chamber_2_pressure"])
    voltage = late.input.amplitude * np.sin(2.0 * np.pi * 100.0 * (columns["time"] - 0.73e-3))
    held = late.record.step  # the voltage is held over a step
    slope = 2.0 * np.pi * 100.0 * late.input.amplitude
    np.testing.assert_allclose(columns["input_voltage"][0, 1:], voltage[1:], atol=slope * held)
    assert columns["input_voltage"][0, 0] == pytest.approx(plain["input_voltage"][0, 0], abs=1e-12)
