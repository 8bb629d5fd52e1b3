"""Judgements side by side: which score is best, and which is worth its channels."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hydrofdi.studies.judgement import Judgement

_RANK_OF_KEEPING = {True: 0, None: 1, False: 2}


def ranked(judgements: Sequence[Judgement]) -> tuple[Judgement, ...]:
    """Best first: those not shown to exceed their false-alarm rate, by q90/95.

    Of equal ones first that with fewer channels. Where nothing is found, by the rate of detection at the
    largest level; then by the area at the middle level.

    A score that alarms on anything finds every leak, so those that do not keep their rate come last, after
    those of which it is not known.
    """
    return tuple(sorted(judgements, key=_place))


def _place(judgement: Judgement) -> tuple[int, float, float, float, str]:
    area, found = judgement.middle_area, found_from(judgement)
    suspicion = 0.0 if math.isnan(area) else area
    second = float(len(judgement.scored.channels)) if math.isfinite(found) else -_largest_rate(judgement)
    kept = _RANK_OF_KEEPING[judgement.keeps_its_rate]
    return kept, found, second, -suspicion, judgement.scored.name


def _largest_rate(judgement: Judgement) -> float:
    """The rate of detection at the largest level; 0 without."""
    rates = [level.detected.value for level in judgement.levels[-1:] if level.detected is not None]
    return rates[0] if rates and math.isfinite(rates[0]) else 0.0


def found_from(judgement: Judgement) -> float:
    """q90/95 [unit of the severity]; infinite if nothing tested is found, or it is not stated."""
    bound = judgement.smallest.get("q90_95")
    value = None if bound is None else bound.value
    return math.inf if value is None else value


def pareto_set(judgements: Sequence[Judgement]) -> frozenset[str]:
    """Names of the scores for which no other finds as small faults with the same channels or fewer.

    Another dominates where its channels are among those of the score, its q90/95 is no larger, and one of
    the two is better. Only scores that keep their false-alarm rate, have a q90/95 and say what they need
    take part.
    """
    able = [
        (judgement.scored.name, frozenset(judgement.scored.channels), found_from(judgement))
        for judgement in judgements
        if judgement.keeps_its_rate and judgement.scored.channels and math.isfinite(found_from(judgement))
    ]
    return frozenset(
        name
        for name, channels, found in able
        if not any(
            others <= channels and other <= found and (others < channels or other < found)
            for _, others, other in able
        )
    )
