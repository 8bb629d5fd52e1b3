"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api.arguments import Names, Texts, names_of
from hydrofdi.api.detectors.healthy_records import labels_of_healthy
from hydrofdi.api.measuring import Counted, Indicators, indicators_of
from hydrofdi.api.sources import Described, open_records
from hydrofdi.detectors.rules import Rules
from hydrofdi.detectors.scores.configuration import load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.faults import summaries
from hydrofdi.indicators.measuring import RecordMeasures, measure_sources, used_channels
from hydrofdi.indicators.selection import assumed_plants, of_machine
from hydrofdi.records.copies import Copies, pairs
from hydrofdi.records.source import HeldSource, MeasuredSource
from hydrofdi.report.detection.answer import remarks_with_counts
from hydrofdi.report.detection.labelled import conclusion, labelled_table, pairs_table
from hydrofdi.report.detection.record import detection_records, study_record
from hydrofdi.settings.messages import counted
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Source
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.measured import measured_study, require_labels
from hydrofdi.studies.reading import made_scores
from hydrofdi.studies.reading import usual_scores as usual_of
from hydrofdi.studies.records import Detection
from hydrofdi.tables.table import Table

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


@dataclass
class Left(Counted):
    """Records that are not evaluated: also repeats of another, and those without a label."""

    n_repeated: int = 0
    n_unlabelled: int = 0
    repeats: list[str] = field(default_factory=list)
    labels: set[str] = field(default_factory=set)
    _copies: Copies = field(default_factory=Copies)
    _firsts: list[RecordMeasures] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, without those that repeat the samples of another."""
        for record in super().count(records):
            self.labels |= {record.label} - {""}
            if record.has_numbers and self._is_repeat(record):
                continue
            self.n_unlabelled += not (record.is_rejected or record.label)
            yield replace(record, sketch=None)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records that are left out."""
        yield from super().sentences()
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_repeated:
            yield f"left out: {self.n_repeated:,} {of} have the samples of another: {pairs(self.repeats)}"
        if self.n_unlabelled:
            yield f"without a label, left out: {self.n_unlabelled:,} {of}"

    def _is_repeat(self, record: RecordMeasures) -> bool:
        if record.sketch is None:
            return False
        number = self._copies.find(record.sketch)
        if number is None:
            self._firsts.append(replace(record, values={}))
            return False
        first = self._firsts[number]
        if record.label and first.label and record.label != first.label:
            if first.sketch is None or record.sketch.digest != first.sketch.digest:
                return False  # a fault may have been made of a healthy record
            raise ConfigError(
                f"{first.record_id} ({first.label}) and {record.record_id} ({record.label}) have the same"
                " samples; one of the labels is wrong"
            )
        self.n_repeated += 1
        self.repeats.append(f"{record.record_id} repeats {first.record_id}")
        return True


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation:
    """Evaluation of indicators on labelled records, as `hydrofdi.evaluate` returns it.

    Attributes
    ----------
    detection : Detection
        Judgements and the records that they rest on; scores that stand clear of their healthy control come
        first.
    left : Left
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

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame."""
        return self.table.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The `table` as a dataset."""
        return self.table.to_xarray()

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

        return draw_figure(DetectionReport("evaluation", Path(), (self.detection,)), figure)

    def _told(self) -> Table:
        first = f"best score: {self.best}" if self.best else "no indicator could measure any record"
        said = (first, *filter(None, [self.conclusion]), *self.remarks, *self.left.sentences())
        return replace(self.table, notes=said)

    def __repr__(self) -> str:
        return repr(self._told())

    def _repr_html_(self) -> str:
        return self._told()._repr_html_()


def evaluate(
    data: Any,
    indicators: Indicators = "dwt",
    *,
    healthy: str | int | Sequence[str | int] = (),
    false_alarm_rate: str | float = "1 %",
    confidence: str | float = "95 %",
    usual_scores: bool = False,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
) -> Evaluation:
    """Judge indicators on labelled records, as ``hydrofdi evaluate`` does.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. Labels and groups come from descriptions of files, or from
        `label` and `group`.
    indicators : str, path, sequence of str, or mapping
        Such as ``dwt,ring_down``; ``all``, or a YAML file with their options and ``scores:`` that combine
        their outputs. In Python also in the other forms of `hydrofdi.measure`.
    healthy : str, int, or sequence of them
        Labels of healthy records, besides those that descriptions name; all others are faulty.
    false_alarm_rate : str or float
        Share of false alarms for which thresholds are set, such as 1 %.
    confidence : str or float
        Confidence of intervals and bounds.
    usual_scores : bool
        Also evaluate mahalanobis and lda of all outputs for each set of sensors, and the largest change of
        dwt.d1 … d5.
    sampling_frequency, channel, unit, label, group
        Of records in memory, as in `hydrofdi.measure`. Records of a unit or a day share a group.

    Returns
    -------
    Evaluation
        Thresholds, false alarms and detections with intervals, areas under ROC curves.

    Raises
    ------
    ConfigError
        No record is labelled as healthy, or a setting is impossible.
    DataError, StoreError
        Records cannot be read.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> noise = numpy.random.default_rng(1).standard_normal((150, 1000))
    >>> noise[100:] *= 2.0
    >>> label = ["sound"] * 100 + ["leaking"] * 50
    >>> evaluation = hydrofdi.evaluate(5e6 + 1e4 * noise, label=label, healthy="sound",
    ...                                sampling_frequency="1 kHz", false_alarm_rate="5 %")
    >>> evaluation.best
    'dwt.d1'
    >>> frame = evaluation.to_pandas()
    >>> frame[frame.population == "leaking"].auc.tolist()[0]
    1.0
    """
    rules = validated(Rules, Source({"false_alarm_rate": false_alarm_rate, "confidence": confidence}))
    chosen = indicators_of(indicators)
    scores = load_scores(fspath(indicators), chosen) if isinstance(indicators, str | PathLike) else {}
    said = Described(sampling_frequency, channel, unit, label, group)
    sources = open_records(data, used_channels(chosen), said)
    is_held = any(isinstance(source, HeldSource) for source in sources)
    if is_held and not any(getattr(source, "is_labelled", True) for source in sources):
        raise ConfigError(
            "label: state the condition of each record, such as label=['healthy', 'leaking', …]"
        )
    chosen = of_machine(chosen, sources)
    columns, measured = measure_sources(
        sources, chosen, is_near=lambda source: isinstance(source, MeasuredSource)
    )
    left = Left()
    labels = [label for source in sources for label in labels_of_healthy(source)]
    labels += names_of("healthy", healthy, "labels of healthy records")
    described = [source.config for source in sources if isinstance(source, MeasuredSource)]
    severity = {label: value for config in described for label, value in config.severity.items()}
    study = measured_study(columns, left.count(measured), dict.fromkeys(labels), severity)
    require_labels(((f"severity.{label}", label) for label in severity), left.labels)
    usual = usual_of(study.records, study.scores, tested_teach=True) if usual_scores else {}
    made = made_scores(study.records, study.scores, usual | dict(scores), tested_teach=True)
    detection = detect(study.records, [*study.scores, *made], rules)
    n_measured = left.n_record - left.n_rejected - left.n_empty
    remarks = *assumed_plants(chosen), *summaries(left.doubts, n_measured)
    return Evaluation(replace(detection, remarks=(*detection.remarks, *remarks)), left)
