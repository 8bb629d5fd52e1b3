"""Outputs of indicators over the runs of an experiment, against healthy runs and their replicates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.contract import Output
from hydrofdi.report.document import Block, group_breaks
from hydrofdi.report.forms.numbers import finite, plain
from hydrofdi.report.intervals import span_of
from hydrofdi.report.runs import RunTable, table_runs
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import joined, row_name, some, span_text
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE, readable_unit
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.units import convert

Array = NDArray[np.float64]

Range = tuple[float, float]
"""Smallest and largest of some numbers; NaN if there is none."""

LEAST_SHARE = 0.01
"""A healthy value below this share of the largest size over all runs counts as near zero."""


@dataclass(frozen=True)
class MeasuredOutput:
    """An output over all runs.

    Attributes
    ----------
    output : Output
    values : ndarray, shape (n_run, *dims)
        In the unit of the output; NaN if a run has none.
    """

    output: Output
    values: Array

    @property
    def title(self) -> str:
        """Its name, and the dimensions of its mean."""
        over = " and ".join(self.output.dims)
        return f"{self.output.name} (mean over {over})" if over else self.output.name

    @property
    def shown_unit(self) -> str:
        """The unit in which a person reads it; ``1`` if it has none."""
        known = np.abs(self.means[np.isfinite(self.means)])
        return readable_unit(self.output.unit, float(known.max())) if known.size else self.output.unit

    def shown(self, values: Array) -> Array:
        """Numbers in the unit of the output, in `shown_unit`."""
        unit = self.shown_unit
        return values if unit == self.output.unit else values * convert(1.0, unit)

    @property
    def means(self) -> Array:
        """The mean over all its dimensions, shape (n_run,); NaN if there is no number."""
        flat = self.values.reshape(len(self.values), -1)
        count = np.isfinite(flat).sum(axis=1)
        with np.errstate(invalid="ignore"):
            means: Array = np.where(np.isfinite(flat), flat, 0.0).sum(axis=1) / count
        return means


@dataclass(frozen=True)
class MeasuredIndicator:
    """An indicator and its outputs over all runs.

    Attributes
    ----------
    label : str
        Its name in the experiment.
    indicator : Indicator
    outputs : tuple of MeasuredOutput
    obstacles : ndarray of str, shape (n_run,), or None
        Reason why a run has no number, empty if it has one; None if the file has no reasons.
    """

    label: str
    indicator: Indicator[Any]
    outputs: tuple[MeasuredOutput, ...]
    obstacles: NDArray[Any] | None = None

    def variable(self, output: MeasuredOutput) -> str:
        """``label.output``."""
        return f"{self.label}.{output.output.name}"

    def obstacle(self, row: int) -> str:
        """Reason why a run has no number; a general one if the file has none."""
        return str("" if self.obstacles is None else self.obstacles[row]) or self.indicator.absence

    @property
    def has_number(self) -> NDArray[np.bool_]:
        """Whether a run has any number, shape (n_run,)."""
        means = np.stack([output.means for output in self.outputs])
        return np.asarray(np.isfinite(means).any(axis=0))


def measured_indicators(data: ExperimentData) -> tuple[MeasuredIndicator, ...]:
    """The stored indicators of an experiment, except that of the details."""
    measured = (
        measured_indicator(label, indicator, data.columns)
        for label, indicator in data.experiment.indicator_choice.made(data.experiment.wavelet).items()
        if label != DWT
    )
    return tuple(indicator for indicator in measured if indicator.outputs)


def measured_indicator(
    label: str, indicator: Indicator[Any], columns: Mapping[str, Array]
) -> MeasuredIndicator:
    """An indicator with those of its outputs that are among the columns."""
    outputs = (
        MeasuredOutput(output, columns[f"{label}.{output.name}"])
        for output in indicator.outputs
        if f"{label}.{output.name}" in columns
    )
    return MeasuredIndicator(label, indicator, tuple(outputs), columns.get(f"{label}{names.OBSTACLE}"))


@dataclass(frozen=True)
class Changes:
    """Changes of all runs against one kind of baseline; each of shape (n_run,), NaN if there is none.

    Attributes
    ----------
    absolute : ndarray
        In the unit of the number, above zero where it rose.
    percent : ndarray
        In percent of the size of the healthy value; NaN if that is near zero.
    low, high : ndarray
        Smallest and largest change of the healthy replicates of the baseline, in the unit of the number.
    """

    absolute: Array
    percent: Array
    low: Array
    high: Array

    @property
    def is_healthy(self) -> NDArray[np.bool_]:
        """Whether the change lies within those of the healthy replicates."""
        with np.errstate(invalid="ignore"):
            return np.asarray((self.absolute >= self.low) & (self.absolute <= self.high))


@dataclass(frozen=True)
class HealthySpread:
    """Spread of the healthy replicates of each run, shape (n_run,); NaN for runs without replicates.

    Attributes
    ----------
    mean : ndarray
        Mean of its replicates.
    low, high : ndarray
        Smallest and largest change of a replicate against the mean of the others, in the unit of the number.
    width : ndarray
        Largest minus smallest replicate; zero without replicates.
    count : ndarray of int
        Replicates with a number.
    """

    mean: Array
    low: Array
    high: Array
    width: Array
    count: NDArray[np.int64]


def relative_change(healthy: Array, values: Array, width: Array | float = 0.0) -> Array:
    """Change from a healthy value in percent of its size, above zero if the number rose.

    NaN if the healthy value is near zero: its size is below 1 % of the largest size over all runs, or
    below the width of its replicates.
    """
    largest = np.nanmax(np.abs(values), initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        known = np.abs(healthy) > np.maximum(LEAST_SHARE * largest, width)
        change: Array = np.where(known, 100.0 * (values - healthy) / np.abs(healthy), np.nan)
    return change


def healthy_spread(values: Array, data: ExperimentData) -> HealthySpread:
    """The spread of the replicates of each healthy run."""
    mean, low, high = (np.full(data.n_run, np.nan) for _ in range(3))
    width, count = np.zeros(data.n_run), np.zeros(data.n_run, dtype=np.int64)
    for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist():
        found = values[data.replicate_of == position]
        found = found[np.isfinite(found)]
        count[position] = len(found)
        if len(found) > 1:
            own = found - (found.sum() - found) / (len(found) - 1)
            mean[position], low[position], high[position] = found.mean(), own.min(), own.max()
            width[position] = np.ptp(found)
    return HealthySpread(mean, low, high, width, count)


def changes(
    values: Array, baseline: NDArray[np.int64], spread: HealthySpread, data: ExperimentData
) -> Changes:
    """Changes against the healthy run of each run, or the mean of its replicates if there are any.

    Parameters
    ----------
    values : ndarray, shape (n_run,)
    baseline : ndarray of int, shape (n_run,)
        Row of the healthy run.
    spread : HealthySpread
        Made from `values`.
    data : ExperimentData
    """
    healthy = spread.mean if data.has_replicates else values
    against = np.where(baseline == names.NO_BASELINE, np.nan, healthy[baseline])
    percent = relative_change(against, values, spread.width[baseline])
    return Changes(values - against, percent, spread.low[baseline], spread.high[baseline])


@dataclass(frozen=True)
class OutputStudy:
    """An output over an experiment.

    Attributes
    ----------
    measured : MeasuredOutput
    healthy : tuple of float
        Range of its values in the fixed baselines; of the mean of their replicates if there are any.
    spread : tuple of float
        Range of the changes of the replicates of the fixed baselines, each against the mean of the others,
        in the unit of the output.
    replicates : HealthySpread
        Of each healthy run.
    n_healthy : int
        Number of fixed baselines, or of their replicates, that have a number.
    n_run : int
        Runs that have a number.
    against : mapping of str to Changes
        ``fixed`` and ``matched`` → changes of all runs.
    """

    measured: MeasuredOutput
    healthy: Range
    spread: Range
    replicates: HealthySpread
    n_healthy: int
    n_run: int
    against: Mapping[str, Changes]


@dataclass(frozen=True)
class IndicatorStudy:
    """An indicator over an experiment: its outputs, and row → reason of a run without any number."""

    measured: MeasuredIndicator
    outputs: tuple[OutputStudy, ...]
    unmeasured: dict[int, str]
    has_replicates: bool


def study_indicators(data: ExperimentData) -> tuple[IndicatorStudy, ...]:
    """All indicators of an experiment except that of the details."""
    return tuple(study_indicator(measured, data) for measured in measured_indicators(data))


def study_indicator(measured: MeasuredIndicator, data: ExperimentData) -> IndicatorStudy:
    """One indicator over the runs of the table."""
    kept = table_runs(data)
    return IndicatorStudy(
        measured,
        tuple(_study_output(output, data, kept) for output in measured.outputs),
        _unmeasured(measured, data, kept),
        data.has_replicates,
    )


def _study_output(measured: MeasuredOutput, data: ExperimentData, kept: NDArray[np.bool_]) -> OutputStudy:
    values, spread = measured.means, healthy_spread(measured.means, data)
    rows = {"fixed": data.fixed_baseline, "matched": data.matched_baseline}
    against = {name: changes(values, baseline, spread, data) for name, baseline in rows.items()}
    baselines = np.unique(data.fixed_baseline[kept & (data.fixed_baseline != names.NO_BASELINE)])
    healthy = spread.mean if data.has_replicates else values
    sources = np.isin(data.replicate_of, baselines) if data.has_replicates else baselines
    return OutputStudy(
        measured=measured,
        healthy=span_of(healthy[baselines]),
        spread=span_of([*spread.low[baselines], *spread.high[baselines]]),
        replicates=spread,
        n_healthy=int(np.isfinite(values[sources]).sum()),
        n_run=int(np.isfinite(values[kept]).sum()),
        against=against,
    )


def _unmeasured(measured: MeasuredIndicator, data: ExperimentData, kept: NDArray[np.bool_]) -> dict[int, str]:
    """Reasons why runs have no number: how they ended, or what is missing in their records."""
    reasons = {}
    for row in np.flatnonzero(kept & ~measured.has_number).tolist():
        status = str(data.columns[names.STATUS][row])
        reasons[row] = measured.obstacle(row) if status == "ok" else status
    return reasons


def indicators_block(studies: tuple[IndicatorStudy, ...], table: RunTable) -> Block | None:
    """What the indicators beside the details measure, and their values without a leak; None without any."""
    if not studies:
        return None
    kinds = [
        each.measured.label
        if each.measured.label == each.measured.indicator.name
        else f"{each.measured.label} ({each.measured.indicator.name})"
        for each in studies
    ]
    what = Table.of(
        {
            "Indicator": kinds,
            "Measures": [each.measured.indicator.summary for each in studies],
            "Channels": [_channels(each.measured.indicator) for each in studies],
            "Options": [_options(each.measured.indicator) or "default" for each in studies],
        },
        key="indicators",
    )
    ranges = [_ranges_table(studies, table)] if studies[0].has_replicates else []
    said = tuple(sentence for each in studies for sentence in _holes(each, table))
    return Block("indicators", "Indicators", said, (what, _outputs_table(studies), *ranges))


def _channels(indicator: Indicator[Any]) -> str:
    return joined([channel.replace("_", " ") for channel in sorted(indicator.channels)])


def _options(indicator: Indicator[Any]) -> str:
    stated = indicator.options.model_dump(mode="json", exclude_defaults=True)
    return ", ".join(f"{name} = {value}" for name, value in stated.items())


def _holes(study: IndicatorStudy, table: RunTable) -> Iterator[str]:
    """Which runs have no number, by the reason."""
    if not study.unmeasured:
        return
    rows, label = {row.position: row for row in table.rows}, study.measured.label
    yield f"{label}: {len(study.unmeasured):,} of {counted(len(rows), 'run')} could not be measured."
    for reason in Counter(study.unmeasured.values()):
        named = [row_name(rows[row]) for row, why in study.unmeasured.items() if why == reason]
        yield f"{some(named)}: {reason}."


def _variables(studies: tuple[IndicatorStudy, ...]) -> list[tuple[str, OutputStudy]]:
    """Label and output of all indicators."""
    return [(each.measured.label, output) for each in studies for output in each.outputs]


def _outputs_table(studies: tuple[IndicatorStudy, ...]) -> Table:
    found = _variables(studies)
    outputs = [output for _, output in found]
    change: list[Column] = []
    note = ""
    if studies[0].has_replicates:
        change = [Column("Healthy change", [_value(each, each.spread) for each in outputs])]
        note = "Healthy change: each replicate against the mean of the others, in the unit of the output."
    columns = (
        Column("Output", [f"{label}.{each.measured.title}" for label, each in found], is_text=True),
        Column("Meaning", [each.measured.output.long_name for each in outputs], is_text=True),
        Column("Unit", [_unit(each) or HOLE for each in outputs], is_text=True),
        Column("Value", [_value(each, each.healthy) for each in outputs]),
        *change,
        Column("Healthy runs", [each.n_healthy for each in outputs]),
    )
    title = "Outputs without a leak, under the conditions of the fixed baseline"
    notes = (note,) if note else ()
    return Table(columns, title, "indicator-outputs", notes, group_breaks([label for label, _ in found]))


def _ranges_table(studies: tuple[IndicatorStudy, ...], table: RunTable) -> Table:
    rows = [
        (label, output, row)
        for label, output in _variables(studies)
        for row in table.rows
        if output.replicates.count[row.position]
    ]
    spreads = [(output.replicates, row.position) for _, output, row in rows]
    counts = [int(spread.count[at]) for spread, at in spreads]
    ends = {
        "Mean": [(spread.mean[at], spread.mean[at]) for spread, at in spreads],
        "Range of changes": [(spread.low[at], spread.high[at]) for spread, at in spreads],
    }
    columns = (
        Column("Output", [f"{label}.{_title(output)}" for label, output, _ in rows], is_text=True),
        Column("Condition", [row_name(row) for *_, row in rows], is_text=True),
        Column("Replicates", counts),
        *(
            Column(title, [_value(output, end) for (_, output, _), end in zip(rows, own, strict=True)])
            for title, own in ends.items()
        ),
    )
    note = (
        "Each replicate against the mean of the others, in the unit of the output. Another draw lies outside"
        " the range of n replicates in at most about 2 of n+1 cases:"
        f" 2 of {max(counts, default=0) + 1} here."
    )
    breaks = group_breaks([id(output) for _, output, _ in rows])
    return Table(columns, "Healthy range of each condition", "indicator-ranges", (note,), breaks)


def _unit(output: OutputStudy) -> str:
    """The unit that an output is shown in; empty for a number without one."""
    unit = output.measured.shown_unit
    return "" if unit == "1" else unit


def _title(output: OutputStudy) -> str:
    unit = _unit(output)
    return f"{output.measured.title} [{unit}]" if unit else output.measured.title


def _value(output: OutputStudy, span: Range) -> str:
    if span[0] != span[0]:
        return HOLE
    return span_text(*(f"{each:.4g}" for each in output.measured.shown(np.array(span)).tolist()))


def indicator_record(study: IndicatorStudy, run_ids: list[str]) -> dict[str, Any]:
    """An indicator: what it is, its outputs with their changes over each axis, and what has no number."""
    indicator = study.measured.indicator
    return {
        "label": study.measured.label,
        "indicator": indicator.name,
        "version": indicator.version,
        "channels": sorted(indicator.channels),
        "options": indicator.options.model_dump(mode="json"),
        "outputs": [_output_record(study, output) for output in study.outputs],
        "not_measured": [{"run_id": run_ids[row], "why": why} for row, why in study.unmeasured.items()],
    }


def _output_record(study: IndicatorStudy, output: OutputStudy) -> dict[str, Any]:
    described, has_replicates = output.measured.output, study.has_replicates
    return {
        "name": described.name,
        "unit": described.unit,
        "long_name": described.long_name,
        "dims": dict(described.dims),
        "runs": output.n_run,
        "healthy_runs": output.n_healthy,
        "healthy": _ends(output.healthy),
        "healthy_change": _ends(output.spread) if has_replicates else None,
    }


def _ends(span: Range) -> list[float | None]:
    return list(map(finite, span))


def output_values(study: IndicatorStudy, row: int) -> dict[str, Any]:
    """``label.output`` → number of a run, or the numbers of an array; None if it has none."""
    return {
        study.measured.variable(output.measured): plain(output.measured.values[row])
        for output in study.outputs
    }


def output_columns(study: IndicatorStudy, row: int) -> dict[str, float | str | None]:
    """Header with unit → number of a run, and its changes; each number of an array by itself.

    With replicates also the healthy range of a change, and 1 if it lies within. If a run of the experiment
    could not be measured, ``label.obstacle`` gives the reason.
    """
    columns: dict[str, float | str | None] = {}
    for output in study.outputs:
        name, unit = study.measured.variable(output.measured), output.measured.output.unit
        shown = "" if unit == "1" else f" [{unit}]"
        values = output.measured.values[row]
        for place in np.ndindex(values.shape):
            index = "".join(f"[{part}]" for part in place)
            columns[f"{name}{index}{shown}"] = finite(float(values[place]))
        for kind, changes in output.against.items():
            change = f"{name} change_{kind}"
            columns[f"{change} [%]"] = finite(float(changes.percent[row]))
            columns[f"{change}{shown}"] = finite(float(changes.absolute[row]))
            if study.has_replicates:
                columns[f"{change} healthy_low{shown}"] = finite(float(changes.low[row]))
                columns[f"{change} healthy_high{shown}"] = finite(float(changes.high[row]))
                columns[f"{change} within_healthy"] = int(changes.is_healthy[row])
    if study.unmeasured:
        columns[f"{study.measured.label}{names.OBSTACLE}"] = study.unmeasured.get(row, "")
    return columns
