"""Ranking of scores, and their Pareto set over channels."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hydrofdi.studies.judgement import Judgement

_RANK_BY_RATE = {True: 0, None: 1, False: 2}


def ranked(judgements: Sequence[Judgement]) -> tuple[Judgement, ...]:
    """Rank scores by q90/95, best first; scores that exceed their false-alarm rate come last.

    Ties are resolved by fewer channels. Scores without a q90/95 are ranked by the detection rate at the
    largest level, then by the area at the middle level.

    A score that always alarms detects every leak, so scores that exceed their rate come last, after those for
    which this is unknown.
    """
    return tuple(sorted(judgements, key=_place))


def _place(judgement: Judgement) -> tuple[int, float, float, float, str]:
    area, found = judgement.middle_area, found_from(judgement)
    suspicion = 0.0 if math.isnan(area) else area
    second = float(len(judgement.scored.channels)) if math.isfinite(found) else -_largest_rate(judgement)
    kept = _RANK_BY_RATE[judgement.keeps_its_rate]
    return kept, found, second, -suspicion, judgement.scored.name


def _largest_rate(judgement: Judgement) -> float:
    """Detection rate at the largest level; 0 if there is none."""
    rates = [level.detected.value for level in judgement.levels[-1:] if level.detected is not None]
    return rates[0] if rates and math.isfinite(rates[0]) else 0.0


def found_from(judgement: Judgement) -> float:
    """q90/95 [unit of the severity]; infinite if no tested severity is detected or it is refused."""
    bound = judgement.smallest.get("q90_95")
    value = None if bound is None else bound.value
    return math.inf if value is None else value


def pareto_set(judgements: Sequence[Judgement]) -> frozenset[str]:
    """Names of the Pareto-optimal scores in channels and q90/95.

    A score dominates another if its channels are a subset, its q90/95 is not larger, and one of the two is
    strictly better. Only scores that meet their false-alarm rate, have a q90/95 and declare their channels
    are included.
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
