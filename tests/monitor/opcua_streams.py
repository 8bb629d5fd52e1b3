"""An OPC UA source that a test opens, and what it gave."""

import time
from contextlib import contextmanager

import numpy as np

from hydrofdi.monitor.configuration import OpcUaConfig
from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.opcua.source import OpcUaSource
from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from tests.monitor.opcua_server import EPOCH

P1, X = Channel.CHAMBER_1_PRESSURE, Channel.PISTON_POSITION
CHANNELS = {
    P1: ChannelConfig(column="ns=1;s=P1", unit="bar"),
    X: ChannelConfig(column="ns=1;s=x", unit="mm", gain=2.0, offset=1.0, sign=-1),
}
NODES = {"P1": 0.0, "x": 0.0}
FAST = OpcUaConfig(publishing_interval=0.05, wait=0.5)
RATE = 100.0


@contextmanager
def opened(url, config=FAST, channels=CHANNELS, rate=RATE):
    source = OpcUaSource(url, config, channels, rate, first_wait=0.1)
    source.open({})
    try:
        yield source
    finally:
        source.close()


class Reader:
    """What a source gave, until something is there or a minute has passed."""

    def __init__(self, source):
        self._source, self.chunks, self.events = source, [], []

    def until(self, is_there):
        deadline = time.monotonic() + 20
        while not is_there(self):
            assert time.monotonic() < deadline, (self.time.size, self.events)
            reading = self._source.read(0.2)
            self.chunks += [reading.chunk] if reading.chunk else []
            self.events += reading.events
        return self

    def has(self, kind, times=1):
        return self.until(lambda reader: len(reader.said(kind)) >= times)

    def samples(self, count):
        return self.until(lambda reader: reader.time.size >= count)

    def said(self, kind):
        return [event.text for event in self.events if event.kind is kind and not event.is_silent]

    @property
    def time(self):
        return np.concatenate([[], *(chunk.time for chunk in self.chunks)]) - EPOCH.timestamp()

    def channel(self, channel):
        return np.concatenate([chunk.channels[channel] for chunk in self.chunks])


def connected(source):
    """A reader of a source whose nodes have all sent their value of before."""
    reader = Reader(source).has(EventKind.CONNECTED)
    time.sleep(0.2)
    return reader
