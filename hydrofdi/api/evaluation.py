"""Evaluations of indicators on labelled records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike, fspath
from typing import Any, Unpack

from hydrofdi.api.sources import Described, LabelledSamples, open_records
from hydrofdi.detectors.rules import Rules, load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.faults import summaries
from hydrofdi.indicators.measuring import measure_sources, used_channels
from hydrofdi.indicators.selection import Indicators, assumed_plants, indicators_of, of_machine
from hydrofdi.records.source import HeldSource, MeasuredSource
from hydrofdi.report.detection.evaluation import Evaluation
from hydrofdi.settings.arguments import names_of
from hydrofdi.settings.files import Source, validated
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.healthy import Left, labels_of_healthy
from hydrofdi.studies.reading import made_scores, measured_study, require_labels
from hydrofdi.studies.reading import usual_scores as usual_of


def evaluate(
    data: Any,
    indicators: Indicators = "dwt",
    *,
    healthy: str | int | Sequence[str | int] = (),
    false_alarm_rate: str | float = "1 %",
    confidence: str | float = "95 %",
    usual_scores: bool = False,
    **samples: Unpack[LabelledSamples],
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
    wanted = load_scores(fspath(indicators), chosen) if isinstance(indicators, str | PathLike) else {}
    said = Described(**samples)
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
    records, scores = measured_study(columns, left.count(measured), dict.fromkeys(labels), severity)
    require_labels(((f"severity.{label}", label) for label in severity), left.labels)
    if usual_scores:
        wanted = usual_of(records, scores, tested_teach=True) | wanted
    made = made_scores(records, scores, wanted, tested_teach=True)
    detection = detect(records, [*scores, *made], rules)
    n_measured = left.n_record - left.n_rejected - left.n_empty
    remarks = *assumed_plants(chosen), *summaries(left.doubts, n_measured)
    return Evaluation(replace(detection, remarks=(*detection.remarks, *remarks)), left)
