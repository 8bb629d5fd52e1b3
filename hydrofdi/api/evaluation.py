"""Evaluations of indicators on labelled records: sentences, tables, plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api.arguments import Names, Texts, names_of
from hydrofdi.api.detectors.healthy_records import labels_of_healthy
from hydrofdi.api.measuring import (
    Counted,
    Indicators,
    assumed_plants,
    indicators_of,
    of_machine,
    with_options,
)
from hydrofdi.api.sources import Said, open_records
from hydrofdi.detectors.rules import Rules
from hydrofdi.detectors.scores.configuration import load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.rates import HealthyPair, Rate, healthy_against_healthy
from hydrofdi.evaluation.roc import Area
from hydrofdi.evaluation.scores import Kind, Population, comparable
from hydrofdi.indicators.faults import summaries
from hydrofdi.indicators.record_measures import RecordMeasures, measure_sources, used_channels
from hydrofdi.records.source import HeldSource, MeasuredSource
from hydrofdi.report.detection.answer import remarks_with_counts
from hydrofdi.report.detection.wording import FROM_LEVELS, SeverityUnit, severity_unit
from hydrofdi.report.table import Column, Table, finite, group_breaks, numbers
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, number_text, percentage
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Source
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.measured import measured_study, require_labels
from hydrofdi.studies.parts import part, records_without_number
from hydrofdi.studies.reading import made_scores
from hydrofdi.studies.reading import usual_scores as usual_of
from hydrofdi.studies.records import Detection, Judgement, StudyRecords, found_from
from hydrofdi.units import convert

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


@dataclass
class Left(Counted):
    """Records that are not evaluated: also repeats of another, and those without a label."""

    n_repeated: int = 0
    n_unlabelled: int = 0
    first_repeat: str = ""
    labels: set[str] = field(default_factory=set)
    _seen: dict[bytes, RecordMeasures] = field(default_factory=dict)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, without those that repeat the samples of another."""
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
class Evaluation:
    """Evaluation of indicators on labelled records, as `hydrofdi.evaluate` returns it.

    Attributes
    ----------
    detection : Detection
        Judgements and the records that they rest on; scores that stand clear of their healthy control come
        first.
    healthy_pairs : mapping of str to tuple of HealthyPair
        Name of a score → every healthy group against every other; empty if there are no two.
    left : Left
    """

    detection: Detection
    healthy_pairs: Pairs
    left: Left

    @cached_property
    def scores(self) -> list[dict[str, Any]]:
        """What each score finds, the best first, as ``hydrofdi evaluate --json`` prints it."""
        records, pairs = self.detection.records, self.healthy_pairs
        return [score_record(records, each, pairs[each.scored.name]) for each in self.detection.judgements]

    @property
    def conclusion(self) -> str:
        """Comparison of healthy groups over all scores; empty if there are fewer than two and a fault."""
        known = [
            score["stands_clear"]
            for each, score in zip(self.detection.judgements, self.scores, strict=True)
            if each.levels and score["stands_clear"] is not None
        ]
        n_not, n_score = known.count(False), len(known)
        if not any(each.levels for each in self.detection.judgements):
            return "no record is labelled faulty, so no detection can be stated"
        if not n_score:
            has_groups = any(map(len, self.healthy_pairs.values()))
            few = f"fewer than two healthy groups have {_LEAST} records: whether only the unit or the day was"
            return f"{few} detected cannot be told" if has_groups else ""
        if not n_not:
            return "in every score, faults differ more from healthy records than healthy groups do"
        extent = "only" if n_not == n_score else "perhaps only"
        return (
            f"{extent} the unit or the day was detected: in {n_not} of {counted(n_score, 'score')}, marked ~,"
            " healthy groups differ from each other as much as faults differ from them"
        )

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
        judged = zip(self.detection.judgements, self.scores, strict=True)
        unit = severity_unit(self.detection)
        rows = [row for each, score in judged for row in _rows(each, score, unit)]
        titles = {"auc": "AUC", "q90_95": "q90/95 [L/min]", "without_number": "without a number"}

        def column(name: str) -> Column:
            values, texts = [row[name] for row in rows], [row["texts"].get(name, HOLE) for row in rows]
            is_text, is_shown = name in ("score", "population"), {*texts} != {HOLE}
            unit = "m^3/s" if name == "q90_95" else ""
            return Column(name, values, unit, titles.get(name, ""), texts, is_text=is_text, is_shown=is_shown)

        breaks = group_breaks([row["score"] for row in rows])
        return Table(
            tuple(column(name) for name in (rows[0] if rows else ()) if name != "texts"),
            n_lead=2,
            breaks=breaks if len(rows) > 2 * len(self.detection.judgements) else (),
        )

    @cached_property
    def pairs(self) -> Table:
        """A row for two healthy groups, those first that the best score tells apart best.

        The threshold of ``fit_group`` is tested on ``test_group``: false ``alarms`` of ``n``, and the area
        under the ROC curve, ``auc``, with ``auc_low`` and ``auc_high``. If no alarms are counted, both groups
        are listed once, and the second reads higher.
        """
        pairs = list(self.healthy_pairs.get(self.best, ()))
        pairs.sort(key=lambda pair: -abs(comparable(pair.area.value - 0.5)))
        has_alarms = any(pair.rate is not None for pair in pairs)
        if not has_alarms:
            pairs = [each for each in pairs if (each.area.value, each.fit_group) > (0.5, each.test_group)]
        titles = ("threshold of", "tested") if has_alarms else ("group", "reads higher")
        areas, rates = [_area_record(pair.area) for pair in pairs], [pair.rate for pair in pairs]
        ends = {name: [area[name] for area in areas] for name in ("value", "low", "high")}
        return Table(
            (
                Column("fit_group", [pair.fit_group for pair in pairs], title=titles[0], is_text=True),
                Column("test_group", [pair.test_group for pair in pairs], title=titles[1], is_text=True),
                Column("auc", ends["value"], title="AUC", text=[*map(_area_text, areas)]),
                *(Column(f"auc_{end}", ends[end], is_shown=False) for end in ("low", "high")),
                Column("alarms", [r and r.count for r in rates], title="false alarms", is_shown=has_alarms),
                Column("n", [r and r.total for r in rates], title="of", is_shown=has_alarms),
            ),
            title=f"Healthy groups against each other by {self.best}: none of them leaks",
            n_lead=2,
        )

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame."""
        return self.table.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The `table` as a dataset."""
        return self.table.to_xarray()

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi evaluate --json`` prints."""
        records, rules = self.detection.records, self.detection.rules
        return {
            "false_alarm_rate_set": rules.false_alarm_rate,
            "confidence": rules.confidence,
            "probability": rules.probability,
            "records": self.left.n_record,
            "rejected": self.left.n_rejected,
            "repeated": self.left.n_repeated,
            "groups": None if records.groups is None else sorted(set(records.groups)),
            "populations": [
                {"label": each.name, "is_healthy": each.kind == "healthy", "n": records.rows(each).size}
                for each in records.populations
            ],
            "conclusion": self.conclusion or None,
            "remarks": list(self.detection.remarks),
            "scores": self.scores,
        }

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
    options: Mapping[str, Any] | None = None,
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
    options : mapping, optional
        Options of one named indicator, as in `hydrofdi.measure`.
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
    chosen = indicators_of(with_options(indicators, options))
    scores = load_scores(fspath(indicators), chosen) if isinstance(indicators, str | PathLike) else {}
    said = Said(sampling_frequency, channel, unit, label, group)
    sources = open_records(data, used_channels(chosen), said)
    is_held = any(isinstance(source, HeldSource) for source in sources)
    if is_held and not any(getattr(source, "is_labelled", True) for source in sources):
        raise ConfigError(
            "label: state the condition of each record, such as label=['healthy', 'leaking', …]"
        )
    chosen = of_machine(chosen, sources)
    columns, measured = measure_sources(sources, chosen)
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
    detection = replace(detection, remarks=(*detection.remarks, *remarks))
    pairs = {each.scored.name: _pairs(detection, each) for each in detection.judgements}
    ranked = ranked_by_control(detection.judgements, pairs)
    return Evaluation(replace(detection, judgements=ranked), pairs, left)


def _pairs(detection: Detection, judgement: Judgement) -> tuple[HealthyPair, ...]:
    """Every healthy group against every other; larger scores are those that read higher."""
    records, rules = detection.records, detection.rules
    healthy = [population for population in records.populations if population.kind is Kind.HEALTHY]
    own = part(records, judgement.scored, healthy)
    if own.groups is None or len(set(own.groups)) < 2:
        return ()
    rule = partial(rules.set_threshold, direction=judgement.direction)
    return healthy_against_healthy(own.scores, own.groups, rule, confidence=rules.confidence)


Pairs = Mapping[str, tuple[HealthyPair, ...]]
"""Name of a score → every healthy group against every other."""


def _rows(judgement: Judgement, score: Mapping[str, Any], unit: SeverityUnit) -> Iterator[dict[str, Any]]:
    """A row for each population: what is known of a score, and its ``texts``."""
    tested = [*score["false_alarms"], *score["detected"]]
    areas, rates = ({each["label"]: each for each in own} for own in (score["auc"], tested))
    limits, smallest = score["threshold"] or {}, judgement.smallest.get("q90_95")
    between = [
        pair["value"]
        for pair in score["healthy_against_healthy"]
        if min(pair["n_healthy"], pair["n"]) >= _LEAST
    ]
    mark = "~ " if score["stands_clear"] is False else ""
    for population in (*judgement.false_alarms, *(level.population for level in judgement.levels)):
        name, is_healthy = population.name, population.kind == "healthy"
        rate, area, missing = rates.get(name, {}), areas.get(name, {}), score["without_number"].get(name, 0)
        texts = {"score": f"{mark}{score['indicator']}", "population": name}
        if rate:
            ends = [percentage(rate[end]) for end in ("rate", "low", "high") if rate[end] is not None]
            share = ", {} % [{}, {}]".format(*ends) if len(ends) == 3 else ""
            texts["alarms"] = f"{rate['alarms']} of {rate['n']}{share}"
        if area:
            texts["auc"] = _area_text(area)
        elif is_healthy and between:
            texts["auc"] = f"{min(between):.2f} … {max(between):.2f}"
        if smallest is not None and not is_healthy:
            texts["q90_95"] = unit.found(smallest).removesuffix(FROM_LEVELS)
        if missing:
            texts["without_number"] = str(missing)
        yield {
            "score": score["indicator"],
            "population": name,
            "kind": population.kind.value,
            "unit": score["unit"],
            **{key: limits.get(key) for key in ("low", "high")},
            **{key: rate.get(key) for key in ("alarms", "n", "rate")},
            **{f"rate_{end}": rate.get(end) for end in ("low", "high")},
            "auc": area.get("value"),
            **{f"auc_{end}": area.get(end) for end in ("low", "high")},
            "q90_95": smallest and smallest.value,
            "without_number": missing,
            "texts": texts,
        }


def _area_text(area: Mapping[str, Any]) -> str:
    return "{} [{}, {}]".format(*(number_text(area[end], 2) for end in ("value", "low", "high")))


def score_record(records: StudyRecords, judgement: Judgement, pairs: Sequence[HealthyPair]) -> dict[str, Any]:
    """What a score finds."""
    scored, threshold, found = judgement.scored, judgement.threshold, finite(found_from(judgement))
    return {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": threshold and numbers(threshold, "low", "high") | {"n": threshold.n_healthy},
        "false_alarms": [
            _rate_record(judgement, each, rate) for each, rate in judgement.false_alarms.items()
        ],
        "auc": [
            {"label": level.population.name} | _area_record(level.area)
            for level in judgement.levels
            if level.area is not None
        ],
        "detected": [
            _rate_record(judgement, level.population, level.detected)
            for level in judgement.levels
            if level.detected is not None
        ],
        "q90_95_L_per_min": None if found is None else convert(found, "L/min"),
        "stands_clear": stands_clear(judgement, pairs),
        "without_number": records_without_number(records, scored),
        "healthy_against_healthy": [
            {"fit_group": each.fit_group, "test_group": each.test_group}
            | _area_record(each.area)
            | {"alarms": each.rate and each.rate.count, "refusal": each.refusal or None}
            for each in pairs
        ],
        "refusals": list(judgement.refusals),
        "remarks": list(judgement.remarks),
        "note": scored.note or None,
    }


def _area_record(area: Area) -> dict[str, Any]:
    return numbers(area, "value", "low", "high") | {"n_healthy": area.n_healthy, "n": area.n_faulty}


def _rate_record(judgement: Judgement, population: Population, rate: Rate) -> dict[str, Any]:
    """Alarms of a population; a rate where there are enough records for one."""
    needed = judgement.counted.get(population)
    stated = {"rate": finite(rate.value), **numbers(rate, "low", "high")}
    return {
        "label": population.name,
        "alarms": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
        **(dict.fromkeys(stated) if needed else stated),
        "records_needed": needed,
    }


_LEAST = 5
"""Records of a healthy group that can be compared with another; areas of fewer are 0 or 1 by chance."""


def healthy_spread(pairs: Sequence[HealthyPair]) -> float:
    """The largest distance of an area of healthy groups from 1/2; NaN without any that can be compared."""
    areas = [pair.area for pair in pairs if min(pair.area.n_healthy, pair.area.n_faulty) >= _LEAST]
    return max((abs(area.value - 0.5) for area in areas), default=math.nan)


def stands_clear(judgement: Judgement, pairs: Sequence[HealthyPair]) -> bool | None:
    """Whether the area of some fault lies further above 1/2 than healthy groups lie from it.

    None if unknown: without two healthy groups that can be compared.
    """
    if math.isnan(spread := healthy_spread(pairs)):
        return None
    areas = [level.area.value - 0.5 for level in judgement.levels if level.area is not None]
    return bool(comparable(max(areas, default=0.0)) > comparable(spread))


def ranked_by_control(judgements: Sequence[Judgement], pairs: Pairs) -> tuple[Judgement, ...]:
    """Best first: those that stand clear of their control, then as `ranked`.

    Of areas with the same two digits the one with the smaller healthy spread comes first.
    """

    def place(judgement: Judgement) -> tuple[bool, bool, float, float, float, str]:
        own = pairs[judgement.scored.name]
        area = 0.0 if math.isnan(judgement.middle_area) else judgement.middle_area
        return (
            stands_clear(judgement, own) is False,
            judgement.keeps_its_rate is False,
            comparable(found_from(judgement)),
            -round(area, 2),
            max(0.0, comparable(healthy_spread(own))),  # NaN counts as 0
            judgement.scored.name,
        )

    return tuple(sorted(judgements, key=place))
