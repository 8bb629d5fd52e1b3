"""The entry of ``hydrofdi`` and of ``python -m hydrofdi``: it handles signals while the rest loads."""

import gc
import os
import signal
import sys
from types import FrameType
from typing import Any

_INTERRUPTED = 130
_OBJECTS_BETWEEN_COLLECTIONS = 200_000
"""Loading modules makes half as many objects and no garbage."""


def main() -> None:
    """Load the command line, run it and exit."""
    _make_streams_sound()
    if sys.flags.optimize > 1:
        print("hydrofdi: options are described by docstrings, so no -OO or PYTHONOPTIMIZE=2", file=sys.stderr)
        sys.exit(2)
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)
    # pydantic would search all installed packages for plugins
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "true")
    if "hydrofdi.cli.app" not in sys.modules:
        _end_quietly_while_loading()
    from hydrofdi.cli.app import main as run

    run()


def _make_streams_sound() -> None:
    """A closed standard stream leads nowhere; what the encoding of an open one lacks is written escaped."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream: Any = getattr(sys, name)
        if stream is None:  # opened in this order, so that no other file gets its number
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115
        elif mode == "w":
            stream.reconfigure(errors="backslashreplace")


def _end_quietly_while_loading() -> None:
    """Let Ctrl-C end the process with one line, and SIGTERM a monitor, until the command takes them back.

    An exception is no choice here: libraries that are being loaded may turn it into errors of their own.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupted)
    if sys.argv[1:2] == ["monitor"]:
        signal.signal(signal.SIGTERM, _stopped)


def _interrupted(number: int, frame: FrameType | None) -> None:
    os.write(2, b"hydrofdi: interrupted\n")
    os._exit(_INTERRUPTED)


def _stopped(number: int, frame: FrameType | None) -> None:
    os._exit(0)


if __name__ == "__main__":
    main()
