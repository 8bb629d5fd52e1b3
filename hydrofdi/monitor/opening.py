"""The sources that texts mean: of a single machine, and those of a fleet, files and topics of brokers."""

from __future__ import annotations

import re
import time
from collections.abc import Collection, Iterator, Sequence
from functools import partial
from glob import escape, glob
from pathlib import Path
from typing import TYPE_CHECKING

from hydrofdi.errors import ConfigError, without_credentials
from hydrofdi.monitor.configuration import PORTS, Address, FleetConfig, Pattern
from hydrofdi.monitor.growing_file import GrowingFile, StandardInput
from hydrofdi.monitor.machines import MachineKind, SourceOf
from hydrofdi.monitor.sources import StreamSource, needing_extra, printable
from hydrofdi.records.streams import Event
from hydrofdi.settings.messages import similar

if TYPE_CHECKING:
    from hydrofdi.monitor.topics import Topics

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/")
_KINDS = "'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT"
_RECORDS = (".h5", ".hdf5", ".mat", ".npz", ".parquet", ".yaml", ".yml")
"""Suffixes of files that contain records, but no lines of text."""


def open_stream(
    text: str,
    kind: MachineKind,
    *,
    sampling_frequency: float | None = None,
    is_followed: bool = True,
    is_resumed: bool = False,
) -> StreamSource:
    """The stream that a text means; nothing is read or connected yet."""
    config, file = kind.config, kind.file
    if scheme := _SCHEME.match(text):
        name = scheme[1].lower()
        if name not in PORTS:
            hint = similar(name, [*PORTS]) or f"; a source is {_KINDS}"
            raise ConfigError(f"{text}: unknown kind of source {name!r}{hint}")
        if sampling_frequency is not None:
            raise ConfigError("sampling_frequency: applies only to text; other sources state times")
        address = Address.parse(text)
        with needing_extra():
            if name == "opc.tcp":
                from hydrofdi.monitor.opcua import OpcUaSource

                return OpcUaSource(address, config.opcua, config.channels, file.sampling_frequency)
            from hydrofdi.monitor.topics import TopicSource

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


_LOOK_EVERY = 2.0
"""Time between searches for new files [s]."""


class Sources:
    """Finds machines, and hands them what comes over connections that they share."""

    def __init__(
        self,
        config: FleetConfig,
        file: Path,
        patterns: Sequence[Pattern],
        *,
        is_followed: bool,
        is_single: bool = False,
    ) -> None:
        self._is_followed, self._is_resumed = is_followed, config.state is not None
        self._files = [pattern for pattern in patterns if pattern.address is None]
        self._looked = -_LOOK_EVERY
        self._topics: list[Topics] = []
        brokers: dict[tuple[str, str, int], list[Pattern]] = {}
        for pattern in patterns:
            if (address := pattern.address) is not None:
                brokers.setdefault((address.scheme, address.host, address.port), []).append(pattern)
        if brokers:
            with needing_extra():
                from hydrofdi.monitor.topics import Topics
            self._topics = [Topics(some, config, file, is_single=is_single) for some in brokers.values()]

    def open(self) -> None:
        """Begin to connect."""
        for topics in self._topics:
            topics.connect()

    def collect(self, source_of: SourceOf, timeout: float) -> Iterator[Event]:
        """Find machines, and let messages wait at their sources; what happened to the connections."""
        if time.monotonic() - self._looked >= _LOOK_EVERY:
            self._looked = time.monotonic()
            for name, path in self._found():
                source_of(name, path, partial(self._file, path))
        for topics in self._topics:
            topics.dispatch(source_of, timeout)
            yield from (topics.events.popleft() for _ in range(len(topics.events)))

    @property
    def is_over(self) -> bool:
        """Whether no further machine will be found."""
        return not self._topics and not self._is_followed

    @property
    def is_behind(self) -> bool:
        """Whether messages have arrived that no round has handed out."""
        return any(topics.is_behind for topics in self._topics)

    def blocking(self) -> Collection[StreamSource]:
        """Sources whose states must be stored so that messages can go on coming."""
        return {source for topics in self._topics for source in topics.blocking()}

    def acknowledge(self) -> None:
        """Let brokers forget what is stored."""
        for topics in self._topics:
            topics.acknowledge()

    def close(self) -> None:
        """End the connections."""
        for topics in self._topics:
            topics.close()

    def _found(self) -> Iterator[tuple[str, str]]:
        for pattern in self._files:
            before, wildcard, after = pattern.text.partition("*")
            paths = sorted(glob(f"{escape(before)}*{escape(after)}")) if wildcard else [pattern.text]
            for path in paths:
                if (name := pattern.name_in(path)) is not None and not Path(path).is_dir():
                    yield printable(name), path

    def _file(self, path: str, kind: MachineKind) -> StreamSource:
        needed, is_resumed = kind.file.channels, self._is_resumed
        return GrowingFile(Path(path), kind.config, self._is_followed, needed, leaves_unended=is_resumed)
