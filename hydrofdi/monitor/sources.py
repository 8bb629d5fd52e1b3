"""Sources of streams: what they have in common; the sources and sinks that addresses mean."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError, without_credentials
from hydrofdi.monitor.configuration import PORTS, Address, MonitorConfig
from hydrofdi.monitor.connections import needing_extra
from hydrofdi.records.streams import Chunk, Event
from hydrofdi.settings.messages import similar

Position = Mapping[str, Any]
"""Where a source continues after a restart: small, and valid as JSON. Empty if it cannot go back."""


class StreamSource:
    """A stream of samples. One thread calls its methods; sockets, event loops and other threads are its own.

    A source may repeat samples, after a restart or as a broker does: the watch drops samples that are not
    later than the last one. The defaults below are those of a source that stores nothing.

    Attributes
    ----------
    name : str
        For display, without credentials.
    events : deque of Event
        What happened since somebody took them: lost connections, dropped samples.
    is_over : bool
        Whether nothing follows what was read.
    may_repeat_all : bool
        Whether a restart without a position may repeat the whole stream, as a pipe does; a broker repeats at
        most the last few seconds.
    address : Address or None
        Of a topic, whose messages come over a connection that machines share.
    """

    is_over = may_repeat_all = False
    address: Address | None = None

    def __init__(self, name: str, events: deque[Event] | None = None) -> None:
        self.name = name
        self.events: deque[Event] = deque() if events is None else events

    def open(self, position: Position) -> None:
        """Begin at the position that an earlier run stored; it is empty at the first start."""

    def read(self, timeout: float) -> Chunk | None:
        """New samples, at most about 65,536; None if after `timeout` seconds there are none, or events.

        Small pieces may be gathered for `connections.GATHER` seconds.
        """
        raise NotImplementedError

    @property
    def position(self) -> Position:
        """Where to continue after all that was read; empty if it cannot go back."""
        return {}

    def confirm(self) -> None:
        """A state that contains all that was read is stored: a broker may discard it."""

    def close(self) -> None:
        """End connections, threads and files."""


def joined(chunks: Sequence[Chunk]) -> Chunk:
    """All samples in one chunk, NaN for a channel that a chunk does not have."""
    if len(chunks) == 1:
        return chunks[0]
    firsts = np.cumsum([0, *(chunk.n_time for chunk in chunks)]).tolist()
    channels = {channel: np.full(firsts[-1], np.nan) for chunk in chunks for channel in chunk.channels}
    unread: dict[int, str] = {}
    for first, chunk in zip(firsts, chunks, strict=False):
        unread |= {first + row: text for row, text in chunk.unread.items()}
        for channel, samples in chunk.channels.items():
            channels[channel][first : first + chunk.n_time] = samples
    return Chunk(np.concatenate([np.empty(0), *(chunk.time for chunk in chunks)]), channels, unread)


def malformed(what: str, text: str, reason: str) -> Chunk:
    """A line or a payload that is not understood: a sample that could not be read."""
    return Chunk(np.array([np.nan]), {}, {0: f"malformed {what} {text[:60]!r}: {reason}"})


_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/")
_KINDS = "'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT"
_RECORDS = (".h5", ".hdf5", ".mat", ".npz", ".parquet", ".yaml", ".yml")
"""Suffixes of files that contain records, but no lines of text."""


def of_detector(config: MonitorConfig, file: DetectorFile) -> MonitorConfig:
    """The configuration with those channels alone that a detector reads, if it has any of them."""
    seen = {*file.channels, file.config.window.channel}
    channels = {channel: each for channel, each in config.channels.items() if channel in seen}
    return config.model_copy(update={"channels": channels}) if channels else config


def open_stream(
    text: str,
    config: MonitorConfig,
    file: DetectorFile,
    *,
    sampling_frequency: float | None = None,
    is_followed: bool = True,
    is_resumed: bool = False,
) -> StreamSource:
    """The stream that a text means; nothing is read or connected yet."""
    from hydrofdi.monitor.growing_file import GrowingFile, StandardInput

    config = of_detector(config, file)
    if scheme := _SCHEME.match(text):
        kind = scheme[1].lower()
        if kind not in PORTS:
            hint = similar(kind, [*PORTS]) or f"; a source is {_KINDS}"
            raise ConfigError(f"{text}: unknown kind of source {kind!r}{hint}")
        if sampling_frequency is not None:
            raise ConfigError("sampling_frequency: applies only to text; other sources state times")
        address = Address.parse(text)
        with needing_extra():
            if kind == "opc.tcp":
                from hydrofdi.monitor.opcua import OpcUaSource

                return OpcUaSource(address, config.opcua, config.channels, file.sampling_frequency)
            from hydrofdi.monitor.fleet.topics import TopicSource

            return TopicSource(str(address), config, file.channels, address)
    if sampling_frequency is not None:
        config = config.model_copy(update={"sampling_frequency": sampling_frequency})
    if text == "-":
        return StandardInput(config, needed=file.channels)
    path = Path(text)
    if path.is_dir() or path.suffix.lower() in _RECORDS:
        raise ConfigError(
            f"{text}: is not a text stream; 'hydrofdi detect' judges it, 'hydrofdi replay' streams it"
        )
    if without_credentials(text) != text and not path.exists():
        raise ConfigError(f"{text}: no such file; a source is {_KINDS}")
    return GrowingFile(path, config, is_followed, file.channels, leaves_unended=is_resumed)
