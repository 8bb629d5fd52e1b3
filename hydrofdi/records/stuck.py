"""Channels that do not change although they should."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array, Channel, RecordBatch
from hydrofdi.units import ABOVE

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
    """Longest time for which the position repeats a value [s]; 0 if it is short, or pressures rest."""
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


_LONGER, _MOVES, _STEPS = 10.0, 0.1, 4.0
"""A channel is frozen if it repeats a value for this many times its next longest repetition, and for the
first number above, while another channel moves by this share of its range, or after steps of this many
digits."""


def frozen_stretch(
    channel: Channel, channels: Mapping[Channel, Array], sampling_frequency: float
) -> slice | None:
    """The samples in which a channel repeats a value as it never does otherwise; None if there are none.

    Commands may rest, rails be ideal, and values at an end of the range be clipped.
    """
    samples = channels[channel]
    turns = np.flatnonzero(np.diff(samples)) + 1
    if channel in (Channel.INPUT_VOLTAGE, *_RAILS) or turns.size < _FEWEST_TURNS:
        return None
    bounds = np.concatenate([[0], turns, [samples.size]])
    lengths = np.diff(bounds)
    longest = int(np.argmax(lengths))
    others = np.delete(lengths, longest).max()
    stretch = slice(int(bounds[longest]), int(bounds[longest + 1]))
    value = samples[stretch.start]
    if lengths[longest] <= max(_FROZEN_FOR * sampling_frequency, _LONGER * others) or value in (
        samples.min(),
        samples.max(),
    ):
        return None
    for other, values in channels.items():
        if other is not channel and np.isfinite(values).all():
            is_still = np.ptp(values) == 0.0
            if not is_still and np.ptp(values[stretch]) > _MOVES * np.ptp(values):
                return stretch
    steps = np.abs(np.diff(samples[: stretch.start + 1]))
    is_abrupt = steps.size > 2 and np.median(steps[-5:]) > _STEPS * steps[steps > 0.0].min()
    return stretch if is_abrupt else None


_FEWEST_TURNS, _VARIED, _ROUNDING = 20, 3.0, 1e-13
"""Fewest changes that show a rate; least ratio of their median size to their 10 % quantile if they are those
of a held signal: the changes of a coarse converter are all of one digit; share of values that is rounding."""


def update_rate(samples: Array, times: Array) -> float | None:
    """How often a channel is really updated [Hz]: its samples repeat, or lie on lines between fewer; None if
    neither is so."""
    changes = np.abs(np.diff(samples))
    turns = np.flatnonzero(changes)
    if turns.size < _FEWEST_TURNS:
        return None
    if np.median(np.diff(turns)) >= 2.0:
        low, middle = np.quantile(changes[turns], [0.1, 0.5])
        return _rate_of(turns, times) if middle > _VARIED * low else None
    steps = np.diff(times)
    bends = np.abs(np.diff(np.diff(samples) / steps))
    rounding = _ROUNDING * float(np.max(np.abs(samples)) / steps.min())
    bent = np.flatnonzero(bends > max(0.02 * np.quantile(bends, 0.98), rounding))
    turns = bent[np.diff(bent, prepend=-2) > 1]  # a knot between two samples bends the line at both
    if turns.size < max(_FEWEST_TURNS, 0.45 * bent.size) or np.quantile(np.diff(turns), 0.1) < 2.0:
        return None
    low, middle = np.quantile(bends[turns], [0.1, 0.5])
    return _rate_of(turns, times) if middle > _VARIED * low else None


def _rate_of(turns: NDArray[np.intp], times: Array) -> float:
    """Rate of changes [Hz], without the longest stretches between them, in which a channel rests."""
    steps = np.diff(times[turns])
    return float(1.0 / np.mean(steps[steps <= 1.6 * np.median(steps)]))


BAND = 0.2
"""Width of the band around the middle as a share of the range: noise does not cause an edge."""
_LEAST_STEPS, _UNEVEN, _ALIKE = 3, 0.05, 0.8
"""Of a period: least distances between edges, their largest spread, and least correlation one period on."""
Direction = Literal["rising", "falling", "both"]
_WANTED = {"rising": (1,), "falling": (-1,), "both": (1, -1)}


def drive_edges(
    samples: Array, drive: tuple[float, float], direction: Direction, side: int = 0
) -> tuple[NDArray[np.intp], int]:
    """First sample beyond the band around the middle after each change of side, and the last side.

    A side is 1 above the band, −1 below it, 0 if unknown; `drive` is the lowest and highest value of the
    channel.
    """
    low, high = drive
    middle, half = (low + high) / 2.0, ABOVE * BAND * (high - low) / 2.0
    sides = np.concatenate([[side], 1 * (samples > middle + half) - (samples < middle - half)])
    decided = np.flatnonzero(sides)
    if not decided.size:
        return decided, side
    # Samples inside the band are skipped, so noise at the middle makes no edge.
    changes = decided[1:][np.diff(sides[decided]) != 0]
    return changes[np.isin(sides[changes], _WANTED[direction])] - 1, int(sides[decided[-1]])


def found_period(batch: RecordBatch, row: int = 0) -> float | None:
    """Period of the drive of a record [s]: the one that is known, or that of u; None if it has none.

    The rising edges of u are even, and u repeats from one to the next. It is rounded to half a sample.
    """
    u = batch.channels.get(Channel.INPUT_VOLTAGE)
    if batch.drive_period is not None or u is None or not np.isfinite(samples := u[row]).all():
        return batch.drive_period
    steps = np.diff(drive_edges(samples, (float(samples.min()), float(samples.max())), "rising")[0])
    if steps.size < _LEAST_STEPS or np.ptp(steps) > max(2.0, _UNEVEN * steps.mean()):
        return None
    lag = round(float(steps.mean()))
    # Even edges alone could be chance; the whole signal must repeat.
    is_repeated = np.corrcoef(samples[:-lag], samples[lag:])[0, 1] > _ALIKE
    return round(2.0 * float(steps.mean())) / (2.0 * batch.sampling_frequency) if is_repeated else None
