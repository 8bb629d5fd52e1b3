"""Histories of a score over days: from the log of a monitor, or from measured records with dates."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.api.sources import Described, open_records
from hydrofdi.detectors.trained.configuration import DetectorConfig, feature_of
from hydrofdi.detectors.trained.measuring import TEMPERATURE
from hydrofdi.diagnosis.trends import FIRST_DATE, History
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators import measure
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.indicators.selection import assumed_plants, make_indicators, of_machine
from hydrofdi.records import Channel, RecordSource

_LOG = b'{"line":'

_P1, _P2, _X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION


def history_of(data: Any, indicator: str, output: str, said: Described) -> History:
    """The history in logs of a monitor, in the lines of one, or in measured records.

    Raises
    ------
    ConfigError, DataError
        Something cannot be read, has no score, no date, or is not of one machine.
    """
    several = data if isinstance(data, list | tuple) else [data]
    paths = [Path(each).expanduser() for each in several if isinstance(each, str | Path)]
    if paths and all(map(_is_log, paths)):
        name = ", ".join(map(str, paths))
        found = _of_lines(((str(path), line) for path in paths for line in _lines(path)), name)
    elif several and all(isinstance(each, Mapping) and "line" in each for each in several):
        found = _of_lines((("the lines", each) for each in several), "the lines")
    else:
        return _of_records(data, indicator, output, said)
    if indicator or output:
        raise ConfigError("indicator, output: are for records; a log has the score of its detector")
    return found


def _is_log(path: Path) -> bool:
    if not path.is_file():
        return False
    with open(path, "rb") as file:
        return file.read(len(_LOG)) == _LOG


def _lines(path: Path) -> Iterator[Mapping[str, Any]]:
    """The lines of windows of a log; a last line that is being written is left out."""
    with open(path, encoding="utf-8") as file:
        for number, text in enumerate(file, 1):
            if not text.endswith("\n"):
                return
            try:
                yield json.loads(text)
            except ValueError:
                raise DataError(f"{path}:{number}: is not a line of a monitor") from None


def _of_lines(lines: Iterable[tuple[str, Mapping[str, Any]]], name: str) -> History:
    """Windows that have a score, also those that are novel: a large leak may be."""
    rows, unit, before = list[tuple[float, float, float]](), "", -math.inf
    for place, line in lines:
        if line.get("line") != "window" or line.get("score") is None:
            continue
        if unit and line["unit"] != unit:
            raise DataError(f"{place}: window {line['number']}: is in {line['unit']}, but others in {unit}")
        unit, time, temperature = line["unit"], float(line["end"]), line.get(TEMPERATURE)
        if time < before and time < FIRST_DATE:
            raise DataError(
                f"{place}: window {line['number']}: the clock goes from {before:.10g} s to {time:.10g} s;"
                " trends need samples with dates (docs/monitoring-sources.md), or one log for each start"
            )
        before = time
        rows.append((time, float(line["score"]), math.nan if temperature is None else float(temperature)))
    if not rows:
        raise DataError(f"{name}: no window has a score")
    time, score, temperature = np.array(sorted(set(rows))).T
    return History(name, "score", unit, time, score, temperature)


def _of_records(data: Any, indicator: str, output: str, said: Described) -> History:
    sources = open_records(data, said=said)
    name = ", ".join(source.name for source in sources)
    chosen = indicator or None
    if chosen is None:
        chosen, options = _balance_of(sources, name)
    else:
        options = {}
    feature = feature_of(DetectorConfig(indicator=chosen, options=options, output=output))
    label = feature.indicator.name
    indicators = of_machine(make_indicators({label: options}), sources)
    rows, unit, remarks = list[tuple[float, float, float]](), "", [*assumed_plants(indicators)]
    n_record = 0
    for batch in (batch for source in sources for batch in source.batches()):
        n_record += batch.n_record
        if not batch.n_record:
            continue
        scores = feature.values(measure(batch, indicators).values)[:, 0]
        own = TEMPERATURE in batch.channels
        warm = batch[TEMPERATURE].mean(axis=1) if own else np.full(batch.n_record, np.nan)
        unit = unit or output_unit(feature.indicator, feature.described, batch)
        for row in np.flatnonzero(np.isfinite(scores)).tolist():
            if math.isnan(batch.dates[row]):
                raise DataError(
                    f"{batch.record_ids[row]}: has no date; take one from the path ('date:' of the"
                    " description), or use a time column of dates (docs/measured.md)"
                )
            rows.append((batch.dates[row], float(scores[row]), float(warm[row])))
    if not rows:
        raise DataError(f"{name}: {feature.label} measures none of {n_record} records")
    if n_record > len(rows):
        remarks.append(f"{feature.label} has no number in {n_record - len(rows):,} of {n_record:,} records")
    time, score, temperature = np.array(sorted(rows)).T
    return History(name, feature.label, unit, time, score, temperature, tuple(remarks))


def _balance_of(sources: Sequence[RecordSource], name: str) -> tuple[str, dict[str, Any]]:
    """The balance that needs no more than the sensors of the first records, and its options."""
    first = next((batch for source in sources for batch in source.batches() if batch.n_record), None)
    known = set() if first is None else first.channels.keys() - first.relative
    spool = "measured" if Channel.SPOOL_POSITION in known else "command"
    if _P1 not in known or not known & {Channel.SPOOL_POSITION, Channel.INPUT_VOLTAGE}:
        raise DataError(
            f"{name}: a balance needs P1, and u or xv, in SI; state what to measure with 'indicator'"
        )
    options = {"spool": spool} | ({} if _P2 in known else {"chambers": 1})
    return ("flow_balance" if _X in known else "pressure_balance"), options
