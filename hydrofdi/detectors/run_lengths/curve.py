"""Delay against mean time between false alarms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from hydrofdi.detectors.run_lengths.delays import Delays, delays
from hydrofdi.detectors.run_lengths.false_alarms import AlarmLimit, FalseAlarms
from hydrofdi.evaluation.refusal import NotStatedError


@dataclass(frozen=True, eq=False)
class CurvePoint:
    """What a chart does at one mean time between false alarms.

    Attributes
    ----------
    wanted : float
        Mean time between false alarms [s].
    limit : AlarmLimit or None
        None where the healthy records do not carry it.
    delays : Delays or None
    refusal : str
        Why there is none.
    """

    wanted: float
    limit: AlarmLimit | None = None
    delays: Delays | None = None
    refusal: str = ""


def delay_curve(
    healthy: FalseAlarms,
    mean_times: Sequence[float],
    streams: ArrayLike,
    instants: ArrayLike,
    onset: ArrayLike,
    *,
    groups: Sequence[str] | None = None,
) -> tuple[CurvePoint, ...]:
    """Delays of the chart of `healthy` at each of several mean times between false alarms.

    Parameters
    ----------
    healthy : FalseAlarms
    mean_times : sequence of float
        Wanted mean times between false alarms [s].
    streams, instants, onset, groups
        Records whose leak sets in, see `delays`.
    """
    points = []
    for wanted in mean_times:
        try:
            limit = healthy.limit(wanted)
        except NotStatedError as refusal:
            points.append(CurvePoint(wanted, refusal=str(refusal)))
            continue
        found = delays(healthy.chart, limit.value, streams, instants, onset, groups=groups)
        points.append(CurvePoint(wanted, limit, found))
    return tuple(points)
