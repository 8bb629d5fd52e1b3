"""A source of an OPC UA server ends when told to, also if a library swallows the cancellation."""

import asyncio
import threading

import pytest

pytest.importorskip("asyncua")

from hydrofdi.monitor.opcua.source import OpcUaSource
from tests.monitor.opcua_streams import CHANNELS, FAST, RATE


class Deaf(OpcUaSource):
    """Takes the first cancellation for something else."""

    async def _follow(self):
        self.began.set()
        try:
            await asyncio.sleep(600)
        except asyncio.CancelledError:
            await asyncio.sleep(600)


@pytest.mark.parametrize("kind", [OpcUaSource, Deaf])
def test_it_ends_when_told_to(kind):
    source = kind("opc.tcp://127.0.0.1:1", FAST, CHANNELS, RATE)
    source.began = threading.Event()
    source.open({})
    if kind is Deaf:
        assert source.began.wait(30)
    closing = threading.Thread(target=source.close, daemon=True)
    closing.start()
    closing.join(60)
    assert not closing.is_alive()
