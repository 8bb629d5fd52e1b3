"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api import evaluate_records as evaluating
from hydrofdi.api.evaluation_record import evaluation_record
from hydrofdi.api.figures import shown
from hydrofdi.api.healthy_control import stands_clear
from hydrofdi.api.page import html_sentences
from hydrofdi.api.table import Table
from hydrofdi.errors import ReportError
from hydrofdi.report.detection.caveats import remarks_with_counts
from hydrofdi.settings.counting import counted
from hydrofdi.settings.suggestions import nearest
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.studies.parts import records_without_number

if TYPE_CHECKING:
    import pandas
    import xarray

    from hydrofdi.evaluation.groups import HealthyPair
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

    def healthy_pairs(self, judgement: Judgement) -> Sequence[HealthyPair]:
        """Every healthy group against every other by a score; empty if there are fewer than two."""
        return self.found.healthy_pairs[judgement.scored.name]

    def stands_clear(self, judgement: Judgement) -> bool | None:
        """Whether some fault differs from healthy records more than healthy groups from each other.

        None if there are fewer than two healthy groups.
        """
        return stands_clear(judgement, self.healthy_pairs(judgement))

    def without_number(self, judgement: Judgement) -> dict[str, int]:
        """Population → number of its records without this score."""
        return records_without_number(self.detection.records, judgement.scored)

    @cached_property
    def table(self) -> Table:
        """A row for each score and population, the best score first.

        ``score``, ``population`` and its ``kind``; limits of the threshold, ``low`` and ``high``, in the
        ``unit`` of the score; ``alarms`` of ``n`` records, their ``rate`` with its interval, ``rate_low`` and
        ``rate_high`` (NaN if there are too few records for one); the area under the ROC curve, ``auc``,
        with ``auc_low`` and ``auc_high``; and ``q90_95``, the leak that is found nine times in ten [m³/s].
        """
        rows = [row for judgement in self.detection.judgements for row in _rows(judgement)]
        return Table("row", {name: [row[name] for row in rows] for name in _COLUMNS}, {"q90_95": "m^3/s"})

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


_COLUMNS = (
    "score", "population", "kind", "unit", "low", "high", "alarms", "n", "rate", "rate_low", "rate_high",
    "auc", "auc_low", "auc_high", "q90_95",
)  # fmt: skip


def _rows(judgement: Judgement) -> Iterator[Mapping[str, Any]]:
    areas = {level.population: level.area for level in judgement.levels}
    rates = {**judgement.false_alarms, **{each.population: each.detected for each in judgement.levels}}
    limits, smallest = judgement.threshold, judgement.smallest.get("q90_95")
    for population, rate in rates.items():
        area, is_stated = areas.get(population), rate is not None and population not in judgement.counted
        yield dict.fromkeys(_COLUMNS) | {
            "score": judgement.scored.name,
            "population": population.name,
            "kind": population.kind.value,
            "unit": judgement.scored.unit,
            "low": None if limits is None else limits.low,
            "high": None if limits is None else limits.high,
            "alarms": None if rate is None else rate.count,
            "n": None if rate is None else rate.total,
            "rate": rate.value if rate is not None and is_stated else None,
            "rate_low": rate.low if rate is not None and is_stated else None,
            "rate_high": rate.high if rate is not None and is_stated else None,
            "auc": None if area is None else area.value,
            "auc_low": None if area is None else area.low,
            "auc_high": None if area is None else area.high,
            "q90_95": None if smallest is None else smallest.value,
        }
