"""``hydrofdi evaluate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Json
from hydrofdi.settings.counting import counted

_SHOWN = 20
"""Most scores, and most pairs of healthy groups, that the terminal shows."""

if TYPE_CHECKING:
    from hydrofdi.api.evaluation import Evaluation, Left


def evaluate(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...", help="Descriptions of measured files, results folders or experiment files."
        ),
    ],
    indicators: Annotated[
        str,
        typer.Option(
            metavar="NAME,…|FILE",
            help="Indicators, 'all', or a YAML file with their options, and 'scores:' that combine "
            "their outputs.",
        ),
    ] = "dwt",
    healthy: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LABEL", help="Label of healthy records, in addition to 'healthy:'. Repeatable."
        ),
    ] = None,
    false_alarm_rate: Annotated[
        str, typer.Option(metavar="SHARE", help="False-alarm rate for which thresholds are set, e.g. 5%.")
    ] = "1%",
    confidence: Annotated[
        str, typer.Option(metavar="SHARE", help="Confidence of intervals and bounds.")
    ] = "95%",
    usual_scores: Annotated[
        bool,
        typer.Option(
            "--usual-scores",
            help="Also evaluate mahalanobis and lda of all outputs for each set of sensors, and the "
            "largest change"
            " of dwt.d1 … d5.",
        ),
    ] = False,
    json: Json = False,
) -> int:
    """Evaluate indicators on labelled records: what each detects, and its alarms on healthy groups.

    Labels and groups come from the descriptions. Healthy groups are tested at the threshold of the other
    healthy groups, and compared with each other as if they were faulty. If there are too few records for a
    result, the output says how many are needed. Scores made of several numbers are cross-fitted: no record is
    scored by a model that saw it or its group. Exit code 1 if records are rejected, repeat the samples of
    another or have no number of any indicator, or an indicator fails.
    """
    from hydrofdi.api.evaluating import evaluate as evaluate_records
    from hydrofdi.cli.terminal import print_json

    evaluation = evaluate_records(
        sources,
        indicators,
        healthy=healthy or (),
        false_alarm_rate=false_alarm_rate,
        confidence=confidence,
        usual_scores=usual_scores,
    )
    if json:
        print_json(evaluation.to_dict())
    else:
        _print(evaluation)
    return _tell(evaluation.left)


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


def _tell(left: Left) -> int:
    from hydrofdi.cli.terminal import tell

    for fault in left.faults:
        tell(f"failed: {fault}")
    if left.n_rejected:
        tell(f"rejected: {left.n_rejected:,} of {counted(left.n_record, 'record')}; {left.first_rejection}")
    if left.n_repeated:
        tell(
            f"left out: {left.n_repeated:,} of {counted(left.n_record, 'record')}"
            " have the samples of another, e.g."
            f" {left.first_repeat}; a threshold must not be tested on the records that set it"
        )
    if left.n_empty:
        tell(f"without any number: {left.n_empty:,} of {counted(left.n_record, 'record')}")
    if left.n_unlabelled:
        tell(f"without a label, left out: {left.n_unlabelled:,} of {counted(left.n_record, 'record')}")
    return 1 if left.n_rejected or left.n_repeated or left.n_empty or left.faults else 0
