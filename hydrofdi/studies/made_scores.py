"""Combined scores of a study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.registry import make_score
from hydrofdi.detectors.scores.configuration import ScoreConfig, combined_numbers
from hydrofdi.detectors.scores.contract import Score
from hydrofdi.detectors.scores.cross_fitting import cross_fitted_scores, known_numbers
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.populations import Kind
from hydrofdi.records import Channel
from hydrofdi.studies.records import Scored, StudyRecords

_DETAILS = tuple(f"dwt.d{level}" for level in range(1, 6))


def usual_scores(
    records: StudyRecords, scores: Sequence[Scored], *, tested_teach: bool = False
) -> dict[str, ScoreConfig]:
    """Default scores: for every set of sensors, a score of all numbers that these sensors give.

    ``mahalanobis`` from healthy fit records, and ``lda`` if there are faulty fit records; in addition the
    rule of the paper, the largest fall of d1 … d5.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
    tested_teach : bool
        Whether faulty test records may be used for training, as in `made_scores`.
    """
    teachers = records.chosen(Kind.FAULT, is_fit=True)
    if tested_teach:
        teachers += records.chosen(Kind.FAULT, is_fit=False)
    kinds = ["mahalanobis", *(["lda"] if teachers else [])]
    made: dict[str, ScoreConfig] = {}
    for sensors in dict.fromkeys(each.channels for each in scores if each.channels):
        names = [each.name for each in scores if each.channels and set(each.channels) <= set(sensors)]
        if len(names) > 1:
            title = " ".join(Channel(channel).symbol for channel in sensors)
            made |= {
                f"{kind}({title})": ScoreConfig.model_validate({"kind": kind, "of": names}) for kind in kinds
            }
    details = [each.name for each in scores if each.name in _DETAILS]
    if len(details) == len(_DETAILS):
        made["largest_change(d1 … d5)"] = ScoreConfig(kind="largest_change", of=details)
    return made


_TRAINING = (Kind.HEALTHY, Kind.FAULT)


def made_scores(
    records: StudyRecords,
    measured: Sequence[Scored],
    wanted: Mapping[str, ScoreConfig],
    *,
    tested_teach: bool = False,
) -> Iterator[Scored]:
    """Make the scores of a study, cross-fitted over its fit records.

    Fit records are scored by models that were not trained on their group, the others by the model of all fit
    records. ``compensated`` gives one score for each of its numbers. If the fit records do not support a
    score, it has no values, and its note says why.

    Parameters
    ----------
    records : StudyRecords
    measured : sequence of Scored
        Numbers that the scores combine.
    wanted : mapping of str to ScoreConfig
        Label → configuration of the score.
    tested_teach : bool
        Whether faulty test records are used to train scores that need faulty records, because there are no
        others. Each is then scored by a model that was not trained on its group, so groups are required.

    Raises
    ------
    ConfigError
        A number is not measured, or the extra of a score is not installed.
    """
    for label, config in wanted.items():
        score, known = make_score(config.kind, config.options), {each.name: each for each in measured}
        combined = combined_numbers(config, [*known], label)
        for names in combined:
            numbers = [known[name] for name in names]
            name = label if len(combined) == 1 else f"{label}.{names[0]}"
            found = _made(records, name, score, numbers, tested_teach)
            if config.kind == "compensated":
                found = replace(found, unit=numbers[0].unit, direction=numbers[0].direction)
            yield replace(found, made_by=config.model_copy(update={"of": names[:1]}) if config.by else config)


def _made(
    records: StudyRecords, name: str, score: Score[Any], numbers: Sequence[Scored], tested_teach: bool
) -> Scored:
    population = [records.populations[each] for each in records.of_record]
    is_faulty = np.array([each.kind is Kind.FAULT for each in population])
    is_fit = np.array([each.is_fit and each.kind in _TRAINING for each in population])
    is_shared = tested_teach and score.needs_faulty
    is_fit |= is_shared & is_faulty
    learning = is_fit & (score.needs_faulty | ~is_faulty)
    values = np.stack([each.values for each in numbers], axis=1)
    kept = [numbers[place] for place in known_numbers(values[learning])]
    left_out = [
        f"{each.name} is left out: too many fit records lack it." for each in numbers if each not in kept
    ]
    notes = [score.caution, *left_out]
    try:
        if is_shared:
            _refuse_few_groups(score.name, records.groups, is_faulty, is_fit)
        if not kept:
            raise NotStatedError("no number is measured in at least 90 % of the fit records")
        values = np.stack([each.values for each in kept], axis=1)
        scores = cross_fitted_scores(score, values, is_faulty, records.groups, is_fit=is_fit)
    except NotStatedError as refusal:
        scores, notes = np.full(is_fit.size, np.nan), [f"{refusal}.", *left_out]
    used = {channel for each in kept for channel in each.channels}
    return Scored(
        name,
        scores,
        tuple(channel.value for channel in Channel if channel.value in used),
        long_name=score.summary,
        direction=score.direction,
        cost=_cost(kept),
        note=" ".join(notes),
    )


def _refuse_few_groups(
    name: str, groups: Sequence[str] | None, is_faulty: NDArray[np.bool_], is_fit: NDArray[np.bool_]
) -> None:
    """Refuse to train on test records if groups do not allow cross-fitting."""
    why = f"the score {name} is cross-fitted on test records"
    if groups is None:
        raise NotStatedError(f"{why}: it needs groups, and no record has one")
    for kind, own in (("healthy", ~is_faulty), ("faulty", is_faulty)):
        n_group = len({groups[row] for row in np.flatnonzero(is_fit & own).tolist()})
        if n_group < 2:
            raise NotStatedError(f"{why}: it needs at least two groups with {kind} records, not {n_group}", 2)


def _cost(numbers: Sequence[Scored]) -> float | None:
    """Total cost of the indicators, each once; None if one was not measured."""
    costs = {each.name.partition(".")[0]: each.cost for each in numbers}
    known = [cost for cost in costs.values() if cost is not None]
    return sum(known) if len(known) == len(costs) else None
