"""Judging of records by a trained detector."""

from __future__ import annotations

from os import PathLike
from typing import Any

from hydrofdi.api.detectors.detector import Detector
from hydrofdi.api.records.held import Names
from hydrofdi.report.table import Table


def detect(
    detector: Detector | str | PathLike[str],
    data: Any,
    *,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> Table:
    """Judge records with a trained detector, window by window, as ``hydrofdi detect`` does.

    Parameters
    ----------
    detector : Detector or path
    data, sampling_frequency, channel, unit
        Records in files or in memory, as in `hydrofdi.measure`.

    Returns
    -------
    Table
        A row for each window, as `Detector.judge` gives it.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.detect("nothing.json", "rig.csv")
    Traceback (most recent call last):
    hydrofdi.errors.ConfigError: nothing.json: No such file or directory
    """
    judge = detector if isinstance(detector, Detector) else Detector.load(detector)
    return judge.judge(data, sampling_frequency=sampling_frequency, channel=channel, unit=unit)
