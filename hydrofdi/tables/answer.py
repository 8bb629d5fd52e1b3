"""What a command answers: from its fields follow text, page and JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from hydrofdi.settings.messages import HOLE, number_text, shown_bytes, time_text
from hydrofdi.tables.table import TEXT_WIDTH, Table, plain

_MOST_VALUES = 6
"""Most values of a list that are shown; of longer ones, the ends."""


class Strong(str):
    """A line that stands out."""

    __slots__ = ()


Piece = str | Table | Mapping[str, Any]
"""Lines, a table, or facts: name → value."""


class Answer:
    """What a command finds. Its class declares fields, and where needed what people read of them.

    It is true if all is well; else the command ends with exit code 1.
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

    def value_text(self, name: str, value: Any) -> str | None:
        """How people read the value of a name with a dot, if not as any other."""

    def lines(self, width: int = TEXT_WIDTH) -> Iterator[tuple[Piece, list[tuple[str, str]]]]:
        """The parts that people read, each with its lines and their style."""
        for part in self.parts():
            yield part, [*self._styled(part, width)]

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        return "\n".join([*(line for _, lines in self.lines() for line, _ in lines), *self.asides()])

    def _repr_html_(self) -> str:
        texts = [
            part._repr_html_() if isinstance(part, Table) else _preformatted(line for line, _ in lines)
            for part, lines in self.lines()
        ]
        return "".join([*texts, _preformatted(self.asides())])

    def _styled(self, part: Piece, width: int) -> Iterator[tuple[str, str]]:
        if isinstance(part, Table):
            yield from ([(part.title, "bold")] if part.title else [])
            yield from ((line, "") for line in part.lines(width))
            yield from ((note, "dim") for note in part.notes)
        elif isinstance(part, Mapping):
            yield from ((line, "") for line in self._fact_lines(part))
        else:
            yield from ((line, "bold" if isinstance(part, Strong) else "") for line in part.split("\n"))

    def _fact_lines(self, record: Mapping[str, Any], indent: str = "") -> Iterator[str]:
        """A line for each fact of a record, below each other; a record within it stands below its name."""
        known = {
            name: value for name, value in record.items() if value or (value == 0 and value is not False)
        }
        width = max(map(len, known), default=0) + 2
        for name, value in known.items():
            title = name if "." in name else name.replace("_", " ")
            is_deep = isinstance(value, Mapping) and any("." in key for key in value)
            if is_deep and "." not in name:
                yield f"{indent}{title}"
                yield from self._fact_lines(value, f"{indent}  ")
            else:
                yield f"{indent}{title:<{width}}{self._text(name, value)}"

    def _text(self, name: str, value: Any) -> str:
        """A value as people read it: parameters with their units, durations and sizes by their names."""
        if isinstance(value, tuple):
            return " → ".join(self._text(name, each) for each in value)
        if isinstance(value, list):
            shown = value if len(value) <= _MOST_VALUES else [value[0], "…", value[-1]]
            listed = ", ".join(self._text(name, each) for each in shown)
            return listed if shown is value else f"{len(value):,} values, {listed}"
        if "." in name and value not in (None, "…") and (text := self.value_text(name, value)) is not None:
            return text
        if isinstance(value, Mapping):
            return ", ".join(f"{key} {self._text(key, each)}" for key, each in value.items())
        if isinstance(value, float):
            return time_text(value) if "seconds" in name else number_text(value)
        if isinstance(value, int) and not isinstance(value, bool):
            return shown_bytes(value) if name.endswith("bytes") else f"{value:,}"
        return HOLE if value is None else str(value)


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


def _preformatted(lines: Iterable[str]) -> str:
    text = "\n".join(lines)
    return f"<pre>{escape(text)}</pre>" if text else ""
