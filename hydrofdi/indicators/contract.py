"""Interface of an indicator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, TypeVar

from hydrofdi.evaluation.scores import Direction
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import Section

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
