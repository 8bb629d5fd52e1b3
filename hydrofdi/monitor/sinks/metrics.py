"""Metrics over HTTP, in the text format of Prometheus."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import Event, EventKind, Line
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.naming import setting
from hydrofdi.store.files import reason


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
            from prometheus_client import start_http_server

            from hydrofdi.monitor.sinks.measures import Measures
        except ModuleNotFoundError as error:
            if error.name != "prometheus_client":
                raise
            raise ConfigError(
                f"{setting('metrics')} needs the extra: pip install 'hydrofdi[monitor]'"
            ) from None
        self._measures = Measures(file)
        try:
            self._server, self._thread = start_http_server(port, host, self._measures.registry)
        except (OSError, UnicodeError) as error:
            raise ConfigError(f"{setting('metrics')}: {address}: {reason(error)}") from None
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self._server.server_port}/metrics"
        self._is_told = False

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Count samples and lines; report the address once."""
        self._measures.count(chunk, lines)
        if self._is_told:
            return ()
        self._is_told = True
        return (Event(EventKind.NOTICE, f"metrics are served at {self.url}"),)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    is_port = port.isascii() and port.isdigit() and int(port) < 2**16
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        is_port = False
    if not (host and colon and is_port):
        raise ConfigError(
            f"{setting('metrics')}: {address!r} is not host:port; write, for example, 127.0.0.1:9464"
        )
    return host.strip("[]"), int(port)
