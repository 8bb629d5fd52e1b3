"""A section for each indicator: its values without a leak, and its change over all that varies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.indicators.axes import Axis
from hydrofdi.report.indicators.study import GroupChange, IndicatorStudy, OutputStudy
from hydrofdi.report.ranges import Range
from hydrofdi.report.wording import HOLE, counted, joined, row_name, signed, some
from hydrofdi.units import convert

_SHOWN_UNITS = {"Pa": "kPa", "m": "mm", "m^3/s": "L/min"}
"""SI unit of an output → unit that it is shown in."""

_NULL = "In parentheses: no more than healthy replicates differ by, so no sign of a leak."
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
    changes = [_changes_sheet(key, study, axis) for axis in study.axes]
    return Block(key, title, (*paragraphs, _against(study)), (_outputs_sheet(key, study), *changes))


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
        f"Changes are in percent of {healthy}, above zero where the number rose (δ is above zero where it"
        f" fell). {null}"
    )


def _outputs_sheet(key: str, study: IndicatorStudy) -> Sheet:
    spread = ("Healthy change [%]",) if study.has_replicates else ()
    return Sheet(
        key,
        "Outputs without a leak, under the conditions of the fixed baseline",
        ("Output", "Meaning", "Unit", "Value", *spread, "Healthy runs"),
        tuple(_output_cells(study, output) for output in study.outputs),
        text_columns=(0, 1, 2),
        note="Healthy change: each replicate against the mean of the others." if spread else "",
    )


def _output_cells(study: IndicatorStudy, output: OutputStudy) -> tuple[Cell, ...]:
    described = output.measured.output
    spread = (Cell(_span(output.spread)),) if study.has_replicates else ()
    return (
        Cell(output.measured.title),
        Cell(described.long_name),
        Cell(_unit(output) or HOLE),
        Cell(_value(output, output.healthy), value=output.healthy.low),
        *spread,
        Cell(f"{output.n_healthy:,}", value=output.n_healthy),
    )


def _changes_sheet(key: str, study: IndicatorStudy, axis: Axis) -> Sheet:
    entries = [(output, change) for output in study.outputs for change in output.over[axis.name]]
    titles = [_title(output) for output, _ in entries]
    breaks = group_breaks(titles)
    return Sheet(
        f"{key}-{axis.name}",
        f"Change over {axis.header}",
        ("Output", axis.header, "Runs", "Value", "Against fixed [%]", "Against matched [%]"),
        tuple(
            (Cell(title if place in (0, *breaks) else ""), *_change_cells(output, change))
            for place, (title, (output, change)) in enumerate(zip(titles, entries, strict=True))
        ),
        breaks=breaks,
        text_columns=(0,),
    )


def _change_cells(output: OutputStudy, change: GroupChange) -> tuple[Cell, ...]:
    return (
        Cell(change.group.text, value=change.group.value),
        Cell(f"{change.n_run:,}", value=change.n_run),
        Cell(_value(output, change.values)),
        Cell(_marked(change.fixed, change.fixed_is_healthy)),
        Cell(_marked(change.matched, change.matched_is_healthy)),
    )


def _marked(span: Range, is_healthy: bool) -> str:
    return f"({_span(span)})" if is_healthy else _span(span)


def _span(span: Range) -> str:
    return _joined(_percent(span.low), _percent(span.high))


def _percent(value: float) -> str:
    """A change with its sign; more decimals where it is small."""
    return signed(value, 1 if abs(value) >= 1.0 or value == 0.0 else 3)


def _unit(output: OutputStudy) -> str:
    """The unit that an output is shown in; empty for a number without one."""
    unit = output.measured.output.unit
    return "" if unit == "1" else _SHOWN_UNITS.get(unit, unit)


def _title(output: OutputStudy) -> str:
    unit = _unit(output)
    return f"{output.measured.title} [{unit}]" if unit else output.measured.title


def _value(output: OutputStudy, span: Range) -> str:
    if span.low != span.low:
        return HOLE
    shown = _SHOWN_UNITS.get(output.measured.output.unit)
    low, high = (value if shown is None else convert(value, shown) for value in (span.low, span.high))
    return _joined(f"{low:.4g}", f"{high:.4g}")


def _joined(low: str, high: str) -> str:
    return low if low == high else f"{low} … {high}".replace(" ", "\N{NO-BREAK SPACE}")
