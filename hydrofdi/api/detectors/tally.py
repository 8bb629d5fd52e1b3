"""What a detector said of records, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cached_property

from hydrofdi.api.detectors.windows import JudgedWindow
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.evaluation.grouped_area import FEWEST_GROUPS
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.indicators.recursive import RecursiveIndicator


class Tally:
    """Windows on their way, counted.

    Parameters
    ----------
    file : DetectorFile
    windows : iterable of JudgedWindow

    Attributes
    ----------
    faults : Counter of str
        Kind of fault → windows, or records without any, that were not judged.
    n_beyond : int
        Windows among them whose score is beyond a limit all the same.
    n_doubtful : int
        Judged windows whose verdict is doubtful.
    first_doubt : str
        The first reason.
    unjudged : dict of (str, str) to str
        Source and record of those of which nothing was judged → the first reason.
    """

    def __init__(self, file: DetectorFile, windows: Iterable[JudgedWindow]) -> None:
        self.file = file
        self.faults: Counter[str] = Counter()
        self.n_beyond = self.n_doubtful = 0
        self.first_doubt = ""
        self.unjudged: dict[tuple[str, str], str] = {}
        self._windows = windows
        self._outcomes: list[float] = []
        self._groups: list[str] = []
        self._blocks: list[str] = []
        self._records: dict[tuple[str, str], None] = {}
        self._has_groups = False

    def __iter__(self) -> Iterator[JudgedWindow]:
        for window in self._windows:
            self._count(window)
            yield window

    def _count(self, window: JudgedWindow) -> None:
        record = (window.source, window.record_id)
        if record not in self._records:
            self._records[record] = None
            self.unjudged[record] = window.fault.message if window.fault else ""
        if window.fault is not None:
            self.faults[window.fault.kind] += 1
            self.n_beyond += window.is_beyond
        if window.doubt:
            self.n_doubtful += 1
            self.first_doubt = self.first_doubt or window.doubt
        if window.alarm is not None and window.line is not None:
            self.unjudged.pop(record, None)
            self._outcomes.append(float(window.alarm))
            self._groups.append(window.group or " ".join(record))
            self._blocks.append(" ".join((*record, str(int(window.line.start / self._duration)))))
            self._has_groups |= bool(window.group)

    @property
    def n_record(self) -> int:
        """Records, those among them that were rejected."""
        return len(self._records)

    @property
    def n_judged(self) -> int:
        """Windows that were judged."""
        return len(self._outcomes)

    @property
    def n_alarm(self) -> int:
        """Alarms."""
        return int(sum(self._outcomes))

    @property
    def hours(self) -> float:
        """Time that was judged [h]: of overlapping windows, what each adds."""
        return self.n_judged * self._every / 3600.0

    @property
    def noun(self) -> str:
        """What is judged."""
        return "estimate" if self.file.config.window.by == "estimate" else "window"

    @cached_property
    def _duration(self) -> float:
        """Of a window, or from one estimate to the next [s]."""
        frequency = self.file.sampling_frequency
        if self.file.config.window.by != "estimate":
            return self.file.n_sample / frequency
        indicator = feature_of(self.file.config).indicator
        assert isinstance(indicator, RecursiveIndicator)
        return indicator.samples_per_estimate(frequency) / frequency

    @property
    def _every(self) -> float:
        """From one window to the next [s]; at most its duration."""
        if self.file.config.window.by == "estimate":
            return self._duration
        frequency = self.file.sampling_frequency
        return min(self.file.config.window.n_every(self.file.n_sample, frequency) / frequency, self._duration)

    @property
    def rests_on(self) -> str | None:
        """What the interval of the share takes as independent: ``groups`` or ``records``; ``windows`` that do
        not overlap if these are too few; None if nothing is, as estimates of a few records.
        """
        if self.n_group >= FEWEST_GROUPS:
            return self.group_noun
        return "windows" if self.file.config.window.by != "estimate" and self.n_judged else None

    @property
    def n_group(self) -> int:
        """Groups of which something was judged; records if nobody stated groups."""
        return len(set(self._groups))

    @property
    def group_noun(self) -> str:
        """What they are: ``groups`` or ``records``."""
        return "groups" if self._has_groups else "records"

    @property
    def rate(self) -> Rate:
        """The share of judged windows that are alarms, with its interval."""
        groups: list[str] | None = self._groups
        if self.rests_on == "windows":
            groups = self._blocks if self._every < self._duration else None
        return alarm_rate(self._outcomes, groups=groups, confidence=self.file.config.confidence)
