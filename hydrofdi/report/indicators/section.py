"""A section for each indicator: values without a leak, changes over all that varies; plain data."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.axes import Axis
from hydrofdi.report.document import Block, group_breaks
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.indicators.study import LEAST_SHARE, Change, IndicatorStudy, OutputStudy, Range
from hydrofdi.report.runs import TableRow
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import joined, row_name, signed, some, span_text
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE
from hydrofdi.store.layout.names import OBSTACLE

_GAP = "\N{NO-BREAK SPACE}"
_NULL = "In parentheses: within the healthy range of each run's own baseline, so no sign of a leak."
_NO_NULL = (
    "Without healthy replicates (replicates: in the experiment file) it is not known how much healthy"
    " actuators differ."
)


def indicator_blocks(analysis: Analysis) -> tuple[Block, ...]:
    """A section for each indicator beside that of the details."""
    return tuple(_block(analysis, study) for study in analysis.indicators)


def _block(analysis: Analysis, study: IndicatorStudy) -> Block:
    measured, kind = study.measured, study.measured.indicator.name
    title = f"Indicator {measured.label}" + (f" ({kind})" if kind != measured.label else "")
    key = f"indicator-{measured.label}"
    paragraphs = (_what(study), *_holes(analysis, study))
    if not study.varies:
        still = "None of its outputs differs between the runs."
        return Block(key, title, (*paragraphs, still), (_outputs_table(key, study),))
    baselines = ("fixed", "matched") if study.has_replicates else analysis.baselines
    changes = [_changes_table(key, study, axis, baselines) for axis in study.axes]
    ranges = (_ranges_table(analysis, key, study),) if study.has_replicates else ()
    against = (_against(study),) if baselines else ()
    idle = joined([axis.header for axis in study.idle_axes])
    not_shown = (f"No output differs over {idle}: not shown.",) if idle else ()
    said = (*paragraphs, *against, *not_shown, *_sealed_outside(analysis, study))
    return Block(key, title, said, (_outputs_table(key, study), *ranges, *changes))


def _what(study: IndicatorStudy) -> str:
    indicator = study.measured.indicator
    channels = joined([channel.replace("_", " ") for channel in sorted(indicator.channels)])
    stated = indicator.options.model_dump(mode="json", exclude_defaults=True)
    options = ", ".join(f"{name} = {value}" for name, value in stated.items()) or "the default ones"
    return f"{indicator.summary} Channels: {channels}. Options: {options}."


def _holes(analysis: Analysis, study: IndicatorStudy) -> Iterator[str]:
    """Which runs have no number, by the reason."""
    if not study.unmeasured:
        return
    rows = {row.position: row for row in analysis.table.rows}
    yield f"{len(study.unmeasured):,} of {counted(study.n_run, 'run')} could not be measured."
    for reason in Counter(study.unmeasured.values()):
        names = [row_name(rows[row]) for row, why in study.unmeasured.items() if why == reason]
        yield f"{some(names)}: {reason}."


def _against(study: IndicatorStudy) -> str:
    healthy = "the mean of the replicates of the healthy run" if study.has_replicates else "the healthy run"
    return (
        f"Changes are in percent of {healthy}, above zero if the number rose (δ is above zero if it"
        f" fell). Δ marks a change in the output's own unit, where the healthy value is near zero: below"
        f" {100 * LEAST_SHARE:g} % of the largest size over all runs, or below the spread of its replicates."
        f" {_NULL if study.has_replicates else _NO_NULL}"
    )


def _sealed_outside(analysis: Analysis, study: IndicatorStudy) -> Iterator[str]:
    """Sealed runs that lie outside of the range of their own replicates."""
    for output in study.outputs if study.has_replicates else ():
        matched = output.against["matched"]
        is_outside = np.isfinite(matched.low) & ~matched.is_healthy
        outside = [row_name(row) for row, _ in _conditions(analysis, output) if is_outside[row.position]]
        if outside:
            yield f"Outside its healthy range without a leak, {output.measured.title}: {some(outside)}."


def _conditions(analysis: Analysis, output: OutputStudy) -> list[tuple[TableRow, int]]:
    """The healthy runs with replicates, and how many of these have a number."""
    counts = output.replicates.count
    return [(row, int(counts[row.position])) for row in analysis.table.rows if counts[row.position]]


def _ranges_table(analysis: Analysis, key: str, study: IndicatorStudy) -> Table:
    rows = [(output, *found) for output in study.outputs for found in _conditions(analysis, output)]
    ends = [
        (spread.mean[at], spread.low[at], spread.high[at])
        for output, row, _ in rows
        for spread, at in [(output.replicates, row.position)]
    ]
    breaks = group_breaks([id(output) for output, *_ in rows])
    columns = (
        Column("Output", _once([_title(output) for output, *_ in rows], breaks), is_text=True),
        Column("Condition", [row_name(row) for _, row, _ in rows], is_text=True),
        Column("Replicates", [count for *_, count in rows]),
        *(
            Column(title, [_value(row[0], span(end)) for row, end in zip(rows, ends, strict=True)])
            for title, span in (("Mean", lambda end: (end[0], end[0])), ("Range of changes", lambda e: e[1:]))
        ),
    )
    note = (
        "Each replicate against the mean of the others, in the unit of the output. Another draw lies outside"
        " the range of n replicates in at most about 2 of n+1 cases:"
        f" 2 of {max((count for *_, count in rows), default=0) + 1} here."
    )
    return Table(columns, "Healthy range of each condition", f"{key}-healthy", (note,), breaks)


def _outputs_table(key: str, study: IndicatorStudy) -> Table:
    outputs, change = study.outputs, []
    if study.has_replicates:
        change = [Column("Healthy change", [_value(each, each.spread) for each in outputs])]
    columns = (
        Column("Output", [each.measured.title for each in outputs], is_text=True),
        Column("Meaning", [each.measured.output.long_name for each in outputs], is_text=True),
        Column("Unit", [_unit(each) or HOLE for each in outputs], is_text=True),
        Column("Value", [_value(each, each.healthy) for each in outputs]),
        *change,
        Column("Healthy runs", [each.n_healthy for each in outputs]),
    )
    note = "Healthy change: each replicate against the mean of the others, in the unit of the output."
    title = "Outputs without a leak, under the conditions of the fixed baseline"
    return Table(columns, title, key, (note,) if change else ())


def _changes_table(key: str, study: IndicatorStudy, axis: Axis, baselines: tuple[str, ...]) -> Table:
    rows = [(output, change) for output in study.outputs for change in output.over[axis.name]]
    titles = [_title(output) for output, _ in rows]
    breaks = group_breaks(titles)
    columns = (
        Column("Output", _once(titles, breaks), is_text=True),
        Column(axis.header, [change.group.text for _, change in rows]),
        Column("Runs", [change.n_run for _, change in rows]),
        Column("Value", [_value(output, change.values) for output, change in rows]),
        *(
            Column(f"Against {name} [%]", [_marked(output, change.against[name]) for output, change in rows])
            for name in baselines
        ),
    )
    title = f"{'Change' if baselines else 'Values'} over {axis.header}"
    return Table(columns, title, f"{key}-{axis.name}", (), breaks)


def _once(titles: list[str], breaks: tuple[int, ...]) -> list[str]:
    """Titles at the first row of each group."""
    return [title if place in (0, *breaks) else "" for place, title in enumerate(titles)]


def _marked(output: OutputStudy, change: Change) -> str:
    if change.percent[0] == change.percent[0] or change.absolute[0] != change.absolute[0]:
        text = span_text(*map(_percent, change.percent))
    else:
        text = f"Δ{_GAP}{_value(output, change.absolute, '+.3g')}"
    return f"({text})".replace(" ", _GAP) if change.is_healthy else text


def _percent(value: float) -> str:
    """A change with its sign; more decimals where it is small."""
    return signed(value, 1 if abs(value) >= 1.0 or value == 0.0 else 3)


def _unit(output: OutputStudy) -> str:
    """The unit that an output is shown in; empty for a number without one."""
    unit = output.measured.shown_unit
    return "" if unit == "1" else unit


def _title(output: OutputStudy) -> str:
    unit = _unit(output)
    return f"{output.measured.title} [{unit}]" if unit else output.measured.title


def _value(output: OutputStudy, span: Range, form: str = ".4g") -> str:
    if span[0] != span[0]:
        return HOLE
    return span_text(*(f"{each:{form}}" for each in output.measured.shown(np.array(span)).tolist()))


def indicator_record(study: IndicatorStudy, run_ids: list[str]) -> dict[str, Any]:
    """An indicator: what it is, its outputs with their changes over each axis, and what has no number."""
    indicator = study.measured.indicator
    return {
        "label": study.measured.label,
        "indicator": indicator.name,
        "version": indicator.version,
        "channels": sorted(indicator.channels),
        "options": indicator.options.model_dump(mode="json"),
        "not_affected_by": [axis.name for axis in study.idle_axes],
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
        "changes": [
            {
                "parameter": axis.name,
                "value": change.group.value,
                "text": change.group.text,
                "runs": change.n_run,
                "values": _ends(change.values),
            }
            | {f"change_{name}": _ends(own.absolute) for name, own in change.against.items()}
            | {f"change_{name}_percent": _ends(own.percent) for name, own in change.against.items()}
            | {
                f"within_healthy_{name}": own.is_healthy if has_replicates else None
                for name, own in change.against.items()
            }
            for axis in study.axes
            for change in output.over[axis.name]
        ],
    }


def _ends(span: Range) -> list[float | None]:
    return list(map(finite, span))


def output_values(study: IndicatorStudy, row: int) -> dict[str, Any]:
    """``label.output`` → number of a run, or the numbers of an array; None if it has none."""
    return {
        study.measured.variable(output.measured): _plain(output.measured.values[row])
        for output in study.outputs
    }


def _plain(values: Any) -> Any:
    return finite(float(values)) if np.ndim(values) == 0 else [_plain(part) for part in values]


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
        columns[f"{study.measured.label}{OBSTACLE}"] = study.unmeasured.get(row, "")
    return columns
