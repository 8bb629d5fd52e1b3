"""Indicators that follow the samples of a record without keeping earlier ones."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI, Section


@dataclass(frozen=True)
class Trace:
    """Estimates over time.

    Attributes
    ----------
    time : ndarray, shape (n_instant,)
        Instants of the estimates, on the clock of the records [s].
    values : mapping of str to ndarray, shape (n_record, n_instant)
        In SI; NaN after an estimator diverged.
    """

    time: Array
    values: Mapping[str, Array]

    def since(self, instant: float) -> Trace:
        """Estimates at an instant [s] or later.

        Rows are contiguous, so that rounding of sums is reproducible.
        """
        later = self.time >= instant - 1e-9
        values = {name: np.ascontiguousarray(values[:, later]) for name, values in self.values.items()}
        return Trace(self.time[later], values)


class RecursiveOptions(Section):
    """Options of every recursive indicator."""

    interval: Annotated[float, SI("s", above=0)] = 0.1
    """Interval between estimates of a trace [s], rounded to whole samples."""

    transient: Annotated[float, SI("s", least=0)] = 2.0
    """Time excluded at the start of a record [s], while estimates are still close to the data sheet."""

    trace_duration: Annotated[float, SI("s", least=0)] = 0.0
    """Length of the records for which the time trace of the score is also stored [s], for charts; 0 stores
    none."""


Chosen = TypeVar("Chosen", bound=RecursiveOptions)

_OF_PRIOR = 0.9
"""Share of its prior standard deviation above which an estimate says nothing of a record."""


class RecursiveIndicator(Indicator[Chosen]):
    """Base of recursive indicators: subclasses define `follow` and `of_record`."""

    needs_scale = True

    @property
    @abstractmethod
    def estimates(self) -> tuple[Output, ...]:
        """Outputs of a whole record; the first one is the score whose trace can be stored."""

    @abstractmethod
    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Values of the trace of whole records after the samples with the indices `due` (n_instant,)."""

    @abstractmethod
    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """`estimates` of whole records, each (n_record,), from the trace after the transient."""

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Estimates, and the trace of the score if it is stored."""
        score = self.estimates[0]
        kept = Output(
            f"{score.name}_trace", score.unit, f"{score.long_name}, over time",
            dims={"instant": self.n_instant}, is_score=False,
        )  # fmt: skip
        return (*self.estimates, kept) if self.n_instant else self.estimates

    @property
    def prior_deviation(self) -> float:
        """Prior standard deviation of the leakage [m³/s]; a record that hardly reduces it has no values."""
        return 0.0

    @property
    def n_instant(self) -> int:
        """Number of estimates in the stored trace."""
        return int(self.options.trace_duration / self.options.interval + 1e-9)

    def samples_per_estimate(self, sampling_frequency: float) -> int:
        """Samples between estimates, at least one."""
        return max(1, round(self.options.interval * sampling_frequency))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if a record has no estimate after the transient, or is shorter than its trace."""
        options = self.options
        if records.duration < options.transient + options.interval - 1e-9:
            needed = f"a transient of {options.transient:g} s and an interval of {options.interval:g} s"
            return f"{records.duration:g} s are too few for {needed}"
        traced = self.trace_instants(records.sampling_frequency)[-1:]
        if traced.size and records.duration <= traced[0]:
            return f"{records.duration:g} s are shorter than the trace of {options.trace_duration:g} s"
        return None

    def trace_instants(self, sampling_frequency: float) -> Array:
        """Instants of the stored trace [s], for records that start at 0."""
        samples = self.samples_per_estimate(sampling_frequency) * np.arange(1, self.n_instant + 1) - 1
        return samples / sampling_frequency

    def trace(self, records: RecordBatch) -> Trace:
        """Estimates over time of whole records, one every ``interval``."""
        frequency = records.sampling_frequency
        every = self.samples_per_estimate(frequency)
        due = np.arange(every - 1, records.n_time, every)
        return Trace(records.start_time + due / frequency, self.follow(records, due))

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Values in SI."""
        trace = self.trace(replace(records, start_time=0.0))
        values = dict(self.of_record(trace.since(self.options.transient)))
        if self.prior_deviation:
            is_prior = values["leakage_error"] > _OF_PRIOR * self.prior_deviation
            values = {name: np.where(is_prior, np.nan, array) for name, array in values.items()}
        if self.n_instant:
            name = self.estimates[0].name
            values[f"{name}_trace"] = trace.values[name][:, : self.n_instant]
        return values
