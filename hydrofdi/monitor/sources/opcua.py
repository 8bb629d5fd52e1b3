"""A stream from an OPC UA server: subscribed nodes, joined by their time stamps."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from threading import Thread
from typing import TYPE_CHECKING

import numpy as np

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.opcua.configuration import OpcUaConfig, credentials, doubts, server_url
from hydrofdi.monitor.sources.columns import Column
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.sample_queue import SampleQueue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_units import factor_to_si
from hydrofdi.records.measured.description.sections import ChannelConfig

if TYPE_CHECKING:
    from hydrofdi.monitor.opcua.following import ServerFollower


class OpcUaSource(StreamSource):
    """Nodes of an OPC UA server.

    Parameters
    ----------
    url : str
        ``opc.tcp://host:port/path``.
    config : OpcUaConfig
    channels : mapping of Channel to ChannelConfig
        `column` is the node id; the unit must be stated.
    sampling_frequency : float
                Sampling frequency of the detector [Hz].
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.

    Raises
    ------
    ConfigError
        Address, nodes, units, files or credentials cannot be used.
    """

    def __init__(
        self,
        url: str,
        config: OpcUaConfig,
        channels: Mapping[Channel, ChannelConfig],
        sampling_frequency: float,
        *,
        first_wait: float = 1.0,
    ) -> None:
        self._name, self._config = server_url(url), config
        if not channels:
            raise ConfigError("an OPC UA server needs 'channels': the node of each channel")
        self._columns = [_column(*item, position) for position, item in enumerate(channels.items())]
        self._queue = SampleQueue(tuple(channels), max(2, round(config.queue * sampling_frequency)))
        self._follower = self._made_follower(config, sampling_frequency, first_wait)
        self._thread = Thread(target=self._run, name="opcua", daemon=True)

    @property
    def name(self) -> str:
        """The address."""
        return self._name

    def open(self, position: Position) -> None:
        """Begin to connect; keep trying if the server does not answer."""
        for doubt in doubts(self._name, self._config):
            self._queue.say(Event(EventKind.INSECURE, doubt))
        self._thread.start()

    def read(self, timeout: float) -> Reading:
        """New samples and events."""
        return self._queue.take(timeout)

    def close(self) -> None:
        """End the connection and its thread."""
        self._follower.stop()
        if self._thread.is_alive():
            self._thread.join()

    def _made_follower(
        self, config: OpcUaConfig, sampling_frequency: float, first_wait: float
    ) -> ServerFollower:
        try:
            from hydrofdi.monitor.opcua.files import key_files
            from hydrofdi.monitor.opcua.following import ServerFollower
            from hydrofdi.monitor.opcua.session import Server
        except ModuleNotFoundError as error:
            if error.name != "asyncua":
                raise
            raise ConfigError("OPC UA needs the extra: pip install 'hydrofdi[monitor]'") from None
        server = Server(self._name, config, credentials(config), key_files(config))
        nodes = [column.title for column in self._columns]
        return ServerFollower(server, nodes, 1 / sampling_frequency, first_wait, self._put, self._queue.say)

    def _run(self) -> None:
        try:
            asyncio.run(self._follower.run())
        except Exception as failure:
            self._queue.fail(failure)

    def _put(self, time: Array, samples: Array) -> None:
        self._queue.put(time, self._in_si(samples))

    def _in_si(self, samples: Array) -> Array:
        return np.stack([column.in_si(samples[:, column.position]) for column in self._columns], axis=1)


def _column(channel: Channel, config: ChannelConfig, position: int) -> Column:
    where = f"channels.{channel}"
    if not config.unit:
        raise ConfigError(f"{where}: write the 'unit' of the node, such as bar")
    factor = factor_to_si(config.unit, channel.unit, where)
    return Column(position, config.column, config, factor)
