"""Indicators judged on labelled records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike, fspath
from typing import Any

from hydrofdi.api.arguments import names_of, number_of
from hydrofdi.api.assumed_plant import assumed_plants
from hydrofdi.api.detectors.healthy_records import labels_of_healthy
from hydrofdi.api.evaluation import Evaluation, Left
from hydrofdi.api.evaluation_tables import conclusion, ranked_by_control
from hydrofdi.api.measuring import Indicators, indicators_of, with_options
from hydrofdi.api.records.columns import Names
from hydrofdi.api.records.sources import Said, Texts, has_held, sources_of
from hydrofdi.config.study.detection import load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.populations import Kind
from hydrofdi.evaluation.rates import HealthyPair, healthy_against_healthy
from hydrofdi.indicators.plausibility import summaries
from hydrofdi.indicators.record_measures import measure_sources, used_channels
from hydrofdi.records import RecordSource
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.settings.messages import percent_hint
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.studies.made_scores import made_scores
from hydrofdi.studies.made_scores import usual_scores as usual_of
from hydrofdi.studies.measured import Labels, measured_study, require_known_severities
from hydrofdi.studies.parts import part
from hydrofdi.studies.rules import Rules


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
    rules = Rules(
        false_alarm_rate=_share("false_alarm_rate", false_alarm_rate, 0.0, 0.5),
        confidence=_share("confidence", confidence, 0.5, 0.9999),
    )
    chosen = indicators_of(with_options(indicators, options))
    scores = load_scores(fspath(indicators), chosen) if isinstance(indicators, str | PathLike) else {}
    said = Said(sampling_frequency, channel, unit, label, group)
    sources = sources_of(data, used_channels(chosen), said)
    if not any(getattr(source, "is_labelled", True) for source in sources) and has_held(sources):
        raise ConfigError(
            "label: state the condition of each record, such as label=['healthy', 'leaking', …]"
        )
    columns, measured = measure_sources(sources, chosen)
    left = Left()
    labels = _labels(sources, names_of("healthy", healthy, "labels of healthy records"))
    study = measured_study(columns, left.count(measured), labels)
    require_known_severities(labels, left.labels)
    usual = usual_of(study.records, study.scores, tested_teach=True) if usual_scores else {}
    made = made_scores(study.records, study.scores, usual | dict(scores), tested_teach=True)
    detection = detect(study.records, [*study.scores, *made], rules)
    n_measured = left.n_record - left.n_rejected - left.n_empty
    remarks = *assumed_plants(sources, chosen), *summaries(left.doubts, n_measured)
    detection = replace(detection, remarks=(*detection.remarks, *remarks))
    pairs = {each.scored.name: _pairs(detection, each) for each in detection.judgements}
    ranked = ranked_by_control(detection.judgements, pairs)
    return Evaluation(replace(detection, judgements=ranked), pairs, left, conclusion(ranked, pairs))


def _share(name: str, given: str | float, least: float, most: float) -> float:
    value = number_of(name, given, "1", "a share such as 0.01 or '1 %'")
    if not least < value <= most:
        allowed = f"must be above {least:g} and at most {most:.4g}"
        raise ConfigError(f"{name}: {allowed}; found {given!r}{percent_hint(given, most)}")
    return value


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
