"""Bytes of text in any pieces → samples."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Collection, Sequence
from itertools import groupby
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.contract import Position, joined, malformed
from hydrofdi.monitor.sources.csv_lines import CsvLines
from hydrofdi.monitor.sources.payload import PayloadError, PayloadReader, SampleClock, parsed
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.counting import counted


class JsonLines:
    """Reads lines with one JSON object each.

    Attributes
    ----------
    header : list of str
        Empty: no lines are needed to continue within the stream.
    """

    def __init__(
        self,
        config: MonitorConfig,
        clock: SampleClock | None,
        needed: Collection[Channel] = (),
    ) -> None:
        self.header: list[str] = []
        self._reader = PayloadReader(config, clock, needed)
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


class TextLines:
    """Reads CSV with a header, or JSON lines: the first character decides.

    Parameters
    ----------
    config : MonitorConfig
        Its channels, its text and its limits.
    name : str
        The stream, for messages.
    position : mapping
        `position` of an earlier run.
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    """

    def __init__(
        self,
        config: MonitorConfig,
        name: str,
        position: Position,
        needed: Collection[Channel] = (),
    ) -> None:
        self._config, self._name, self._needed = config, name, needed
        self._largest, frequency = config.limits.payload, config.sampling_frequency
        n_sample = int(position.get("n_sample", 0))
        self._clock = None if frequency is None else SampleClock(frequency, n_sample)
        encoding = config.format.encoding
        self._encoding = "utf-8-sig" if encoding.lower() in ("utf-8", "utf8") else encoding
        self._lines: CsvLines | JsonLines | None = None
        self._rest, self._is_skipping = b"", "is_skipping" in position
        if header := position.get("header"):
            self._lines = self._csv()
            self._lines.read(list(header))

    @property
    def n_unfinished(self) -> int:
        """Number of bytes of the unfinished last line."""
        return len(self._rest)

    @property
    def position(self) -> dict[str, Any]:
        """Header and sample count, which are needed to continue with the unfinished line."""
        known: dict[str, Any] = {}
        if self._lines is not None and self._lines.header:
            known["header"] = list(self._lines.header)
        if self._clock is not None:
            known["n_sample"] = self._clock.n_sample
        if self._is_skipping:
            known["is_skipping"] = True
        return known

    def forget_unfinished(self) -> None:
        """Discard the unfinished last line."""
        self._rest, self._is_skipping = b"", False

    def read(self, data: bytes, *, is_end: bool = False) -> Chunk | None:
        """Samples of the lines that are now complete; None without one.

        Parameters
        ----------
        data : bytes
        is_end : bool
            Whether nothing follows; the last line then needs no line end.

        Raises
        ------
        DataError
            It begins with UTF-16 or binary data, or the first line is not a usable header.
        """
        self._require_text(data)
        text = (self._rest + data).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        whole, end, rest = text.rpartition(b"\n")
        if is_end:
            whole, end, rest = whole + end + rest, b"", b""
        self._rest = rest
        lines = whole.decode(self._encoding, errors="replace").split("\n") if whole else []
        if self._is_skipping and (lines or end):
            lines, self._is_skipping = lines[1:], False
        if len(rest) > self._largest:
            lines.append(rest.decode(self._encoding, errors="replace"))
            self._rest, self._is_skipping = b"", True
        chunks: list[Chunk] = []
        for fits, some in groupby(lines, self._fits):
            found = list(some)
            chunks += self._chunks(found) if fits else [self._too_long(line) for line in found]
        return joined(chunks) if chunks else None

    def _require_text(self, data: bytes) -> None:
        """Refuse UTF-16 and binary data before the first line."""
        if self._lines is not None:
            return
        if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
            raise DataError(
                f"{self._name}: is in UTF-16; convert it to UTF-8 with 'iconv -f UTF-16 -t UTF-8'"
            )
        if b"\0" in data.partition(b"\n")[0]:
            raise DataError(f"{self._name}: is not text in UTF-8; is it a binary file, or in UTF-16?")

    def _fits(self, line: str) -> bool:
        """Whether a line is short enough."""
        return len(line) * 4 <= self._largest or len(line.encode()) <= self._largest

    def _too_long(self, line: str) -> Chunk:
        return malformed("line", line, f"is longer than {counted(self._largest, 'byte')}")

    def _chunks(self, lines: list[str]) -> list[Chunk]:
        if self._lines is None:
            first = next((line.strip() for line in lines if line.strip()), "")
            if not first:
                return []
            self._lines = self._json() if first.startswith("{") else self._csv()
        return self._lines.read(lines)

    def _json(self) -> JsonLines:
        return JsonLines(self._config, self._clock, self._needed)

    def _csv(self) -> CsvLines:
        return CsvLines(self._config, self._clock, self._name, self._needed)
