"""Which fault records show: hypotheses with probabilities, sizes, and what tells them apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from hydrofdi.api.sources import Described, open_records
from hydrofdi.diagnosis.answer import Diagnosis
from hydrofdi.diagnosis.diagnosing import diagnose as diagnose_records
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.selection import Indicators, indicators_of
from hydrofdi.records import Channel
from hydrofdi.settings.arguments import Names, Texts, names_of
from hydrofdi.studies.healthy import HealthyRecords, is_of_study


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
    return Diagnosis(**vars(diagnose_records(asked, past, used, stated[0])))
