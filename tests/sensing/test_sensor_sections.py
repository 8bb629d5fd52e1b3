"""Mistakes in the sections of sensors, and their units."""

import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.request import parameter_unit
from hydrofdi.errors import ConfigError


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ("pressure_1_sensor.bits=12", "pressure_1_sensor"),
        ("pressure_1_sensor={bits: 12, lowest: 0}", "pressure_1_sensor"),
        ("spool_sensor={lowest: 2 mm, highest: 1 mm}", "spool_sensor"),
        ("voltage_sensor.order=first", "voltage_sensor"),
        ("voltage_sensor.bandwidth=100 Hz", "voltage_sensor"),
        ("pressure_1_sensor.noise=-1 kPa", "pressure_1_sensor.noise"),
        ("pressure_1_sensor.noise=1 mm", "pressure_1_sensor.noise"),
        ("pressure_1_sensor.drift=1 Pa", "pressure_1_sensor.drift"),
        ("pressure_1_sensor.noise_density=1 Pa", "pressure_1_sensor.noise_density"),
        ("pressure_1_sensor={noise: 1 kPa, noise_density: 1 Pa/√Hz}", "pressure_1_sensor"),
        ("spool_sensor={noise_bandwidth: 1 kHz, noise_density: 1 nm/√Hz}", "spool_sensor"),
        ("measurement.anti_alias_order=3", "measurement.anti_alias_order"),
        ("sweep.grid.pressure_1_sensor.nose=[1 kPa]", "pressure_1_sensor.nose"),
        ("measurement.jitter=1 ms", "measurement.jitter"),
    ],
)
def test_mistake_is_reported(setting, key):
    with pytest.raises(ConfigError, match=key):
        load_experiment(None, [setting])


def test_impossible_point_of_a_sweep_is_reported_with_its_values():
    settings = ["sweep.grid.record.sampling_frequency=[500, 1000]", "measurement.jitter=0.4 ms"]
    experiment = load_experiment(None, [*settings, "store.signals=none"])
    with pytest.raises(ConfigError, match=r"sampling_frequency = 1000 Hz: measurement.jitter = 0.0004 s"):
        expand_runs(experiment)


def test_quantities_have_the_unit_of_their_channel():
    sensor = load_experiment(None, ["position_sensor={noise: 5 µm, lowest: -20 cm, drift: 1 µm/min}"])
    assert sensor.position_sensor.noise == 5e-6
    assert sensor.position_sensor.lowest == -0.2
    assert sensor.position_sensor.drift == pytest.approx(1e-6 / 60)
    assert parameter_unit("pressure_2_sensor.lowest") == "Pa"
    assert parameter_unit("velocity_sensor.noise_density") == "m/s/Hz^0.5"
    assert parameter_unit("velocity_sensor.drift") == "m/s^2"
    assert parameter_unit("voltage_sensor.bits") is None
