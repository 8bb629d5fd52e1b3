"""Trajectories as sensors show them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sensor import SensorConfig
from hydrofdi.sensing.conversion import quantised, random_error, saturated, systematic_error
from hydrofdi.sensing.dynamics import first_order_response, second_order_response
from hydrofdi.sensing.sampling import interpolated_signal, sampling_instants
from hydrofdi.simulation import Trajectory

Sensor = SensorConfig[float, float, float]
Signal = NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """A signal that has a sensor: its name in a trajectory, and the section of its sensor."""

    signal: str
    section: str


CHANNELS = (
    Channel("chamber_1_pressure", "pressure_1_sensor"),
    Channel("chamber_2_pressure", "pressure_2_sensor"),
    Channel("valve_supply_pressure", "supply_sensor"),
    Channel("piston_position", "position_sensor"),
    Channel("piston_velocity", "velocity_sensor"),
    Channel("spool_position", "spool_sensor"),
    Channel("input_voltage", "voltage_sensor"),
)

CLOCK = "clock"
"""What the jitter is drawn for; all channels share it."""


def measure(runs: Sequence[RunParameters], trajectory: Trajectory) -> Trajectory:
    """A trajectory as the sensors of its runs show it; time and leakage flow stay as they are.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
    trajectory : Trajectory
        What really happened. Runs that failed are left as they are.

    Returns
    -------
    Trajectory
        The same object where every sensor is ideal.
    """
    signals = {
        channel.signal: _measured_rows(channel, runs, trajectory)
        for channel in CHANNELS
        if not all(run.is_shown_exactly(channel.section) for run in runs)
    }
    changes: dict[str, Any] = signals
    return replace(trajectory, **changes) if signals else trajectory


def _measured_rows(channel: Channel, runs: Sequence[RunParameters], trajectory: Trajectory) -> Signal:
    signals: Signal = np.array(getattr(trajectory, channel.signal))
    for row, run in enumerate(runs):
        if trajectory.outcomes[row].is_ok and not run.is_shown_exactly(channel.section):
            signals[row] = sensor_reading(channel, run, signals[row], trajectory.time)
    return signals


def sensor_reading(channel: Channel, run: RunParameters, signal: Signal, time: Signal) -> Signal:
    """What the sensor of a channel shows: lag, sampling, errors, range and resolution, in this order.

    Parameters
    ----------
    channel : Channel
    run : RunParameters
    signal : ndarray, shape (n_time,)
        What really happened, in the unit of the channel.
    time : ndarray, shape (n_time,)
        Nominal sampling instants [s].

    Returns
    -------
    ndarray, shape (n_time,)
    """
    sensor: Sensor = getattr(run, channel.section)
    reading = _response(sensor, signal, 1.0 / run.run.sampling_frequency)
    if run.measurement.jitter > 0.0:
        instants = sampling_instants(time, run.measurement.jitter, random_generator(run, CLOCK))
        reading = interpolated_signal(reading, time, instants)
    reading = np.asarray(reading + systematic_error(time, sensor.bias, sensor.drift))
    if sensor.noise > 0.0:
        reading = reading + random_error(time.size, sensor.noise, random_generator(run, channel.section))
    reading = saturated(reading, sensor.lowest, sensor.highest)
    if sensor.bits is not None and sensor.lowest is not None:
        reading = quantised(reading, sensor.lowest, sensor.resolution)
    return np.asarray(reading, dtype=float)


def _response(sensor: Sensor, signal: Signal, interval: float) -> Signal:
    if sensor.bandwidth is None:
        return signal
    if sensor.order == "first":
        return first_order_response(signal, interval, sensor.bandwidth)
    return second_order_response(signal, interval, sensor.bandwidth, sensor.damping_ratio)


def random_generator(run: RunParameters, source: str) -> np.random.Generator:
    """The random numbers of one source of error in one run.

    The seed is the SHA-256 of ``measurement.seed``, the source and all parameters that the signals of the
    run depend on, so that draws do not depend on other runs, their order, batch or worker, and differ from
    record to record. They come from NumPy's PCG64 and keep their bits within one version of NumPy.

    Parameters
    ----------
    run : RunParameters
    source : str
        Section of a sensor, or `CLOCK`.
    """
    text = f"{run.measurement.seed}\n{source}\n{run.record_text}"
    seed = int.from_bytes(hashlib.sha256(text.encode()).digest(), "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
