"""What an evaluation of indicators on labelled records says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from hydrofdi.evaluation.scores import Kind, comparable
from hydrofdi.report.detection.record import detection_lines, detection_records, study_record
from hydrofdi.report.detection.sections import remarks_with_counts
from hydrofdi.report.detection.wording import FROM_LEVELS, severity_unit
from hydrofdi.settings.messages import HOLE, counted, number_text, percentage
from hydrofdi.studies.healthy import Left
from hydrofdi.studies.records import LEAST_OF_GROUP, Detection
from hydrofdi.tables.answer import Answer, Piece, Strong
from hydrofdi.tables.table import Column, Table, group_breaks

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


_MOST_ROWS = 20
"""Most scores, and pairs of groups, that are shown."""


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation(Answer):
    """Evaluation of indicators on labelled records, as `hydrofdi.evaluate` returns it.

    Attributes
    ----------
    detection : Detection
        Judgements and the records that they rest on; scores that stand clear of their healthy control come
        first.
    left : Left
        Records that are left out.
    """

    detection: Detection
    left: Left

    @cached_property
    def scores(self) -> list[dict[str, Any]]:
        """What each score finds, the best first, as ``hydrofdi evaluate --json`` prints it."""
        return detection_records(self.detection)

    @property
    def conclusion(self) -> str:
        """Comparison of healthy groups over all scores; empty if there are fewer than two and a fault."""
        judgements = [judgement for judgement in self.detection.judgements if judgement.levels]
        known = [judgement.stands_clear for judgement in judgements if judgement.stands_clear is not None]
        n_not, n_score = known.count(False), len(known)
        if not judgements and self.detection.judgements:
            return "no record is labelled faulty, so no detection can be stated"
        if not n_score and not any(judgement.healthy_pairs for judgement in self.detection.judgements):
            return ""
        if not n_score:
            few = f"fewer than two healthy groups have {LEAST_OF_GROUP} records"
            return f"{few}: whether only the unit or the day was detected cannot be told"
        if not n_not:
            return "in every score, faults differ more from healthy records than healthy groups do"
        return (
            f"{'only' if n_not == n_score else 'perhaps only'} the unit or the day was detected: in"
            f" {n_not} of {counted(n_score, 'score')}, marked ~, healthy groups differ from each other"
            " as much as faults differ from them"
        )

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """Remarks, and what is not stated and why; those on some of the scores have their number."""
        return remarks_with_counts(self.detection)

    @property
    def best(self) -> str:
        """Name of the best score; empty if none was tested on faulty records."""
        return next((judgement.name for judgement in self.detection.judgements if judgement.levels), "")

    @cached_property
    def table(self) -> Table:
        """A row for each score and population, the best score first, with the columns of a study's CSV.

        ``indicator``, ``population`` and its ``kind``; limits of the threshold, ``threshold_low`` and
        ``threshold_high``, in the ``unit`` of the score; ``alarms`` of ``n`` records, their ``rate`` with its
        interval, ``low`` and ``high`` (NaN if there are too few records for one); the area under the ROC
        curve, ``auc``, with ``auc_low`` and ``auc_high``; ``q90_95_L_per_min``, the leak that is found nine
        times in ten; and how many records are ``not_measurable``.
        """
        unit = severity_unit(self.detection)
        by_name = {judgement.name: judgement for judgement in self.detection.judgements}
        bound = f"q90_95{unit.suffix}"
        titles = {
            "indicator": "score",
            "population": "population",
            "alarms": "alarms",
            "auc": "AUC",
            bound: f"q90/95{unit.bracket}",
            "not_measurable": "without a number",
        }

        def text_of(line: dict[str, Any], name: str) -> str:
            judgement = by_name[line["indicator"]]
            if name == "indicator":
                return f"{'~ ' if judgement.stands_clear is False else ''}{line[name]}"
            if name == "alarms" and line["n"] is not None:
                ends = [percentage(line[end]) for end in ("rate", "low", "high") if line[end] is not None]
                share = ", {} % [{}, {}]".format(*ends) if len(ends) == 3 else ""
                return f"{line['alarms']} of {line['n']}{share}"
            if name == "auc" and line["kind"] == Kind.HEALTHY and (areas := judgement.healthy_areas):
                return f"{min(areas):.2f} … {max(areas):.2f}"
            if name == "auc" and line["auc"] is not None:
                return _area_text(line["auc"], line["auc_low"], line["auc_high"])
            if name == bound and line["kind"] == Kind.FAULT:
                return unit.found(judgement.bound).removesuffix(FROM_LEVELS)
            return str(line[name]) if name in ("population", "not_measurable") and line[name] else HOLE

        lines = [line for line in detection_lines([self.detection]) if "population" in line]
        columns = []
        for name in [*titles, *(each for each in (lines[0] if lines else ()) if each not in titles)]:
            texts = [text_of(line, name) for line in lines]
            column = Column(name, [line[name] for line in lines], title=titles.get(name, ""), text=texts)
            is_text, is_shown = name in ("indicator", "population"), name in titles and {*texts} != {HOLE}
            columns.append(replace(column, is_text=is_text, is_shown=is_shown))
        breaks = group_breaks([line["indicator"] for line in lines])
        return Table(tuple(columns), n_lead=2, breaks=breaks if len(lines) > 2 * len(by_name) else ())

    @cached_property
    def pairs(self) -> Table:
        """A row for two healthy groups, those first that the best score tells apart best.

        The threshold of ``fit_group`` is tested on ``test_group``.
        """
        pairs = [pair for best in self.detection.judgements[:1] for pair in best.healthy_pairs]
        pairs.sort(key=lambda pair: -abs(comparable(pair.area.value - 0.5)))
        areas, rates = [pair.area for pair in pairs], [pair.rate for pair in pairs]
        texts = [_area_text(area.value, area.low, area.high) for area in areas]
        return Table(
            (
                Column("fit_group", [pair.fit_group for pair in pairs], title="threshold of", is_text=True),
                Column("test_group", [pair.test_group for pair in pairs], title="tested", is_text=True),
                Column("auc", [area.value for area in areas], title="AUC", text=texts),
                Column("auc_low", [area.low for area in areas], is_shown=False),
                Column("auc_high", [area.high for area in areas], is_shown=False),
                Column("alarms", [r and r.count for r in rates], title="false alarms"),
                Column("n", [r and r.total for r in rates], title="of"),
            ),
            title=f"Healthy groups against each other by {self.best}: none of them leaks",
            n_lead=2,
        )

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

    def parts(self) -> Iterator[Piece]:
        """The conclusion from healthy groups, the scores (best first), and what is not stated, and why."""
        records, conclusion = self.detection.records, self.conclusion
        counts = ", ".join(f"{records.rows(each).size:,} {each.name}" for each in records.populations)
        n_group = len(set(records.groups or ()))
        yield f"Records: {counts}; {counted(n_group, 'group') if n_group else 'no groups'}"
        if not self.best:
            yield "no indicator could measure any record"
            return
        if conclusion:
            yield Strong(f"{conclusion[0].upper()}{conclusion[1:]}.")
        yield from ("", replace(self.table, most=_MOST_ROWS * len(records.populations)))
        if len(self.pairs):
            yield from ("", replace(self.pairs, most=_MOST_ROWS))
        yield ""
        yield from (f"- {sentence}" for sentence in self.remarks)

    def asides(self) -> Iterator[str]:
        """What is left out."""
        yield from self.left.sentences()
        yield from self.left.unmeasured()

    def __bool__(self) -> bool:
        return not (self.left.is_lacking or self.left.n_repeated)

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame."""
        return self.table.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The `table` as a dataset."""
        return self.table.to_xarray()

    def plot(self, figure: str = "densities") -> Figure:
        """The best scores of all records with the limits, or another figure of a study by its name.

        Parameters
        ----------
        figure : str
            ``densities``, ``roc``, ``false_alarms``; with known leaks also ``answer``, ``ranking``, ``pod``.

        Raises
        ------
        ReportError
            There is no such figure, or the records do not suffice for it.
        """
        from hydrofdi.report.detection.report import DetectionReport
        from hydrofdi.report.figures import draw_figure

        return draw_figure(DetectionReport((self.detection,)), figure)


def _area_text(value: float, low: float, high: float) -> str:
    return f"{number_text(value, 2)} [{number_text(low, 2)}, {number_text(high, 2)}]"
