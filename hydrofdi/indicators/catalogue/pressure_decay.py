"""How fast the chamber pressures fall while the actuator rests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms.stretches import stretches_where

_CHAMBERS = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE
_SHOWN_BY = {"command": Channel.INPUT_VOLTAGE, "position": Channel.PISTON_POSITION}


class PressureDecayOptions(Section):
    """Options of `PressureDecay`."""

    rest: Literal["auto", "command", "position", "whole"] = "auto"
    """Definition of rest. ``command``: the input voltage, if it has a scale, is zero. ``position``: the
    piston stands still. ``auto``: the first of these that the records have. ``whole``: all the time, in a
    rest test."""

    largest_command: Annotated[float, SI("V", least=0)] = 0.02
    """Largest input voltage that counts as zero [V]."""

    largest_speed: Annotated[float, SI("m/s", least=0)] = 1e-3
    """Speed up to which the piston counts as standing still [m/s], as a mean over ``speed_time``."""

    largest_relative_speed: Annotated[float, SI("1/s", least=0)] = 0.02
    """The same over the range of the position in the record [1/s], for a position in counts."""

    speed_time: Annotated[float, SI("s", above=0)] = 0.1
    """Time over which the speed is measured [s]."""

    settling: Annotated[float, SI("s", least=0)] = 0.2
    """Time at the start of each rest that is left out [s]."""

    least_duration: Annotated[float, SI("s", above=0)] = 0.2
    """Shortest rest that counts, after settling [s]."""


class PressureDecay(Indicator[PressureDecayOptions]):
    """Rates of the chamber pressures and of the size of their difference at rest."""

    name = "pressure_decay"
    version = 1
    summary = (
        "Rates of change of the chamber pressures, and of the magnitude of their difference, while the"
        " actuator rests."
    )
    source = "EN 1779 (1999), leak testing: change of pressure; least squares over the rests are a choice"
    equation = "dP/dt: common slope of all rests; dP_1/dt ≈ −(β/V) q_il where nothing moves or is fed"
    absence = "it contains no rest that is long enough"
    Options = PressureDecayOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """Both chamber pressures, and what tells the rests where it is named."""
        shown_by = _SHOWN_BY.get(self.options.rest)
        return frozenset(_CHAMBERS) | (frozenset() if shown_by is None else {shown_by})

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """What may show the rests."""
        return frozenset(_SHOWN_BY.values()) if self.options.rest == "auto" else frozenset()

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Rates are negative where a pressure falls, and where the pressures approach each other."""
        return (
            Output("chamber_1", "Pa/s", "rate of the chamber-1 pressure at rest"),
            Output("chamber_2", "Pa/s", "rate of the chamber-2 pressure at rest"),
            Output(
                "difference",
                "Pa/s",
                "rate of the size of the difference of the chamber pressures at rest",
                direction=Direction.FALLING,
            ),
            Output.quality("duration", "s", "time at rest that was looked at"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Nothing tells the rests."""
        if self.options.rest == "command" and Channel.INPUT_VOLTAGE in records.relative:
            return "input_voltage has no scale: where it is zero is not known"
        if self._shown_by(records) is None:
            return (
                "neither input_voltage nor piston_position tells when it rests; rest: whole takes all of it"
            )
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Pa/s; NaN if a record has no rest."""
        frequency, options = records.sampling_frequency, self.options
        rests = stretches_where(
            self._is_resting(records),
            round(options.settling * frequency),
            max(2, round(options.least_duration * frequency)),
        )
        first, second = (records[channel] for channel in _CHAMBERS)
        difference = first - second
        duration = rests.n_sample(records.n_record) / frequency
        signs = np.sign(rests.means(difference))
        return {
            "chamber_1": frequency * rests.drifts(first),
            "chamber_2": frequency * rests.drifts(second),
            "difference": frequency * rests.drifts(difference, signs),
            "duration": np.where(duration > 0.0, duration, np.nan),
        }

    def _shown_by(self, records: RecordBatch) -> str | None:
        if self.options.rest != "auto":
            return self.options.rest
        known = records.channels.keys() - (records.relative & {Channel.INPUT_VOLTAGE})
        return next((name for name, channel in _SHOWN_BY.items() if channel in known), None)

    def _is_resting(self, records: RecordBatch) -> NDArray[np.bool_]:
        options = self.options
        match self._shown_by(records):
            case "command":
                resting: NDArray[np.bool_] = np.abs(records[Channel.INPUT_VOLTAGE]) <= options.largest_command
                return resting
            case "position":
                return _is_still(records, options)
        return np.ones((records.n_record, records.n_time), dtype=bool)


def _is_still(records: RecordBatch, options: PressureDecayOptions) -> NDArray[np.bool_]:
    """Whether the piston has moved little since some time ago."""
    position, frequency = records[Channel.PISTON_POSITION], records.sampling_frequency
    largest = np.full(records.n_record, options.largest_speed)
    if Channel.PISTON_POSITION in records.relative:
        largest = options.largest_relative_speed * np.ptp(position, axis=1)
    lag = max(1, round(options.speed_time * frequency))
    still = np.zeros(position.shape, dtype=bool)
    moved = np.abs(position[:, lag:] - position[:, : max(records.n_time - lag, 0)])
    still[:, lag:] = moved <= largest[:, None] * lag / frequency
    return still
