"""Standard input as a stream."""

from __future__ import annotations

import os
import select
from collections.abc import Collection

from hydrofdi.errors import DataError
from hydrofdi.monitor.sources.columns import Channels
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.payload import LARGEST
from hydrofdi.monitor.sources.text.config import TextConfig
from hydrofdi.monitor.sources.text.lines import TextLines
from hydrofdi.records.channels import Channel

BLOCK = 1 << 17
"""Bytes that are read at once: some thousand samples."""

_LEAP = 2
"""Counted samples that are left out at a restart, so that a gap is seen where there was one."""


class StandardInput(StreamSource):
    """Standard input, or another descriptor: a pipe, a file or a terminal. It cannot go back.

    Parameters
    ----------
    channels : mapping of Channel to ChannelConfig, optional
    config : TextConfig, optional
    descriptor : int
    largest : int
        Bytes of a line.
    needed : collection of Channel
        What a column must not miss by its unit alone.
    """

    def __init__(
        self,
        channels: Channels | None = None,
        config: TextConfig | None = None,
        descriptor: int = 0,
        largest: int = LARGEST,
        needed: Collection[Channel] = (),
    ) -> None:
        self._needed = needed
        self._channels, self._config = channels or {}, config or TextConfig()
        self._descriptor, self._largest = descriptor, largest
        self._is_over = False
        self._text = self._lines({})

    @property
    def name(self) -> str:
        """Standard input."""
        return "standard input"

    def open(self, position: Position) -> None:
        """Begin; samples without time are counted on, behind a gap.

        Raises
        ------
        DataError
            Standard input is closed.
        """
        try:
            os.fstat(self._descriptor)
        except OSError:
            raise DataError("standard input is closed") from None
        counted = position.get("n_sample")
        self._text = self._lines({} if counted is None else {"n_sample": int(counted) + _LEAP})

    def read(self, timeout: float) -> Reading:
        """What has come; after `timeout` seconds without anything, an empty reading.

        Raises
        ------
        DataError
            The first line is no usable header.
        """
        if self._is_over:
            return Reading(is_over=True)
        if not select.select([self._descriptor], [], [], timeout)[0]:
            return Reading()
        data = self._data()
        self._is_over = not data
        chunk, events = self._text.read(data, is_end=self._is_over)
        return Reading(chunk, events, self._is_over)

    @property
    def position(self) -> Position:
        """How many samples without time were counted."""
        return {key: value for key, value in self._text.position.items() if key == "n_sample"}

    @property
    def may_repeat_all(self) -> bool:
        """Whoever writes may begin anew."""
        return True

    def close(self) -> None:
        """Nothing to do."""

    def _data(self) -> bytes:
        try:
            return os.read(self._descriptor, BLOCK)
        except OSError:
            return b""

    def _lines(self, position: Position) -> TextLines:
        return TextLines(self._channels, self._config, self.name, position, self._largest, self._needed)
