"""Metrics over HTTP, in the text format of Prometheus."""

from __future__ import annotations

import socket
from collections.abc import Sequence
from contextlib import suppress
from ipaddress import ip_address
from threading import Thread, Timer
from typing import Any
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import Event, EventKind, Line
from hydrofdi.records.streams import Chunk
from hydrofdi.store.files import reason

_PATIENCE = 3.0
"""Longest time that a client gets [s]."""


class MetricsSink:
    """Counts lines, and serves the counts.

    Parameters
    ----------
    address : str
        ``host:port``; a free port if it is 0. ``[::1]:9464`` for IPv6.
    file : DetectorFile

    Raises
    ------
    ConfigError
        It is not an address, cannot be used, or the extra is not installed.
    """

    def __init__(self, address: str, file: DetectorFile) -> None:
        host, port = _host_and_port(address)
        try:
            from prometheus_client import make_wsgi_app

            from hydrofdi.monitor.sinks.measures import Measures
        except ModuleNotFoundError as error:
            if error.name != "prometheus_client":
                raise
            raise ConfigError("metrics needs the extra: pip install 'hydrofdi[monitor]'") from None
        self._measures = Measures(file)
        try:
            family, _, _, _, found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
            self._server = _Server(family, (host, port), make_wsgi_app(self._measures.registry))
        except (OSError, UnicodeError) as error:
            raise ConfigError(f"metrics: {address}: {reason(error)}") from None
        self._thread = Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self._server.server_port}/metrics"
        self._said = [Event(EventKind.NOTICE, f"metrics are served at {self.url}")]
        if not ip_address(str(found[0]).partition("%")[0]).is_loopback:
            text = f"everyone who reaches {self.url} can read the metrics"
            self._said.append(Event(EventKind.INSECURE, text))

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Count samples and lines; report the address once."""
        self._measures.count(chunk, lines)
        said, self._said = self._said, []
        return said

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(WSGIServer):
    """Answers one client after the other: those that send nothing take no threads."""

    def __init__(self, family: int, address: tuple[str, int], application: Any) -> None:
        self.address_family = family
        super().__init__(address, _Handler)
        self.set_app(application)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that break off."""


class _Handler(WSGIRequestHandler):
    def setup(self) -> None:
        """Give the client a while."""
        super().setup()
        self._end = Timer(_PATIENCE, self._break_off)
        self._end.start()

    def finish(self) -> None:
        """The client is served."""
        self._end.cancel()
        super().finish()

    def log_message(self, *_: Any) -> None:
        """Say nothing."""

    def _break_off(self) -> None:
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    is_port = port.isascii() and port.isdigit() and int(port) < 2**16
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        is_port = False
    if not (host and colon and is_port):
        raise ConfigError(f"metrics: {address!r} is not host:port; write, for example, 127.0.0.1:9464")
    return host.strip("[]"), int(port)
