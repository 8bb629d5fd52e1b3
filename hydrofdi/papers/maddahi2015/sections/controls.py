"""The controls that the paper does not have, as sentences and tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block, Cell, Rows, Sheet
from hydrofdi.report.runs.rows import level_name
from hydrofdi.report.wording import (
    HOLE,
    delta_cells,
    joined,
    labels_text,
    litres_per_minute,
    modulus_cell,
    modulus_header,
    modulus_text,
    signed,
    some,
)
from hydrofdi.settings.counting import counted


def controls_block(study: Study) -> Block:
    """Does the d3 rule alarm on a sealed actuator; which level is best under a matched baseline."""
    alarms, best = study.sealed_alarms, study.best_levels
    return Block(
        "controls",
        "Controls: no leak, and a matched baseline",
        (_alarm_sentence(alarms), _best_level_sentence(best)),
        (_alarm_sheet(study), _best_level_sheet(study)),
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


def _alarm_sheet(study: Study) -> Sheet:
    levels = [f"δd{level}" for level in range(1, study.table.n_level + 1)]
    headers = (*_label_header(study.sealed_alarms), modulus_header(), "d3 rule", *levels)
    n_label = len(_label_header(study.sealed_alarms))
    return Sheet(
        "sealed-alarms",
        "The d3 rule on the sealed actuator: δ [%] against the fixed baseline",
        headers,
        Rows(study.sealed_alarms, _alarm_cells),
        text_columns=(*range(n_label), n_label + 1),
    )


def _alarm_cells(alarm: SealedAlarm) -> tuple[Cell, ...]:
    return (
        *_labels(alarm),
        modulus_cell(alarm.bulk_modulus),
        Cell(_WORDS[alarm.alarm], alarm.alarm is True, _WORDS[alarm.alarm]),
        *delta_cells(alarm.delta_fixed),
    )


def _best_level_sheet(study: Study) -> Sheet:
    headers = (*_label_header(study.best_levels), "Leakage [L/min]", modulus_header(), "Best level", "δ [%]")
    n_label = len(_label_header(study.best_levels))
    return Sheet(
        "best-levels",
        "The best level of each mode against the matched baseline",
        headers,
        Rows(study.best_levels, _best_level_cells),
        text_columns=(*range(n_label), n_label + 2),
    )


def _best_level_cells(mode: BestLevel) -> tuple[Cell, ...]:
    return (
        *_labels(mode),
        Cell(litres_per_minute(mode.leakage_flow)),
        modulus_cell(mode.bulk_modulus),
        Cell(level_name(mode.level) or HOLE, value=level_name(mode.level)),
        Cell(signed(mode.delta), value=mode.delta),
    )


def _label_header(controls: Sequence[SealedAlarm | BestLevel]) -> tuple[str, ...]:
    return ("Parameters",) if controls and controls[0].labels else ()


def _labels(control: SealedAlarm | BestLevel) -> tuple[Cell, ...]:
    return (Cell(labels_text(control.labels)),) if control.labels else ()
