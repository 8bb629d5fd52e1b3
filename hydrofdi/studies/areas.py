"""Areas under the ROC curves of a study."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction, suspicion
from hydrofdi.evaluation.grouped_area import FEWEST_GROUPS, MANY_GROUPS, clustered_area, grouped_area
from hydrofdi.evaluation.roc import Area, area_under_curve, roc_curve
from hydrofdi.evaluation.scores import Array
from hydrofdi.studies.parts import Notes, Part
from hydrofdi.studies.rules import Rules


@dataclass(frozen=True, eq=False)
class Suspicion:
    """Transformation of scores so that larger is more suspicious, and the healthy records for comparison.

    Attributes
    ----------
    healthy : Part
    direction : Direction
    centre : float
        Healthy reference value for both directions: the median of the fit records.
    rules : Rules
    """

    healthy: Part
    direction: Direction
    centre: float
    rules: Rules

    def of(self, part: Part) -> Array:
        """Transformed scores, larger is more suspicious, shape (n_record,)."""
        return suspicion(part.scores, self.direction, self.centre)

    def area(self, faulty: Part, notes: Notes) -> Area | None:
        """Area under the ROC curve against the healthy records.

        Its interval is over groups if there are enough of them.
        """
        healthy, confidence = self.healthy, self.rules.confidence
        if not (np.isfinite(self.centre) and faulty.scores.size):
            return None
        if healthy.groups is not None and faulty.groups is not None:
            groups = healthy.groups, faulty.groups
            n_group = len({*healthy.groups, *faulty.groups})
            if n_group >= FEWEST_GROUPS:
                over_groups = clustered_area if n_group >= MANY_GROUPS else grouped_area
                return notes.unless_refused(
                    lambda: over_groups(self.of(healthy), self.of(faulty), *groups, confidence=confidence)
                )
            notes.remarks.append(
                f"fewer than {FEWEST_GROUPS} groups: intervals of areas assume independent records, and are"
                " too short"
            )
        return notes.unless_refused(
            lambda: area_under_curve(self.of(healthy), self.of(faulty), confidence=confidence)
        )

    def partial_area(self, faulty: Part) -> float:
        """Scaled partial area up to the false-alarm rate; NaN without scores of both kinds."""
        if not np.isfinite(self.centre):
            return math.nan
        try:
            curve = roc_curve(self.of(self.healthy), self.of(faulty))
        except NotStatedError:
            return math.nan
        return curve.partial_area(self.rules.false_alarm_rate)


def suspicion_from(fit: Part, healthy: Part, direction: Direction, rules: Rules) -> Suspicion:
    """`Suspicion` defined by the healthy fit records."""
    known = fit.scores[~np.isnan(fit.scores)]
    return Suspicion(healthy, direction, float(np.median(known)) if known.size else math.nan, rules)
