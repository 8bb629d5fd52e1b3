"""Indicators judged on labelled records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any

from hydrofdi.api import evaluate_records as evaluating
from hydrofdi.api.arguments import names_of, number_of
from hydrofdi.api.evaluation import Evaluation
from hydrofdi.api.measuring import Indicators, indicators_of, with_options
from hydrofdi.api.records.held import Names
from hydrofdi.api.records.sources import Said, Texts, has_held, sources_of
from hydrofdi.config.study.scores import load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.record_measures import used_channels
from hydrofdi.settings.messages import percent_hint
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
        As in `hydrofdi.measure`; a YAML file may hold ``scores:`` made of their numbers.
    options : mapping, optional
        Options of one named indicator, as in `hydrofdi.measure`.
    healthy : str, int, or sequence of them
        Labels of healthy records; all others are faulty.
    false_alarm_rate : str or float
        That thresholds are set for.
    confidence : str or float
        Confidence of intervals and bounds.
    usual_scores : bool
        Whether scores of several numbers are made as well: mahalanobis, lda and the largest change.
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
    found = evaluating.evaluate(
        sources,
        chosen,
        tuple(names_of("healthy", healthy, "labels of healthy records")),
        rules,
        scores=scores,
        with_usual_scores=usual_scores,
    )
    return Evaluation(found)


def _share(name: str, given: str | float, least: float, most: float) -> float:
    value = number_of(name, given, "1", "a share such as 0.01 or '1 %'")
    if not least < value <= most:
        allowed = f"must be above {least:g} and at most {most:.4g}"
        raise ConfigError(f"{name}: {allowed}; found {given!r}{percent_hint(given, most)}")
    return value
