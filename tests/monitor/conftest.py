"""A broker for a test, and things that are closed behind it."""

from contextlib import ExitStack

import pytest

from tests.monitor.brokers import Broker


@pytest.fixture
def broker(tmp_path):
    """mosquitto, which listens."""
    broker = Broker(tmp_path)
    try:
        broker.start()
        yield broker
    finally:
        broker.stop()


@pytest.fixture
def closing():
    """Calls ``close`` of what a test opened: ``source = closing(source_at(…))``."""
    with ExitStack() as stack:

        def keep(thing):
            stack.callback(thing.close)
            return thing

        yield keep
