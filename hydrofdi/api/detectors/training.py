"""Detectors trained on healthy records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal

from hydrofdi.api.arguments import names_of
from hydrofdi.api.detectors.detector import Detector
from hydrofdi.api.detectors.train_on import channels_needed, require_place, train_on
from hydrofdi.api.measuring import Indicators
from hydrofdi.api.places import path_of
from hydrofdi.api.records.held import Names
from hydrofdi.api.records.sources import Said, Texts, sources_of
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.training import stated_detector
from hydrofdi.settings.ready import located
from hydrofdi.settings.yaml_source import plain


def train(
    data: Any,
    indicator: Indicators | None = None,
    *,
    options: Mapping[str, Any] | None = None,
    output: str | None = None,
    direction: Literal["rising", "falling", "both"] | None = None,
    window: str | float | None = None,
    every: str | float | None = None,
    by: Literal["time", "cycle", "estimate"] | None = None,
    false_alarm_rate: str | float | None = None,
    confidence: str | float | None = None,
    threshold: Literal["quantile", "tolerance"] | None = None,
    accept: bool | None = None,
    healthy: str | int | Sequence[str | int] = (),
    config: str | PathLike[str] | Mapping[str, Any] | None = None,
    out: str | PathLike[str] | None = None,
    command: str = "",
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
) -> Detector:
    """Train a detector on healthy records, as ``hydrofdi train`` does.

    Of labelled records those with a healthy label are used, of a sweep the runs without a leak, of a study
    its healthy fit records; of other records all. Too few are refused with the number that is needed.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them.
    indicator : str, path, mapping or sequence of str, optional
        What is measured, ``"dwt"`` by default; a label, where `config` has several. Also in the forms that
        `hydrofdi.measure` takes, ``{"flow_balance": {"spool": "command"}}``; a YAML file or a mapping with
        other keys of a detector stands for `config`.
    options : mapping, optional
        Options of the indicator, such as ``{"spool": "command"}``.
    output : str, optional
        Which number of the indicator is the score, such as ``"d2"``.
    direction : {"rising", "falling", "both"}, optional
        Which departure raises an alarm; by default that of the output.
    window, every : str or float, optional
        Duration of a window, and time from the start of one to the next [s]; that of the records where left
        out.
    by : {"time", "cycle", "estimate"}, optional
        Windows by time or by cycle of the drive, or each estimate of a recursive indicator.
    false_alarm_rate : str or float, optional
        Share of healthy windows that may raise an alarm; ``"1 %"`` by default.
    confidence : str or float, optional
        Confidence of the interval of the rate; ``"95 %"`` by default.
    threshold : {"quantile", "tolerance"}, optional
        Keep the rate on average, or with the confidence.
    accept : bool, optional
        Whether to train although estimates are physically impossible in most healthy windows.
    healthy : str, int, or sequence of them, optional
        Labels of healthy records.
    config : path or mapping, optional
        YAML file with the same settings, options of the indicator and a chart; or what would stand in one.
        Keywords win over it.
    out : path, optional
        Where the detector is written; `Detector.save` does it later.
    command : str, optional
        The command that the file states as its origin.
    sampling_frequency, channel, unit, label, group
        Of records in memory, as in `hydrofdi.measure`.

    Returns
    -------
    Detector
        Its `summary` states the false-alarm rate and the data behind it.

    Raises
    ------
    ConfigError
        With every mistake, or too few healthy records.
    DataError, StoreError
        Records cannot be read, or the file cannot be written.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> pressure = 5e6 + 1e4 * numpy.random.default_rng(1).standard_normal((200, 1000))
    >>> detector = hydrofdi.train(pressure, output="d2", sampling_frequency="1 kHz", false_alarm_rate="2 %")
    >>> detector.false_alarm_rate, detector.sampling_frequency
    (0.02, 1000.0)
    >>> print(detector.summary)
    It judges windows of 1 s at 1000 Hz and needs P1 (chamber_1_pressure).
    A score ...
    >>> hydrofdi.train(pressure[:10], output="d2", sampling_frequency="1 kHz")
    Traceback (most recent call last):
    hydrofdi.evaluation.refusal.NotStatedError: ... needs 99 healthy windows ...
    """
    if indicator is not None and config is None and not _is_name(indicator):
        config, indicator = _config(indicator), None
    given: dict[tuple[str, ...], tuple[str, Any]] = {
        ("indicator",): ("indicator", indicator),
        ("options",): ("options", None if options is None else plain(options)),
        ("output",): ("output", output),
        ("direction",): ("direction", direction),
        ("false_alarm_rate",): ("false_alarm_rate", false_alarm_rate),
        ("confidence",): ("confidence", confidence),
        ("threshold",): ("threshold", threshold),
        ("accept",): ("accept", accept),
        ("window", "duration"): ("window", window),
        ("window", "every"): ("every", every),
        ("window", "by"): ("by", by),
    }
    stated = stated_detector(
        config if config is None or isinstance(config, Mapping) else path_of(config),
        {key: (name, value) for key, (name, value) in given.items() if value is not None},
    )
    if out is not None:
        require_place(path_of(out))
    said = Said(sampling_frequency, channel, unit, label, group)
    labels = tuple(names_of("healthy", healthy, "labels of healthy records"))
    sources = sources_of(data, channels_needed(stated), said)
    detector = Detector(train_on(sources, stated, healthy=labels, command=command))
    if out is not None:
        detector.save(out)
    return detector


def _is_name(indicator: Indicators) -> bool:
    """Whether it is the name of an indicator, not a file, a mapping or a list."""
    return isinstance(indicator, str) and not located(path_of(indicator)).is_file()


def _config(given: Indicators) -> str | PathLike[str] | Mapping[str, Any]:
    """The configuration of a detector; labels with options, and lists of names, are its ``indicators``."""
    if isinstance(given, str | PathLike):
        return given
    keys = {"indicators", "extends", *DetectorConfig.model_fields}
    if isinstance(given, Mapping) and not keys.isdisjoint(given):
        return given
    return {"indicators": given}
