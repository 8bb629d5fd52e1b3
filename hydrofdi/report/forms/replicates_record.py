"""Healthy replicates as plain data for JSON."""

from __future__ import annotations

from typing import Any

from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.replicates import ReplicatedRow, ReplicateStudy
from hydrofdi.report.runs.rows import level_name
from hydrofdi.units import convert


def replicates_record(study: ReplicateStudy) -> dict[str, Any]:
    """Ranges of the replicates, the rows against them, and how often a rule alarms on a healthy actuator."""
    return {
        "settled": study.is_settled,
        "ranges": [
            {
                "bulk_modulus_MPa": convert(healthy.bulk_modulus, "MPa"),
                "replicates": healthy.n_replicate,
                "low_percent": healthy.low.tolist(),
                "high_percent": healthy.high.tolist(),
            }
            for healthy in study.ranges
        ],
        "rows": [
            _row_record(entry, baseline)
            for baseline, entries in (("fixed", study.fixed), ("matched", study.matched))
            for entry in entries
        ],
        "alarms_on_healthy": {
            level_name(level): _alarm_record(study, level) for level in range(study.n_level)
        },
    }


def _row_record(entry: ReplicatedRow, baseline: str) -> dict[str, Any]:
    return {
        "run_id": entry.row.run_id,
        "baseline": baseline,
        "delta_percent": [finite(value) for value in entry.delta],
        "outside_healthy_range": list(entry.outside),
    }


def _alarm_record(study: ReplicateStudy, level: int) -> dict[str, Any]:
    share = study.alarms(level)
    return {"alarms": share.count, "of": share.total, "interval_95": [share.low, share.high]}
