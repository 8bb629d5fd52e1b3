"""Scores that are made of several measured numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.populations import Kind
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.records import Channel
from hydrofdi.scoring import cross_fitted_scores, make_score, score_kind
from hydrofdi.settings.mistakes import nearest
from hydrofdi.studies.records import Scored, StudyRecords

LARGEST_CHANGE = "largest_change"
COMPENSATED = "compensated"


@dataclass(frozen=True)
class Made:
    """How a score is made.

    Attributes
    ----------
    kind : str
        A score of `hydrofdi.scoring`, or ``largest_change``: the largest fall below the healthy mean, as a
        share of it.
    of : tuple of str
        Single numbers, or labels of indicators for all of their numbers.
    by : tuple of str
        What ``compensated`` regresses on.
    """

    kind: str
    of: tuple[str, ...]
    by: tuple[str, ...] = ()


def learned_scores(
    records: StudyRecords, scores: Sequence[Scored], chosen: Mapping[str, Made]
) -> Iterator[Scored]:
    """Scores of all records, learned on fit records alone.

    Fit records are scored by models that saw neither them nor their group, so that thresholds can be set on
    them. Of several numbers, each is compensated by itself.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
    chosen : mapping of str to Made
        Label → what is made.

    Raises
    ------
    ConfigError
        A number is not among the scores, or the extra is not installed.
    """
    for label, made in chosen.items():
        features, proxies = (_found(scores, names, label) for names in (made.of, made.by))
        if made.kind != COMPENSATED:
            yield _score(records, label, made.kind, features)
            continue
        for feature in features:
            name = label if len(features) == 1 else f"{label}({feature.name})"
            yield _score(records, name, made.kind, [feature, *proxies])


def _found(scores: Sequence[Scored], names: Sequence[str], label: str) -> list[Scored]:
    """The numbers of some names, each once, in the order of the names."""
    found: dict[str, Scored] = {}
    for name in names:
        own = [each for each in scores if each.name == name or each.name.startswith((f"{name}.", f"{name}["))]
        if not own:
            known = [each.name for each in scores]
            raise ConfigError(f"scores: {label}: {name!r} is not measured{nearest(name, known)}")
        found |= {each.name: each for each in own}
    return list(found.values())


def _score(records: StudyRecords, label: str, kind: str, features: Sequence[Scored]) -> Scored:
    values = np.stack([feature.values for feature in features], axis=1)
    healthy, faulty = _fit_rows(records, Kind.HEALTHY), _fit_rows(records, Kind.FAULT)
    used = {channel for feature in features for channel in feature.channels}
    note = f"{kind} of {len(features)} numbers, learned on fit records"
    direction = Direction.RISING if kind == LARGEST_CHANGE else score_kind(kind).direction
    try:
        if kind == LARGEST_CHANGE:
            found = _largest_fall(values, healthy)
        else:
            found = cross_fitted_scores(
                make_score(kind), values, faulty, records.groups, is_fit=healthy | faulty
            )
    except NotStatedError as refusal:
        found, note = np.full(len(values), np.nan), str(refusal)
    return Scored(
        label,
        found,
        tuple(channel.value for channel in Channel if channel.value in used),
        "%" if kind == LARGEST_CHANGE else features[0].unit if kind == COMPENSATED else "1",
        f"{kind} of {', '.join(feature.name for feature in features[:3])}{' …' * (len(features) > 3)}",
        direction,
        _cost(features),
        note,
    )


def _fit_rows(records: StudyRecords, kind: Kind) -> np.ndarray:
    numbers = [records.populations.index(each) for each in records.chosen(kind, is_fit=True)]
    return np.isin(records.of_record, numbers)


def _largest_fall(values: Array, healthy: np.ndarray) -> Array:
    """How far the feature that fell most lies below its mean over healthy fit records [%].

    The rule of "the largest positive sensitivity": Maddahi et al., CDSR 2015, paper 181.
    """
    known = values[healthy][np.isfinite(values[healthy]).all(axis=1)]
    if not known.size or not known.mean(axis=0).all():
        raise NotStatedError("no healthy fit record has all numbers, or one of them is zero on average")
    means = known.mean(axis=0)
    return np.asarray(100.0 * np.max((means - values) / means, axis=1))


def _cost(features: Sequence[Scored]) -> float | None:
    """CPU time of the indicators of the features, each once [s]; None where one was not measured."""
    costs = {feature.name.partition(".")[0]: feature.cost for feature in features}
    known = [cost for cost in costs.values() if cost is not None]
    return sum(known) if len(known) == len(costs) else None
