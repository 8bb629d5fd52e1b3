"""Cost of indicators, in a batch and for single records, relative to the simulation of the record."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from full_lanes import advance_full_lanes
from jobs import AT_REST, Job, lane_jobs

from hydrofdi.indicators import Indicator, indicator_names, make_indicators, measure
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.simulation.batch import simulate_batch

RECORD = 20.0
"""Duration of the measured record [s]."""

BATCH = 64
"""Number of records measured together; smaller for indicators that are not cheap."""

FEW = 2


@dataclass
class Cost:
    """An indicator, records that it can measure, and its time in each round [s per record]."""

    indicator: Indicator
    records: RecordBatch
    together: list[float] = field(default_factory=list)
    alone: list[float] = field(default_factory=list)
    per_kernel: list[float] = field(default_factory=list)


def simulated_records(values: Mapping[str, Any] = MappingProxyType({})) -> RecordBatch:
    """Simulate a batch of records from the jobs in the lanes."""
    jobs = lane_jobs(RECORD, values=values)
    runs = [parameters for parameters, _ in jobs]
    trajectory = simulate_batch(runs, [coefficient for _, coefficient in jobs])
    rows = np.arange(BATCH) % len(jobs)
    shape = (len(jobs), trajectory.time.size)
    channels = {
        channel: np.broadcast_to(getattr(trajectory, channel), shape)[rows]
        for channel in Channel
        if hasattr(trajectory, channel)
    }
    channels[Channel.SUPPLY_PRESSURE] = np.broadcast_to(trajectory.valve_supply_pressure, shape)[rows]
    return RecordBatch(
        channels,
        round(1.0 / float(trajectory.time[1] - trajectory.time[0]), 9),
        tuple(str(row) for row in range(BATCH)),
        drive_period=runs[0].input.period,
    )


def resting_records() -> RecordBatch:
    """Simulate records with rests, which only the position shows."""
    records = simulated_records(AT_REST)
    others = {key: samples for key, samples in records.channels.items() if key != Channel.INPUT_VOLTAGE}
    return replace(records, channels=others)


def measure_indicators(
    rounds: int, advance: Callable[[list[Job]], object], names: Sequence[str] = ()
) -> tuple[dict[str, dict[str, float]], float]:
    """Time of each indicator [ms per record], and of all cheap ones together relative to the kernel.

    Parameters
    ----------
    rounds : int
    advance : callable
        Runs only the kernel.
    names : sequence of str
        Indicators to measure; by default all.
    """
    jobs, sources = lane_jobs(RECORD), [simulated_records(), resting_records()]
    indicators = make_indicators(list(names) or indicator_names())
    costs = {name: Cost(each, _measurable(each, sources)) for name, each in indicators.items()}
    advance(jobs)
    kernel, sums = [], []
    for _ in range(rounds):
        kernel.append(_seconds(lambda: advance(jobs)) / len(jobs))
        cheap = 0.0
        for cost in costs.values():
            _measure(cost)
            cost.per_kernel.append(cost.together[-1] / kernel[-1])
            cheap += cost.per_kernel[-1] if cost.indicator.is_cheap else 0.0
        sums.append(cheap)
    rows = {"kernel": {"ms_in_batch": 1e3 * float(np.median(kernel))}}
    rows |= {name: _row(cost) for name, cost in costs.items()}
    return rows, float(np.median(sums))


def tell_indicators(rows: dict[str, dict[str, float]], cheap: float) -> None:
    lines = [f"\n{'indicators, per record':26} {'ms in batch':>12} {'ms alone':>12} {'times the kernel':>17}"]
    for name, row in rows.items():
        alone, ratio = row.get("ms_alone", np.nan), row.get("times_the_kernel", 1.0)
        lines.append(f"{name:26} {row['ms_in_batch']:12.3f} {alone:12.3f} {ratio:17.2f}")
    lines.append(f"{'all cheap ones':26} {'':25} {cheap:17.2f}")
    print("\n".join(lines), file=sys.stderr, flush=True)


def _measurable(indicator: Indicator, sources: list[RecordBatch]) -> RecordBatch:
    """First records that an indicator can measure: some need a drive, some a rest."""
    return next(
        records
        for records in sources
        if measure(records.rows([0]), {indicator.name: indicator}).obstacles[indicator.name] == (None,)
    )


def _measure(cost: Cost) -> None:
    chosen = {cost.indicator.name: cost.indicator}
    some = cost.records if cost.indicator.is_cheap else cost.records.rows(range(FEW))
    single = cost.records.rows([0])
    cost.together.append(_seconds(lambda: measure(some, chosen)) / some.n_record)
    cost.alone.append(_seconds(lambda: measure(single, chosen)))


def _row(cost: Cost) -> dict[str, float]:
    return {
        "ms_in_batch": 1e3 * float(np.median(cost.together)),
        "ms_alone": 1e3 * float(np.median(cost.alone)),
        "times_the_kernel": float(np.median(cost.per_kernel)),
        "is_cheap": float(cost.indicator.is_cheap),
    }


def _seconds(act: Callable[[], object]) -> float:
    start = time.perf_counter()
    act()
    return time.perf_counter() - start


if __name__ == "__main__":
    tell_indicators(*measure_indicators(9, advance_full_lanes, sys.argv[1:]))
