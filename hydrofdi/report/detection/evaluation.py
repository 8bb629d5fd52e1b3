"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from hydrofdi.report.detection.answer import remarks_with_counts
from hydrofdi.report.detection.record import (
    conclusion,
    detection_records,
    labelled_table,
    pairs_table,
    study_record,
)
from hydrofdi.studies.healthy import Left
from hydrofdi.studies.records import Detection
from hydrofdi.tables.table import Table


@dataclass(frozen=True, eq=False, repr=False)
class EvaluationAnswer:
    """Judgements of indicators on labelled records, and the records that are left out."""

    detection: Detection
    left: Left

    @cached_property
    def scores(self) -> list[dict[str, Any]]:
        """What each score finds, the best first, as ``hydrofdi evaluate --json`` prints it."""
        return detection_records(self.detection)

    @property
    def conclusion(self) -> str:
        """Comparison of healthy groups over all scores; empty if there are fewer than two and a fault."""
        return conclusion(self.detection)

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """Remarks, and what is not stated and why; those on some of the scores have their number."""
        return remarks_with_counts(self.detection)

    @property
    def best(self) -> str:
        """Name of the best score; empty if no indicator gave a number."""
        return next((each.scored.name for each in self.detection.judgements), "")

    @cached_property
    def table(self) -> Table:
        """A row for each score and population, the best score first, with the columns of a study's CSV.

        ``indicator``, ``population`` and its ``kind``; limits of the threshold, ``threshold_low`` and
        ``threshold_high``, in the ``unit`` of the score; ``alarms`` of ``n`` records, their ``rate`` with its
        interval, ``low`` and ``high`` (NaN if there are too few records for one); the area under the ROC
        curve, ``auc``, with ``auc_low`` and ``auc_high``; ``q90_95_L_per_min``, the leak that is found nine
        times in ten; and how many records are ``not_measurable``.
        """
        return labelled_table(self.detection)

    @cached_property
    def pairs(self) -> Table:
        """A row for two healthy groups, those first that the best score tells apart best."""
        return pairs_table(self.detection)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi evaluate --json`` prints."""
        groups, rules = self.detection.records.groups, self.detection.rules
        return {
            "records": self.left.n_record,
            "rejected": self.left.n_rejected,
            "repeated": self.left.n_repeated,
            "groups": None if groups is None else sorted(set(groups)),
            "records_for_false_alarms": rules.records_for_false_alarms,
            "records_for_detection": rules.records_for_detection,
            "conclusion": self.conclusion or None,
            "detection": self.scores,
            "studies": [study_record(self.detection)],
        }

    def _told(self) -> Table:
        first = f"best score: {self.best}" if self.best else "no indicator could measure any record"
        said = (first, *filter(None, [self.conclusion]), *self.remarks, *self.left.sentences())
        return replace(self.table, notes=said)

    def __repr__(self) -> str:
        return repr(self._told())

    def _repr_html_(self) -> str:
        return self._told()._repr_html_()
