"""Channels whose sizes are unusual: their unit or gain is probably wrong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.recording import Recording
from hydrofdi.settings import readable as usual
from hydrofdi.settings.readable import shown_quantity
from hydrofdi.units import parse_quantity

_LOWEST = 1e5
"""A running hydraulic machine has some pressure above this [Pa]; a chamber at tank pressure may be below."""
_LIKELY_UNITS = ((60.0, "MPa or bar"), (600.0, "bar"), (10e3, "psi"), (_LOWEST, "kPa"))
"""Upper limit of the values → their probable unit."""

_USUAL = {
    Channel.CHAMBER_1_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.CHAMBER_2_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.SUPPLY_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.RETURN_PRESSURE: usual.RETURN_PRESSURE,
    Channel.PISTON_POSITION: usual.POSITION,
    Channel.SPOOL_POSITION: usual.SPOOL_POSITION,
    Channel.INPUT_VOLTAGE: usual.VOLTAGE,
}
_MOST_RATIO = 5.0
"""Ratio of the mean chamber pressures above which one of them may have another unit; pressures that are alike
differ by about ten if one is in bar and read as MPa."""


def unusual_sizes(recording: Recording) -> Iterator[Issue]:
    """Remarks on channels beyond the usual sizes, and on chamber pressures that are not alike."""
    yield from low_pressures(recording)
    channels = {
        channel: samples
        for channel, samples in recording.channels.items()
        if channel not in recording.relative and np.all(np.isfinite(samples))
    }
    for channel in (each for each in _USUAL if each in channels):
        low, high = (parse_quantity(bound, channel.unit) for bound in _USUAL[channel])
        largest = float(np.max(np.abs(channels[channel])))
        if largest > high or (0.0 < largest < low and not channel.is_pressure):
            text = f"{channel}: values up to {shown_quantity(largest, channel.unit)} are far"
            sides = "above" if largest > high else "below"
            yield Issue(f"{text} {sides} the usual {' … '.join(_USUAL[channel])}", channel, kind="unusual")
    chambers = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE
    means = {channel: float(np.mean(channels[channel])) for channel in chambers if channel in channels}
    if len(means) == 2 and max(means.values()) > _MOST_RATIO * abs(min(means.values())):
        larger, smaller = sorted(means, key=means.__getitem__, reverse=True)
        shown = [shown_quantity(means[channel], "Pa") for channel in (larger, smaller)]
        text = f"{larger}: the mean is {shown[0]}, but {shown[1]} of {smaller}; is a unit or gain wrong?"
        yield Issue(text, larger, kind="unusual")


def low_pressures(recording: Recording) -> Iterator[Issue]:
    """Remarks on the chamber and supply pressures if none of them reaches 0.1 MPa."""
    highest = {
        channel: float(np.max(samples))
        for channel, samples in recording.channels.items()
        if channel.is_pressure
        and channel is not Channel.RETURN_PRESSURE
        and channel not in recording.relative
        and np.all(np.isfinite(samples))
    }
    if not highest or max(highest.values()) >= _LOWEST:
        return
    for channel, value in highest.items():
        unit = next(unit for most, unit in _LIKELY_UNITS if value < most)
        text = (
            f"{channel}: values up to {value:.4g} Pa; is the unit {unit}? Hydraulic pressures exceed 0.1 MPa"
        )
        yield Issue(text, channel, kind="low_pressure")
