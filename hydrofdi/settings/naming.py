"""Settings in messages: keywords in Python, options on the command line."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_AS_OPTIONS = ContextVar("as_options", default=False)

_OPTIONS = {"flows": "--flow", "settings": "--set", "shared_directory": "--no-shared-directory"}
"""Keywords whose option has another name."""

_FUNCTIONS = {"indicators": "list_indicators", "report": "results"}
"""Commands whose function has another name."""

ONLY_COMMANDS = frozenset({"configs", "init", "monitor"})
"""Commands without a function."""


@contextmanager
def settings_as_options() -> Iterator[None]:
    """Within this context messages name settings as options of the command line."""
    token = _AS_OPTIONS.set(True)
    try:
        yield
    finally:
        _AS_OPTIONS.reset(token)


def command(name: str) -> str:
    """A command as its reader calls it: ``hydrofdi.check(…)``; ``'hydrofdi check'`` on the command line."""
    word = name.partition(" ")[0]
    if _AS_OPTIONS.get() or word in ONLY_COMMANDS:
        return f"'hydrofdi {name}'"
    return f"hydrofdi.{_FUNCTIONS.get(word, word)}(…)"


def setting(name: str, value: str = "") -> str:
    """A setting as its reader writes it.

    Parameters
    ----------
    name : str
        Keyword of the Python API, such as ``sampling_frequency``.
    value : str
        An example.

    Returns
    -------
    str
        ``sampling_frequency='1 kHz'``; ``--sampling-frequency '1 kHz'`` on the command line.
    """
    if not _AS_OPTIONS.get():
        return f"{name}={value!r}" if value else name
    option = _OPTIONS.get(name, f"--{name.replace('_', '-')}")
    return f"{option} {shlex.quote(value)}" if value else option
