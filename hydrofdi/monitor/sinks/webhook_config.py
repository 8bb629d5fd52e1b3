"""Settings of events that are posted to a web address."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

from pydantic import Field

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.secret_files import exposed, secret_in
from hydrofdi.settings.quantities import SI, Section

TOKEN = "HYDROFDI_WEBHOOK_TOKEN"
_THIS_MACHINE = ("localhost", "127.0.0.1", "::1")


class WebhookConfig(Section):
    """Events as JSON, posted to an address."""

    url: str = ""
    """``https://…``. A secret address belongs here, not on the command line."""

    events: tuple[EventKind, ...] = (EventKind.ALARM_RAISED, EventKind.ALARM_CLEARED)
    """Kinds of events that are posted."""

    machine: Annotated[str, Field(max_length=200)] = ""
    """Name of the machine in each post; by default the name of the computer."""

    token_file: Path | None = None
    """File that contains only the secret of ``Authorization: Bearer``, readable only by its owner; by default
    the environment variable HYDROFDI_WEBHOOK_TOKEN."""

    ca_file: Path | None = None
    """Certificates (PEM) that sign the server's certificate; by default those of the operating system."""

    timeout: Annotated[float, SI("s", above=0.0, most=300.0)] = 10.0
    """Time to wait for a response [s]."""


def checked_url(config: WebhookConfig) -> str:
    """The address in a configuration.

    Raises
    ------
    ConfigError
        It is not an address, contains credentials, or would send the secret unencrypted. The message does not
        repeat it.
    """
    try:
        parts = urlsplit(config.url)
        host, _ = parts.hostname, parts.port
    except ValueError:
        host = None
    if not host or parts.scheme not in ("http", "https") or not config.url.isprintable() or " " in config.url:
        raise ConfigError("webhook: write the address as https://host/path")
    if "@" in parts.netloc:
        raise ConfigError(f"webhook: no credentials in an address; use 'webhook.token_file' or {TOKEN}")
    if parts.scheme == "http" and host not in _THIS_MACHINE and bearer_token(config):
        raise ConfigError("webhook: the secret would be sent unencrypted; use https://")
    return config.url


def shown_url(url: str) -> str:
    """The address without its path, which may be a secret, and without credentials."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc}" if "@" not in url else f"{parts.scheme}://…"


def bearer_token(config: WebhookConfig) -> str:
    """The secret; empty if there is none.

    Raises
    ------
    ConfigError
        Its file cannot be read or does not contain exactly one line, or the secret does not fit in a header.
    """
    file = config.token_file
    token = os.environ.get(TOKEN, "") if file is None else secret_in(file, "webhook.token_file", "secret")
    if not token.isascii() or not token.isprintable():
        raise ConfigError("webhook: the secret contains characters that are not allowed in a header")
    return token


def doubts(config: WebhookConfig) -> Iterator[str]:
    """A sentence for each setting that is less safe than it could be."""
    yield from exposed(config.token_file)
