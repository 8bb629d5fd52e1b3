"""Channels that do not change although they should."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel

_FROZEN_FOR, _FROZEN_MOVE = 1.0, 0.3
"""A position is stuck if it repeats one value for longer than the first number [s], while the 5 … 95 % range
of a pressure exceeds the second, a share of the largest pressure: no friction holds a piston against that."""
_CHAMBERS = (Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE)
_RAILS = (Channel.SUPPLY_PRESSURE, Channel.RETURN_PRESSURE)
"""Both are constant if the supply is ideal; a trained detector knows whether they were in healthy records."""


def must_change(channel: Channel) -> bool:
    """Whether a channel that is constant throughout is stuck."""
    return (channel.is_pressure and channel not in _RAILS) or channel is Channel.PISTON_VELOCITY


def is_ideal_rail(channel: Channel, value: float) -> bool:
    """Whether a supply or return pressure may be constant at this value; supply at zero is a dead sensor."""
    return channel in _RAILS and (value > 0.0 or channel is Channel.RETURN_PRESSURE)


def frozen_time(channels: Mapping[Channel, Array], sampling_frequency: float) -> float:
    """Longest time for which the position repeats one value [s]; 0 if that is short, or the pressures rest.

    Parameters
    ----------
    channels : mapping of Channel to ndarray, shape (n_time,)
    sampling_frequency : float
        [Hz]
    """
    position = channels.get(Channel.PISTON_POSITION)
    apart = max(1, int(_FROZEN_FOR * sampling_frequency / 2.0))
    if position is None or not np.any(position[apart::apart] == position[:-apart:apart]):
        return 0.0  # a longer run contains two neighbours of this grid
    turns = np.flatnonzero(np.diff(position)) + 1
    bounds = np.concatenate([[0], turns, [position.size]])
    longest = int(np.argmax(np.diff(bounds)))
    frozen = slice(bounds[longest], bounds[longest + 1])
    time = float((frozen.stop - frozen.start) / sampling_frequency)
    chambers = [channels[each] for each in _CHAMBERS if each in channels]
    pressures = [samples for samples in chambers if np.isfinite(samples).all()]
    if time <= _FROZEN_FOR or not pressures:
        return 0.0
    moves = max(float(np.ptp(np.quantile(samples[frozen], [0.05, 0.95]))) for samples in pressures)
    level = max(float(np.max(np.abs(samples))) for samples in pressures)
    return time if moves > _FROZEN_MOVE * level else 0.0
