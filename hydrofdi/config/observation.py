"""The sections of the observation: sensors, what they share, and the analysed part of a record."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import Field, GetCoreSchemaHandler, model_validator
from pydantic_core import CoreSchema, core_schema

from hydrofdi.config.drive import InputConfig, RecordConfig, is_whole
from hydrofdi.settings.messages import counted, shown_quantity
from hydrofdi.settings.quantities import SI, Section, field_quantity
from hydrofdi.transforms import WaveletConfig


class SensorConfig(Section):
    """A sensor and the converter behind it; without settings it is ideal and changes nothing."""

    order: Literal["ideal", "first", "second"] = "ideal"
    """Dynamics. ``ideal``: no lag. ``first``: first-order lag. ``second``: second-order lag with
    ``damping_ratio``. Either starts at rest at the record's first value."""

    bandwidth: Annotated[float, SI("Hz", above=0, usual=("0.01 Hz", "1 MHz"))] | None = None
    """Corner frequency of a first-order sensor, where its gain is −3 dB, or undamped natural frequency of a
    second-order one, where its gain is 1/(2 ``damping_ratio``) [Hz]."""

    damping_ratio: Annotated[float, SI("1", above=0, usual=("0.05", "5"))] = 0.7
    """Damping ratio of a second-order sensor [-]. A choice: about the flattest gain."""

    noise: float = 0.0
    """Standard deviation of white Gaussian noise, in the unit of the signal. Without ``noise_bandwidth`` it
    applies to each sample and no filter changes it. With ``noise_bandwidth`` it applies to the sensor's
    output."""

    noise_bandwidth: Annotated[float, SI("Hz", above=0, usual=("0.1 Hz", "100 MHz"))] | None = None
    """Bandwidth that ``noise`` is stated for [Hz]: its density is ``noise``/√``noise_bandwidth``, which
    ``measurement.anti_alias`` filters. Without that filter all of ``noise`` is in the record."""

    noise_density: float = 0.0
    """Instead of ``noise``: one-sided density of the sensor's white Gaussian noise, in the unit of the signal
    per √Hz, such as ``20 Pa/√Hz``. ``measurement.anti_alias`` filters it; without that filter, it is the
    density of the record, up to half the sampling frequency."""

    bias: float = 0.0
    """Constant error, in the unit of the signal."""

    drift: float = 0.0
    """Error that grows from the record's start on, in the unit of the signal per second."""

    gain_error: Annotated[float, SI("1", above=-1, usual=("1e-6", "0.2"))] = 0.0
    """Relative error of the gain [-]: 0.005 shows 100.5 for 100."""

    hum: float = 0.0
    """Amplitude of a sine of ``hum_frequency`` that the mains adds, in the unit of the signal; its phase is
    drawn for each record, as the noise is."""

    hum_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "1 kHz"))] = 50.0
    """Frequency of the hum [Hz]: that of the mains."""

    delay: Annotated[float, SI("s", least=0, usual=("1 µs", "1 s"))] = 0.0
    """Age of each sample [s]: the channel is that much behind the time of the record, such as those late in
    the sequence of a multiplexer."""

    lowest: float | None = None
    """Lower end of the range, in the unit of the signal; lower values are clipped to it."""

    highest: float | None = None
    """Upper end of the range, in the unit of the signal; higher values are clipped to it."""

    bits: Annotated[int, Field(strict=True, ge=1, le=32)] | None = None
    """Resolution of the converter: 2^bits levels from ``lowest`` to ``highest``, both ends included."""

    @model_validator(mode="after")
    def _settings_fit_each_other(self) -> Self:
        if self.order == "ideal" and self.bandwidth is not None:
            raise ValueError("an ideal sensor has no bandwidth; set order to first or second")
        if self.order != "ideal" and self.bandwidth is None:
            raise ValueError(f"a sensor of {self.order} order needs a bandwidth")
        if self.noise_density and (self.noise or self.noise_bandwidth is not None):
            raise ValueError("noise_density excludes noise and noise_bandwidth; remove them")
        if self.bits is not None and (self.lowest is None or self.highest is None):
            raise ValueError("bits needs a range to divide; give lowest and highest")
        if self.lowest is not None and self.highest is not None and not self._span > 0.0:
            quantity = field_quantity(type(self).model_fields["bias"])
            unit = quantity.unit if quantity else "1"
            lowest, highest = (shown_quantity(end, unit) for end in (self.lower_end, self.upper_end))
            raise ValueError(f"lowest = {lowest} must be below highest = {highest}")
        return self

    @cached_property
    def is_ideal(self) -> bool:
        """Whether it shows the signal as it is."""
        errors = (
            self.noise, self.noise_density, self.bias, self.drift, self.gain_error, self.hum, self.delay,
        )  # fmt: skip
        return self.order == "ideal" and not any(errors) and self.lowest is None and self.highest is None

    @property
    def gain(self) -> float:
        """Reading over signal, without the other errors [-]."""
        return 1.0 + self.gain_error

    @property
    def density(self) -> float:
        """One-sided density of the noise in front of the converter, in the signal's unit per √Hz."""
        if self.noise_bandwidth is not None:
            return self.noise / math.sqrt(self.noise_bandwidth)
        return self.noise_density

    @property
    def resolution(self) -> float:
        """Distance of neighbouring levels of the converter (LSB), in the signal's unit; 0 without bits."""
        return 0.0 if self.bits is None else self._span / (2**self.bits - 1)

    @property
    def lower_end(self) -> float:
        """Lower end of the range, −∞ where it is open, in the signal's unit."""
        return -math.inf if self.lowest is None else self.lowest

    @property
    def upper_end(self) -> float:
        """Upper end of the range, ∞ where it is open, in the signal's unit."""
        return math.inf if self.highest is None else self.highest

    @property
    def _span(self) -> float:
        return self.upper_end - self.lower_end


class PressureSensorConfig(SensorConfig):
    """Pressure sensor. Like every sensor, it is ideal and changes nothing unless set otherwise."""

    noise: Annotated[float, SI("Pa", least=0, usual=("10 Pa", "10 MPa"))] = 0.0
    noise_density: Annotated[float, SI("Pa/Hz^0.5", least=0, usual=("0.01 Pa/√Hz", "1 MPa/√Hz"))] = 0.0
    hum: Annotated[float, SI("Pa", least=0, usual=("1 Pa", "10 MPa"))] = 0.0
    bias: Annotated[float, SI("Pa", usual=("100 Pa", "1 GPa"))] = 0.0
    drift: Annotated[float, SI("Pa/s", usual=("0.01 Pa/s", "10 MPa/s"))] = 0.0
    lowest: Annotated[float, SI("Pa", usual=("100 Pa", "1 GPa"))] | None = None
    highest: Annotated[float, SI("Pa", usual=("100 Pa", "1 GPa"))] | None = None


class LengthSensorConfig(SensorConfig):
    """Position sensor. Like every sensor, it is ideal and changes nothing unless set otherwise."""

    noise: Annotated[float, SI("m", least=0, usual=("1 nm", "10 mm"))] = 0.0
    noise_density: Annotated[float, SI("m/Hz^0.5", least=0, usual=("0.001 nm/√Hz", "1 mm/√Hz"))] = 0.0
    hum: Annotated[float, SI("m", least=0, usual=("0.1 nm", "10 mm"))] = 0.0
    bias: Annotated[float, SI("m", usual=("10 nm", "10 m"))] = 0.0
    drift: Annotated[float, SI("m/s", usual=("0.1 nm/s", "1 m/s"))] = 0.0
    lowest: Annotated[float, SI("m", usual=("10 nm", "10 m"))] | None = None
    highest: Annotated[float, SI("m", usual=("10 nm", "10 m"))] | None = None


class VelocitySensorConfig(SensorConfig):
    """Velocity sensor. Like every sensor, it is ideal and changes nothing unless set otherwise."""

    noise: Annotated[float, SI("m/s", least=0, usual=("0.1 µm/s", "1 m/s"))] = 0.0
    noise_density: Annotated[float, SI("m/s/Hz^0.5", least=0, usual=("0.1 nm/s/√Hz", "0.1 m/s/√Hz"))] = 0.0
    hum: Annotated[float, SI("m/s", least=0, usual=("0.1 µm/s", "1 m/s"))] = 0.0
    bias: Annotated[float, SI("m/s", usual=("1 µm/s", "100 m/s"))] = 0.0
    drift: Annotated[float, SI("m/s^2", usual=("0.01 µm/s^2", "10 m/s^2"))] = 0.0
    lowest: Annotated[float, SI("m/s", usual=("1 µm/s", "100 m/s"))] | None = None
    highest: Annotated[float, SI("m/s", usual=("1 µm/s", "100 m/s"))] | None = None


class VoltageSensorConfig(SensorConfig):
    """Voltage sensor. Like every sensor, it is ideal and changes nothing unless set otherwise."""

    noise: Annotated[float, SI("V", least=0, usual=("1 µV", "10 V"))] = 0.0
    noise_density: Annotated[float, SI("V/Hz^0.5", least=0, usual=("1 nV/√Hz", "1 V/√Hz"))] = 0.0
    hum: Annotated[float, SI("V", least=0, usual=("1 µV", "10 V"))] = 0.0
    bias: Annotated[float, SI("V", usual=("10 µV", "1 kV"))] = 0.0
    drift: Annotated[float, SI("V/s", usual=("0.1 µV/s", "100 V/s"))] = 0.0
    lowest: Annotated[float, SI("V", usual=("10 µV", "1 kV"))] | None = None
    highest: Annotated[float, SI("V", usual=("10 µV", "1 kV"))] | None = None


class TemperatureSensorConfig(SensorConfig):
    """Temperature sensor. Like every sensor, it is ideal and changes nothing unless set otherwise."""

    noise: Annotated[float, SI("K", least=0, usual=("0.0001 K", "10 K"))] = 0.0
    noise_density: Annotated[float, SI("K/Hz^0.5", least=0, usual=("1e-6 K/√Hz", "10 K/√Hz"))] = 0.0
    hum: Annotated[float, SI("K", least=0, usual=("0.0001 K", "10 K"))] = 0.0
    bias: Annotated[float, SI("K", usual=("0.001 K", "100 K"))] = 0.0
    drift: Annotated[float, SI("K/s", usual=("1e-6 K/s", "10 K/s"))] = 0.0
    lowest: Annotated[float, SI("K", usual=("100 K", "1000 K"))] | None = None
    highest: Annotated[float, SI("K", usual=("100 K", "1000 K"))] | None = None


class MeasurementConfig(Section):
    """Common settings of the sensors."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Replicate: seed of noise and jitter. Each sensor draws its own; another seed gives another replicate of
    every record."""

    pairing: Literal["independent", "common"] = "independent"
    """Noise and jitter of the records of one replicate. ``independent``: each record draws its own.
    ``common``: all have the same, so that a healthy and a leaking record differ only in the leak."""

    jitter: Annotated[float, SI("s", least=0, usual=("1 ns", "10 ms"))] = 0.0
    """Standard deviation of the sampling instants about their nominal ones [s]; one clock samples all
    signals. At most a quarter of the sampling interval."""

    pressures_at: Literal["chambers", "valve"] = "chambers"
    """Place of the sensors of the chamber pressures: at the ``chambers``, or at the ``valve``, which hoses
    separate from the chambers."""

    anti_alias: Annotated[float, SI("Hz", above=0, usual=("0.1 Hz", "1 MHz"))] | None = None
    """Corner frequency of the Butterworth low-pass that every signal passes between its sensor and the
    converter, where its gain is −3 dB [Hz]; without it, sampling folds what is above half the sampling
    frequency."""

    anti_alias_order: Literal[2, 4] = 4
    """Order of this low-pass: number of its poles."""


MOST_JITTER = 0.25
"""Largest standard deviation of the sampling instants over the sampling interval."""


def require_jitter_fits(measurement: MeasurementConfig, record: RecordConfig) -> None:
    """Sampling instants do not overtake each other."""
    if measurement.jitter * record.sampling_frequency > MOST_JITTER + 1e-9:
        raise ValueError(
            f"measurement.jitter = {measurement.jitter:g} s is more than a quarter"
            f" of the sampling interval of {1 / record.sampling_frequency:g} s"
        )


_PERIODS = re.compile(r"\s*((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*periods?\s*")


@dataclass(frozen=True)
class TimeOrPeriods(SI):
    """Annotation of a time from zero on [s], or of a number of periods, held as a text like ``2 periods``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse, and check a time's limit."""
        return core_schema.no_info_plain_validator_function(self._time_or_periods)

    def _time_or_periods(self, value: Any) -> float | str:
        if not isinstance(value, str) or not value.rstrip().endswith(("period", "periods")):
            if not math.isfinite(time := self.parse(value)):
                raise ValueError(f"must be zero or a positive time; found {value}")
            return time
        if (periods := _PERIODS.fullmatch(value)) is None:
            raise ValueError(f"must be zero or more periods, such as '1 period'; found {value!r}")
        number = float(periods[1])
        return f"{number:.15g} {'period' if number == 1.0 else 'periods'}"


class AnalysisConfig(Section):
    """The analysed part of a record. It can change without a new simulation."""

    discard: Annotated[float | str, TimeOrPeriods("s", least=0)] = 0.0
    """Initial part of the record that indicators and features ignore: a time [s], or periods of the input
    such as ``1 period``, for any ``input.period``. Signals still contain it, and so do the values of the
    plant itself: leakage flows, extremes, hydraulic mode, settling."""

    def discarded_time(self, period: float) -> float:
        """Start of the record that is left out, for an input of some period [s]."""
        if isinstance(self.discard, str):
            return float(self.discard.split()[0]) * period
        return self.discard

    def shown_discard(self, period: float) -> str:
        """What is left out, for a period of the input [s]: ``4 s``, ``1 period of input.period = 2 s``."""
        if isinstance(self.discard, str):
            return f"{self.discard} of input.period = {period:g} s"
        return f"{self.discard:g} s"


def require_discard_fits(analysis: AnalysisConfig, drive: InputConfig, record: RecordConfig) -> None:
    """What is left out of a record is a whole number of samples, and of a period that there is."""
    if isinstance(analysis.discard, str) and not drive.is_periodic:
        raise ValueError(
            f"analysis.discard = {analysis.discard} needs an input with a period, and input.shape ="
            f" {drive.shape} has none; give a time"
        )
    time, shown = analysis.discarded_time(drive.period), analysis.shown_discard(drive.period)
    if time and not is_whole(time * record.sampling_frequency):
        raise ValueError(f"analysis.discard = {shown} is not a multiple of the sampling interval")


def require_record_fits(
    record: RecordConfig, analysis: AnalysisConfig, drive: InputConfig, wavelet: WaveletConfig
) -> None:
    """What is analysed of a record supports the levels of the wavelet; else, which key takes what value."""
    from pywt import Wavelet, dwt_max_level

    length = Wavelet(wavelet.name).dec_len
    n_left_out = round(analysis.discarded_time(drive.period) * record.sampling_frequency)
    n_kept = record.n_sample - n_left_out
    deepest = dwt_max_level(max(n_kept - wavelet.latest_start, 0), length)
    if wavelet.levels <= deepest:
        return
    n_needed = (length - 1) * 2**wavelet.levels + wavelet.latest_start
    least = (n_left_out + n_needed) / record.sampling_frequency
    left = f" after analysis.discard = {analysis.shown_discard(drive.period)}" if n_left_out else ""
    lower = f", or wavelet.levels to {deepest}" if deepest > 0 else ""
    raise ValueError(
        f"record.duration = {record.duration:g} s leaves {counted(max(n_kept, 0), 'sample')}{left}, but"
        f" wavelet.levels = {wavelet.levels} of {wavelet.name} needs {n_needed:,};"
        f" set record.duration to {least:.10g} s or more{lower}"
    )
