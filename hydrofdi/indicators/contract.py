"""What an indicator is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, TypeVar

from hydrofdi.evaluation.direction import Direction
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import Section

Chosen = TypeVar("Chosen", bound=Section)


@dataclass(frozen=True)
class Output:
    """A number that an indicator gives for each record, or an array of them.

    Attributes
    ----------
    name : str
        Letters, digits and ``_``.
    unit : str
        SI; ``"1"`` for numbers without a unit. Where the unit is that of a channel in counts, the number is
        in counts.
    long_name : str
        Short description for a person.
    dims : dict of str to int
        Dimensions in addition to the record, and their lengths.
    direction : Direction, optional
        Which departure from health means internal leakage, by definition or theory and not by what records
        show; None if it depends on the actuator, the drive or the band.
    is_score : bool
        Whether it is judged as a detector; False if it says how good the other outputs are (standard
        errors, condition numbers, counts), what is estimated beside them, or one of them in another unit.
    """

    name: str
    unit: str
    long_name: str
    dims: Mapping[str, int] = field(default_factory=dict)
    direction: Direction | None = None
    is_score: bool = True

    @classmethod
    def quality(cls, name: str, unit: str, long_name: str) -> Output:
        """An output that says how good the others are."""
        return cls(name, unit, long_name, is_score=False)

    @property
    def departure(self) -> str:
        """What leakage does to it, in a word for a table."""
        return {"rising": "rises", "falling": "falls", "both": "departs"}.get(self.direction or "", "–")


class Indicator(Protocol[Chosen]):
    """Numbers measured from records. Subclass it, give it a model of ``Options`` and say what it needs.

    Attributes
    ----------
    name : str
        Name in files and on the command line; that of its module.
    version : int
        Raised whenever the same record and options give other numbers.
    summary : str
        What it tells, in one sentence.
    source : str
        Where it was published.
    equation : str
        Its definition, in one line.
    caution : str
        What has to be known before its numbers are believed; empty if nothing has.
    absence : str
        Why a record may have none of its outputs, in a few words.
    is_cheap : bool
        Whether it costs less than the simulation of the record.
    needs_scale : bool
        Whether channels in counts are of no use to it.
    Options : type of Section
        Model of its options; it is valid without any.
    options : Section
        Its options.
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

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen

    @property
    def channels(self) -> frozenset[Channel]:
        """The channels that it needs."""
        ...

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """Channels that it uses if records have them. It sees only these and the channels that it needs."""
        return frozenset()

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it gives."""
        ...

    def obstacle(self, records: RecordBatch) -> str | None:
        """Why records that have its channels cannot be measured, as a sentence; None if they can.

        This concerns what a batch has in common: its length, its sampling, its drive.
        """
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Its outputs, each of shape (n_record, *dims); NaN if a record does not have them.

        The numbers of a record do not depend, to the bit, on the others in its batch.
        """
        ...
