"""Limit of a control chart from healthy scores over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from hydrofdi.detectors.charts import make_chart
from hydrofdi.detectors.run_lengths import FalseAlarms
from hydrofdi.detectors.trained.charting import standardised
from hydrofdi.detectors.trained.configuration import ChartConfig
from hydrofdi.detectors.trained.file import ChartLimit, Scale
from hydrofdi.detectors.trained.training.learned import Learned
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.grouped_area import FEWEST_GROUPS
from hydrofdi.records import Array

_N_PIECE = 20
"""Number of pieces that records are cut into if there are fewer than five records."""

_HOUR = 3600.0

RestsOn = Literal["pieces", "records", "groups"]


def chart_in_full(chart: ChartConfig, direction: Direction) -> ChartConfig:
    """Chart configuration with all options; the direction refers to scores that rise with leakage."""
    turned = Direction.BOTH if direction is Direction.BOTH else Direction.RISING
    made = make_chart(chart.chart, {"direction": turned, **chart.options})
    return chart.model_copy(update={"options": made.options.model_dump(mode="json")})


def chart_limit(
    learned: Learned, chart: ChartConfig, healthy: Scale, direction: Direction, confidence: float
) -> ChartLimit:
    """Limit that healthy scores, in time order, reach once within the required time on average.

    Parameters
    ----------
    learned : Learned
    chart : ChartConfig
        Chart configuration with all options.
    healthy : Scale
    direction : Direction
        Direction of the score.
    confidence : float

    Raises
    ------
    NotStatedError
        The healthy records are shorter in total than the required time; the message states the required
        length.
    """
    lines = [standardised(each.line.scores, healthy, direction) for each in learned.records]
    streams, groups, rests_on = _streams(lines, learned)
    alarms = FalseAlarms(
        make_chart(chart.chart, chart.options), streams, learned.interval, groups=groups
    ).limit(chart.false_alarm_every, confidence=confidence)
    return ChartLimit(
        limit=alarms.value,
        mean_time=_known(alarms.mean_time),
        interval=(alarms.low, _known(alarms.high)),
        hours=alarms.duration / _HOUR,
        rests_on=rests_on,
    )


def _streams(lines: Sequence[Array], learned: Learned) -> tuple[Array, list[str] | None, RestsOn]:
    """Scores as an array, padded with NaN, and their groups."""
    if len(set(learned.groups)) >= FEWEST_GROUPS:
        return _side_by_side(lines), learned.groups, "groups" if learned.has_groups else "records"
    length = max(1, sum(line.size for line in lines) // _N_PIECE)
    pieces = [line[first : first + length] for line in lines for first in range(0, line.size, length)]
    return _side_by_side(pieces), None, "pieces"


def _side_by_side(lines: Sequence[Array]) -> Array:
    streams = np.full((len(lines), max(line.size for line in lines)), np.nan)
    for row, line in enumerate(lines):
        streams[row, : line.size] = line
    return streams


def _known(time: float) -> float | None:
    return time if math.isfinite(time) else None
