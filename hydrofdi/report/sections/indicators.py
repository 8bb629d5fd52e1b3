"""A section for each indicator: its values without a leak, and its change over all that varies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.axes import Axis
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.indicators.changes import LEAST_SHARE
from hydrofdi.report.indicators.study import GroupChange, IndicatorStudy, OutputStudy
from hydrofdi.report.ranges import Range
from hydrofdi.report.runs import TableRow
from hydrofdi.report.wording import joined, row_name, signed, some
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE

_NULL = "In parentheses: within the healthy range of each run's own baseline, so no sign of a leak."
_NO_NULL = (
    "Without healthy replicates (replicates: in the experiment file) it is not known how much healthy"
    " actuators differ."
)


def indicator_blocks(analysis: Analysis) -> tuple[Block, ...]:
    """A section for each indicator beside that of the details."""
    return tuple(_block(analysis, study) for study in analysis.indicators)


def _block(analysis: Analysis, study: IndicatorStudy) -> Block:
    measured = study.measured
    kind = measured.indicator.name
    title = f"Indicator {measured.label}" + (f" ({kind})" if kind != measured.label else "")
    key = f"indicator-{measured.label}"
    paragraphs = (_what(study), *_holes(analysis, study))
    if not study.varies:
        still = "None of its outputs differs between the runs."
        return Block(key, title, (*paragraphs, still), (_outputs_sheet(key, study),))
    baselines = ("fixed", "matched") if study.has_replicates else analysis.baselines
    changes = [_changes_sheet(key, study, axis, baselines) for axis in study.axes]
    ranges = (_ranges_sheet(analysis, key, study),) if study.has_replicates else ()
    against = (_against(study),) if baselines else ()
    said = (*paragraphs, *against, *_idle(study), *_sealed_outside(analysis, study))
    return Block(key, title, said, (_outputs_sheet(key, study), *ranges, *changes))


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
    null = _NULL if study.has_replicates else _NO_NULL
    return (
        f"Changes are in percent of {healthy}, above zero if the number rose (δ is above zero if it"
        f" fell). Δ marks a change in the output's own unit, where the healthy value is near zero: below"
        f" {100 * LEAST_SHARE:g} % of the largest size over all runs, or below the spread of its replicates."
        f" {null}"
    )


def _idle(study: IndicatorStudy) -> Iterator[str]:
    if study.idle_axes:
        yield f"No output differs over {joined([axis.header for axis in study.idle_axes])}: not shown."


def _sealed_outside(analysis: Analysis, study: IndicatorStudy) -> Iterator[str]:
    """Sealed runs that lie outside of the range of their own replicates."""
    if not study.has_replicates:
        return
    for output in study.outputs:
        is_outside = np.isfinite(output.matched.low) & ~output.matched.is_healthy
        outside = [row_name(row) for row, _ in _conditions(analysis, output) if is_outside[row.position]]
        if outside:
            yield f"Outside its healthy range without a leak, {output.measured.title}: {some(outside)}."


def _conditions(analysis: Analysis, output: OutputStudy) -> list[tuple[TableRow, int]]:
    """The healthy runs with replicates, and how many of these have a number."""
    counts = output.replicates.count
    return [(row, int(counts[row.position])) for row in analysis.table.rows if counts[row.position]]


def _ranges_sheet(analysis: Analysis, key: str, study: IndicatorStudy) -> Sheet:
    cells: list[tuple[Cell, ...]] = []
    breaks, most = [], 0
    for output in study.outputs:
        breaks.append(len(cells))
        spread = output.replicates
        for place, (row, count) in enumerate(_conditions(analysis, output)):
            most, at = max(most, count), row.position
            cells.append((
                Cell("" if place else _title(output)),
                Cell(row_name(row)),
                Cell(f"{count:,}", value=count),
                Cell(_value(output, Range(float(spread.mean[at]), float(spread.mean[at])))),
                Cell(_value(output, Range(float(spread.low[at]), float(spread.high[at])))),
            ))  # fmt: skip
    return Sheet(
        f"{key}-healthy",
        "Healthy range of each condition",
        ("Output", "Condition", "Replicates", "Mean", "Range of changes"),
        tuple(cells),
        breaks=tuple(breaks[1:]),
        text_columns=(0, 1),
        note="Each replicate against the mean of the others, in the unit of the output. Another draw "
        "lies outside the range of n replicates in at most about 2 of n+1 cases: "
        f"2 of {most + 1} here.",
    )


def _outputs_sheet(key: str, study: IndicatorStudy) -> Sheet:
    spread = ("Healthy change",) if study.has_replicates else ()
    return Sheet(
        key,
        "Outputs without a leak, under the conditions of the fixed baseline",
        ("Output", "Meaning", "Unit", "Value", *spread, "Healthy runs"),
        tuple(_output_cells(study, output) for output in study.outputs),
        text_columns=(0, 1, 2),
        note="Healthy change: each replicate against the mean of the others, in the unit of the output."
        if spread
        else "",
    )


def _output_cells(study: IndicatorStudy, output: OutputStudy) -> tuple[Cell, ...]:
    described = output.measured.output
    spread = (Cell(_value(output, output.spread)),) if study.has_replicates else ()
    return (
        Cell(output.measured.title),
        Cell(described.long_name),
        Cell(_unit(output) or HOLE),
        Cell(_value(output, output.healthy), value=output.healthy.low),
        *spread,
        Cell(f"{output.n_healthy:,}", value=output.n_healthy),
    )


def _changes_sheet(key: str, study: IndicatorStudy, axis: Axis, baselines: tuple[str, ...]) -> Sheet:
    entries = [(output, change) for output in study.outputs for change in output.over[axis.name]]
    titles = [_title(output) for output, _ in entries]
    breaks = group_breaks(titles)
    return Sheet(
        f"{key}-{axis.name}",
        f"{'Change' if baselines else 'Values'} over {axis.header}",
        ("Output", axis.header, "Runs", "Value", *(f"Against {name} [%]" for name in baselines)),
        tuple(
            (Cell(title if place in (0, *breaks) else ""), *_change_cells(output, change, baselines))
            for place, (title, (output, change)) in enumerate(zip(titles, entries, strict=True))
        ),
        breaks=breaks,
        text_columns=(0,),
    )


def _change_cells(output: OutputStudy, change: GroupChange, baselines: tuple[str, ...]) -> tuple[Cell, ...]:
    against = {
        "fixed": (change.fixed, change.fixed_absolute, change.fixed_is_healthy),
        "matched": (change.matched, change.matched_absolute, change.matched_is_healthy),
    }
    return (
        Cell(change.group.text, value=change.group.value),
        Cell(f"{change.n_run:,}", value=change.n_run),
        Cell(_value(output, change.values)),
        *(Cell(_marked(output, *against[name])) for name in baselines),
    )


def _marked(output: OutputStudy, percent: Range, absolute: Range, is_healthy: bool) -> str:
    has_percent = percent.low == percent.low or absolute.low != absolute.low
    text = _span(percent) if has_percent else f"Δ\N{NO-BREAK SPACE}{_value(output, absolute, '+.3g')}"
    return f"({text})".replace(" ", "\N{NO-BREAK SPACE}") if is_healthy else text


def _span(span: Range) -> str:
    return _joined(_percent(span.low), _percent(span.high))


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
    if span.low != span.low:
        return HOLE
    low, high = output.measured.shown(np.array([span.low, span.high])).tolist()
    return _joined(f"{low:{form}}", f"{high:{form}}")


def _joined(low: str, high: str) -> str:
    return low if low == high else f"{low} … {high}".replace(" ", "\N{NO-BREAK SPACE}")
