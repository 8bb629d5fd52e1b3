"""Mistakes in the sections of sensors, and their units."""

from __future__ import annotations

import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.request import parameter_unit
from hydrofdi.errors import ConfigError


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("pressure_1_sensor.bits=12", "bits needs a range to divide; give lowest and highest"),
        ("pressure_1_sensor={bits: 12, lowest: 0}", "bits needs a range to divide"),
        ("spool_sensor={lowest: 2 mm, highest: 1 mm}", "lowest = 2 mm must be below highest = 1 mm"),
        ("spool_sensor={lowest: 1 mm, highest: 1 mm}", "must be below"),
        ("voltage_sensor.order=first", "a sensor of first order needs a bandwidth"),
        ("voltage_sensor.bandwidth=100 Hz", "an ideal sensor has no bandwidth; set order to first or second"),
        ("voltage_sensor.order=third", "must be 'ideal', 'first' or 'second'; found 'third'"),
        ("pressure_1_sensor.noise=-1 kPa", "must be at least 0"),
        ("pressure_1_sensor.noise=1 mm", "must be convertible to Pa"),
        ("pressure_1_sensor.drift=1 Pa", "must be convertible to Pa/s"),
        ("pressure_1_sensor.noise_density=1 Pa", "must be convertible to Pa/Hz^0.5"),
        ("pressure_1_sensor={noise: 1 kPa, noise_density: 1 Pa/√Hz}", "noise_density excludes noise"),
        ("spool_sensor={noise_bandwidth: 1 kHz, noise_density: 1 nm/√Hz}", "noise_density excludes noise"),
        ("measurement.anti_alias=0", "must be greater than 0"),
        ("measurement.anti_alias_order=3", "must be 2 or 4; found 3"),
        ("velocity_sensor.drift=1 m/s", "must be convertible to m/s^2"),
        ("pressure_1_sensor.nose=1 kPa", "unknown key; did you mean 'noise'?"),
        ("pressure_3_sensor.noise=1 kPa", "did you mean 'pressure_"),
        ("sweep.grid.pressure_1_sensor.nose=[1 kPa]", "did you mean 'pressure_1_sensor.noise'?"),
        ("pressure_1_sensor={bits: 33, lowest: 0, highest: 1 MPa}", "must be at most 32"),
        ("measurement.seed=-1", "must be at least 0"),
        ("measurement.jitter=1 ms", "measurement.jitter = 0.001 s is more than a quarter of the sampling"),
    ],
)
def test_mistake_is_reported(setting: str, sentence: str) -> None:
    with pytest.raises(ConfigError) as raised:
        load_experiment(None, [setting])
    assert sentence in str(raised.value)


def test_impossible_point_of_a_sweep_is_reported_with_its_values() -> None:
    settings = ["sweep.grid.record.sampling_frequency=[500, 1000]", "measurement.jitter=0.4 ms"]
    experiment = load_experiment(None, [*settings, "store.signals=none"])
    with pytest.raises(ConfigError, match=r"sampling_frequency = 1000 Hz: measurement.jitter = 0.0004 s"):
        expand_runs(experiment)


def test_quantities_have_the_unit_of_their_channel() -> None:
    sensor = load_experiment(None, ["position_sensor={noise: 5 µm, lowest: -20 cm, drift: 1 µm/min}"])
    assert sensor.position_sensor.noise == 5e-6
    assert sensor.position_sensor.lowest == -0.2
    assert sensor.position_sensor.drift == pytest.approx(1e-6 / 60)
    assert parameter_unit("pressure_2_sensor.lowest") == "Pa"
    assert parameter_unit("velocity_sensor.noise_density") == "m/s/Hz^0.5"
    assert parameter_unit("velocity_sensor.drift") == "m/s^2"
    assert parameter_unit("voltage_sensor.bits") is None
