"""Records of a study: population, severity of the fault, and scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.scores.configuration import ScoreConfig
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True)
class Scored:
    """Values of a score for every record.

    Attributes
    ----------
    name : str
        Name, such as ``ring_down.damping_ratio`` or ``dwt.detail_rms[2]``.
    values : ndarray, shape (n_record,)
        NaN if a record cannot be measured.
    channels : tuple of str
        Channels that it needs, in the order of `hydrofdi.records.Channel`.
    unit, long_name : str
    direction : Direction or None
        Direction of change that means a fault; None if it must be learned from fit records.
    cost : float or None
        CPU time per record [s]; None if it was not measured.
    note : str
        Issue on the score, such as how it was trained.
    made_by : ScoreConfig or None
        How it combines numbers; None if it is one.
    indicator : str
        Name of the indicator that measures it; empty if it combines several or is not measured here.
    """

    name: str
    values: Array
    channels: tuple[str, ...] = ()
    unit: str = "1"
    long_name: str = ""
    direction: Direction | None = None
    cost: float | None = None
    note: str = ""
    indicator: str = ""
    made_by: ScoreConfig | None = None


@dataclass(frozen=True, eq=False)
class StudyRecords:
    """Records of one design of a study, simulated or measured.

    Attributes
    ----------
    populations : tuple of Population
    of_record : ndarray of int, shape (n_record,)
        Index of the population of each record.
    severity : ndarray, shape (n_record,)
        True severity of the fault, such as the mean leakage flow of the record [unit of the severity]; 0
        without a fault, NaN if unknown.
    severity_unit : str
        SI.
    groups : tuple of str or None
        Group of each record; records of a group (a unit, a day) may be dependent. None if all are
        independent.
    design : mapping of str to object
        Settings common to all records, such as ``record.duration``: dotted parameter → value in SI.
    per_mean_flow : float
        Flow of the same leaks at `REFERENCE_DROP`, per mean leakage flow of the record: the median over the
        faulty records [-]; NaN if unknown.
    remarks : tuple of str
        Remarks on all rates of these records, such as that the draws are dependent.
    """

    populations: tuple[Population, ...]
    of_record: NDArray[np.intp]
    severity: Array
    severity_unit: str = "m^3/s"
    groups: Sequence[str] | None = None
    design: Mapping[str, object] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    per_mean_flow: float = float("nan")

    def rows(self, population: Population) -> NDArray[np.intp]:
        """Rows of the records of a population."""
        return np.flatnonzero(self.of_record == self.populations.index(population))

    def chosen(self, kind: Kind, *, is_fit: bool) -> tuple[Population, ...]:
        """Populations of a kind, ascending in severity."""
        own = (each for each in self.populations if each.kind is kind and each.is_fit is is_fit)
        return tuple(sorted(own, key=lambda each: each.severity))
