"""Pressures as shares of the supply pressure or of the hold pressure."""

from __future__ import annotations

from dataclasses import replace

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.recording import Recording
from hydrofdi.records.measured.rejection import RejectionError

_HOLD = 5
"""The last fifth is the hold."""


def reference_pressure(recording: Recording, kind: str) -> float:
    """The pressure by which the others are divided, in the unit of its channel.

    Raises
    ------
    DataError
        Some pressures have a scale and some have none.
    RejectionError
        It is not above zero.
    """
    units = {recording.unit(channel) for channel in recording.channels if channel.is_pressure}
    if len(units) > 1:
        raise DataError(
            f"normalize: pressures in {' and in '.join(sorted(units, reverse=True))}"
            " cannot be divided by one another"
        )
    if kind == "supply":
        pressure = float(recording.channels[Channel.SUPPLY_PRESSURE].mean())
    else:
        last = recording.n_time - recording.n_time // _HOLD
        chambers = (Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE)
        pressure = max(float(recording.channels[chamber][last:].mean()) for chamber in chambers)
    if not pressure > 0.0:
        raise RejectionError(
            "no_reference", f"the {kind} pressure is {pressure:g}; pressures cannot be divided by it"
        )
    return pressure


def normalized(recording: Recording, kind: str, pressure: float) -> Recording:
    """A recording with divided pressures, which are then relative."""
    pressures = frozenset(channel for channel in recording.channels if channel.is_pressure)
    unit = recording.unit(Channel.CHAMBER_1_PRESSURE)
    text = f"pressures are divided by the {kind} pressure, {pressure:.4g} {unit}"
    return replace(
        recording,
        channels={
            channel: samples / pressure if channel in pressures else samples
            for channel, samples in recording.channels.items()
        },
        relative=recording.relative | pressures,
        normalized=pressures,
        remarks=(*recording.remarks, Issue(text, kind="normalized")),
    )
