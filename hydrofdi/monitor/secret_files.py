"""Files that contain a secret: a password, a token, a private key."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path

from hydrofdi.errors import ConfigError


def secret_in(file: Path, key: str, what: str = "password") -> str:
    """The only line of a file, without its line end.

    Parameters
    ----------
    file : path
    key : str
        Key of the configuration, for messages, such as ``mqtt.password_file``.
    what : str
        Meaning of the line, for messages.

    Raises
    ------
    ConfigError
        The file cannot be read, or does not contain exactly one line. No message shows its content.
    """
    try:
        secret = file.read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not a text file in UTF-8"
        raise ConfigError(f"{key}: {file}: {reason}") from None
    if not secret or "\n" in secret:
        raise ConfigError(f"{key}: {file}: must contain one line, the {what}")
    return secret


def exposed(*files: Path | None) -> Iterator[str]:
    """A sentence for each file that every user of the machine can read."""
    for file in files:
        if file is not None and file.stat().st_mode & stat.S_IROTH:
            yield f"{file}: every user of this machine can read it; use 'chmod 600'"
