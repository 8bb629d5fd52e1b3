"""Labelled records: what each score finds, healthy groups against each other, and what follows from them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hydrofdi.evaluation.scores import Kind, comparable
from hydrofdi.report.detection.record import detection_lines, pair_records
from hydrofdi.report.detection.wording import FROM_LEVELS, severity_unit
from hydrofdi.report.table import Column, Table, group_breaks
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, number_text, percentage
from hydrofdi.studies.records import LEAST_OF_GROUP, Detection


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
    best = detection.judgements[:1]
    rows = [
        row | {"of": each.rate and each.rate.total}
        for judgement in best
        for row, each in zip(pair_records(judgement), judgement.healthy_pairs, strict=True)
    ]
    rows.sort(key=lambda row: -abs(comparable(row["value"] - 0.5)))
    has_alarms = any(row["of"] is not None for row in rows)
    if not has_alarms:
        rows = [row for row in rows if (row["value"], row["fit_group"]) > (0.5, row["test_group"])]
    groups = ("threshold of", "tested") if has_alarms else ("group", "reads higher")
    titles = {"fit_group": groups[0], "test_group": groups[1], "value": "AUC"}
    titles |= {"alarms": "false alarms", "of": "of"} if has_alarms else {}
    texts = [_area_text(row["value"], row["low"], row["high"]) for row in rows]
    names = ("fit_group", "test_group", "value", "low", "high", "alarms", "of")
    columns = (
        Column(name, [row[name] for row in rows], title=titles.get(name, ""), is_shown=name in titles)
        for name in names
    )
    made = [
        replace(each, text=texts) if each.name == "value" else replace(each, is_text="group" in each.name)
        for each in columns
    ]
    title = "Healthy groups against each other by {}: none of them leaks"
    return Table(
        tuple(made), title=title.format(*(each.scored.name for each in best)) if best else "", n_lead=2
    )


def _area_text(value: float, low: float, high: float) -> str:
    return f"{number_text(value, 2)} [{number_text(low, 2)}, {number_text(high, 2)}]"
