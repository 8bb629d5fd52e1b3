"""Healthy scores along the time → the limit of a control chart."""

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
from hydrofdi.evaluation.bootstrap import FEWEST_GROUPS
from hydrofdi.evaluation.direction import Direction
from hydrofdi.records import Array

_N_PIECE = 20
"""Pieces that records are cut into where there are fewer than five of them."""

_HOUR = 3600.0

RestsOn = Literal["pieces", "records", "groups"]


def chart_in_full(chart: ChartConfig, direction: Direction) -> ChartConfig:
    """With all options. Scores that a leak lowers are turned, so that a chart of them rises."""
    turned = Direction.BOTH if direction is Direction.BOTH else Direction.RISING
    made = make_chart(chart.chart, {"direction": turned, **chart.options})
    return chart.model_copy(update={"options": made.options.model_dump(mode="json")})


def chart_limit(
    learned: Learned, chart: ChartConfig, healthy: Scale, direction: Direction, confidence: float
) -> ChartLimit:
    """The limit that healthy scores, in their order along each record, reach once in the wanted time.

    Parameters
    ----------
    learned : Learned
    chart : ChartConfig
        In full.
    healthy : Scale
    direction : Direction
        Of the score.
    confidence : float

    Raises
    ------
    NotStatedError
        The healthy records are shorter, together, than the wanted time; it tells how long they have to be.
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
    """Scores side by side, NaN behind the shorter ones, with their groups."""
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
