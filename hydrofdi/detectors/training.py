"""Training of a detector: healthy records, measured window by window, and the score that they teach."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain, compress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors import verdicts
from hydrofdi.detectors.configuration import (
    DetectorConfig,
    Feature,
    TimedChart,
    direction_of,
    feature_of,
    stated_indicators,
)
from hydrofdi.detectors.file import Basis, Scale, TrainedScore
from hydrofdi.detectors.rules import OF_ONE, ScoreConfig, make_score
from hydrofdi.detectors.scores.contract import cross_fitted_scores, healthy_scale, known_numbers, plain_data
from hydrofdi.errors import ConfigError, DataError, Issue, NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.balancing import WindowOptions
from hydrofdi.indicators.estimation.whole_record import likeliest_wrong, sentence
from hydrofdi.indicators.faults import CAUSES, OF_LEAKS
from hydrofdi.indicators.measuring import spool_remedy, used_channels
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.recording import found_period
from hydrofdi.records.streams import Chunk, EvenStream, TimeWindower, Window, Windower
from hydrofdi.settings.messages import time_text

_CHUNK = 2**17
"""Number of samples of a record that are cut at a time; overlapping windows multiply their memory."""

_MOST_SAMPLES = 2**21
"""Number of samples per channel that are measured at a time."""

_WRONG_SIZES = {"unusual", "low_pressure"}
"""Kinds of remarks on channels whose unit or gain is probably wrong."""

_NOT_EVEN = {"uneven", "gaps"}
"""Kinds of remarks on records whose samples are not even, or mostly missing."""

_OUTLYING = 8.0
"""Healthy spreads from the median beyond which a record with most of its windows is said to be unlike the
others; a choice."""

N_PIECE = 20
"""Pieces of a single record by which a score is cross-fitted, and of few records for the limit of a chart."""


class _Record(NamedTuple):
    """Duration [s], group, label and name of a record; group and label are empty if unknown."""

    duration: float
    group: str
    label: str
    name: str


class HealthyScores:
    """Scores of healthy records over time, and statistics of their channels; samples are not kept.

    Attributes
    ----------
    config, feature, channels : DetectorConfig, Feature, tuple of Channel
        What is measured, and the channels that it reads.
    direction : Direction
        Direction of change of the score that means a leak.
    records : list of _Record
        In the order in which they were read.
    record : list of int, length n_score
        Index of the record of each window.
    is_apart : list of bool
        Whether a window is used to set limits: only non-overlapping windows are.
    measured : list of Measured
        What is measured of each window; of windows that set no limits, the numbers alone.
    all_scores : ndarray, shape (n_score,)
        Set by `learn`.
    complete : list of Measured
        What is measured of the windows that set limits and have all numbers.
    faults : list of Issue
        Why windows that would set limits have no score.
    groups, has_groups : list of str, length n_record, and bool
        A record without a group is its own group; whether any was stated.
    duration : float
        Duration of a window [s].
    facts : dict of Channel to list of mapping of str to ndarray, shape (n_window,)
        As from `channel_facts`.
    """

    def __init__(self, config: DetectorConfig, first: RecordBatch, drive: tuple[float, float] | None) -> None:
        self.direction, window, frequency = direction_of(config), config.window, first.sampling_frequency
        if window.by == "cycle" and (window.duration is None or window.every is not None):
            length = "give the length of each cycle, counted from its edge, as 'window' alone"
            raise ConfigError(f"by=cycle: {length}")
        self.config, self.first, self.drive, self.feature = config, first, drive, feature_of(config)
        seen = self.feature.channels | (used_channels(self.feature.indicators) & first.channels.keys())
        seen |= {window.channel} if window.by == "cycle" else set()
        seen |= {verdicts.TEMPERATURE} & first.channels.keys()
        self.channels = tuple(channel for channel in Channel if channel in seen)
        duration = first.duration if window.duration is None else window.duration
        self.n_sample = round(duration * frequency)
        self.duration = self.n_sample / frequency
        if self.n_sample < 2:
            raise ConfigError(f"window: {duration:g} s at {frequency:g} Hz are fewer than 2 samples")
        self.windower = window.windower(self.n_sample, self.channels, frequency, drive)
        self.records: list[_Record] = []
        self.record: list[int] = []
        self.is_apart: list[bool] = []
        self.measured: list[verdicts.Measured] = []
        self.all_scores: Array = np.empty(0)
        self.facts: dict[Channel, list[Mapping[str, Array]]] = {}

    def read(self, batches: Iterable[RecordBatch]) -> None:
        """Measure the windows of records."""
        waiting = list[Window]()
        for records in batches:
            if records.n_record:
                self._check(records)
            for row in range(records.n_record):
                name = " ".join(dict.fromkeys((records.sources[row], records.record_ids[row]))).strip()
                label = records.labels[row] if records.labels else ""
                self.records.append(_Record(records.duration, records.groups[row], label, name))
                end = -np.inf
                for window in windows_along(records, row, self.windower):
                    self.record.append(len(self.records) - 1)
                    self.is_apart.append(bool(window.time[0] > end))
                    end = float(window.time[-1]) if self.is_apart[-1] else end
                    waiting.append(window)
                    if len(waiting) * self.n_sample >= _MOST_SAMPLES:
                        self._measure(waiting)
                        waiting = []
        self._measure(waiting)
        pairs = zip(self.measured, self.is_apart, strict=True)
        self.complete = [each for each, is_apart in pairs if is_apart and np.isfinite(each.numbers).all()]
        self.faults = [each.fault for each in self.measured if each.fault is not None]
        self.groups = [each.group or f"record {index}" for index, each in enumerate(self.records)]
        self.has_groups = any(each.group for each in self.records)

    def _measure(self, windows: Sequence[Window]) -> None:
        """Measure all windows that wait."""
        apart, nothing = self.is_apart[len(self.measured) :], np.full(len(self.feature.numbers), np.nan)
        pairs, sound = [*zip(windows, apart, strict=True)], iter(list[verdicts.Measured]())
        if known := [pair for pair in pairs if pair[0].fault is None]:
            own, are_apart = zip(*known, strict=True)
            records = verdicts.records_of(own, self.channels, self.windower.sampling_frequency)
            for channel in self.channels if any(are_apart) else ():
                samples = records[channel][list(are_apart)]
                if channel is not verdicts.TEMPERATURE:
                    self.facts.setdefault(channel, []).append(verdicts.channel_facts(samples))
            sound = iter(verdicts.measured_windows(records, self.feature))
        for window, is_apart in pairs:
            each = verdicts.Measured(nothing, window.fault) if window.fault else next(sound)
            self.measured.append(each if is_apart else verdicts.Measured(each.numbers))

    @property
    def n_impossible(self) -> Counter[str]:
        """Output → number of windows in which it is doubtful."""
        return Counter(doubt.where for each in self.complete for doubt in each.doubts)

    @cached_property
    def refused(self) -> list[Issue]:
        """Why no actuator gives a window, of each such window."""
        return [issue for each in self.complete for issue in self._refusals(each.doubts)[:1]]

    @property
    def conditions(self) -> dict[str, tuple[float, float]]:
        """Condition → its lowest and highest value."""
        values: dict[str, list[float]] = {}
        for each in self.complete:
            doubtful = {doubt.where for doubt in each.doubts}
            for name, value in each.conditions.items():
                if name not in doubtful and np.isfinite(value):
                    values.setdefault(name, []).append(value)
        return {name: (min(own), max(own)) for name, own in sorted(values.items())}

    def _refusals(self, doubts: Sequence[Issue]) -> list[Issue]:
        """Doubts by which no actuator gives a window. A leak or a load explains one of a misfit and an
        invisible compressibility; without position, the forces that replace it explain any misfit.
        """
        spared = {*OF_LEAKS} if len({each.kind for each in doubts}.intersection(OF_LEAKS)) < 2 else set()
        if Channel.PISTON_POSITION not in self.channels:
            spared = {*OF_LEAKS, "unexplained"}
        return [each for each in doubts if each.kind not in spared]

    def _check(self, batch: RecordBatch) -> None:
        """Check that a batch matches the first one."""
        first, channels, config = self.first, self.channels, self.config
        source, other = batch.sources[0], first.sources[0]
        if batch.sampling_frequency != first.sampling_frequency:
            raise DataError(
                f"{source}: is sampled at {batch.sampling_frequency:g} Hz, but {other} at"
                f" {first.sampling_frequency:g} Hz; a detector needs a single sampling frequency"
            )
        if missing := [channel for channel in channels if channel not in batch.channels]:
            pairs = (
                pair for pair in self.feature.indicators.items() if not pair[1].channels.isdisjoint(missing)
            )
            label, needs = next(pairs, (f"the detector after {other}", self.feature.indicator))
            remedy = spool_remedy(missing, needs)
            raise DataError(f"{source}: has no {' and no '.join(missing)}, which {label} needs{remedy}")
        if obstacle := verdicts.without_scale(batch, channels):
            raise DataError(f"{source}: {obstacle}")
        for remark in chain.from_iterable(batch.remarks):
            if remark.kind in _NOT_EVEN and remark.is_unusable:
                raise DataError(f"{source}: {remark.message}")
            if not config.accept and remark.kind in _WRONG_SIZES and remark.where in channels:
                raise DataError(f"{source}: {remark.message}; --accept trains anyway")
        needs_length = config.window.by == "time" and config.window.duration is None
        if needs_length and batch.n_time != first.n_time:
            raise DataError(
                f"{source}: lasts {batch.duration:g} s, but {other} {first.duration:g} s; give the duration"
                " of a window as 'window'"
            )

    @property
    def interval(self) -> float:
        """Mean time between scores [s]."""
        if isinstance(self.windower, TimeWindower):
            return self.windower.n_every / self.windower.sampling_frequency
        return sum(each.duration for each in self.records) / len(self.record)

    @cached_property
    def is_used(self) -> NDArray[np.bool_]:
        """Whether each score is used to set limits, shape (n_score,)."""
        return np.array(self.is_apart, dtype=bool) & ~np.isnan(self.all_scores)

    @cached_property
    def scores(self) -> Array:
        """The scores that are used to set limits."""
        return self.all_scores[self.is_used]

    @property
    def hours(self) -> float:
        """Time that has scores [h]."""
        n_score = int(np.isfinite(self.all_scores).sum())
        return n_score * self.interval / 3600.0 if n_score else 0.0

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Group index of each score that is used to set limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return numbers[np.array(self.record, dtype=np.intp)[self.is_used]]

    def learn(self, faulty: RecordSource | None) -> TrainedScore | None:
        """Set the scores of the windows: the number itself, or the cross-fitted score of several numbers."""
        config, both, n_healthy = self.config, [self], len(self.measured)
        if faulty is not None:
            both.append(HealthyScores(config, self.first, self.drive))
            both[1].read(faulty.batches(labels=True))
        values = np.array([window.numbers for each in both for window in each.measured])
        if config.score is None or not n_healthy:
            self.all_scores = values.reshape(-1)
            return None
        numbers = [*self.feature.numbers]
        is_fit = np.array([is_apart for each in both for is_apart in each.is_apart])
        is_faulty = np.arange(len(values)) >= n_healthy
        score = make_score(config.score.kind, config.score.options)
        has_some = np.isfinite(values).any(axis=1)
        kept = known_numbers(values[is_fit & has_some & (score.needs_faulty | ~is_faulty)])
        if config.score.kind in OF_ONE:
            # the number itself may be missing more often
            kept = sorted({0, *kept}) if config.score.kind == "compensated" else [*range(values.shape[1])]
            if not np.isfinite(values[:n_healthy, 0]).any():
                raise self._no_score(numbers[0])
        records = enumerate(record for each in both for record in each.records)
        names = [record.group or f"record {index:09d}" for index, record in records]
        groups = [names[index] for index in self.record]
        groups += [names[len(self.records) + index] for each in both[1:] for index in each.record]
        if len(set(groups)) == 1:
            groups = [f"piece {N_PIECE * place // n_healthy}" for place in range(n_healthy)]
        used = np.ascontiguousarray(values[:, kept])
        self.all_scores = cross_fitted_scores(score, used, is_faulty, groups, is_fit=is_fit)[:n_healthy]
        taught = is_fit & np.isfinite(used).all(axis=1)
        return TrainedScore(
            numbers=tuple(numbers[place] for place in kept),
            rule=plain_data(score.fit(used[is_fit], is_faulty[is_fit])),
            n_healthy=np.sum(taught & ~is_faulty),
            n_faulty=np.sum(taught & is_faulty & score.needs_faulty),
        )

    def _no_score(self, label: str) -> NotStatedError:
        longest = time_text(max(record.duration for record in self.records))
        absent = f"no window ends within its records, of which the longest lasts {longest}"
        reasons = Counter(fault.message for fault in self.faults)
        reason = next((text for text, _ in reasons.most_common(1)), absent)
        return NotStatedError(f"no healthy record has {label}: {reason}")

    def require_scores(self, name: str) -> None:
        """Check that there are scores, and that estimates are possible in at least half of the windows."""
        if not self.scores.size:
            raise self._no_score(self.feature.label)
        if 2 * len(self.refused) > self.scores.size and not self.config.accept:
            outputs = " and ".join(sorted({each.where for each in self.refused}))
            likely = f"{self._likely}; ".removeprefix("; ")
            raise DataError(
                f"{name}: {outputs}: beyond what the described actuator allows in {len(self.refused):,} of"
                f" {self.scores.size:,} healthy windows: {CAUSES} {likely}--accept trains anyway"
            )

    @cached_property
    def _likely(self) -> str:
        """The constants of the data sheet that are likeliest wrong, if it does not fit most windows."""
        of_balance = (each.options for each in self.feature.indicators.values())
        options = next((each for each in of_balance if isinstance(each, WindowOptions)), None)
        unfit = [self.n_impossible[name] for name, each in self.feature.outputs.items() if each.is_fit]
        if options is None or Channel.PISTON_POSITION not in self.channels:
            return ""
        if 2 * max(len(self.refused), *unfit) <= self.scores.size:
            return ""
        return sentence(options, likeliest_wrong(options, self.first))

    def config_in_full(self, chart: TimedChart | None) -> DetectorConfig:
        """The configuration with all that it left out."""
        config, window, feature = self.config, self.config.window, self.feature
        every = window.every or (self.duration if window.by == "time" else None)
        in_full: dict[str, Any] = {
            "direction": self.direction,
            "chart": chart,
            "window": window.model_copy(update={"duration": self.duration, "every": every}),
        }
        if config.score is None:
            in_full["options"] = feature.indicator.options.model_dump(mode="json")
            in_full["output"] = feature.label.removeprefix(f"{config.indicator}.")
        else:
            in_full["indicators"] = stated_indicators(feature.indicators, in_full=True)
        return config.model_copy(update=in_full)

    def positive(self, used: Feature) -> tuple[str, ...]:
        """Outputs that can only be positive, and are so in all windows."""
        doubts = {(doubt.where, doubt.kind) for each in self.complete for doubt in each.doubts}
        names = (name for name, each in used.outputs.items() if each.is_positive)
        return tuple(name for name in names if (name, "not_positive") not in doubts)

    def fits(self, used: Feature) -> dict[str, float]:
        """Output that states how well the model explains a window → largest value without a doubt."""
        usual = {name: each.possible[1] or 0.0 for name, each in used.outputs.items() if each.is_fit}
        return {
            name: max(value, *(each.fits[name] for each in self.complete)) for name, value in usual.items()
        }

    def scale(self) -> Scale:
        """Median, spread and range of the scores that set limits."""
        (centre, spread), own = healthy_scale(self.scores), self.scores
        return Scale(centre=centre, spread=spread, range=(float(own.min()), float(own.max())))

    def basis(self, sources: Sequence[str], healthy: Scale) -> Basis:
        """The data behind a detector."""
        spreads = verdicts.standardised(self.scores, healthy, self.direction)
        spreads = np.abs(spreads) if self.direction is Direction.BOTH else spreads
        used = np.array(self.record, dtype=np.intp)[self.is_used].tolist()
        populations = Counter(self.records[index].label for index in used)
        del populations[""]
        windows, far = Counter(used), Counter(compress(used, spreads > _OUTLYING))
        return Basis(
            sources=tuple(sources),
            n_record=len(self.records),
            n_window=self.scores.size,
            n_group=len(set(self.groups)) if self.has_groups else 0,
            populations=dict(sorted(populations.items())),
            not_judged=dict(sorted(Counter(fault.kind for fault in self.faults).items())),
            impossible=dict(sorted(self.n_impossible.items())),
            likely=self._likely,
            outlying={self.records[index].name: n for index, n in far.items() if 2 * n > windows[index]},
            drive_period=found_period(self.first),
        )


def windows_along(records: RecordBatch, row: int, windower: Windower) -> Iterator[Window]:
    """Windows of a record, a few at a time, as from a stream."""
    channels, time = tuple(windower.needs), records.time
    stream = EvenStream(records.sampling_frequency, channels)
    state, held = stream.start(), windower.start()
    for first in range(0, records.n_time, _CHUNK):
        part = slice(first, first + _CHUNK)
        chunk = Chunk(time[part], {channel: records[channel][row, part] for channel in channels})
        state, pieces, _ = stream.step(state, chunk)
        for piece in pieces:
            held, windows = windower.step(held, piece)
            yield from windows


def healthy_scores(healthy: RecordSource, config: DetectorConfig) -> HealthyScores:
    """What is measured of healthy records."""
    drive = _drive(healthy, config.window.channel) if config.window.by == "cycle" else None
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    if (first := next(batches, None)) is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    scored = HealthyScores(_with_score(config, first), first, drive)
    scored.read(chain([first], batches))
    return scored


def _with_score(config: DetectorConfig, first: RecordBatch) -> DetectorConfig:
    """The same with a second alarm, unless an output is stated: on the flow through all clearances; and with
    the effect of the oil temperature taken out, if that is measured.
    """
    feature = feature_of(config)
    if config.score is not None or not feature.described.is_score:
        return config
    of, indicators, oil = [feature.label], stated_indicators(feature.indicators), verdicts.TEMPERATURE
    if not config.output and config.direction in (None, Direction.RISING):
        of += [feature.through_all] if feature.through_all in feature.outputs else []
    by = (
        [f"{verdicts.TEMPERATURE}.mean"]
        if config.compensate and verdicts.TEMPERATURE in first.channels
        else []
    )
    if len(of) + len(by) == 1:
        return config
    if by:
        indicators |= {oil: {"kind": "pressure_statistics", "channel": oil}}
    score = ScoreConfig(kind="either", of=[*of, *by], options={"proxies": len(by)})
    own = {"indicator": "", "options": {}, "output": "", "indicators": indicators, "score": score}
    return config.model_copy(update=own)


def _drive(healthy: RecordSource, channel: Channel) -> tuple[float, float]:
    """Lowest and highest value of the channel whose edges start cycles, over all healthy records."""
    low, high = np.inf, -np.inf
    for batch in healthy.batches(labels=True):
        if batch.n_record and channel in batch.channels:
            low = min(low, float(np.nanmin(batch[channel])))
            high = max(high, float(np.nanmax(batch[channel])))
    if not low < high:
        fault = "is missing in" if high == -np.inf else "never changes in"
        raise NotStatedError(
            f"by=cycle: {channel} {fault} all healthy records, but cycles start at its edges;"
            " choose another channel under 'window:', or use windows by time"
        )
    return low, high
