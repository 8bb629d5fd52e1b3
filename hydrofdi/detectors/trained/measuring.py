"""What is measured of windows, computed identically for training, judging and streams."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

import numpy as np

from hydrofdi.detectors.scores.configuration import OF_ONE
from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.errors import Issue
from hydrofdi.indicators import Output, measure
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window
from hydrofdi.settings.messages import number_text
from hydrofdi.units import convert

TEMPERATURE = Channel.OIL_TEMPERATURE

_ESTIMATES = ("bulk_modulus", "supply_pressure")


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
    """What is measured of a window.

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


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            return f"{channel} is in counts, but a detector needs it in {channel.unit}"
    return None
