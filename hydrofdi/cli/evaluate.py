"""``hydrofdi evaluate``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hydrofdi.cli.options import Json, Sources
from hydrofdi.settings.counting import counted

_SHOWN = 20
"""Most scores, and most pairs of healthy groups, that the terminal shows."""

if TYPE_CHECKING:
    from hydrofdi.api.evaluation import Evaluation


def evaluate(
    sources: Sources,
    json: Json = False,
    **settings: Any,
) -> int:
    """Evaluate indicators on labelled records: what each detects, and its alarms on healthy groups.

    Labels and groups come from the descriptions. Healthy groups are tested at the threshold of the other
    healthy groups, and compared with each other as if they were faulty. If there are too few records for a
    result, the output says how many are needed. Scores made of several numbers are cross-fitted: no record is
    scored by a model that saw it or its group. Exit code 1 if records are rejected, repeat the samples of
    another or have no number of any indicator, or an indicator fails.
    """
    from hydrofdi.api.evaluation import evaluate as evaluate_records
    from hydrofdi.cli.terminal import print_json, tell

    evaluation = evaluate_records(sources, **settings)
    if json:
        print_json(evaluation.to_dict())
    else:
        _print(evaluation)
    for sentence in evaluation.left.sentences():
        tell(sentence)
    return 1 if evaluation.left.is_lacking or evaluation.left.n_repeated else 0


def _print(evaluation: Evaluation) -> None:
    """Print the conclusion from healthy groups, the scores (best first), and what is not stated, and why."""
    from rich.text import Text

    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal

    console, records, conclusion = terminal(), evaluation.detection.records, evaluation.conclusion
    counts = ", ".join(f"{records.rows(each).size:,} {each.name}" for each in records.populations)
    n_group = len(set(records.groups or ()))
    console.print(f"Records: {counts}; {counted(n_group, 'group') if n_group else 'no groups'}")
    if not evaluation.best:
        console.print("no indicator could measure any record")
        return
    if conclusion:
        console.print(Text(f"{conclusion[0].upper()}{conclusion[1:]}.", style="bold"))
    console.print()
    print_table(console, evaluation.table, _SHOWN * len(records.populations))
    if len(evaluation.pairs):
        console.print()
        print_table(console, evaluation.pairs, _SHOWN)
    console.print()
    for sentence in evaluation.remarks:
        console.print(f"- {sentence}")
