"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api.evaluation_tables import evaluation_record, pairs_table, scores_table
from hydrofdi.api.measuring import Counted
from hydrofdi.api.notebook import html_sentences, shown
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.evaluation.rates import HealthyPair
from hydrofdi.indicators.record_measures import RecordMeasures
from hydrofdi.report.detection.answer import remarks_with_counts
from hydrofdi.report.table import Table
from hydrofdi.settings.counting import counted
from hydrofdi.settings.messages import Guessable, nearest
from hydrofdi.studies.judgement import Detection

if TYPE_CHECKING:
    import pandas
    import xarray

    from hydrofdi.report.figures import Figure


@dataclass
class Left(Counted):
    """Records that are not evaluated: also repeats of another, and those without a label."""

    n_repeated: int = 0
    n_unlabelled: int = 0
    first_repeat: str = ""
    labels: set[str] = field(default_factory=set)
    _seen: dict[bytes, RecordMeasures] = field(default_factory=dict)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, without those that repeat the samples of another.

        Raises
        ------
        ConfigError
            Records with the same samples have different labels.
        """
        for record in super().count(records):
            self.labels |= {record.label} - {""}
            if record.has_numbers and self._is_repeat(record):
                continue
            self.n_unlabelled += not (record.is_rejected or record.label)
            yield record

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records that are left out."""
        yield from super().sentences()
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_repeated:
            yield f"left out: {self.n_repeated:,} {of} have the samples of another, e.g. {self.first_repeat}"
        if self.n_unlabelled:
            yield f"without a label, left out: {self.n_unlabelled:,} {of}"

    def _is_repeat(self, record: RecordMeasures) -> bool:
        first = self._seen.setdefault(record.digest, record)
        if first is record:
            return False
        if record.label and first.label and record.label != first.label:
            raise ConfigError(
                f"{first.record_id} ({first.label}) and {record.record_id} ({record.label}) have the same"
                " samples; one of the labels is wrong"
            )
        self.n_repeated += 1
        self.first_repeat = self.first_repeat or f"{record.record_id} repeats {first.record_id}"
        return True


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation(Guessable):
    """Evaluation of indicators on labelled records, as `hydrofdi.evaluate` returns it.

    Attributes
    ----------
    detection : Detection
        Judgements and the records that they rest on; scores that stand clear of their healthy control come
        first.
    healthy_pairs : mapping of str to tuple of HealthyPair
        Name of a score → every healthy group against every other; empty if there are no two.
    left : Left
    conclusion : str
        Comparison of healthy groups over all scores; empty if there are fewer than two.
    """

    detection: Detection
    healthy_pairs: Mapping[str, tuple[HealthyPair, ...]]
    left: Left
    conclusion: str

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
        return scores_table(self)

    @cached_property
    def pairs(self) -> Table:
        """A row for two healthy groups, those first that the best score tells apart best.

        The threshold of ``fit_group`` is tested on ``test_group``: false ``alarms`` of ``n``, and the area
        under the ROC curve, ``auc``, with ``auc_low`` and ``auc_high``. If no alarms are counted, both groups
        are listed once, and the second reads higher.
        """
        return pairs_table(self)

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame."""
        return self.table.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The `table` as a dataset."""
        return self.table.to_xarray()

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi evaluate --json`` prints."""
        return evaluation_record(self)

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
        return [first, *filter(None, [self.conclusion]), *self.remarks, *self.left.sentences()]

    def __repr__(self) -> str:
        return "\n".join([repr(self.table), *self._sentences()])

    def _repr_html_(self) -> str:
        return html_sentences("Evaluation", self._sentences()) + self.table._repr_html_()
