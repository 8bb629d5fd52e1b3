"""Interface of an indicator, and bases of those of one channel and of those that follow samples."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.evaluation.scores import Direction
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section

Chosen = TypeVar("Chosen", bound=Section)


@dataclass(frozen=True)
class Output:
    """A number or array that an indicator computes for each record.

    Attributes
    ----------
    name : str
        Letters, digits and ``_``.
    unit : str
        SI; ``"1"`` for dimensionless numbers. If the channel is in counts, so is the output.
    long_name : str
        Short description.
    dims : dict of str to int
        Dimensions in addition to the record, and their lengths.
    direction : Direction, optional
        Direction of change caused by internal leakage, by definition or theory rather than from data; None if
        it depends on the actuator, the drive or the band.
    is_score : bool
        Whether the output is evaluated as a detector score; False for quality measures of other outputs
        (standard errors, condition numbers, counts), auxiliary estimates, and repetitions in another unit.
    possible : tuple of (float or None)
        Lowest and highest value that a machine can have, such as those of a bulk modulus; others show that
        the model of the indicator does not describe the record.
    error : str
        Output with the standard deviation; then a value is impossible only if it is more than four of them
        below the lowest.
    is_fit : bool
        Whether the output states how well the model explains the record; then values outside of `possible`
        are possible, but the other outputs are doubtful.
    clearances : tuple of (str, float)
        Output with the flow through all clearances, and the share of its growth in warmer oil that this one
        takes up; by default all of its own.
    """

    name: str
    unit: str
    long_name: str
    dims: Mapping[str, int] = field(default_factory=dict)
    direction: Direction | None = None
    is_score: bool = True
    possible: tuple[float | None, float | None] = (None, None)
    error: str = ""
    is_fit: bool = False
    clearances: tuple[str, float] = ("", 1.0)

    @classmethod
    def quality(cls, name: str, unit: str, long_name: str) -> Output:
        """An output that measures the quality of other outputs; not a score."""
        return cls(name, unit, long_name, is_score=False)

    @property
    def is_positive(self) -> bool:
        """Whether the quantity can only be positive."""
        return self.possible[0] is not None and not self.error and not self.is_fit

    @property
    def departure(self) -> str:
        """Effect of leakage on the output, as one word for tables."""
        return {"rising": "rises", "falling": "falls", "both": "departs"}.get(self.direction or "", "–")


class Indicator(Protocol[Chosen]):
    """Interface of an indicator: quantities measured from records.

    To add one, subclass it and define ``Options``, the channels and the outputs.

    Attributes
    ----------
    name : str
        Name in files and on the command line.
    version : int
        Increased whenever results change for the same record and options.
    summary : str
        What it measures, in one sentence; by default the class's docstring.
    source : str
        Publication.
    equation : str
        Its definition, in one line.
    caution : str
        Limitations that users must know; empty if there are none.
    absence : str
        Short reason why a record may have no outputs.
    is_cheap : bool
        Whether it takes less time than the simulation of the record.
    needs_scale : bool
        Whether it requires channels in SI, not in counts.
    Options : type of Section
        Model of its options; all of them have defaults.
    options : Section
        Options of this instance.
    """

    name: ClassVar[str]
    version: ClassVar[int]
    summary: ClassVar[str]
    source: ClassVar[str]
    equation: ClassVar[str] = ""
    caution: ClassVar[str] = ""
    absence: ClassVar[str] = "has no finite number"
    is_cheap: ClassVar[bool] = True
    needs_scale: ClassVar[bool] = False
    Options: ClassVar[type[Section]] = Section
    options: Chosen

    def __init_subclass__(cls, **more: Any) -> None:
        """Take the summary from the docstring."""
        super().__init_subclass__(**more)
        if cls.__doc__ and "summary" not in vars(cls):
            cls.summary = " ".join(cls.__doc__.partition("\n\n")[0].split())

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen

    @property
    def channels(self) -> frozenset[Channel]:
        """Channels that it needs; by default those that its options name."""
        named: frozenset[Channel] = getattr(self.options, "channels", frozenset())
        return named

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """Channels that are used if available: those that the options name.

        An indicator sees only these and the required channels.
        """
        named: frozenset[Channel] = getattr(self.options, "optional_channels", frozenset())
        return named

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Outputs of the indicator."""
        ...

    def obstacle(self, records: RecordBatch) -> str | None:
        """Why records with the required channels cannot be measured, as a sentence; None if they can.

        It concerns the properties that a batch shares: length, sampling, drive.
        """
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Measure a batch: each output has shape (n_record, *dims), NaN if a record has no value.

        The values of a record are bit-identical whatever other records are in its batch.
        """
        ...


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


Following = TypeVar("Following", bound=RecursiveOptions)


class RecursiveIndicator(Indicator[Following]):
    """Base of recursive indicators: subclasses define `follow` and `of_record`."""

    needs_scale = True

    @property
    @abstractmethod
    def estimates(self) -> tuple[Output, ...]:
        """Outputs of a whole record; the first one is the score whose trace can be stored."""

    @abstractmethod
    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Values of the trace of whole records after the samples with the indices `due` (n_instant,)."""

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """`estimates` of whole records, each (n_record,), from the trace after the transient."""
        raise NotImplementedError

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

    def watched_instants(self, sampling_frequency: float, n_discarded: int) -> Array:
        """Instants of the stored trace after its transient [s], on the clock of the whole record."""
        instants = self.trace_instants(sampling_frequency)
        # An instant at the end of the transient counts, whatever its last bit.
        settled = instants[instants >= self.options.transient - 1e-9]
        return np.asarray(settled + n_discarded / sampling_frequency)

    def trace(self, records: RecordBatch) -> Trace:
        """Estimates over time of whole records, one every ``interval``."""
        frequency = records.sampling_frequency
        every = self.samples_per_estimate(frequency)
        due = np.arange(every - 1, records.n_time, every)
        return Trace(records.start_time + due / frequency, self.follow(records, due))

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Values in SI."""
        trace = self.trace(replace(records, start_time=0.0))
        return {**self.of_record(trace.since(self.options.transient)), **self.stored_trace(records, trace)}

    def stored_trace(self, records: RecordBatch, trace: Trace | None = None) -> dict[str, Array]:
        """The output with the trace of the score, if it is stored."""
        if not self.n_instant:
            return {}
        name = self.estimates[0].name
        return {f"{name}_trace": (trace or self.trace(records)).values[name][:, : self.n_instant]}


class ChannelOptions(Section):
    """Options of an indicator of one channel."""

    channel: Channel = Channel.CHAMBER_1_PRESSURE
    """Channel to measure."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The measured channel."""
        return frozenset({self.channel})


ChosenChannel = TypeVar("ChosenChannel", bound=ChannelOptions)


class SingleChannelIndicator(Indicator[ChosenChannel]):
    """An indicator that needs one channel, which its options name."""

    @property
    def unit(self) -> str:
        """Unit of the channel."""
        return self.options.channel.unit

    def signal(self, records: RecordBatch) -> Array:
        """Samples of the channel, shape (n_record, n_time)."""
        return records[self.options.channel]
