"""Descriptions that are proposed for files: what their headers and first rows state, in YAML to paste."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.columns import MOST_SHOWN, RejectionError, is_unit, shortened, split_title
from hydrofdi.records.description import FormatConfig, unit_mistake
from hydrofdi.records.dialects import below_preamble, encoding_of, long_form, thousands_of
from hydrofdi.records.opening import open_table
from hydrofdi.records.proposed_time import Proposal, clocks_of, step_of, time_lines, time_of
from hydrofdi.records.rows import MISSING_LIKE
from hydrofdi.records.text import TextTable, last_part

_WITHOUT_UNIT = {"LabVIEW Measurement": "s", "SampleTime[ms]": "ms"}
"""Text above the rows of a program → the unit of its column of time, which it does not state."""


def proposed_description(file: Path, pattern: str, frequency: float | None = None) -> str:
    """YAML of a description of files with what one of them states; an ellipsis stands for the rest."""
    try:
        found = _proposal(file)
        with (
            np.errstate(all="ignore"),
            open_table(file, str(file), FormatConfig(**found.form)) as found.table,
        ):
            titles = found.table.titles
            found.names = [*found.names[: len(titles)], *titles[len(found.names) :]]
            return "\n".join(_lines(found, pattern, frequency))
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None


def _lines(found: Proposal, pattern: str, frequency: float | None) -> Iterator[str]:
    yield f"files: {pattern!r}"
    channels, time = found.channels(), time_of(found)
    found.form |= _missing(found, [*channels.values(), *([] if time is None else [time])])
    if found.form:
        yield f"format: {_flow(found.form)}"
    clocks: dict[int, int] = {}
    if frequency:
        yield f"sampling_frequency: {frequency:g} Hz"
    elif time is None:
        yield "sampling_frequency: …"
    else:
        clocks = clocks_of(found, time)
        time = min(set(clocks.values()), key=lambda each: step_of(found.table, each)) if clocks else time
        yield from time_lines(found, time, [*channels.values()], has_clocks=bool(clocks))
    left = [
        shortened(title)
        for n, title in enumerate(found.names)
        if n not in (*channels.values(), time) and title
    ]
    if left and "long" not in found.form:
        yield f"# other columns: {', '.join(left[:MOST_SHOWN])}{', …' * (len(left) > MOST_SHOWN)}"
    yield "channels:"
    for channel, position in channels.items():
        clock = clocks.get(position, time)
        own = f", time: {clock + 1}" if clock is not None and clock != time else ""
        keys = f"{{column: {found.named(position)}, unit: {found.unit(position, channel.unit)}{own}}}"
        yield f"  {channel}: {keys}" + f"  # {found.names[position]}" * found.named(position).isdigit()
    if not channels:
        yield "  chamber_1_pressure: {column: '…', unit: …}"


def _flow(form: Mapping[str, Any]) -> str:
    def text(value: Any) -> str:
        if isinstance(value, Mapping):
            return _flow(value)
        if isinstance(value, list):
            return f"[{', '.join(map(text, value))}]"
        return str(value).lower() if isinstance(value, bool | int) else f"{value!r}"

    return f"{{{', '.join(f'{key}: {text(value)}' for key, value in form.items())}}}"


def _missing(found: Proposal, positions: Sequence[int]) -> dict[str, Any]:
    """Texts in the columns that programs write for missing values."""
    if not isinstance(found.table, TextTable):
        return {}
    with suppress(DataError, RejectionError):
        found.table.load([n for n in positions if not found.table.is_dated(n)])
        return {}
    tokens = found.table.tokens(MISSING_LIKE)
    return {"missing": tokens} if tokens else {}


def _proposal(file: Path) -> Proposal:
    encoding = encoding_of(file)
    skip, table = below_preamble(file, encoding)
    if not isinstance(table, TextTable):
        return Proposal(table, names=[title.rpartition("/")[2] for title in table.titles])
    form = {"skip": skip, "encoding": encoding}
    defaults = FormatConfig().model_dump()
    found = Proposal(table, {key: value for key, value in form.items() if value != defaults[key]})
    found.names = [title if is_unit(title.rpartition("/")[2]) else last_part(title) for title in table.titles]
    first = table.first_numeric
    if signs := thousands_of(first[1] if first else []):
        found.form |= signs
    elif table.has_decimal_commas:
        found.form["decimal"] = ","
    if table.units_in_cells:
        found.form["units_in_cells"] = True
    if found.channels():
        above = table.lines_above(first[0]) if first else []
        found.units = dict(_units_beside(found, above))
        if first and table.n_between:
            found.form |= {"skip": first[0] - 1, "header": False}
    elif long := long_form(table):
        found.form["long"] = long
        with open_table(file, str(file), FormatConfig(**found.form)) as pivoted:
            found.names = pivoted.titles
    return found


def _units_beside(found: Proposal, above: Sequence[Sequence[str]]) -> Iterator[tuple[int, str]]:
    """Units in a line above the rows that has one for each channel; the time of programs that state none."""
    channels = found.channels()
    for cells in above:
        texts = [split_title(cell.strip())[0] for cell in cells]
        fits = (n < len(texts) and not unit_mistake(texts[n], each.unit) for each, n in channels.items())
        if channels and all(fits):
            yield from ((n, text) for n, text in enumerate(texts) if is_unit(text))
            break
    units = (unit for text, unit in _WITHOUT_UNIT.items() if any(text in cells for cells in above))
    if unit := next(units, ""):
        yield from ((n, unit) for n, name in enumerate(found.names) if name == found.names[0])
