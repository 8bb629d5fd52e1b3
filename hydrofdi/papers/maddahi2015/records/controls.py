"""Controls as plain data."""

from __future__ import annotations

import math
from typing import Any

from hydrofdi.papers.maddahi2015.claims import D3
from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm
from hydrofdi.papers.maddahi2015.records.phases import labels_record, phases_record
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.runs import largest_positive, level_name
from hydrofdi.units import convert


def controls_record(study: Study) -> dict[str, Any]:
    """The d3 rule on sealed actuators, and the best levels against the matched baseline."""
    return {
        "sealed_alarms": [
            _alarm_record(alarm) | _alarm_standing(study, place)
            for place, alarm in enumerate(study.sealed_alarms)
        ],
        "best_level_matched": [
            _best_level_record(mode) | _best_level_standing(study, place)
            for place, mode in enumerate(study.best_levels)
        ],
    }


def _alarm_record(alarm: SealedAlarm) -> dict[str, Any]:
    return {
        "bulk_modulus_MPa": convert(alarm.bulk_modulus, "MPa"),
        "alarm": alarm.alarm,
        "delta_fixed_percent": [finite(value) for value in alarm.delta_fixed],
    } | labels_record(alarm.labels)


def _best_level_record(mode: BestLevel) -> dict[str, Any]:
    return {
        "leakage_L_per_min": finite(convert(mode.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(mode.bulk_modulus, "MPa"),
        "level": level_name(mode.level),
        "delta_matched_percent": finite(mode.delta),
    } | labels_record(mode.labels)


def _alarm_standing(study: Study, place: int) -> dict[str, Any]:
    configured, *settled = study.standings
    record = phases_record(configured.alarms[place], "delta_d3_percent")
    for standing in settled:
        deltas = standing.alarm_deltas[place]
        record["settled"] = {
            "alarm": None if any(map(math.isnan, deltas)) else largest_positive(deltas) == D3,
            "delta_fixed_percent": [finite(value) for value in deltas],
            **phases_record(standing.alarms[place], "delta_d3_percent"),
        }
    return record


def _best_level_standing(study: Study, place: int) -> dict[str, Any]:
    configured, *settled = study.standings
    record = phases_record(configured.best_levels[place], "delta_matched_percent")
    for standing in settled:
        record["settled"] = phases_record(standing.best_levels[place], "delta_matched_percent")
    return record
