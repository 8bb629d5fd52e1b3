"""Pressures that are too low for hydraulics: their unit is probably wrong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrofdi.records.batch import Remark
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.recording import Recording

_LOWEST = 1e5
"""A running hydraulic machine has some pressure above this [Pa]; a chamber at tank pressure may be below."""
_LIKELY_UNITS = ((60.0, "MPa or bar"), (600.0, "bar"), (10e3, "psi"), (_LOWEST, "kPa"))
"""Upper limit of the values → their probable unit."""


def low_pressures(recording: Recording) -> Iterator[Remark]:
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
        yield Remark("low_pressure", text, channel)
