"""What reaches the record when sensors are set, and what stays as it is."""

import h5py
import numpy as np
import pytest

from hydrofdi.config import RunParameters, RunSpec, load_experiment, request
from hydrofdi.errors import ConfigError
from hydrofdi.execution import compute
from hydrofdi.simulation import sensing
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.store.names import stored_variables
from tests import machines
from tests.commands import run_json
from tests.conftest import sweep_in

SIGNALS = [variable.name for variable in stored_variables("all") if variable.is_signal]
NOISY = (
    "pressure_1_sensor={order: second, bandwidth: 200 Hz, noise: 5 kPa, bias: 1 kPa, drift: 100 Pa/s,"
    " lowest: 0, highest: 250 bar, bits: 14}",
    "velocity_sensor={noise: 1 mm/s, order: first, bandwidth: 150 Hz}", "supply_sensor.noise=1 kPa",
    "measurement.jitter=20 µs",
)  # fmt: skip


def run_with(*settings):
    warming = ["fluid.temperature=45 °C", "fluid.temperature_drift=1 K/s"]
    usual = [*machines.settings_of(machines.RIG), "record.duration=2 s", "input.period=0.5 s", *warming]
    return load_experiment(None, [*usual, *settings]).nominal_parameters


def columns_of(runs, coefficients):
    return compute.compute_columns(
        [compute.Job.of(RunSpec(run), "run", K_i) for run, K_i in zip(runs, coefficients, strict=True)]
    )


LEAKS = (0.0, 2e-9, 1e-8)
VARIED = [
    run_with(*NOISY, f"leakage.internal_coefficient={K_i}", f"measurement.seed={seed}")
    for K_i in LEAKS
    for seed in (0, 1)
]
VARIED_LEAKS = [K_i for K_i in LEAKS for _ in (0, 1)]


@pytest.fixture(scope="module")
def varied():
    return columns_of(VARIED, VARIED_LEAKS)


def test_every_measurable_signal_has_a_channel_and_every_channel_a_section():
    without = {"internal_leakage_flow", "load_force", "reference_position"}
    assert {channel.signal for channel in sensing.CHANNELS} == set(SIGNALS) - without
    sections = [name for name in RunParameters.model_fields if name.endswith("_sensor")]
    assert sorted(channel.section for channel in sensing.CHANNELS) == sorted(sections)


def test_what_happened_is_judged_and_what_is_measured_is_stored(varied):
    ideal = columns_of([run.with_defaults(request.SENSING) for run in VARIED], VARIED_LEAKS)
    features = {"detail_rms", "approximation_rms", "mean_chamber_1_pressure"}
    measured = features | {channel.signal for channel in sensing.CHANNELS}
    for name, values in varied.items():
        if name not in ("dwt.analysis_id", "dwt.obstacle"):
            same = np.array_equal(values, ideal[name], equal_nan=values.dtype.kind == "f")
            assert same != (name in measured or name.startswith("dwt.")), name


def test_bits_do_not_depend_on_order_or_on_neighbours_of_which_one_fails(varied):
    order, broken = [4, 0, 3, 5, 1, 2], run_with(*NOISY, "fluid.bulk_modulus=1e7 MPa")
    shuffled = columns_of([*(VARIED[k] for k in order), broken], [*(VARIED_LEAKS[k] for k in order), 0.0])
    alone = columns_of(VARIED[3:4], VARIED_LEAKS[3:4])
    for name in [*SIGNALS, "detail_rms"]:
        np.testing.assert_array_equal(shuffled[name][:6], varied[name][order])
        np.testing.assert_array_equal(alone[name][0], varied[name][3])
    assert shuffled["status"].tolist() == ["ok"] * 6 + ["diverged"]
    assert np.isnan(shuffled["detail_rms"][6]).all()
    happened = simulate_batch([broken], [0.0]).chamber_1_pressure
    np.testing.assert_array_equal(shuffled["chamber_1_pressure"][6:], happened)


def test_one_clock_samples_all_channels():
    run = run_with("measurement.jitter=0.1 ms")
    happened, columns = simulate_batch([run], [0.0]), columns_of([run], [0.0])
    instants = sensing.sampling_instants(happened.time, 1e-4, sensing.random_generator(run, sensing.CLOCK))
    for channel in sensing.CHANNELS:
        record = getattr(happened, channel.signal)[0]
        expected = sensing.interpolated_signal(record, happened.time, instants)
        np.testing.assert_array_equal(columns[channel.signal][0], expected, err_msg=channel.signal)


def test_errors_come_before_the_range_and_the_range_before_the_levels():
    run = run_with("pressure_1_sensor={bias: 1 MPa, lowest: 0, highest: 4 MPa, bits: 2}")
    signal, time = np.array([-2e6, 0.1e6, 0.7e6, 9e6]), np.arange(4) / 500.0
    levels = np.array([0.0, 4e6 / 3, 4e6 / 3, 4e6])
    np.testing.assert_allclose(sensing.sensor_reading(sensing.CHANNELS[0], run, signal, time), levels)


@pytest.mark.parametrize(("setting", "key"), [
    ("pressure_1_sensor.bits=12", "pressure_1_sensor"), ("voltage_sensor.order=first", "voltage_sensor"),
    ("spool_sensor={lowest: 2 mm, highest: 1 mm}", "spool_sensor"),
    ("pressure_1_sensor.noise=-1 kPa", "pressure_1_sensor.noise"),
    ("pressure_1_sensor.noise=1 mm", "pressure_1_sensor.noise"),
    ("pressure_1_sensor={noise: 1 kPa, noise_density: 1 Pa/√Hz}", "pressure_1_sensor"),
    ("spool_sensor={noise_bandwidth: 1 kHz, noise_density: 1 nm/√Hz}", "spool_sensor"),
    ("measurement.anti_alias_order=3", "measurement.anti_alias_order"),
    ("sweep.grid.pressure_1_sensor.nose=[1 kPa]", "pressure_1_sensor.nose"),
    ("measurement.jitter=1 ms", "measurement.jitter"),
])  # fmt: skip
def test_mistake_is_reported(setting, key):
    with pytest.raises(ConfigError, match=key):
        load_experiment(None, [setting])


def test_quantities_have_the_unit_of_their_channel():
    sensor = load_experiment(None, ["position_sensor={noise: 5 µm, lowest: -20 cm, drift: 1 µm/min}"])
    assert (sensor.position_sensor.noise, sensor.position_sensor.lowest) == (5e-6, -0.2)
    assert sensor.position_sensor.drift == pytest.approx(1e-6 / 60)
    for key, unit in (
        ("pressure_2_sensor.lowest", "Pa"), ("velocity_sensor.noise_density", "m/s/Hz^0.5"),
        ("velocity_sensor.drift", "m/s^2"), ("voltage_sensor.bits", None),
    ):  # fmt: skip
        assert request.parameter_unit(key) == unit


SWEEP = """\
name: measured
record: {duration: 2 s}
pressure_1_sensor: {order: first, bandwidth: 150 Hz, noise: 5 kPa, lowest: 0, highest: 250 bar, bits: 12}
measurement: {jitter: 20 µs}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], measurement.seed: [0, 1]}}
"""


def test_replicates_of_a_sweep_differ_in_what_is_measured_alone_and_simulate_gives_their_bits(tmp_path):
    measured = sweep_in(tmp_path, SWEEP)
    alone = ("--set", "leakage.internal_coefficient=1e-8", "--set", "measurement.seed=1")
    run_id = run_json("simulate", measured.config, *alone, "--out", "run.h5", cwd=tmp_path)["run_id"]
    happened = ("energy_residual", "chamber_1_pressure_max", "internal_leakage_flow", "verdict")
    shown = ("detail_rms", "chamber_1_pressure", "chamber_2_pressure", "piston_velocity", "input_voltage")
    with h5py.File(measured.file) as swept, h5py.File(tmp_path / "run.h5") as file:
        for leak in (0.0, 1e-8):
            first, second = np.flatnonzero(swept["internal_leakage_coefficient"][:] == leak)
            assert not np.array_equal(swept["detail_rms"][first], swept["detail_rms"][second])
            for name in happened:
                np.testing.assert_array_equal(swept[name][first], swept[name][second])
        row = [*swept["run_id"].asstr()[:]].index(run_id)
        for name in shown:
            np.testing.assert_array_equal(np.atleast_2d(file[name][:])[0], swept[name][row], err_msg=name)
