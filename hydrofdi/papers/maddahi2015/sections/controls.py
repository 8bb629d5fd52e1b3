"""The controls that the paper does not have, as sentences and tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block
from hydrofdi.report.runs import level_name
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import (
    joined,
    labels_text,
    litres_per_minute,
    modulus_column,
    modulus_text,
    signed,
    some,
)
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE


def controls_block(study: Study) -> Block:
    """Does the d3 rule alarm on a sealed actuator; which level is best under a matched baseline."""
    alarms, best = study.sealed_alarms, study.best_levels
    return Block(
        "controls",
        "Controls: no leak, and a matched baseline",
        (_alarm_sentence(alarms), _best_level_sentence(best)),
        (_alarm_table(study), _best_level_table(study)),
        ("spectrum", "mode_plane"),
    )


def _alarm_sentence(alarms: tuple[SealedAlarm, ...]) -> str:
    decided = [alarm for alarm in alarms if alarm.alarm is not None]
    if not decided:
        return "The d3 rule could not be tested: no sealed run above the normal EBM has succeeded."
    raised = [alarm for alarm in decided if alarm.alarm]
    if not raised:
        return f"The d3 rule raises no alarm in all {len(decided):,} sealed cases above the normal EBM."
    places = list(dict.fromkeys(modulus_text(alarm.bulk_modulus) for alarm in raised))
    return (
        f"The d3 rule raises an alarm on the sealed actuator in {len(raised):,} of {len(decided):,} cases"
        f" above the normal EBM ({some(places)}): there the EBM alone makes δd3 positive and the largest."
    )


def _best_level_sentence(best: tuple[BestLevel, ...]) -> str:
    counts = Counter("open" if mode.is_open else level_name(mode.level) or "no level" for mode in best)
    if not best:
        return "No leaky mode can be compared with the matched baseline."
    parts = [f"{level} in {count:,}" for level, count in sorted(counts.items())]
    return (
        f"Against the matched baseline the largest positive δ of the {counted(len(best), 'leaky mode')}"
        f" is: {joined(parts)}."
    )


_WORDS = {True: "alarm", False: "silent", None: "open"}


def _alarm_table(study: Study) -> Table:
    alarms = study.sealed_alarms
    marked = [k for k, alarm in enumerate(alarms) if alarm.alarm]
    levels = (
        Column(f"δd{level + 1}", [alarm.delta_fixed[level] for alarm in alarms], text=signed)
        for level in range(study.table.n_level)
    )
    return Table(
        (
            *_labels(alarms),
            modulus_column([alarm.bulk_modulus for alarm in alarms]),
            Column("d3 rule", [_WORDS[alarm.alarm] for alarm in alarms], is_text=True, strong=marked),
            *levels,
        ),
        "The d3 rule on the sealed actuator: δ [%] against the fixed baseline",
        "sealed-alarms",
    )


def _best_level_table(study: Study) -> Table:
    best = study.best_levels
    return Table(
        (
            *_labels(best),
            Column("Leakage [L/min]", [litres_per_minute(mode.leakage_flow) for mode in best]),
            modulus_column([mode.bulk_modulus for mode in best]),
            Column("Best level", [level_name(mode.level) or HOLE for mode in best], is_text=True),
            Column("δ [%]", [mode.delta for mode in best], text=signed),
        ),
        "The best level of each mode against the matched baseline",
        "best-levels",
    )


def _labels(controls: Sequence[SealedAlarm | BestLevel]) -> list[Column]:
    texts = [labels_text(control.labels) for control in controls]
    return [Column("Parameters", texts, is_text=True)] if any(texts) else []
