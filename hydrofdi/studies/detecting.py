"""Evaluation and ranking of all scores of a study, and the detector of its best."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.detectors.rules import CHANGE, Rules
from hydrofdi.detectors.trained.configuration import stated_indicators
from hydrofdi.evaluation.rates import confidence_text, simultaneous_confidence
from hydrofdi.evaluation.scores import Kind
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import read_study, within
from hydrofdi.studies.records import Detection, Judgement, Scored, StudyRecords, pareto_set, ranked


def detect(records: StudyRecords, scores: Sequence[Scored], rules: Rules) -> Detection:
    """Evaluate all scores of a study.

    Top-ranked scores and scores in the Pareto set were selected among many, so they get a second bound,
    ``q90_95_of_all``, that is simultaneous for all scores.
    """
    judged = [judge(records, scored, rules) for scored in scores]
    judgements = ranked(judged, is_labelled=records.is_labelled)
    best = pareto_set(judgements)
    judgements = tuple(
        judge(records, each.scored, rules, n_tried=len(scores))
        if rank == 0 or each.scored.name in best
        else each
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
            f"{counted(n_group, 'group')}: intervals of rates allow for"
            " differences between groups, curves of detection"
            " do not"
        )
    if not records.chosen(Kind.FAULT, is_fit=False):
        remarks.append("no faulty record is tested: there are no results on detection")
    return remarks


def judge_study(data: ExperimentData) -> tuple[Detection, ...]:
    """Evaluate every score of every design of a stored study."""
    rules = data.experiment.detection
    return tuple(detect(design.records, design.scores, rules) for design in read_study(data))


def winner(detection: Detection, sensors: Collection[str] = ()) -> Judgement | None:
    """The best score that keeps its false-alarm rate, can be trained and needs no more than some sensors.

    Changes since an earlier record cannot be trained: a detector judges each record by itself.
    """
    for judgement in detection.judgements:
        scored = judgement.scored
        names = [scored.name] if scored.made_by is None else [*scored.made_by.of, *scored.made_by.by]
        is_change = any(name.endswith(CHANGE) for name in names)
        if judgement.keeps_its_rate and within(scored, sensors) and not is_change:
            return judgement
    return None


def detector_settings(experiment: ExperimentConfig, judgement: Judgement, rules: Rules) -> dict[str, Any]:
    """Keys of a detector that computes a judged score, with the threshold of the study."""
    made, scored = experiment.indicator_choice.made(experiment.wavelet), judgement.scored
    settings: dict[str, Any] = {
        "direction": str(judgement.direction),
        "false_alarm_rate": rules.false_alarm_rate,
        "confidence": rules.confidence,
        "threshold": rules.threshold,
        "chart": None,
        "compensate": False,
    }
    if scored.made_by is None:
        label, _, output = scored.name.partition(".")
        options = made[label].options.model_dump(mode="json")
        return settings | {"indicator": made[label].name, "options": options, "output": output}
    names = [*scored.made_by.of, *scored.made_by.by]
    used = dict.fromkeys(name.partition(".")[0] for name in names)
    indicators = stated_indicators({label: made[label] for label in used}, in_full=True)
    return settings | {"indicators": indicators, "score": scored.made_by.model_dump(mode="json")}
