"""Signals that have a sensor, and the Gaussian noise of their records: autocovariance and samples."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.drive import RecordConfig
from hydrofdi.config.sections.sensor import MeasurementConfig, SensorConfig
from hydrofdi.sensing.sampling import Lag, butterworth_lags, first_order_lag, second_order_lag


@dataclass(frozen=True)
class Channel:
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
    Channel("chamber_1_pressure", "pressure_1_sensor"),
    Channel("chamber_2_pressure", "pressure_2_sensor"),
    Channel("valve_supply_pressure", "supply_sensor"),
    Channel("piston_position", "position_sensor"),
    Channel("piston_velocity", "velocity_sensor"),
    Channel("spool_position", "spool_sensor"),
    Channel("input_voltage", "voltage_sensor"),
    Channel("oil_temperature", "temperature_sensor"),
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
