"""Standard input as a stream."""

from __future__ import annotations

import os
import select
from collections.abc import Collection

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.text_lines import TextLines
from hydrofdi.records.channels import Channel

BLOCK = 1 << 17
"""Bytes that are read at once: a few thousand samples."""

_LEAP = 2
"""Sample numbers that a restart skips, so that the gap is detected."""


class StandardInput(StreamSource):
    """Standard input, or another descriptor: a pipe, a file or a terminal. It cannot go back.

    Parameters
    ----------
    config : MonitorConfig, optional
        Its channels, its text and its limits.
    descriptor : int
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    """

    def __init__(
        self,
        config: MonitorConfig | None = None,
        descriptor: int = 0,
        needed: Collection[Channel] = (),
    ) -> None:
        self._config, self._descriptor, self._needed = config or MonitorConfig(), descriptor, needed
        self._is_over = False
        self._text = self._lines({})

    @property
    def name(self) -> str:
        """Standard input."""
        return "standard input"

    def open(self, position: Position) -> None:
        """Begin; the count of samples without time continues after a gap.

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
        """New samples and events; an empty reading after `timeout` seconds without any.

        Raises
        ------
        DataError
            The first line is not a usable header.
        """
        if self._is_over:
            return Reading(is_over=True)
        if not select.select([self._descriptor], [], [], timeout)[0]:
            return Reading()
        data = self._data()
        self._is_over = not data
        return Reading(self._text.read(data, is_end=self._is_over), (), self._is_over)

    @property
    def position(self) -> Position:
        """The number of samples without time."""
        return {key: value for key, value in self._text.position.items() if key == "n_sample"}

    @property
    def may_repeat_all(self) -> bool:
        """True: the writer may begin anew."""
        return True

    def close(self) -> None:
        """Do nothing."""

    def _data(self) -> bytes:
        try:
            return os.read(self._descriptor, BLOCK)
        except OSError:
            return b""

    def _lines(self, position: Position) -> TextLines:
        return TextLines(self._config, self.name, position, self._needed)
