"""Steps of the drive, shared by the indicators that analyse the time after a step."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms.steps import Steps, half_periods, jumps

_LEAST_RATIO = 8.0
"""Least ratio of largest to mean change of a command with steps; noise stays below it."""


class SteppingOptions(Section):
    """Options that define the steps of the drive."""

    steps: Literal["auto", "command", "period", "signal"] = "auto"
    """``command``: the jumps of the input voltage. ``period``: every half period of the drive. ``signal``:
    the largest changes of the signal itself. ``auto``: the first of these that is available."""

    jump_time: Annotated[float, SI("s", above=0)] = 10e-3
    """Longest duration of a jump [s]; its instant is where it exceeds ``least_jump``."""

    least_jump: Annotated[float, SI("1", above=0, most=1)] = 0.5
    """Smallest jump relative to the largest in the record [-]; smaller ones are ignored."""

    spacing: Annotated[float, SI("s", above=0)] = 0.1
    """Jumps that follow another within this time count as part of it [s]."""


def stepping_channels(options: SteppingOptions) -> frozenset[Channel]:
    """Channels required to find the steps."""
    return frozenset({Channel.INPUT_VOLTAGE} if options.steps == "command" else ())


def optional_stepping_channels(options: SteppingOptions) -> frozenset[Channel]:
    """Channels that are used to find the steps if available."""
    return frozenset({Channel.INPUT_VOLTAGE} if options.steps == "auto" else ())


def stepping_obstacle(records: RecordBatch, options: SteppingOptions) -> str | None:
    """Message if the steps of records cannot be found, else None."""
    if options.steps == "period" and records.drive_period is None:
        return "the period of the drive is unknown"
    return None


def drive_steps(records: RecordBatch, options: SteppingOptions, signal: Array) -> Steps:
    """The steps of the drive after the first sample of each record.

    Parameters
    ----------
    records : RecordBatch
    options : SteppingOptions
    signal : ndarray, shape (n_record, n_time)
        Signal used to find the steps if there is neither a command nor a period.
    """
    lag, spacing = (
        max(1, round(time * records.sampling_frequency)) for time in (options.jump_time, options.spacing)
    )
    match _shown_by(records, options):
        case "command":
            return jumps(records[Channel.INPUT_VOLTAGE], lag, spacing, _LEAST_RATIO, options.least_jump)
        case "period" if records.drive_period is not None:
            return half_periods(
                records.n_record,
                records.n_time,
                records.sampling_frequency,
                records.drive_period,
                records.start_time,
            )
    return jumps(signal, lag, spacing, least_share=options.least_jump)


def alternating_side(records: RecordBatch, signal: Array) -> Array:
    """Alternating sign of a drive that is not measured, from step to step, shape (n_record, n_time).

    It is +1 after a step at which the signal rises, e.g. the pressure of the supplied chamber.
    """
    steps = drive_steps(records, SteppingOptions(), signal)
    turns = np.zeros(signal.shape, dtype=int)
    turns[steps.record, steps.sample] = 1
    side = 1.0 - 2.0 * (np.cumsum(turns, axis=1) % 2)
    rise = np.sum(side[:, :-1] * np.diff(signal, axis=1), axis=1, keepdims=True)
    return side * np.where(rise < 0.0, -1.0, 1.0)


def _shown_by(records: RecordBatch, options: SteppingOptions) -> str:
    if options.steps != "auto":
        return options.steps
    if Channel.INPUT_VOLTAGE in records.channels:
        return "command"
    return "signal" if records.drive_period is None else "period"
