"""What a command answers: from its fields follow text, page and JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from html import escape
from typing import Any

from hydrofdi.report.table import TEXT_WIDTH, Table, plain
from hydrofdi.settings.readable import HOLE, number_text, shown_bytes, time_text

_MOST_VALUES = 6
"""Most values of a list that are shown; of longer ones, the ends."""


class Strong(str):
    """A line that stands out."""

    __slots__ = ()


Piece = str | Table | Mapping[str, Any]
"""Lines, a table, or facts: name → value."""


class Answer:
    """What a command finds. Its class declares fields, and where needed what people read of them.

    It is true if all is well; else the command ends with exit code 1. Parameters are shown in its ``units``,
    if it has any.
    """

    def parts(self) -> Iterable[Piece]:
        """What people read."""
        return [self.to_dict()]

    def asides(self) -> Iterable[str]:
        """Sentences beside it: warnings, and what was left out."""
        return ()

    def to_dict(self) -> dict[str, Any]:
        """Its fields as JSON has them; None in place of what is not finite."""
        record: dict[str, Any] = plain(self)
        return record

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        return "\n".join([*(line for _, lines in said(self) for line, _ in lines), *self.asides()])

    def _repr_html_(self) -> str:
        texts = [
            part._repr_html_() if isinstance(part, Table) else _preformatted(line for line, _ in lines)
            for part, lines in said(self)
        ]
        return "".join([*texts, _preformatted(self.asides())])


@dataclass(frozen=True, repr=False)
class Reply(Answer):
    """An answer whose JSON, parts and sentences beside it are stated."""

    record: Mapping[str, Any]
    said: Iterable[Piece] = ()
    told: Iterable[str] = ()
    is_sound: bool = True

    def __bool__(self) -> bool:
        return self.is_sound

    def parts(self) -> Iterable[Piece]:
        """What is stated."""
        return self.said

    def asides(self) -> Iterable[str]:
        """What is stated."""
        return self.told

    def to_dict(self) -> dict[str, Any]:
        """What is stated."""
        record: dict[str, Any] = plain(self.record)
        return record


def said(found: Answer, width: int = TEXT_WIDTH) -> Iterator[tuple[Piece, list[tuple[str, str]]]]:
    """The parts that people read, each with its lines and their style."""
    units = getattr(found, "units", {})
    if units:
        from hydrofdi.config.shown_values import shown_in
    with shown_in(units) if units else nullcontext():
        for part in found.parts():
            yield part, [*_styled_lines(part, width)]


def _styled_lines(part: Piece, width: int) -> Iterator[tuple[str, str]]:
    if isinstance(part, Table):
        yield from ([(part.title, "bold")] if part.title else [])
        yield from ((line, "") for line in part.lines(width))
        yield from ((note, "dim") for note in part.notes)
    elif isinstance(part, Mapping):
        yield from ((line, "") for line in _fact_lines(part))
    else:
        yield from ((line, "bold" if isinstance(part, Strong) else "") for line in part.split("\n"))


def _preformatted(lines: Iterable[str]) -> str:
    text = "\n".join(lines)
    return f"<pre>{escape(text)}</pre>" if text else ""


def _fact_lines(record: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """A line for each fact of a record, below each other; a record within it stands below its name."""
    known = {name: found for name, found in record.items() if found or (found == 0 and found is not False)}
    width = max(map(len, known), default=0) + 2
    for name, found in known.items():
        title = name if "." in name else name.replace("_", " ")
        is_deep = isinstance(found, Mapping) and any("." in key for key in found)
        if is_deep and "." not in name:
            yield f"{indent}{title}"
            yield from _fact_lines(found, f"{indent}  ")
        else:
            yield f"{indent}{title:<{width}}{_text(name, found)}"


def _text(name: str, found: Any) -> str:
    """A value as people read it: parameters with their units, durations and sizes by their names."""
    if isinstance(found, tuple):
        return " → ".join(_text(name, each) for each in found)
    if isinstance(found, list):
        shown = found if len(found) <= _MOST_VALUES else [found[0], "…", found[-1]]
        text = ", ".join(_text(name, each) for each in shown)
        return text if shown is found else f"{len(found):,} values, {text}"
    if "." in name and found != "…":
        from hydrofdi.config.request import parameter_names
        from hydrofdi.config.shown_values import shown_value

        parameter = name.rpartition(": ")[2]
        if parameter in parameter_names() and found is not None:
            return shown_value(parameter, found)
    if isinstance(found, Mapping):
        return ", ".join(f"{key} {_text(key, each)}" for key, each in found.items())
    if isinstance(found, float):
        return time_text(found) if "seconds" in name else number_text(found)
    if isinstance(found, int) and not isinstance(found, bool):
        return shown_bytes(found) if name.endswith("bytes") else f"{found:,}"
    return HOLE if found is None else str(found)
