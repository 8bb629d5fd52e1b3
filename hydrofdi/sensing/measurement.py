"""Trajectories as measured by sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.sensing.channels import CHANNELS, CLOCK, Channel, random_generator
from hydrofdi.sensing.conversion import quantised, saturated, systematic_error
from hydrofdi.sensing.feedback import feedback_noise
from hydrofdi.sensing.lagging import LaggedRuns
from hydrofdi.sensing.noise import gaussian_noise, noise_autocovariance
from hydrofdi.sensing.sampling import interpolated_signal, sampling_instants
from hydrofdi.simulation.trajectory import Trajectory

Signal = NDArray[np.float64]


class Measurement:
    """The sensors of a batch of runs.

    As a tap it evaluates lags at every step of the solver during simulation; `show` then applies all sensors
    to the trajectory.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        The simulated runs.
    """

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        self.runs = runs
        self._lagged: dict[int, tuple[LaggedRuns, int]] = {}

    def wants(self, position: int) -> bool:
        """Whether any channel of the run has a lag."""
        return any(channel.lags(self.runs[position]) for channel in CHANNELS)

    def feedback_noise(self, position: int) -> Signal | None:
        """Noise of the position that the controller of a run reads, at each of its samples [m], or None."""
        return feedback_noise(self.runs[position])

    def reader(self, positions: Sequence[int]) -> LaggedRuns:
        """Reader that evaluates the lags of these runs."""
        lagged = LaggedRuns([self.runs[position] for position in positions])
        self._lagged |= {position: (lagged, lane) for lane, position in enumerate(positions)}
        return lagged

    def show(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory as measured; time and leakage flow are unchanged.

        Parameters
        ----------
        trajectory : Trajectory
            True signals, simulated with this object as the tap. Failed runs are unchanged.

        Returns
        -------
        Trajectory
            The measured trajectory; the same object if every sensor is ideal.

        Raises
        ------
        KeyError
            A run has lags but was simulated without this object as the tap.
        """
        changes: dict[str, Any] = {
            channel.signal: self._rows(channel, trajectory)
            for channel in CHANNELS
            if not all(run.is_shown_exactly(channel.section) for run in self.runs)
        }
        return replace(trajectory, **changes) if changes else trajectory

    def _rows(self, channel: Channel, trajectory: Trajectory) -> Signal:
        signals: Signal = np.array(getattr(trajectory, channel.signal))
        for row, run in enumerate(self.runs):
            if trajectory.outcomes[row].is_ok and not run.is_shown_exactly(channel.section):
                if channel.lags(run):
                    lagged, lane = self._lagged[row]
                    samples = lagged.samples[channel][lane]
                else:
                    samples = sampled(run, signals[row], trajectory.time)
                signals[row] = sensor_reading(channel, run, samples, trajectory.time)
        return signals


def sampled(run: RunParameters, signal: Signal, time: Signal) -> Signal:
    """The record resampled at the jittered instants of a run's clock, by cubic spline; shape (n_time,)."""
    if run.measurement.jitter == 0.0:
        return signal
    instants = sampling_instants(time, run.measurement.jitter, random_generator(run, CLOCK))
    return interpolated_signal(signal, time, instants)


def sensor_reading(channel: Channel, run: RunParameters, samples: Signal, time: Signal) -> Signal:
    """Reading of the sensor of a channel: errors, range and resolution are applied in this order.

    Parameters
    ----------
    channel : Channel
    run : RunParameters
    samples : ndarray, shape (n_time,)
        True values after all lags, in the unit of the channel.
    time : ndarray, shape (n_time,)
        Nominal sampling instants [s].

    Returns
    -------
    ndarray, shape (n_time,)
    """
    sensor = channel.sensor(run)
    reading = np.asarray(samples + systematic_error(time, sensor.bias, sensor.drift))
    noise = noise_autocovariance(sensor, run.measurement, run.record)
    if noise[0] > 0.0:
        reading = reading + gaussian_noise(noise, time.size, random_generator(run, channel.section))
    reading = saturated(reading, sensor.lowest, sensor.highest)
    if sensor.bits is not None and sensor.lowest is not None:
        reading = quantised(reading, sensor.lowest, sensor.resolution)
    return np.asarray(reading, dtype=float)
