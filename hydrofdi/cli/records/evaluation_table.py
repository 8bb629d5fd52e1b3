"""An evaluation of labelled records on the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import compress

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.terminal import terminal
from hydrofdi.evaluation.auc import Area
from hydrofdi.evaluation.groups import HealthyPair
from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.pipeline.evaluating import Evaluation
from hydrofdi.studies.judgement import Judgement
from hydrofdi.units import convert

_SHOWN = 20
"""Scores, and pairs of healthy groups, that the terminal shows."""

_HOLE = "–"


def print_evaluation(evaluation: Evaluation) -> None:
    """The scores, the best first; healthy groups against each other; what is not stated, and why."""
    console, detection = terminal(), evaluation.detection
    _print_records(console, evaluation)
    if not detection.judgements:
        console.print("no indicator gave a number of any record")
        return
    shown = detection.judgements[:_SHOWN]
    console.print(_scores_table(evaluation, shown))
    if len(detection.judgements) > len(shown):
        console.print(f"… the first {len(shown)} of {len(detection.judgements)} scores; --json has all")
    best = detection.judgements[0]
    pairs = evaluation.healthy_pairs[best.scored.name]
    if pairs:
        console.print(Text(f"\nHealthy against healthy, {best.scored.name}: none leaks", style="bold"))
        console.print(_pairs_table(pairs))
        if len(pairs) > _SHOWN:
            console.print(f"… the {_SHOWN} that differ most of {len(pairs)} pairs; --json has all")
    sentences = [(sentence, 0) for sentence in detection.remarks]
    is_made = [bool(np.isfinite(each.scored.values).any()) for each in detection.judgements]
    refused = list(compress(detection.judgements, [not each for each in is_made]))
    sentences += Counter(each.scored.note for each in refused).most_common()
    sentences += _told(list(compress(detection.judgements, is_made)))
    for sentence, count in sentences:
        of_all = f" ({count} of {len(detection.judgements)} scores)" if count else ""
        console.print(f"- {sentence}{of_all}")


def _print_records(console: Console, evaluation: Evaluation) -> None:
    records = evaluation.detection.records
    counts = ", ".join(f"{records.rows(each).size:,} {each.name}" for each in records.populations)
    n_group = 0 if records.groups is None else len(set(records.groups))
    console.print(f"{counts}; {f'{n_group} groups' if n_group else 'no groups'}")


def _scores_table(evaluation: Evaluation, judgements: Sequence[Judgement]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("score", no_wrap=True)
    levels = judgements[0].levels
    for level in levels:
        table.add_column(f"AUC {level.population.name}", no_wrap=True)
    has_pairs = any(evaluation.healthy_pairs.values())
    if has_pairs:
        table.add_column("healthy groups", no_wrap=True)
    table.add_column("false alarms", no_wrap=True)
    has_severity = any(judgement.smallest for judgement in judgements)
    if has_severity:
        table.add_column("q90/95 [L/min]", justify="right")
    for judgement in judgements:
        row = [judgement.scored.name, *(_area(level.area) for level in judgement.levels)]
        row += [_extreme(evaluation.healthy_pairs[judgement.scored.name])] if has_pairs else []
        row += [_false_alarms(judgement)]
        table.add_row(*row, *([_found(judgement)] if has_severity else []))
    return table


def _area(area: Area | None) -> str:
    return _HOLE if area is None else f"{area.value:.2f} [{area.low:.2f}, {area.high:.2f}]"


def _extreme(pairs: Sequence[HealthyPair]) -> str:
    """The areas between which those of healthy groups lie."""
    areas = [pair.area.value for pair in pairs]
    return f"{min(areas):.2f} … {max(areas):.2f}" if areas else _HOLE


def _false_alarms(judgement: Judgement) -> str:
    rates = list(judgement.false_alarms.items())
    return _rate(judgement, *rates[0]) if rates else _HOLE


def _rate(judgement: Judgement, population: Population, rate: Rate) -> str:
    if population in judgement.counted:
        return f"{rate.count} of {rate.total}"
    return f"{rate.value:.1%} [{rate.low:.1%}, {rate.high:.1%}]"


def _found(judgement: Judgement) -> str:
    bound = judgement.smallest.get("q90_95")
    return _HOLE if bound is None else bound.sentence(scale=convert(1.0, "L/min"))


def _pairs_table(pairs: Sequence[HealthyPair]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for header in ("threshold of", "tested", "AUC", "alarms"):
        table.add_column(header, no_wrap=True)
    apart = sorted(pairs, key=lambda pair: -abs(pair.area.value - 0.5))
    for pair in apart[:_SHOWN]:
        alarms = _HOLE if pair.rate is None else f"{pair.rate.count} of {pair.rate.total}"
        table.add_row(pair.fit_group, pair.test_group, _area(pair.area), alarms)
    return table


def _told(judgements: Sequence[Judgement]) -> list[tuple[str, int]]:
    """What is not stated and what is remarked of scores, each sentence once with the number of its scores."""
    texts = [text for judgement in judgements for text in (*judgement.refusals, *judgement.remarks)]
    return Counter(texts).most_common(_SHOWN)
