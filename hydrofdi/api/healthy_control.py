"""Healthy groups against each other, the control of a score: does it tell the fault, or the unit?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from hydrofdi.evaluation.groups import HealthyPair
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Judgement
from hydrofdi.studies.ranking import found_from

Pairs = Mapping[str, tuple[HealthyPair, ...]]
"""Name of a score → every healthy group against every other."""


def healthy_spread(pairs: Sequence[HealthyPair]) -> float:
    """The largest distance of an area of healthy groups from 1/2; NaN without any."""
    return max((abs(pair.area.value - 0.5) for pair in pairs), default=math.nan)


def stands_clear(judgement: Judgement, pairs: Sequence[HealthyPair]) -> bool | None:
    """Whether the area of some fault lies further above 1/2 than healthy groups lie from it.

    None if unknown: without two healthy groups.
    """
    if not pairs:
        return None
    areas = [level.area.value - 0.5 for level in judgement.levels if level.area is not None]
    return max(areas, default=0.0) > healthy_spread(pairs)


def ranked_by_control(judgements: Sequence[Judgement], pairs: Pairs) -> tuple[Judgement, ...]:
    """Best first: those that stand clear of their control, then as `ranked`.

    Of areas with the same two digits the one with the smaller healthy spread comes first.
    """

    def place(judgement: Judgement) -> tuple[bool, bool, float, float, float, str]:
        own = pairs[judgement.scored.name]
        area = 0.0 if math.isnan(judgement.middle_area) else judgement.middle_area
        spread = healthy_spread(own) if own else 0.0
        return (
            stands_clear(judgement, own) is False,
            judgement.keeps_its_rate is False,
            found_from(judgement),
            -round(area, 2),
            spread,
            judgement.scored.name,
        )

    return tuple(sorted(judgements, key=place))


def conclusion(judgements: Sequence[Judgement], pairs: Pairs) -> str:
    """What the control says of all scores, in one sentence; empty if there is none."""
    known = [stands_clear(each, pairs[each.scored.name]) for each in judgements if each.levels]
    known = [each for each in known if each is not None]
    n_not, n_score = known.count(False), len(known)
    if not n_score:
        return ""
    if n_not == n_score:
        return (
            "only the unit or the day was detected: in every score, healthy groups differ "
            "from each other as much as faults differ from them"
        )
    if n_not:
        return (
            f"by {n_not} of {counted(n_score, 'score')}, marked ~, healthy"
            " groups differ from each other as much as"
            " faults differ from them: what these detect may be the unit or the day"
        )
    return "by every score, a fault differs from healthy records more than healthy groups from each other"
