"""Median and range of each feature over the values of each parameter that varies."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.responses.features import Feature, detail_changes, detail_sizes, indicator_features
from hydrofdi.report.responses.rank import RankCorrelation, rank_correlation
from hydrofdi.report.runs.axes import Axis, swept_runs, varied_axes
from hydrofdi.store import ExperimentData

Array = NDArray[np.float64]

MANY_RUNS = 40
"""Groups of at least this many runs show the range from 5 to 95 %, others the smallest and the largest."""

FIXED = "the fixed baseline"
MATCHED = "the sealed actuator under the same conditions"
NOTHING = ""


@dataclass(frozen=True)
class Spread:
    """A feature over the runs of a group, in its unit; NaN if no run has a number.

    Attributes
    ----------
    median, low, high : float
        Low and high: 5 and 95 % in groups of `MANY_RUNS` or more, else the smallest and the largest.
    n_run : int
        Runs that have a number.
    """

    median: float
    low: float
    high: float
    n_run: int


@dataclass(frozen=True)
class Response:
    """A feature over an axis.

    Attributes
    ----------
    feature : Feature
        Its name, unit and values of all runs.
    over : tuple of Spread
        One for each group of the axis.
    rank : RankCorrelation or None
        With the parameter, if it has many values.
    """

    feature: Feature
    over: tuple[Spread, ...]
    rank: RankCorrelation | None


@dataclass(frozen=True)
class AxisResponses:
    """All features over one axis.

    Attributes
    ----------
    axis : Axis
        Parameter, header with unit, and groups of runs with their texts.
    against : str
        Baseline of δ in words; empty if the features are not changes.
    responses : tuple of Response
    """

    axis: Axis
    against: str
    responses: tuple[Response, ...]

    @property
    def has_quantiles(self) -> bool:
        """Whether all ranges are those from 5 to 95 %."""
        return all(int(group.rows.sum()) >= MANY_RUNS for group in self.axis.groups)


@dataclass(frozen=True)
class ResponseStudy:
    """Responses over the runs that an experiment requests; added baselines are left out.

    Attributes
    ----------
    axes : tuple of AxisResponses
        One for each parameter that varies, in the order of the file.
    runs : ndarray of bool, shape (n_run,)
        The runs used.
    """

    axes: tuple[AxisResponses, ...]
    runs: NDArray[np.bool_]


def study_responses(data: ExperimentData) -> ResponseStudy:
    """The responses of an experiment.

    Leakage is compared with the sealed actuator under the same conditions, so that the leak alone is seen;
    all else with the fixed baseline. Where every run is its own baseline, the RMS stand in place of δ.
    """
    runs = swept_runs(data)
    fixed, matched = (detail_changes(data, matched=is_matched) for is_matched in (False, True))
    measured = tuple(indicator_features(data))
    axes = []
    for axis in varied_axes(data, runs):
        against = MATCHED if axis.is_leakage and matched else FIXED if fixed else NOTHING
        details = {MATCHED: matched, FIXED: fixed, NOTHING: detail_sizes(data)}[against]
        axes.append(_over(axis, against, (*details, *measured)))
    return ResponseStudy(tuple(axes), runs)


def _over(axis: Axis, against: str, features: tuple[Feature, ...]) -> AxisResponses:
    responses = (
        Response(
            feature, tuple(spread(feature.values[group.rows]) for group in axis.groups), _rank(axis, feature)
        )
        for feature in features
    )
    return AxisResponses(axis, against, tuple(responses))


def _rank(axis: Axis, feature: Feature) -> RankCorrelation | None:
    if not axis.is_in_fifths or axis.numbers is None:
        return None
    return rank_correlation(axis.numbers, feature.values)


def spread(values: Array) -> Spread:
    """Median and range of the finite numbers."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Spread(math.nan, math.nan, math.nan, 0)
    ends = (0.05, 0.95) if known.size >= MANY_RUNS else (0.0, 1.0)
    median, low, high = np.quantile(known, [0.5, *ends]).tolist()
    return Spread(median, low, high, known.size)
