"""Trajectories as measured by sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.sensing.noise import (
    CHANNELS,
    CLOCK,
    Channel,
    gaussian_noise,
    hum_phase,
    noise_autocovariance,
    random_generator,
)
from hydrofdi.sensing.sampling import Clocks, LagLanes, interpolated_signal, sampling_instants
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.inputs import SignalByName, steps_per_control

Signal = NDArray[np.float64]


class Measurement:
    """The sensors of a batch of runs.

    As a tap it evaluates lags and delays at every step of the solver during simulation; `show` then applies
    all sensors to the trajectory.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        The simulated runs.
    """

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        self.runs = runs
        self._lagged: dict[int, tuple[LaggedRuns, int]] = {}

    def wants(self, position: int) -> bool:
        """Whether any channel of the run has a lag or a delay."""
        return any(channel.needs_steps(self.runs[position]) for channel in CHANNELS)

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
            A run has lags or delays but was simulated without this object as the tap.
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
                if channel.needs_steps(run):
                    lagged, lane = self._lagged[row]
                    samples = lagged.samples[channel][lane]
                else:
                    shown = getattr(trajectory, channel.shown_signal(run))[row]
                    samples = sampled(run, shown, trajectory.time)
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

    `samples` (n_time,) are true values after all lags, `time` the nominal sampling instants [s].
    """
    sensor = channel.sensor(run)
    reading = np.asarray(sensor.gain * samples + systematic_error(time, sensor.bias, sensor.drift))  # (m4)
    if sensor.hum:
        phase = hum_phase(run, channel.section)
        reading = reading + hum(time, sensor.hum, sensor.hum_frequency, phase)
    noise = noise_autocovariance(sensor, run.measurement, run.record)
    if noise[0] > 0.0:
        reading = reading + gaussian_noise(noise, time.size, random_generator(run, channel.section))
    reading = saturated(reading, sensor.lowest, sensor.highest)  # (m5)
    if sensor.bits is not None and sensor.lowest is not None:
        reading = quantised(reading, sensor.lowest, sensor.resolution)  # (m6)
    return np.asarray(reading, dtype=float)


Value = Any
"""A float, or an array of any shape."""


def systematic_error(time: Value, bias: float, drift: float) -> Value:
    """Error from bias and drift [per s] of a sensor at a time [s], in the unit of the signal."""
    return bias + drift * np.asarray(time)


def hum(time: Value, amplitude: float, frequency: float, phase: float) -> Value:
    """Sine that the mains adds at a time [s]: frequency in Hz, phase in rad, in the unit of the amplitude."""
    return amplitude * np.sin(2.0 * math.pi * frequency * np.asarray(time) + phase)


def saturated(signal: Value, lowest: float | None, highest: float | None) -> Value:
    """The signal limited to a range; None means no limit."""
    if lowest is None and highest is None:
        return signal
    return np.clip(signal, lowest, highest)


def quantised(signal: Value, lowest: float, resolution: float) -> Value:
    """The signal rounded to the nearest levels of a converter, from the lowest on."""
    return lowest + resolution * np.round((np.asarray(signal) - lowest) / resolution)  # (m6)


def quantisation_noise(resolution: float) -> float:
    """Standard deviation of quantisation noise, in the unit of the signal.

    It is modelled as white noise with uniform distribution over one level. This holds if the signal changes
    by more than one level between samples, or if its noise covers one level.

    Parameters
    ----------
    resolution : float
        Step between adjacent levels (LSB).
    """
    return resolution / math.sqrt(12.0)  # (m7)


class LaggedRuns:
    """Lags of runs with the same ``run`` section: reads their signals at every solver step and samples.

    `samples`: channel that has a lag or a delay in any run → (n_run, n_time).
    """

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        self._runs = runs
        read = [channel for channel in CHANNELS if any(map(channel.needs_steps, runs))]
        self._lanes = {channel: LagLanes([channel.lags(run) for run in runs]) for channel in read}
        self._clocks = {channel: _clocks(runs, channel) for channel in read}
        self.samples = {channel: np.zeros((len(runs), runs[0].record.n_sample)) for channel in read}

    def __call__(self, first_step: int, signal: SignalByName) -> None:
        """Process the signals of consecutive steps, starting at step `first_step`."""
        for channel, samples in self.samples.items():
            values = np.array(signal(channel.signal)[:, : len(samples)], order="C")
            for lane, run in enumerate(self._runs):
                if (shown := channel.shown_signal(run)) != channel.signal:
                    values[:, lane] = signal(shown)[:, lane]
            self._lanes[channel].advance(values)
            self._clocks[channel].sample(values, first_step, samples)


def _clocks(runs: Sequence[RunParameters], channel: Channel) -> Clocks:
    record = runs[0].record
    time = np.arange(record.n_sample) / record.sampling_frequency
    deviations = np.zeros((len(runs), record.n_sample))
    for lane, parameters in enumerate(runs):
        if jitter := parameters.measurement.jitter:
            deviations[lane] = sampling_instants(time, jitter, random_generator(parameters, CLOCK)) - time
        if delay := channel.sensor(parameters).delay:
            # (m3): not before the record.
            deviations[lane] = np.maximum(deviations[lane] - delay, -time)
    return Clocks(record, deviations)


LOOP = "position_feedback"
"""Random source of the noise in the loop at instants that are not sampled."""


def feedback_noise(run: RunParameters) -> NDArray[np.float64] | None:
    """Noise and hum of the position [m] at the samples of the controller of a run (n_control,), or None.

    The variance of the noise is that of a record sampled at the rate of the controller, without the
    anti-alias filter. At instants that the record samples too, both have the same noise, if the noise of the
    record is white with the same variance and there is no jitter.
    """
    sensor, record, shared = run.position_sensor, run.record, run.measurement
    own_rate = record.model_copy(update={"sampling_frequency": 1.0 / run.control.sample_time})
    unfiltered = shared.model_copy(update={"anti_alias": None})
    (variance,) = noise_autocovariance(sensor, unfiltered, own_rate)
    if not run.control.is_measured or not (variance or sensor.hum):
        return None
    steps = np.arange(0, record.n_step, steps_per_control(run))
    noise = gaussian_noise((variance,), steps.size, random_generator(run, LOOP))
    recorded = noise_autocovariance(sensor, shared, record)
    if len(recorded) == 1 and math.isclose(recorded[0], variance) and shared.jitter == 0.0:
        sampled = steps % record.steps_per_sample == 0
        samples = gaussian_noise(recorded, record.n_sample, random_generator(run, "position_sensor"))
        noise[sampled] = samples[steps[sampled] // record.steps_per_sample]
    if sensor.hum:
        noise += hum(record.step * steps, sensor.hum, sensor.hum_frequency, hum_phase(run, "position_sensor"))
    return noise
