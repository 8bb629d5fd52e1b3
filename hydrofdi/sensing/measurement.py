"""Trajectories as sensors show them."""

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
from hydrofdi.simulation import Trajectory

Signal = NDArray[np.float64]


class Measurement:
    """The sensors of a batch of runs.

    As a tap it follows what lags at every step of the solver, while the runs are simulated; `show` then gives
    what all sensors show.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        As they are simulated.
    """

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        self.runs = runs
        self._lagged: dict[int, tuple[LaggedRuns, int]] = {}

    def wants(self, position: int) -> bool:
        """Whether something lags in the run."""
        return any(channel.lags(self.runs[position]) for channel in CHANNELS)

    def feedback_noise(self, position: int) -> Signal | None:
        """Noise of the position that the controller of a run reads [m], at each of its samples, or None."""
        return feedback_noise(self.runs[position])

    def reader(self, positions: Sequence[int]) -> LaggedRuns:
        """What follows these runs."""
        lagged = LaggedRuns([self.runs[position] for position in positions])
        self._lagged |= {position: (lagged, lane) for lane, position in enumerate(positions)}
        return lagged

    def show(self, trajectory: Trajectory) -> Trajectory:
        """A trajectory as the sensors show it; time and leakage flow stay as they are.

        Parameters
        ----------
        trajectory : Trajectory
            What really happened, simulated with this as the tap. Runs that failed are left as they are.

        Returns
        -------
        Trajectory
            The same object where every sensor is ideal.

        Raises
        ------
        KeyError
            A run lags, and was simulated without this as the tap.
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
    """A record as the clock of a run takes it, from the cubic spline through it; shape (n_time,)."""
    if run.measurement.jitter == 0.0:
        return signal
    instants = sampling_instants(time, run.measurement.jitter, random_generator(run, CLOCK))
    return interpolated_signal(signal, time, instants)


def sensor_reading(channel: Channel, run: RunParameters, samples: Signal, time: Signal) -> Signal:
    """What the sensor of a channel makes of samples: errors, range and resolution, in this order.

    Parameters
    ----------
    channel : Channel
    run : RunParameters
    samples : ndarray, shape (n_time,)
        Of what really happened behind all lags, in the unit of the channel.
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
