"""The entry of ``hydrofdi`` and of ``python -m hydrofdi``: it handles signals while the rest loads."""

import gc
import os
import signal
import sys
from types import FrameType

_INTERRUPTED = 130
_OBJECTS_BETWEEN_COLLECTIONS = 200_000
"""Loading modules makes half as many objects and no garbage."""


def main() -> None:
    """Load the command line, run it and exit."""
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)
    # pydantic would search all installed packages for plugins
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "true")
    if "hydrofdi.cli.app" not in sys.modules:
        _end_quietly_while_loading()
    from hydrofdi.cli.app import main as run

    run()


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
