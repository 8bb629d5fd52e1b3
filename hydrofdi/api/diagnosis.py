"""Since when the leakage grows, how fast, and when it reaches a limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hydrofdi.api.sources import Described, open_records
from hydrofdi.diagnosis.histories import (
    History,
    MeasuredScore,
    balance_of,
    history_of_records,
    logged_histories,
    require_files,
)
from hydrofdi.diagnosis.trends import TrendAnswer, Trends, estimate
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators import measure
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.indicators.selection import Indicators, assumed_plants, indicators_of, of_machine
from hydrofdi.records import Channel
from hydrofdi.records.times import FIRST_DATE, instant
from hydrofdi.settings.arguments import Names, Texts, names_of, number_of, positive_of
from hydrofdi.settings.messages import nearest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hydrofdi.diagnosis.diagnosing import Diagnosis

_LEAST_RATE = 0.002


class Trend(TrendAnswer):
    """The trend of a score, as `hydrofdi.trend` returns it."""

    def plot(self) -> Figure:
        """The points, the level with its interval, the onset, the limit and when it is reached."""
        from hydrofdi.report.figures.signals import draw_trend

        return draw_trend(**self.drawing())


def trend(
    data: Any,
    *,
    limit: str | float | None = None,
    machine: str = "",
    indicator: Indicators = "",
    output: str = "",
    every: str | float = "1 day",
    begin: str | None = None,
    false_alarm_rate: str | float = "1 %",
    confidence: float | str = 0.95,
    sampling_frequency: str | float | None = None,
) -> Trend | Trends:
    """State since when a score grows, how fast, and when it reaches a limit, as ``hydrofdi trend`` does.

    Parameters
    ----------
    data : path, list of paths, or list of mappings
        Logs of a monitor (``hydrofdi monitor --log``) or its lines; or measured records with dates, in files.
    limit : str or float, optional
        Score whose date is wanted, such as ``0.5 L/min``.
    machine : str, optional
        Of the log of a fleet, the machine; by default each has an answer.
    indicator : str, path or mapping, optional
        What is measured of records: a name, or a YAML file with its options as for `measure`; by default the
        balance that their sensors allow.
    output : str, optional
        Output of the indicator; by default its first score.
    every : str or float
        Span of time whose scores make a point, their median.
    begin : str, optional
        Date at which the clock of a log is zero, such as ``2026-01-31T12:00Z``, if it does not state dates.
    false_alarm_rate : str or float
        Share of histories without a change in which a trend may be stated, from 0.2 %.
    confidence : str or float
        Confidence level of all intervals.
    sampling_frequency : str or float, optional
        Of a data file without a column of time [Hz].

    Returns
    -------
    Trend
        ``answer``, ``has_trend``, ``onset``, ``rate``, ``reached`` and more, with intervals; ``table``,
        ``plot()``. Of several machines, `Trends`: machine → `Trend`.

    Raises
    ------
    ConfigError, DataError
        An argument is invalid, a record has no date, or the history has fewer than 12 points.
    """
    span = positive_of("every", every, "s", "a duration such as '1 day'")
    rate, level = (
        positive_of(name, given, "1", "a share such as '1 %'")
        for name, given in (("false_alarm_rate", false_alarm_rate), ("confidence", confidence))
    )
    if not _LEAST_RATE <= rate < 1.0:
        raise ConfigError(f"false_alarm_rate: must be from 0.2 % to below 100 %; found {false_alarm_rate!r}")
    if not 0.0 < level < 1.0:
        raise ConfigError(f"confidence: must be below 1; found {confidence!r}")
    zero = None if begin is None else _instant_of(begin)

    def accept(unit: str, is_dated: bool) -> float | None:
        if is_dated and zero is not None:
            raise ConfigError("begin: the clock of the scores states dates already")
        if limit is None:
            return None
        expected = f"a score in {unit}, such as a number with its unit"
        value = number_of("limit", limit, unit, expected, needs_unit=True)
        if not math.isfinite(value):
            raise ConfigError(f"limit: must be finite; found {limit!r}")
        return value

    def trend_of(history: History) -> Trend:
        wanted = accept(history.unit, history.is_dated)
        history = history if zero is None else replace(history, time=zero + history.time)
        return Trend(**vars(estimate(history, span, wanted, rate, level)))

    histories = logged_histories(data)
    if histories is None:
        said = Described(sampling_frequency)
        histories = {"": _history_of_records(data, indicator, output, said, accept)}
    elif indicator or output:
        raise ConfigError("indicator, output: are for records; a log has the score of its detector")
    if machine:
        if machine not in histories:
            raise ConfigError(
                f"machine: there is no {machine!r}{nearest(machine, [*filter(None, histories)])}"
            )
        histories = {machine: histories[machine]}
    if len(histories) == 1:
        return trend_of(*histories.values())
    trends, without = dict[str, Trend](), dict[str, DataError]()
    for name, history in sorted(histories.items()):
        try:
            trends[name] = trend_of(history)
        except DataError as error:
            without[name] = error
    if not trends:
        raise next(iter(without.values()))
    return Trends(trends, without)


def _history_of_records(
    data: Any, indicator: Indicators, output: str, said: Described, accept: Callable[[str, bool], object]
) -> History:
    from hydrofdi.detectors.configuration import DetectorConfig, feature_of

    sources = open_records(data, said=said)
    require_files(sources)
    chosen = indicators_of(indicator or balance_of(sources))
    if len(chosen) > 1:
        raise ConfigError(f"indicator: a trend is of one; found {', '.join(chosen)}")
    (own,) = chosen.values()
    options = own.options.model_dump(exclude_unset=True)
    feature = feature_of(DetectorConfig(indicator=own.name, options=options, output=output))
    indicators = of_machine({own.name: own}, sources)
    score = MeasuredScore(
        feature.label,
        lambda batch: output_unit(feature.indicator, feature.described, batch),
        lambda batch: feature.values(measure(batch, indicators).values)[:, 0],
    )
    return history_of_records(sources, score, assumed_plants(indicators), accept)


def _instant_of(begin: str) -> float:
    """The instant at which a clock is zero [s since 1970]."""
    try:
        zero = instant(begin).nanoseconds / 1e9
    except (ValueError, AttributeError) as error:
        raise ConfigError(f"begin: {error}") from None
    if zero < FIRST_DATE:
        raise ConfigError(f"begin: must be after 2001-09-09; found {begin!r}")
    return zero


def diagnose(
    data: Any,
    history: Any = None,
    indicators: Indicators = "flow_balance",
    *,
    healthy: str | int | Sequence[str | int] = (),
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
) -> Diagnosis:
    """Name the fault that records of a machine show, or say that nothing is wrong.

    Parameters
    ----------
    data : path, results, array_like, mapping, DataFrame, Dataset, or list of these
        Records with P1, x, and u or the spool position; better with P2. As for `hydrofdi.measure`. Of
        labelled records, those that are not healthy. All records are cut into pieces of 20 s, or of the
        shortest record of 10 s or more.
    history : same, optional
        Healthy records of the same machine, at least three, better twelve, of other days. By default the
        healthy ones of labelled records; if there are none, the data sheet takes their place.
    indicators : str, path, or mapping, optional
        A file or mapping of indicators as for `hydrofdi.measure`, of which ``flow_balance`` has the options.
    healthy : str, int, or sequence of them, optional
        Labels of healthy records, besides those that descriptions name.
    sampling_frequency, channel, unit, label : optional
        As for `hydrofdi.measure`.

    Returns
    -------
    Diagnosis

    Raises
    ------
    ConfigError, DataError
        An argument is invalid, or channels are missing.
    """
    from hydrofdi.diagnosis.diagnosing import diagnose as diagnose_records
    from hydrofdi.studies.healthy import HealthyRecords, is_of_study

    said = Described(sampling_frequency, channel, unit)
    sources = open_records(data, tuple(Channel), replace(said, label=label))
    is_own, names = history is None, tuple(names_of("healthy", healthy, "labels of healthy records"))
    history_sources = sources if is_own else open_records(history, tuple(Channel), said)
    for source in (*sources, *history_sources):
        if is_of_study(source):
            text = "a study draws another machine for each record; diagnose records of one machine"
            raise ConfigError(f"{source.name}: {text}")
    known = HealthyRecords(history_sources, names)
    is_one = is_own and known.is_unlabelled
    past = [] if is_one else [*known.batches()]
    if is_own and not is_one:
        asked = [*HealthyRecords(sources, names, is_faulty=True).batches()]
    else:
        asked = [batch for source in sources for batch in source.batches()]
    if not asked:
        raise ConfigError(f"{known.name}: all records are healthy; there is none to diagnose")
    used = sources if is_own else [*sources, *history_sources]
    chosen = indicators_of(indicators).values()
    stated = [each.options.model_dump(exclude_unset=True) for each in chosen if each.name == "flow_balance"]
    if len(stated) != 1:
        raise ConfigError(f"diagnose needs one flow_balance; {len(stated)} are among the indicators")
    return diagnose_records(asked, past, used, stated[0])
