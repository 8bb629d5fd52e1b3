"""The sections of the sensors, one for each measured signal, and of what the sensors share."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from hydrofdi.settings.messages import shown_quantity
from hydrofdi.settings.quantities import SI, Section, field_quantity


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
