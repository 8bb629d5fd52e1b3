"""Verdicts on windows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.measuring import feature_of, outputs_of_records, records_of
from hydrofdi.detectors.trained.novelty import findings, not_positive, wrong_side
from hydrofdi.detectors.trained.verdict import Verdict
from hydrofdi.errors import Issue
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.plausibility import doubts_of
from hydrofdi.records import Channel
from hydrofdi.records.streams import Window
from hydrofdi.settings.counting import counted


class Judge:
    """Judges windows with a trained detector. The verdict on a window does not depend on other windows.

    Parameters
    ----------
    file : DetectorFile

    Raises
    ------
    ConfigError
        The indicator cannot be made.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        self._feature = feature_of(file.config)

    @property
    def indicator(self) -> Indicator[Any]:
        """Indicator that measures windows."""
        return self._feature.indicator

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels that a window needs."""
        return self.file.channels

    def judge(self, windows: Sequence[Window]) -> list[Verdict]:
        """A verdict on each window, in order."""
        verdicts = [Verdict(None, None, None, self._fault(window)) for window in windows]
        sound = [place for place, verdict in enumerate(verdicts) if verdict.fault is None]
        if sound:
            judged = self._judge_valid([windows[place] for place in sound])
            for place, verdict in zip(sound, judged, strict=True):
                verdicts[place] = verdict
        return verdicts

    def _fault(self, window: Window) -> Issue | None:
        missing = [channel for channel in self.channels if channel not in window.channels]
        if window.fault is not None:
            return window.fault
        if missing:
            return Issue(f"has no {' and no '.join(missing)}", kind="missing_channel")
        if window.time.size != self.file.n_sample:
            return Issue(
                f"has {counted(window.time.size, 'sample')} instead of {self.file.n_sample}",
                kind="other_length",
            )
        return None

    def _judge_valid(self, windows: Sequence[Window]) -> list[Verdict]:
        records = records_of(windows, self.channels, self.file.sampling_frequency)
        values, obstacles = outputs_of_records(records, self._feature)
        every_doubts = doubts_of(self.indicator, values, fits=self.file.fits)
        faults = findings(records, self.file.ranges)
        return [
            verdict_of(self.file, float(score), fault, obstacle, doubts)
            for score, fault, obstacle, doubts in zip(
                values[self._feature.described.name], faults, obstacles, every_doubts, strict=True
            )
        ]


def verdict_of(
    file: DetectorFile,
    score: float,
    fault: Issue | None = None,
    obstacle: str | None = None,
    doubts: Sequence[Issue] = (),
) -> Verdict:
    """Verdict on a score.

    Parameters
    ----------
    file : DetectorFile
    score : float
        NaN if there is none.
    fault : Issue, optional
        Why the window is not judged. For novel windows, score and margin are still given, and the fault
        states whether the score is beyond a limit.
    obstacle : str, optional
        Why there is no score.
    doubts : sequence of Issue
        About the numbers of the window. If a quantity can only be positive, and is not, a window without an
        alarm is novel.
    """
    if fault is not None and fault.kind != "novel":
        return Verdict(None, None, None, fault)
    if math.isnan(score):
        reason = Issue(obstacle or "the indicator has no value", kind="no_number")
        return Verdict(None, None, None, fault or reason)
    limits = [(score - file.limits.low)] if file.limits.low is not None else []
    limits += [file.limits.high - score] if file.limits.high is not None else []
    distance = min(limits, default=math.inf)
    margin = distance / file.healthy.spread
    if distance >= 0.0:
        fault = fault or not_positive(file, doubts) or wrong_side(file, score)
    if fault is None:
        return Verdict(score, distance < 0.0, margin, doubt="; ".join(doubt.message for doubt in doubts))
    if distance < 0.0:
        fault = replace(fault, message=f"{fault.message}; the score is also beyond its limit")
    return Verdict(score, None, margin, fault)
