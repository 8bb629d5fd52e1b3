"""Labelled records of any source → what each indicator finds, and what healthy groups say of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from hydrofdi.api.assumed_plant import assumed_plants
from hydrofdi.api.detectors.healthy_records import labels_of_healthy
from hydrofdi.api.healthy_control import conclusion, ranked_by_control
from hydrofdi.config.study.detection import ScoreConfig
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.groups import HealthyPair, healthy_against_healthy
from hydrofdi.evaluation.populations import Kind
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.plausibility import Doubt, summaries
from hydrofdi.indicators.record_measures import RecordMeasures, measure_sources
from hydrofdi.records import RecordSource
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.studies.made_scores import made_scores
from hydrofdi.studies.measured import Labels, measured_study, require_known_severities
from hydrofdi.studies.parts import part
from hydrofdi.studies.rules import Rules
from hydrofdi.studies.usual_scores import usual_scores


@dataclass
class Left:
    """Records that are not evaluated, and indicators that failed.

    Attributes
    ----------
    n_record : int
        All that were read.
    n_rejected, n_repeated, n_unlabelled, n_empty : int
        Rejected, repeats of another, without a label, without a number of any indicator.
    first_rejection, first_repeat : str
    faults : dict of str to None
        What is wrong with indicators that failed.
    labels : set of str
        Of all records, the rejected ones as well.
    doubts : list of Doubt
        Of all records.
    """

    n_record: int = 0
    n_rejected: int = 0
    n_repeated: int = 0
    n_unlabelled: int = 0
    n_empty: int = 0
    first_rejection: str = ""
    first_repeat: str = ""
    faults: dict[str, None] = field(default_factory=dict)
    labels: set[str] = field(default_factory=set)
    doubts: list[Doubt] = field(default_factory=list)
    _seen: dict[bytes, RecordMeasures] = field(default_factory=dict)

    def count(self, records: Iterator[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, counted; without those that repeat the samples of another.

        Raises
        ------
        ConfigError
            Records with the same samples have different labels.
        """
        for record in records:
            self.n_record += 1
            self.labels |= {record.label} - {""}
            self.faults |= dict.fromkeys(record.faults.values())
            self.doubts += record.doubts
            if record.is_rejected:
                self.n_rejected += 1
                self.first_rejection = self.first_rejection or f"{record.record_id}: {_reason(record)}"
            elif record.has_numbers and self._is_repeat(record):
                continue
            else:
                self.n_unlabelled += not record.label
                self.n_empty += not record.has_numbers
            yield record

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


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Indicators judged on labelled records.

    Attributes
    ----------
    detection : Detection
        Scores that stand clear of their healthy control come first.
    healthy_pairs : mapping of str to tuple of HealthyPair
        Name of a score → every healthy group against every other; empty if there are no two.
    left : Left
    conclusion : str
        What healthy groups say of all scores; empty if there are no two.
    """

    detection: Detection
    healthy_pairs: Mapping[str, tuple[HealthyPair, ...]]
    left: Left
    conclusion: str


def evaluate(
    sources: Sequence[RecordSource],
    indicators: Mapping[str, Indicator[Any]],
    healthy: Sequence[str],
    rules: Rules,
    *,
    scores: Mapping[str, ScoreConfig] | None = None,
    with_usual_scores: bool = False,
) -> Evaluation:
    """Measure records, join them with their labels, and judge every number, and every score made of numbers.

    Scores are cross-fitted: no record is scored by a model that saw it or its group.

    Parameters
    ----------
    sources : sequence of RecordSource
        With the channels that the indicators use.
    indicators : mapping of str to Indicator
    healthy : sequence of str
        Labels of healthy records beside those that descriptions name.
    rules : Rules
    scores : mapping of str to ScoreConfig, optional
        By label.
    with_usual_scores : bool
        Whether the usual scores are made as well.

    Raises
    ------
    ConfigError
        No record is known to be healthy, records with the same samples have different labels, or a score
        needs an extra that is not installed.
    DataError, StoreError
        A source cannot be read.
    """
    columns, measured = measure_sources(sources, indicators)
    left = Left()
    labels = _labels(sources, healthy)
    study = measured_study(columns, left.count(measured), labels)
    require_known_severities(labels, left.labels)
    usual = usual_scores(study.records, study.scores, tested_teach=True) if with_usual_scores else {}
    made = made_scores(study.records, study.scores, usual | dict(scores or {}), tested_teach=True)
    detection = detect(study.records, [*study.scores, *made], rules)
    n_measured = left.n_record - left.n_rejected - left.n_empty
    remarks = *assumed_plants(sources, indicators), *summaries(left.doubts, n_measured)
    detection = replace(detection, remarks=(*detection.remarks, *remarks))
    pairs = {each.scored.name: _pairs(detection, each) for each in detection.judgements}
    ranked = ranked_by_control(detection.judgements, pairs)
    return Evaluation(replace(detection, judgements=ranked), pairs, left, conclusion(ranked, pairs))


def _labels(sources: Sequence[RecordSource], healthy: Sequence[str]) -> Labels:
    described = [source.config for source in sources if isinstance(source, MeasuredSource)]
    named = [label for source in sources for label in labels_of_healthy(source)]
    severity = {label: value for config in described for label, value in config.severity.items()}
    return Labels(tuple(dict.fromkeys([*named, *healthy])), severity)


def _pairs(detection: Detection, judgement: Judgement) -> tuple[HealthyPair, ...]:
    """Every healthy group against every other; larger scores are those that read higher."""
    records, rules = detection.records, detection.rules
    healthy = [population for population in records.populations if population.kind is Kind.HEALTHY]
    own = part(records, judgement.scored, healthy)
    if own.groups is None or len(set(own.groups)) < 2:
        return ()
    rule = partial(rules.set_threshold, direction=judgement.direction)
    return healthy_against_healthy(own.scores, own.groups, rule, confidence=rules.confidence)


def _reason(record: RecordMeasures) -> str:
    return next(iter(record.reasons.values()), record.status)
