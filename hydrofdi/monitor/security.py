"""Passwords and certificates of connections, and why a network fails. No text shows a secret."""

from __future__ import annotations

import os
import socket
import ssl
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hydrofdi.errors import ConfigError


def credentials(section: str, username: str, password_file: Path | None) -> tuple[str, str]:
    """User and password of a section of the configuration, or else of the environment; empty without any.

    Raises
    ------
    ConfigError
        The file of the password does not contain exactly one line, or there is no user for a password.
    """
    variable = f"HYDROFDI_{section.upper()}"
    username = username or os.environ.get(f"{variable}_USERNAME", "")
    password = os.environ.get(f"{variable}_PASSWORD", "")
    if password_file is not None:
        with usable(f"{section}.password_file", password_file):
            password = password_file.read_text(encoding="utf-8").rstrip("\r\n")
        if not password or "\n" in password:
            raise ConfigError(
                f"{section}.password_file: {password_file}: must contain one line, the password"
            )
    if password and not username:
        raise ConfigError(f"{section}.username: is missing; there is a password without a user")
    return username, password


@contextmanager
def usable(key: str, file: Path) -> Iterator[None]:
    """Raise errors of a file under its key, never with the content of the file."""
    try:
        yield
    except (OSError, ValueError, TypeError) as error:
        reason = error.strerror if isinstance(error, OSError) and not isinstance(error, ssl.SSLError) else ""
        raise ConfigError(f"{key}: {file}: {reason or 'is not what this key needs'}") from None


def exposed(*files: Path | None) -> Iterator[str]:
    """A sentence for each file that every user of the machine can read."""
    for file in files:
        if file is not None and file.exists() and file.stat().st_mode & stat.S_IROTH:
            yield f"{file}: every user of this machine can read it; use 'chmod 600'"


def network_reason(error: OSError) -> str:
    """What an error of the network means. It never contains what the other side sent."""
    match error:
        case ssl.SSLCertVerificationError():
            return f"its certificate is refused: {error.verify_message}"
        case ssl.SSLError():
            return f"no encrypted connection ({(error.reason or 'unknown').lower().replace('_', ' ')})"
        case socket.gaierror():
            return "its name cannot be resolved"
    return os.strerror(error.errno).lower() if error.errno else "it does not answer"
