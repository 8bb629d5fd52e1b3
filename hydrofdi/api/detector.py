"""Trained detectors."""

from __future__ import annotations

from itertools import chain
from os import PathLike
from typing import Any

from hydrofdi.api.places import path_of
from hydrofdi.api.sources import Names, sources_of
from hydrofdi.api.table import Table
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.reading import load_detector
from hydrofdi.pipeline.detecting import JudgedWindow, channels_read, detect


class Detector:
    """A trained detector, which judges records window by window.

    Attributes
    ----------
    file : DetectorFile
        Indicator, limits and what its promise rests on, in SI.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Detector:
        """The detector in a file that ``hydrofdi train`` wrote.

        Raises
        ------
        ConfigError
            It is no detector file, or one of another version.
        """
        return cls(load_detector(path_of(path)))

    def judge(
        self,
        data: Any,
        *,
        sampling_frequency: str | float | None = None,
        channel: Names = None,
        unit: Names = None,
    ) -> Table:
        """Judge every window of records, as ``hydrofdi detect`` does.

        Parameters
        ----------
        data, sampling_frequency, channel, unit
            Records in files or in memory, as `hydrofdi.measure` has them.

        Returns
        -------
        Table
            A row for each window, or record without any: ``record_id``, ``source``, ``group``, ``start`` and
            ``end`` [s], ``score``, ``margin`` in healthy spreads, ``alarm`` (None where the window is not
            judged), and the ``fault`` and ``reason`` why.

        Raises
        ------
        ConfigError, DataError, StoreError
            As the command says it.
        """
        sources = sources_of(data, channels_read(self.file), sampling_frequency, channel, unit)
        windows = [*chain.from_iterable(detect(self.file, source) for source in sources)]
        rows = [_row(window) for window in windows]
        columns = {name: [row[name] for row in rows] for name in _NAMES}
        return Table("window", columns, {"start": "s", "end": "s", "score": self.file.unit})

    def __repr__(self) -> str:
        limits = self.file.limits
        ends = (("below", limits.low), ("above", limits.high))
        alarms = " or ".join(f"{side} {end:.4g}" for side, end in ends if end is not None)
        config = self.file.config
        return f"{config.indicator}.{config.output}: alarm {alarms} {self.file.unit}"


_NAMES = ("record_id", "source", "group", "start", "end", "score", "margin", "alarm", "fault", "reason")


def _row(window: JudgedWindow) -> dict[str, Any]:
    line, fault = window.line, window.fault
    return {
        "record_id": window.record_id,
        "source": window.source,
        "group": window.group,
        "start": None if line is None else line.start,
        "end": None if line is None else line.end,
        "score": None if line is None else line.verdict.score,
        "margin": None if line is None else line.verdict.margin,
        "alarm": window.alarm,
        "fault": "" if fault is None else fault.kind,
        "reason": "" if fault is None else fault.text,
    }
