"""Lines of JSON as samples."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from hydrofdi.monitor.sources.columns import Channels
from hydrofdi.monitor.sources.malformed import malformed
from hydrofdi.monitor.sources.payload import PayloadError, PayloadReader, parsed
from hydrofdi.monitor.sources.sample_clock import SampleClock
from hydrofdi.monitor.sources.text.config import TextConfig
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk


class JsonLines:
    """Reads lines with one JSON object each.

    Attributes
    ----------
    header : list of str
        Empty: no lines are needed to continue within the stream.
    """

    def __init__(
        self,
        channels: Channels,
        config: TextConfig,
        clock: SampleClock | None,
        needed: Collection[Channel] = (),
    ) -> None:
        self.header: list[str] = []
        self._reader = PayloadReader(channels, config.time, clock, needed=needed, zone=config.time_zone)
        self._clock = clock

    def read(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines."""
        chunks: list[Chunk] = []
        objects: list[tuple[str, dict[str, Any]]] = []
        for line in lines:
            if not line or line.isspace():
                continue
            try:
                objects.append((line, parsed(line)))
            except PayloadError as error:
                chunks += [*self._samples(objects), self._refused(line, error)]
                objects = []
        return chunks + self._samples(objects)

    def _samples(self, objects: Sequence[tuple[str, dict[str, Any]]]) -> list[Chunk]:
        together = self._together([found for _, found in objects])
        return [together] if together else self._one_by_one(objects)

    def _together(self, objects: Sequence[dict[str, Any]]) -> Chunk | None:
        """Objects with the same keys and one sample each, as one block; None for other objects."""
        if len(objects) < 2 or len({tuple(found) for found in objects}) > 1:
            return None
        try:
            return self._reader.chunk({key: [found[key] for found in objects] for key in objects[0]})
        except PayloadError:
            return None

    def _one_by_one(self, objects: Sequence[tuple[str, dict[str, Any]]]) -> list[Chunk]:
        chunks = []
        for line, found in objects:
            try:
                chunks.append(self._reader.chunk(found))
            except PayloadError as error:
                chunks.append(self._refused(line, error))
        return chunks

    def _refused(self, line: str, error: PayloadError) -> Chunk:
        if self._clock is not None:
            self._clock.skip(1)
        return malformed("line", line, str(error))
