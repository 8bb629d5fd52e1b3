"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api import evaluate_records as evaluating
from hydrofdi.api.evaluation_tables import evaluation_record, pairs_table, scores_table
from hydrofdi.api.figures import shown
from hydrofdi.api.page import html_sentences
from hydrofdi.errors import ReportError
from hydrofdi.report.detection.caveats import remarks_with_counts
from hydrofdi.report.table import Table
from hydrofdi.settings.counting import counted
from hydrofdi.settings.messages import nearest
from hydrofdi.studies.judgement import Detection

if TYPE_CHECKING:
    import pandas
    import xarray

    from hydrofdi.report.figures import Figure


class Evaluation:
    """Evaluation of indicators on labelled records, as `hydrofdi.evaluate` returns it.

    Attributes
    ----------
    found : evaluate_records.Evaluation
        Judgements, healthy groups against each other, and what was left out, in SI.
    """

    def __init__(self, found: evaluating.Evaluation) -> None:
        self.found = found

    @property
    def detection(self) -> Detection:
        """Judgements, the best first, and the records that they rest on."""
        return self.found.detection

    @property
    def conclusion(self) -> str:
        """Comparison of healthy groups over all scores; empty if there are fewer than two."""
        return self.found.conclusion

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
        """A row for each score and population, the best score first.

        ``score``, ``population`` and its ``kind``; limits of the threshold, ``low`` and ``high``, in the
        ``unit`` of the score; ``alarms`` of ``n`` records, their ``rate`` with its interval, ``rate_low`` and
        ``rate_high`` (NaN if there are too few records for one); the area under the ROC curve, ``auc``,
        with ``auc_low`` and ``auc_high``; ``q90_95``, the leak that is found nine times in ten [m³/s]; and
        how many records are ``without_number``.
        """
        return scores_table(self.found)

    @cached_property
    def pairs(self) -> Table:
        """A row for two healthy groups, those first that the best score tells apart best.

        The threshold of ``fit_group`` is tested on ``test_group``: false ``alarms`` of ``n``, and the area
        under the ROC curve, ``auc``, with ``auc_low`` and ``auc_high``. If no alarms are counted, both groups
        are listed once, and the second reads higher.
        """
        return pairs_table(self.found)

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame."""
        return self.table.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The `table` as a dataset."""
        return self.table.to_xarray()

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi evaluate --json`` prints."""
        return evaluation_record(self.found)

    def plot(self, figure: str = "densities") -> Figure:
        """The best scores of all records with the limits, or another figure of a study by its name.

        Parameters
        ----------
        figure : str
            ``densities``, ``roc``, ``false_alarms``; with known leaks also ``answer``, ``ranking``, ``pod``
            and ``det``.

        Raises
        ------
        ReportError
            There is no such figure, or the records do not suffice for it.
        """
        from hydrofdi.report.detection.report import DetectionReport
        from hydrofdi.report.figures import draw_figure

        report = DetectionReport("evaluation", Path(), (self.detection,))
        known = [*report.figures()]
        if figure not in known:
            raise ReportError(f"no figure {figure!r}{nearest(figure, known)}")
        return shown(draw_figure(report, figure))

    def _sentences(self) -> list[str]:
        first = f"best score: {self.best}" if self.best else "no indicator could measure any record"
        left = self.found.left
        without = f"without a label, left out: {left.n_unlabelled:,} of {counted(left.n_record, 'record')}"
        unlabelled = [without] if left.n_unlabelled else []
        return [first, *filter(None, [self.conclusion]), *self.remarks, *unlabelled]

    def __repr__(self) -> str:
        return "\n".join([repr(self.table), *self._sentences()])

    def _repr_html_(self) -> str:
        return html_sentences("Evaluation", self._sentences()) + self.table._repr_html_()
