"""Sensor models: from simulated to measured signals, with lags, clocks, noise and converters."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.compilation.object_code import strict_kernel
from hydrofdi.config import RunParameters
from hydrofdi.config.drive import RecordConfig
from hydrofdi.config.observation import MeasurementConfig, SensorConfig
from hydrofdi.physics import equation, settled
from hydrofdi.simulation.balances import Trajectory


class Lag(NamedTuple):
    """Coefficients of one step of a lag: error e, and rate r in units of the angular frequency.

    e_{k+1} = ee e_k + er r_k + eu (u_{k+1} − u_k), r_{k+1} = re e_k + rr r_k + ru (u_{k+1} − u_k)
    """

    ee: float
    er: float
    re: float
    rr: float
    eu: float
    ru: float


@lru_cache(maxsize=1024)
def first_order_lag(angle: float) -> Lag:
    """First-order lag y' = ω (u − y); the angle is ω times the step [rad]."""
    decay = math.exp(-angle)
    # (m1): expm1 keeps the digits of 1 − a if the step is short.
    return Lag(decay, 0.0, 0.0, 0.0, math.expm1(-angle) / angle, 0.0)


@lru_cache(maxsize=1024)
def second_order_lag(angle: float, damping_ratio: float) -> Lag:
    """Second-order lag y'' = ω² (u − y) − 2 ζ ω y'; the angle is ω times the step [rad]."""
    from scipy.linalg import expm

    # (m2): the third state is the rise of u over the step, which is constant.
    rates = np.array([[0.0, 1.0, -1.0 / angle], [-1.0, -2.0 * damping_ratio, 0.0], [0.0, 0.0, 0.0]])
    (ee, er, eu), (re, rr, ru), _ = expm(angle * rates).tolist()
    return Lag(ee, er, re, rr, eu, ru)


def butterworth_lags(angle: float, order: int) -> tuple[Lag, ...]:
    """Butterworth filter of even order, as second-order lags in series.

    The angle is 2π times the −3 dB corner frequency times the step [rad].
    """
    ratios = [math.sin(math.pi * k / (2 * order)) for k in range(1, order, 2)]  # (m10)
    return tuple(second_order_lag(angle, ratio) for ratio in ratios)


class LagLanes:
    """Lags in series for several signals in parallel; each starts at rest at the first value of its signal.

    Parameters
    ----------
    lags_of_lane : sequence of sequence of Lag, length n_lane
        Lags that each signal passes, in series; without lags a signal is unchanged.
    """

    def __init__(self, lags_of_lane: Sequence[Sequence[Lag]]) -> None:
        n_lag, n_lane = max(map(len, lags_of_lane), default=0), len(lags_of_lane)
        self._lags = np.zeros((n_lag, len(Lag._fields), n_lane))
        for lane, lags in enumerate(lags_of_lane):
            for index, lag in enumerate(lags):
                self._lags[index, :, lane] = lag
        self._states: NDArray[np.float64] | None = None

    def advance(self, signals: NDArray[np.float64]) -> None:
        """Replace the next values of the signals, shape (n_step, n_lane), by the outputs of the lags."""
        if self._states is None:
            self._states = np.zeros((len(self._lags), 3, signals.shape[1]))
            self._states[:, 0] = signals[0]
        for lag, state in zip(self._lags, self._states, strict=True):
            advance_lag(signals, lag, state)


@strict_kernel
def advance_lag(signals: NDArray[np.float64], lag: NDArray[np.float64], state: NDArray[np.float64]) -> None:
    """Replace signals (n_step, n_lane) by the output of a lag (6, n_lane), in place.

    The state (3, n_lane): last value, error and rate of each lane; updated in place.
    """
    for i in range(signals.shape[0]):
        for k in range(signals.shape[1]):
            value, error, rate = signals[i, k], state[1, k], state[2, k]
            change = value - state[0, k]
            state[0, k] = value
            # Zero instead of subnormal numbers, in which a constant signal would end.
            state[1, k] = settled(lag[0, k] * error + lag[1, k] * rate + lag[4, k] * change)
            state[2, k] = settled(lag[2, k] * error + lag[3, k] * rate + lag[5, k] * change)
            signals[i, k] = value + state[1, k]


def sampling_instants(
    time: NDArray[np.float64], jitter: float, generator: np.random.Generator
) -> NDArray[np.float64]:
    """Actual sampling instants of a clock with jitter [s]: normally distributed about the nominal ones.

    They are limited to the first and last of those.
    """
    instants = time + jitter * generator.standard_normal(time.size)  # (m3)
    return np.clip(instants, time[0], time[-1])


def interpolated_signal(signal: ArrayLike, time: ArrayLike, instants: ArrayLike) -> NDArray[np.float64]:
    """Values of a record of at least four samples at some instants, by cubic spline."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.asarray(time), np.asarray(signal))(np.asarray(instants)), dtype=float)


class Clocks:
    """Clocks that sample several signals in parallel, from their values at every step of the solver.

    Between steps, a signal is the cubic polynomial through the four nearest steps.

    Parameters
    ----------
    record : RecordConfig
        Solver step and sampling of the record.
    deviations : ndarray, shape (n_lane, n_time)
        Deviation of each sampling instant from nominal, positive if late [s].
    """

    def __init__(self, record: RecordConfig, deviations: NDArray[np.float64]) -> None:
        self._steps_per_sample, self._n_time = record.steps_per_sample, record.n_sample
        self._is_exact = not deviations.any()
        if not self._is_exact:
            nominal = record.steps_per_sample * np.arange(record.n_sample)
            instants = nominal + deviations / record.step
            # Two nodes on each side of the instant, except at the ends of the record.
            self._first_nodes = np.clip(np.floor(instants).astype(np.int64) - 1, 0, record.n_step - 4)
            self._offsets = instants - self._first_nodes
            # How far the nodes of a sample lie from its nominal step, perhaps in another block.
            self._reach = 4 + int(np.abs(self._first_nodes - nominal).max())

    def sample(self, values: NDArray[np.float64], first_step: int, samples: NDArray[np.float64]) -> None:
        """Add the contribution of a block of steps (n_step, n_lane) to the samples (n_lane, n_time).

        Blocks must be contiguous; the samples are zero before the first.
        """
        every = self._steps_per_sample
        if self._is_exact:
            # From the first step of the block that is a sample.
            picked = values[-first_step % every :: every].T
            samples[:, -(-first_step // every) :][:, : picked.shape[1]] = picked
            return
        first = max(0, (first_step - self._reach) // every)
        last = min(self._n_time, (first_step + len(values) + self._reach) // every + 1)
        add_nodes(values, first_step, self._first_nodes, self._offsets, first, last, samples)


@equation
def cubic_weight(node: int, place: float) -> float:
    """Weight of node 0 … 3 in the cubic polynomial through the values at four nodes."""
    weight = 1.0
    for other in range(4):
        if other != node:
            # Lagrange's form: 1 at its own node, 0 at the others.
            weight *= (place - other) / (node - other)
    return weight


@strict_kernel
def add_nodes(
    values: NDArray[np.float64],
    first_step: int,
    first_nodes: NDArray[np.int64],
    offsets: NDArray[np.float64],
    first: int,
    last: int,
    samples: NDArray[np.float64],
) -> None:
    """Add the contributions of the nodes within a block of steps (n_step, n_lane) to the samples.

    `first_nodes` and `offsets` (n_lane, n_time): step of the first of the four nodes, and offset of the
    sample from it [steps]; samples from `first` to `last` are updated.
    """
    for lane in range(samples.shape[0]):
        for k in range(first, last):
            for node in range(4):
                step = first_nodes[lane, k] + node - first_step
                if 0 <= step < values.shape[0]:
                    samples[lane, k] += cubic_weight(node, offsets[lane, k]) * values[step, lane]


@dataclass(frozen=True)
class SensedSignal:
    """A signal that has a sensor: its name in a trajectory, and the section of its sensor."""

    signal: str
    section: str

    def sensor(self, run: RunParameters) -> SensorConfig:
        """Sensor configuration of this channel in a run."""
        sensor: SensorConfig = getattr(run, self.section)
        return sensor

    def shown_signal(self, run: RunParameters) -> str:
        """Signal of a trajectory that the sensor of a run shows: that of the channel, or of a hose."""
        if run.reads_at_valve and self.signal.startswith("chamber_"):
            return self.signal.replace("chamber_", "line_")
        return self.signal

    def needs_steps(self, run: RunParameters) -> bool:
        """Whether a reading depends on the signal between the samples."""
        is_late = self.sensor(run).delay > 0.0 or bool(self.lags(run))
        return is_late and not run.is_shown_exactly(self.section)

    def lags(self, run: RunParameters) -> tuple[Lag, ...]:
        """Lags that the signal passes before sampling; empty if there are none."""
        sensor, shared, turn = self.sensor(run), run.measurement, 2.0 * math.pi * run.record.step
        lags: tuple[Lag, ...] = ()
        if sensor.bandwidth is not None and sensor.order == "first":
            lags = (first_order_lag(turn * sensor.bandwidth),)
        elif sensor.bandwidth is not None:
            lags = (second_order_lag(turn * sensor.bandwidth, sensor.damping_ratio),)
        if shared.anti_alias is not None:
            lags += butterworth_lags(turn * shared.anti_alias, shared.anti_alias_order)
        return lags


CHANNELS = (
    SensedSignal("chamber_1_pressure", "pressure_1_sensor"),
    SensedSignal("chamber_2_pressure", "pressure_2_sensor"),
    SensedSignal("valve_supply_pressure", "supply_sensor"),
    SensedSignal("piston_position", "position_sensor"),
    SensedSignal("piston_velocity", "velocity_sensor"),
    SensedSignal("spool_position", "spool_sensor"),
    SensedSignal("input_voltage", "voltage_sensor"),
    SensedSignal("oil_temperature", "temperature_sensor"),
)

CLOCK = "clock"
"""Random source of the sampling jitter; all channels share it."""


def random_generator(run: RunParameters, source: str) -> np.random.Generator:
    """Random generator of one source of error in one record.

    The seed is the SHA-256 of the replicate (``measurement.seed``), the source, and with
    ``measurement.pairing: independent`` all parameters that determine the record. So draws do not depend on
    other records, on order, batch or worker, or on the analysis. The generator is NumPy's PCG64; draws are
    bit-identical within one version of NumPy.

    Parameters
    ----------
    source : str
        Section of a sensor, or `CLOCK`.
    """
    record = run.text() if run.measurement.pairing == "independent" else "common"
    text = f"{run.measurement.seed}\n{source}\n{record}"
    seed = int.from_bytes(hashlib.sha256(text.encode()).digest(), "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))


def hum_phase(run: RunParameters, section: str) -> float:
    """Phase of the hum of a sensor at the start of a record, uniform over a turn [rad]."""
    return 2.0 * math.pi * random_generator(run, f"{section}.hum").random()


_NEGLIGIBLE = 40.0
"""Lag in time constants beyond which samples count as independent: e^−40 is below rounding."""


@lru_cache(maxsize=1024)
def noise_autocovariance(
    sensor: SensorConfig, measurement: MeasurementConfig, record: RecordConfig
) -> tuple[float, ...]:
    """Autocovariance of a sensor's noise in the record, in the square of the signal's unit.

    ``noise`` alone is the standard deviation of each sample. A noise density passes the anti-alias filter,
    and sampling aliases the rest. Without a filter the record contains the noise up to ``noise_bandwidth``,
    at least up to half the sampling frequency.

    Returns
    -------
    tuple of float
        At lags 0, 1, … [samples]; zero beyond.
    """
    half, corner, order = (
        0.5 * record.sampling_frequency,
        measurement.anti_alias,
        measurement.anti_alias_order,
    )
    if not sensor.density:
        return (sensor.noise**2,)
    if corner is None:
        return (sensor.density**2 * max(half, sensor.noise_bandwidth or 0.0),)
    # Decay per sample of the slowest pole, whose damping ratio is sin(π/(2n)).
    decay = 2.0 * math.pi * corner * math.sin(0.5 * math.pi / order) / record.sampling_frequency
    delays = (
        np.arange(min(1 + math.ceil(_NEGLIGIBLE / decay), 10 * record.n_sample)) / record.sampling_frequency
    )
    return tuple(filtered_noise_autocovariance(sensor.density, corner, order, delays).tolist())


def filtered_noise_autocovariance(
    density: float, corner: float, order: int, delay: ArrayLike
) -> NDArray[np.float64]:
    """Autocovariance of white noise after a Butterworth low-pass filter, at lags [s].

    The density is one-sided, per √Hz; the corner f_c is at −3 dB [Hz]. At zero lag it is the variance: the
    square of the density times the filter's noise bandwidth f_c π/(2n)/sin(π/(2n)).
    """
    half_turn = math.pi / (2 * order)
    poles = np.exp(1j * half_turn * np.arange(1, 2 * order, 2))
    turns = 2.0 * math.pi * corner * np.abs(np.asarray(delay, dtype=float))
    responses = np.exp(1j * np.multiply.outer(turns, poles)) @ poles
    return np.asarray(density**2 * corner * half_turn * np.imag(responses))  # (m9)


def gaussian_noise(
    autocovariance: tuple[float, ...], n_time: int, generator: np.random.Generator
) -> NDArray[np.float64]:
    """Gaussian noise with a given autocovariance, stationary from the first sample on.

    White noise is filtered by circular convolution, on a period long enough to avoid wrap-around correlation.

    Parameters
    ----------
    autocovariance : tuple of float
        At lags 0, 1, … [samples]; zero beyond.

    Returns
    -------
    ndarray, shape (n_time,)
    """
    if len(autocovariance) == 1:
        return math.sqrt(autocovariance[0]) * generator.standard_normal(n_time)
    n_distance = len(autocovariance)
    # A power of two for the transform, and so long that no lag reaches round the circle into the record.
    ring = np.zeros(1 << (max(n_time, n_distance) + n_distance - 2).bit_length())
    ring[:n_distance], ring[1 - n_distance :] = autocovariance, autocovariance[:0:-1]
    # A covariance has no negative power; rounding can leave some.
    power = np.maximum(np.fft.rfft(ring).real, 0.0)
    colours = np.sqrt(power) * np.fft.rfft(generator.standard_normal(ring.size))
    return np.asarray(np.fft.irfft(colours, ring.size)[:n_time])


Signal = NDArray[np.float64]

SignalByName = Callable[[str], Signal]
"""Function from the name of a signal to its values, shape (n_step, n_lane); only the first lanes are used."""


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

    def _rows(self, channel: SensedSignal, trajectory: Trajectory) -> Signal:
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


def sensor_reading(channel: SensedSignal, run: RunParameters, samples: Signal, time: Signal) -> Signal:
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
        """Process the signals of consecutive steps, starting at step `first_step`; blocks are contiguous."""
        for channel, samples in self.samples.items():
            values = np.array(signal(channel.signal)[:, : len(samples)], order="C")
            for lane, run in enumerate(self._runs):
                if (shown := channel.shown_signal(run)) != channel.signal:
                    values[:, lane] = signal(shown)[:, lane]
            self._lanes[channel].advance(values)
            self._clocks[channel].sample(values, first_step, samples)


def _clocks(runs: Sequence[RunParameters], channel: SensedSignal) -> Clocks:
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


def steps_per_control(run: RunParameters) -> int:
    """Number of steps per sample of the controller."""
    return round(run.control.sample_time / run.record.step)


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


def reading_errors(
    run: RunParameters, steps: NDArray[np.int64], noise: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Error of the position before the converter, at the given steps.

    Parameters
    ----------
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.
    noise : ndarray, shape (n_control,), optional
        Noise at each sample of the controller [m]; by default none.

    Returns
    -------
    ndarray, shape (n,)
        Bias, drift and noise [m]; zero if the controller reads the true position.
    """
    if not run.control.is_measured:
        return np.zeros(steps.shape)
    sensor = run.position_sensor
    errors = np.asarray(sensor.bias + sensor.drift * run.record.step * steps, dtype=float)
    # The noise of a sample is held until the controller takes the next.
    return errors if noise is None else errors + noise[steps // steps_per_control(run)]
