"""What is measured of windows, or along a stream, computed identically for training, judging and streams."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.scores.configuration import OF_ONE
from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators import Output, measure
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.indicators.recursive import RecursiveIndicator, instants
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk, State, Window
from hydrofdi.settings.readable import number_text
from hydrofdi.units import convert

TEMPERATURE = Channel.OIL_TEMPERATURE

_ESTIMATES = ("bulk_modulus", "supply_pressure")

_INDICATOR = "indicator."

_LOST, _LOST_AT_FIRST = 10, 600.0
"""Patience before a restart: number of consecutive estimates without a score, after the transient, if the
indicator had a score before; else time since its start [s], because its first window may be long."""

_LEAST_CHECKED_TIME = 1.0
"""Minimum time before an estimate whose samples are checked [s]."""


class Leak(NamedTuple):
    """Mean flow across piston and closed valve of any law, and its standard deviation [m³/s]."""

    flow: float
    deviation: float

    @property
    def interval(self) -> tuple[float, float]:
        """Two deviations around the flow, not below zero [m³/s]."""
        return max(0.0, self.flow - 2.0 * self.deviation), max(0.0, self.flow + 2.0 * self.deviation)

    def to_dict(self) -> dict[str, float]:
        """The flow, and the ends of its interval."""
        low, high = self.interval
        return {"flow": self.flow, "low": low, "high": high}

    @property
    def size(self) -> str:
        """The flow and its interval as text."""
        ends = (max(0.0, self.flow), *self.interval)
        flow, low, high = (number_text(convert(each, "L/min"), 2) for each in ends)
        return f"{flow} L/min ({low} to {high})"

    def __str__(self) -> str:
        return f"a mean leak of {self.size}"


@dataclass(frozen=True, slots=True)
class Measured:
    """What is measured of a window, or by a recursive indicator at an instant.

    Attributes
    ----------
    numbers : ndarray, shape (n_number,)
        NaN where there is none.
    fault : Issue or None
        Why numbers are missing.
    fits, conditions : mapping of str to float
        Outputs that state how well the model explains the samples; conditions of the machine, in SI, NaN if
        there are none.
    clearance : float
        Flow through all clearances, of which numbers take up shares.
    leak : Leak or None
        None if the indicator does not state it.
    """

    numbers: Array
    fault: Issue | None = None
    doubts: tuple[Issue, ...] = ()
    fits: Mapping[str, float] = field(default_factory=dict)
    conditions: Mapping[str, float] = field(default_factory=dict)
    clearance: float = math.nan
    leak: Leak | None = None


def records_of(
    windows: Sequence[Window], channels: Collection[Channel], sampling_frequency: float
) -> RecordBatch:
    """Windows as a batch of records that start at time 0, without a drive period.

    Parameters
    ----------
    windows : sequence of Window
        At least one; all of equal length, with all channels.
    sampling_frequency : float
        Sampling frequency of the detector, not of each window [Hz], so that scores have the same meaning.
    """
    samples = {channel: np.stack([window.channels[channel] for window in windows]) for channel in channels}
    return RecordBatch(samples, sampling_frequency, tuple(str(window.number) for window in windows))


def measured_windows(
    records: RecordBatch, feature: Feature, fits: Mapping[str, float] | None = None
) -> list[Measured]:
    """What is measured of valid windows, bit-identical whatever the others are; `fits` as of `doubts_of`."""
    measures, indicators = measure(records, feature.indicators), feature.indicators
    values, numbers = measures.values, feature.values(measures.values)
    doubts = [doubts_of(each, values, f"{label}.", fits) for label, each in indicators.items()]
    clearances = values.get(feature.through_all, numbers[:, 0])
    stated = {name: values[name] for name, output in feature.outputs.items() if output.is_fit}
    conditions = temperatures(records) | {name: values[name] for name in estimated_conditions(feature)}
    found = []
    for row in range(records.n_record):
        obstacle = next(filter(None, (measures.obstacles[label][row] for label in indicators)), None)
        found.append(
            Measured(
                numbers[row],
                Issue(obstacle, kind="no_number") if obstacle else None,
                tuple(chain.from_iterable(each[row] for each in doubts)),
                of_row(stated, row),
                of_row(conditions, row) | _invisible(chain.from_iterable(each[row] for each in doubts)),
                float(clearances[row]),
                _leak(feature, values, row),
            )
        )
    return found


def _leak(feature: Feature, values: Mapping[str, Array], row: int) -> Leak | None:
    found = Leak(*(float(values[name][row]) for name in feature.leak)) if feature.leak else None
    return found if found and math.isfinite(sum(found)) else None


def _invisible(doubts: Iterable[Issue]) -> dict[str, float]:
    """A bulk modulus is unknown, not another one, where no compressibility is visible."""
    return {each.where: math.nan for each in doubts if each.kind == "incompressible"}


def of_row(columns: Mapping[str, Array], row: int) -> dict[str, float]:
    """One value of each column."""
    return {name: float(values[row]) for name, values in columns.items()}


def estimated_conditions(feature: Feature) -> dict[str, Output]:
    """Outputs that describe the condition of the machine and are not judged themselves."""
    numbers = [*feature.numbers]
    is_single = feature.score is None or feature.score.kind in OF_ONE
    judged = numbers[:1] if is_single else numbers
    return {
        name: each
        for name, each in feature.outputs.items()
        if each.name in _ESTIMATES and not each.dims and name not in judged
    }


def temperatures(records: RecordBatch) -> dict[str, Array]:
    """Mean oil temperature of each window [K]; nothing if it is not measured."""
    return {TEMPERATURE: records[TEMPERATURE].mean(axis=1)} if TEMPERATURE in records.channels else {}


class Estimator:
    """Computes estimates along a stream; they are bit-identical however the stream is split into pieces.

    The indicator restarts after a gap, after missing samples, and after its score has been missing for long.
    It gives no score during the transient that follows.
    """

    def __init__(
        self,
        feature: Feature,
        channels: Collection[Channel],
        sampling_frequency: float,
        fits: Mapping[str, float] | None = None,
    ) -> None:
        indicator = feature.indicator
        if not isinstance(indicator, RecursiveIndicator):
            raise ConfigError(f"{indicator.name} is not recursive; judge it by windows")
        followed = f"{next(iter(feature.indicators))}.{indicator.estimates[0].name}"
        if feature.label != followed:
            raise ConfigError(f"only {followed} can be judged by estimate, not {feature.label}")
        self.indicator: RecursiveIndicator[Any] = indicator
        self._score, self._channels, self.sampling_frequency = followed, tuple(channels), sampling_frequency
        self._feature, self._prefix, self._fits = feature, followed.partition(".")[0] + ".", fits
        self._conditions = [*estimated_conditions(feature)]
        self.n_every = indicator.samples_per_estimate(sampling_frequency)
        self.interval = self.n_every / sampling_frequency
        look = max(indicator.options.transient, _LEAST_CHECKED_TIME)
        self.n_look = max(2, round(look * sampling_frequency))

    def start(self) -> State:
        """State before the first sample: only arrays."""
        none = np.empty((1, 0))
        begun = self.indicator.start(self._records(0, dict.fromkeys(self._channels, none)))
        return {
            "n_seen": np.array([0]),
            "n_lost": np.array([0]),
            "had_score": np.array([False]),
            "is_missing": np.array([False]),
            **{_INDICATOR + name: array for name, array in begun.items()},
        }

    def step(self, state: State, piece: Chunk) -> tuple[State, list[tuple[int, Measured]]]:
        """State after a piece, and the estimates in it, each with the place of its last sample."""
        state = self.start() if piece.begins_anew else state
        missing = np.vstack([~np.isfinite(piece.channels[channel]) for channel in self._channels])
        found: list[tuple[int, Measured]] = []
        for first, stop, is_missing in _runs(np.any(missing, axis=0)):
            if is_missing:
                if not state["is_missing"][0]:
                    rows = zip(self._channels, missing, strict=True)
                    lost = " and ".join(channel for channel, row in rows if row[first])
                    fault = Issue(f"no sample of {lost}; {self._anew}", kind="missing")
                    found.append((first, Measured(np.array([np.nan]), fault)))
                state = {**self.start(), "is_missing": np.array([True])}
                continue
            while first < stop:
                state, first, estimates = self._advance(state, piece, first, stop)
                found += estimates
        return state, found

    def _advance(
        self, state: State, piece: Chunk, first: int, stop: int
    ) -> tuple[State, int, list[tuple[int, Measured]]]:
        """Advance to `stop`, or to the sample at which the indicator restarts."""
        n_before, indicator = int(state["n_seen"][0]), self.indicator
        n_lost, had_score = int(state["n_lost"][0]), bool(state["had_score"][0])
        samples = {
            channel: np.ascontiguousarray(piece.channels[channel][None, first:stop], dtype=float)
            for channel in self._channels
        }
        own = {
            key.removeprefix(_INDICATOR): part for key, part in state.items() if key.startswith(_INDICATOR)
        }
        followed, trace = indicator.step(own, self._records(n_before, samples))
        due = instants(n_before, stop - first, self.n_every)
        is_settled = (n_before + due) / self.sampling_frequency >= indicator.options.transient - 1e-9
        found: list[tuple[int, Measured]] = []
        after: dict[str, NDArray[Any]] = {
            "n_seen": np.array([n_before + stop - first]),
            "n_lost": state["n_lost"],
            "had_score": state["had_score"],
            "is_missing": np.array([False]),
            **{_INDICATOR + name: np.asarray(array) for name, array in followed.items()},
        }
        if not is_settled.any():
            return after, stop, found
        values = {self._prefix + name: rows[0, is_settled] for name, rows in trace.values.items()}
        doubts = doubts_of(indicator, values, self._prefix, self._fits)
        names = [self._prefix + each.name for each in indicator.outputs if each.is_fit]
        fits = {name: values[name] for name in names}
        known = {name: values[name] for name in self._conditions if name in values}
        for row, place in enumerate(first + due[is_settled]):
            numbers, fault = values[self._score][row : row + 1], None
            has_score = bool(np.isfinite(numbers[0]))
            n_lost, had_score = 0 if has_score else n_lost + 1, had_score or has_score
            patience = indicator.options.transient if had_score else _LOST_AT_FIRST
            is_given_up = n_lost == max(_LOST, math.ceil(patience / self.interval - 1e-9))
            if not has_score:
                lost = f"{self._score} has had no value for {n_lost * self.interval:.4g} s"
                fault = Issue(f"{lost}; {self._anew}" if is_given_up else lost, kind="no_number")
            explained, conditions = of_row(fits, row), of_row(known, row) | _invisible(doubts[row])
            leak = _leak(self._feature, values, row)
            clearance = float(values.get(self._feature.through_all, values[self._score])[row])
            each = Measured(numbers, fault, doubts[row], explained, conditions, clearance, leak)
            found.append((int(place), each))
            if is_given_up:
                return self.start(), int(place) + 1, found
        after |= {"n_lost": np.array([n_lost]), "had_score": np.array([had_score])}
        return after, stop, found

    @property
    def _anew(self) -> str:
        return f"it restarts and gives no score for {self.indicator.options.transient:g} s"

    def _records(self, n_before: int, samples: Mapping[Channel, Array]) -> RecordBatch:
        return RecordBatch(
            samples, self.sampling_frequency, ("stream",), start_time=n_before / self.sampling_frequency
        )


def _runs(is_missing: NDArray[np.bool_]) -> Iterator[tuple[int, int, bool]]:
    """First, stop and kind of each run of equal flags."""
    bounds = [0, *(np.flatnonzero(np.diff(is_missing)) + 1).tolist(), is_missing.size]
    for first, stop in pairwise(bounds):
        if stop > first:
            yield first, stop, bool(is_missing[first])


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            found = "is normalised" if channel in records.normalized else "is in counts"
            return f"{channel} {found}, but a detector needs it in {channel.unit}"
    return None
