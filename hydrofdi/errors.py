"""The error tree: who can fix it decides the type.

::

    HydrofdiError            the user can fix it: short lines, no traceback, exit code 2
    ├── ConfigError          an experiment file or an option is wrong
    ├── DataError            a measured file is unusable
    ├── StoreError           a result file is missing, damaged, locked or of another version
    ├── UnknownNameError     a table has no column of this name
    └── ReportError          there is nothing to report, or the records do not support it

Everything else that is raised is a bug in hydrofdi or of its caller and keeps its traceback.
A run that fails is no exception at all but a stored row with a status and a sentence.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

_CREDENTIALS = re.compile(r"(?P<begin>://?).*@|(?P<slashes>//)\S*@|(?<![^\s/:'\"])[^\s/:'\"]+:\S*@")
_QUERY = re.compile(r"(://[^\s?]*\?)[^\s'\"]+")


def without_credentials(text: str) -> str:
    """What somebody typed, with an ellipsis for what stands before ``@``, behind ``//`` or a colon, and for
    the query of a URL, where tokens stand.
    """
    shown = _CREDENTIALS.sub(lambda found: f"{found['begin'] or found['slashes'] or ''}…@", text)
    return _QUERY.sub(r"\1…", shown)


class HydrofdiError(Exception):
    """Anything that the user of hydrofdi can fix. Its text repeats no credentials."""

    def __str__(self) -> str:
        return without_credentials(super().__str__())


@dataclass(frozen=True)
class Issue:
    """Something that is wrong or doubtful: in a configuration, a record or a window.

    Attributes
    ----------
    message : str
        What was found, what is allowed, what to do.
    where : str
        Dotted key or channel; ``""`` if it concerns the whole.
    origin : str
        ``file:line`` or the command-line option that set the value.
    kind : str
        One word, such as ``clipped`` or ``stuck``; ``""`` in a configuration.
    is_unusable : bool
        Whether no indicator that needs the channel can be measured.
    """

    message: str
    where: str = ""
    origin: str = ""
    kind: str = ""
    is_unusable: bool = False

    def __str__(self) -> str:
        where = "" if self._origin_names_key else self.where
        text = ": ".join(part for part in (self.origin, where, self.message) if part)
        return text.replace("\n", "\\n")

    @property
    def _origin_names_key(self) -> bool:
        """Whether the origin is an option or a keyword that names the key already."""
        keyword = self.origin.lstrip("-").replace("-", "_")
        return f" {self.where}=" in self.origin or keyword in self.where.split(".")


class ConfigError(HydrofdiError, ValueError):
    """A configuration that cannot be used; carries all of its mistakes."""

    def __init__(self, mistakes: Sequence[Issue] | str) -> None:
        if isinstance(mistakes, str):
            mistakes = [Issue(mistakes)]
        self.mistakes = tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


class DataError(HydrofdiError, ValueError):
    """A measured file that cannot be used; its message names the file, and the line where there is one."""


class StoreError(HydrofdiError, OSError):
    """A result file that is missing, damaged, locked, or written by another version."""


class UnknownNameError(HydrofdiError, KeyError):
    """A name that is not there; its message lists the names that are, or the one that was probably meant."""

    def __str__(self) -> str:
        return without_credentials(str(self.args[0]))


class ReportError(HydrofdiError):
    """Nothing to show."""


class NotStatedError(ReportError):
    """The records do not support this result; `records_needed` would suffice, if known."""

    def __init__(self, message: str, records_needed: int | None = None) -> None:
        self.records_needed = records_needed
        super().__init__(message)


def is_interruption(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: h5py makes one of its own of it, in the middle of its calls."""
    return isinstance(error, KeyboardInterrupt) or (error is not None and is_interruption(error.__context__))


@contextmanager
def interruption(on_request: Callable[[], None], at_once: Collection[int] = ()) -> Iterator[list[int]]:
    """Note the first Ctrl-C or SIGTERM and call a function; the second, or one `at_once`, stops at once."""
    requests: list[int] = []

    def handle(number: int, frame: FrameType | None) -> None:
        if number in at_once or requests:
            raise KeyboardInterrupt
        requests.append(number)
        on_request()

    previous = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield requests
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


class SweepInterrupted(KeyboardInterrupt):
    """A sweep that was stopped early; `summary` is there if it could finish the runs in progress."""

    def __init__(self, completed: int, stored: int, planned: int, summary: Any = None) -> None:
        self.summary = summary
        super().__init__(
            f"interrupted; {stored_so_far(stored, planned)}"
            if completed
            else "interrupted before the first run ended; nothing was stored"
        )


def stored_so_far(stored: int, planned: int) -> str:
    """What a sweep that ended early leaves behind."""
    return f"runs stored: {stored:,} of {planned:,}; the same command continues from there"
