"""Labelled records: what each score finds, healthy groups against each other, and what follows from them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hydrofdi.evaluation.scores import Kind, comparable
from hydrofdi.report.detection.record import detection_lines
from hydrofdi.report.detection.wording import FROM_LEVELS, severity_unit
from hydrofdi.settings.messages import HOLE, counted, number_text, percentage
from hydrofdi.studies.records import LEAST_OF_GROUP, Detection
from hydrofdi.tables.table import Column, Table, group_breaks


def conclusion(detection: Detection) -> str:
    """Comparison of healthy groups over all scores; empty if there are fewer than two and a fault."""
    judgements = [each for each in detection.judgements if each.levels]
    known = [each.stands_clear for each in judgements if each.stands_clear is not None]
    n_not, n_score = known.count(False), len(known)
    if not judgements:
        return "no record is labelled faulty, so no detection can be stated"
    if not n_score:
        few = f"fewer than two healthy groups have {LEAST_OF_GROUP} records: whether only the unit or the day"
        has_groups = any(each.healthy_pairs for each in detection.judgements)
        return f"{few} was detected cannot be told" if has_groups else ""
    if not n_not:
        return "in every score, faults differ more from healthy records than healthy groups do"
    return (
        f"{'only' if n_not == n_score else 'perhaps only'} the unit or the day was detected: in {n_not} of"
        f" {counted(n_score, 'score')}, marked ~, healthy groups differ from each other as much as faults"
        " differ from them"
    )


def labelled_table(detection: Detection) -> Table:
    """A row for each score and population with the numbers of CSV, the best score first."""
    unit, by_name = severity_unit(detection), {each.scored.name: each for each in detection.judgements}
    found = f"q90_95{unit.suffix}"
    titles = {
        "indicator": "score",
        "population": "population",
        "alarms": "alarms",
        "auc": "AUC",
        found: f"q90/95{unit.bracket}",
        "not_measurable": "without a number",
    }

    def text_of(line: dict[str, Any], name: str) -> str:
        judgement = by_name[line["indicator"]]
        if name == "indicator":
            return f"{'~ ' if judgement.stands_clear is False else ''}{line[name]}"
        if name == "alarms" and line["n"] is not None:
            ends = [percentage(line[end]) for end in ("rate", "low", "high") if line[end] is not None]
            share = ", {} % [{}, {}]".format(*ends) if len(ends) == 3 else ""
            return f"{line['alarms']} of {line['n']}{share}"
        if name == "auc" and line["kind"] == Kind.HEALTHY and (areas := judgement.healthy_areas):
            return f"{min(areas):.2f} … {max(areas):.2f}"
        if name == "auc" and line["auc"] is not None:
            return _area_text(line["auc"], line["auc_low"], line["auc_high"])
        if name == found and line["kind"] == Kind.FAULT:
            return unit.found(judgement.smallest.get("q90_95")).removesuffix(FROM_LEVELS)
        return str(line[name]) if name in ("population", "not_measurable") and line[name] else HOLE

    lines = [line for line in detection_lines([detection]) if "population" in line]
    columns = []
    for name in [*titles, *(each for each in (lines[0] if lines else ()) if each not in titles)]:
        texts = [text_of(line, name) for line in lines]
        column = Column(name, [line[name] for line in lines], title=titles.get(name, ""), text=texts)
        is_text, is_shown = name in ("indicator", "population"), name in titles and {*texts} != {HOLE}
        columns.append(replace(column, is_text=is_text, is_shown=is_shown))
    breaks = group_breaks([line["indicator"] for line in lines])
    return Table(tuple(columns), n_lead=2, breaks=breaks if len(lines) > 2 * len(by_name) else ())


def pairs_table(detection: Detection) -> Table:
    """A row for two healthy groups, those first that the best score tells apart best.

    The threshold of ``fit_group`` is tested on ``test_group``. If no alarms are counted, both groups are
    listed once, and the second reads higher.
    """
    best = next(iter(detection.judgements), None)
    pairs = [] if best is None else list(best.healthy_pairs)
    pairs.sort(key=lambda pair: -abs(comparable(pair.area.value - 0.5)))
    has_alarms = any(pair.rate is not None for pair in pairs)
    if not has_alarms:
        pairs = [each for each in pairs if (each.area.value, each.fit_group) > (0.5, each.test_group)]
    titles = ("threshold of", "tested") if has_alarms else ("group", "reads higher")
    areas, rates = [pair.area for pair in pairs], [pair.rate for pair in pairs]
    texts = [_area_text(area.value, area.low, area.high) for area in areas]
    return Table(
        (
            Column("fit_group", [pair.fit_group for pair in pairs], title=titles[0], is_text=True),
            Column("test_group", [pair.test_group for pair in pairs], title=titles[1], is_text=True),
            Column("auc", [area.value for area in areas], title="AUC", text=texts),
            Column("auc_low", [area.low for area in areas], is_shown=False),
            Column("auc_high", [area.high for area in areas], is_shown=False),
            Column("alarms", [r and r.count for r in rates], title="false alarms", is_shown=has_alarms),
            Column("n", [r and r.total for r in rates], title="of", is_shown=has_alarms),
        ),
        title=f"Healthy groups against each other by {best.scored.name if best else ''}: none of them leaks",
        n_lead=2,
    )


def _area_text(value: float, low: float, high: float) -> str:
    return f"{number_text(value, 2)} [{number_text(low, 2)}, {number_text(high, 2)}]"
