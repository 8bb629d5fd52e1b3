"""Windows of streams, and the same windows of whole records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk
from hydrofdi.records.streams.cycles import CycleWindower
from hydrofdi.records.streams.even import EvenStream
from hydrofdi.records.streams.sliding import TimeWindower
from hydrofdi.records.streams.window import Window
from hydrofdi.records.streams.windower import Windower
from hydrofdi.records.stuck import Direction


def make_windower(
    by: Literal["time", "cycle"],
    n_sample: int,
    n_every: int | None = None,
    *,
    channels: Sequence[Channel],
    sampling_frequency: float,
    drive_channel: Channel = Channel.INPUT_VOLTAGE,
    drive: tuple[float, float] | None = None,
    edge: Direction = "rising",
) -> Windower:
    """The windower of a stream, by time or by cycle.

    Parameters
    ----------
    by : str
        ``time`` or ``cycle``.
    n_sample : int
        Samples of a window.
    n_every : int, optional
        Samples from the start of one window to the start of the next; `n_sample` by default. Only by time.
    channels : sequence of Channel
        Channels of the windows.
    sampling_frequency : float
        Expected [Hz].
    drive_channel : Channel
        Its edges start cycles. Pieces must contain it, too.
    drive : (float, float), optional
        Lowest and highest value of the drive; needed by cycle.
    edge : str
        Which edges start a cycle.

    Raises
    ------
    ValueError
        A number of samples is below 1, or cycles have no range of the drive.
    """
    every = n_sample if n_every is None else n_every
    if min(n_sample, every) < 1:
        raise ValueError("windows need at least one sample, and at least one sample from start to start")
    if by == "time":
        return TimeWindower(n_sample, every, channels, sampling_frequency)
    if drive is None or not drive[1] > drive[0]:
        raise ValueError("cycles need the range of the drive")
    return CycleWindower(n_sample, channels, sampling_frequency, drive_channel, drive, edge)


def windows_of(time: Array, channels: Mapping[Channel, Array], windower: Windower) -> list[Window]:
    """Windows of a whole record: those of a stream of its samples.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        [s]
    channels : mapping of Channel to ndarray, shape (n_time,)
        In SI.
    windower : Windower
    """
    stream = EvenStream(windower.sampling_frequency, windower.needs)
    _, pieces, _ = stream.step(stream.start(), Chunk(time, channels))
    state, windows = windower.start(), []
    for piece in pieces:
        state, ended = windower.step(state, piece)
        windows += ended
    return windows
