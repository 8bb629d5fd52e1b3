"""An evaluation of labelled records on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.records.evaluation_columns import HOLE, area_text, print_scores
from hydrofdi.cli.terminal import terminal
from hydrofdi.evaluation.groups import HealthyPair
from hydrofdi.report.wording import capitalized
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.evaluation import Evaluation
    from hydrofdi.studies.judgement import Judgement

_SHOWN = 20
"""Most scores, and most pairs of healthy groups, that the terminal shows."""

_AREA_WIDTH = len("0.00 [0.00, 0.00]")


def print_evaluation(evaluation: Evaluation) -> None:
    """Print the conclusion from healthy groups, the scores (best first), and what is not stated, and why."""
    console, detection = terminal(), evaluation.detection
    _print_records(console, evaluation)
    if not detection.judgements:
        console.print("no indicator could measure any record")
        return
    if evaluation.conclusion:
        console.print(Text(f"{capitalized(evaluation.conclusion)}.", style="bold"))
    console.print()
    shown = detection.judgements[:_SHOWN]
    print_scores(console, evaluation, shown)
    if len(detection.judgements) > len(shown):
        console.print(
            f"… the first {len(shown)} of {counted(len(detection.judgements), 'score')}; --json has all"
        )
    _print_pairs(console, evaluation, detection.judgements[0])
    console.print()
    told = Table.grid(padding=(0, 1, 0, 0))
    for sentence in evaluation.remarks:
        told.add_row("-", sentence)
    console.print(told)


def _print_records(console: Console, evaluation: Evaluation) -> None:
    records = evaluation.detection.records
    counts = ", ".join(f"{records.rows(each).size:,} {each.name}" for each in records.populations)
    n_group = 0 if records.groups is None else len(set(records.groups))
    console.print(f"Records: {counts}; {counted(n_group, 'group') if n_group else 'no groups'}")


def _print_pairs(console: Console, evaluation: Evaluation, judgement: Judgement) -> None:
    pairs, name = evaluation.healthy_pairs(judgement), judgement.scored.name
    if not pairs:
        return
    console.print(Text(f"\nHealthy groups against each other by {name}: none of them leaks", style="bold"))
    console.print(_pairs_table(pairs))
    if len(pairs) > _SHOWN:
        console.print(f"… the {_SHOWN} of {len(pairs)} pairs that differ most; --json has all")


def _pairs_table(pairs: Sequence[HealthyPair]) -> Table:
    """The pairs that differ most; in both orders only if alarms depend on the order."""
    has_alarms = any(pair.rate is not None for pair in pairs)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for header in ("threshold of", "tested") if has_alarms else ("group", "reads higher"):
        table.add_column(header, overflow="fold")
    for header in ("AUC", *(["false alarms"] if has_alarms else [])):
        table.add_column(header, no_wrap=True, min_width=_AREA_WIDTH)
    apart = sorted(pairs, key=lambda pair: -abs(pair.area.value - 0.5))
    if not has_alarms:
        apart = [pair for pair in apart if _comes_first(pair)]
    for pair in apart[:_SHOWN]:
        alarms = HOLE if pair.rate is None else f"{pair.rate.count} of {pair.rate.total}"
        own = [area_text(pair.area), *([alarms] if has_alarms else [])]
        table.add_row(pair.fit_group, pair.test_group, *own)
    return table


def _comes_first(pair: HealthyPair) -> bool:
    """Whether the second group of a pair reads higher; equal groups are in the order of their names."""
    is_equal = pair.area.value == 0.5
    return pair.area.value > 0.5 or (is_equal and pair.fit_group < pair.test_group)
