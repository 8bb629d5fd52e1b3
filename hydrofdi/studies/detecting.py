"""All scores of a study, judged and ranked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hydrofdi.evaluation.multiplicity import confidence_text, simultaneous_confidence
from hydrofdi.evaluation.populations import Kind
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.judging import judge
from hydrofdi.studies.ranking import pareto_set, ranked
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.studies.rules import Rules


def detect(records: StudyRecords, scores: Sequence[Scored], rules: Rules) -> Detection:
    """Results of a study for all its scores.

    Those that come first or are in the Pareto set were chosen among many, so they have a second bound,
    ``q90_95_of_all``, that holds for all scores together.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
        All that were tried, also those that nobody will report: their number counts. Names are distinct.
    rules : Rules
    """
    judgements = ranked([judge(records, scored, rules) for scored in scores])
    best = pareto_set(judgements)
    among_all = replace(rules, n_tried=len(scores))
    judgements = tuple(
        judge(records, each.scored, among_all) if rank == 0 or each.scored.name in best else each
        for rank, each in enumerate(judgements)
    )
    return Detection(
        records, judgements, rules, best, (*records.remarks, *_remarks(records, len(scores), rules))
    )


def _remarks(records: StudyRecords, n_tried: int, rules: Rules) -> list[str]:
    remarks = []
    if n_tried > 1:
        together = simultaneous_confidence(rules.confidence, n_tried)
        remarks.append(
            f"{counted(n_tried, 'score')} were tried. The bounds apply to a"
            " score chosen in advance. If you pick the"
            f" best of {n_tried}, use the {confidence_text(together)} % bound (Bonferroni)"
        )
    if records.groups is not None:
        n_group = len(set(records.groups))
        remarks.append(
            f"{counted(n_group, 'group')}: intervals of rates allow for what"
            " differs between them, curves of detection"
            " do not"
        )
    if not records.chosen(Kind.FAULT, is_fit=False):
        remarks.append("no faulty record is tested: nothing is said of detection")
    return remarks
