"""Whoever follows an OPC UA server ends when told to, also if a library swallows the cancellation."""

import asyncio
import threading

import pytest

pytest.importorskip("asyncua")

from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.monitor.opcua.following import ServerFollower
from hydrofdi.monitor.opcua.session import Server


class Deaf(ServerFollower):
    """Takes the first cancellation for something else."""

    async def _follow(self):
        self.began.set()
        try:
            await asyncio.sleep(600)
        except asyncio.CancelledError:
            await asyncio.sleep(600)


def follower(kind):
    server = Server("opc.tcp://127.0.0.1:1", OpcUaConfig(), None, None)
    return kind(server, ["ns=1;s=P1"], 0.01, 0.1, put=lambda *_: None, say=lambda _: None)


@pytest.mark.parametrize("kind", [ServerFollower, Deaf])
def test_it_ends_when_told_to(kind):
    follows = follower(kind)
    follows.began = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(follows.run()), daemon=True)
    thread.start()
    if kind is Deaf:
        assert follows.began.wait(30)
    follows.stop()
    thread.join(60)
    assert not thread.is_alive()
