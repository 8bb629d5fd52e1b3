from threading import Thread

import numpy as np
import pytest

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources.sample_queue import SampleQueue
from hydrofdi.records.channels import Channel

CHANNELS = (Channel.CHAMBER_1_PRESSURE, Channel.PISTON_POSITION)


def put(queue, start, n=10):
    time = np.arange(start, start + n, dtype=float)
    queue.put(time, np.stack([time, -time], axis=1))


def everything(queue):
    readings = []
    while (reading := queue.take(0.0)).chunk is not None or reading.events:
        readings.append(reading)
    return readings


def test_samples_come_out_in_order_with_their_channels():
    queue = SampleQueue(CHANNELS, 100)
    put(queue, 0)
    put(queue, 10)
    chunk = queue.take(0.0).chunk
    assert chunk.time.tolist() == list(range(20))
    assert np.array_equal(chunk.channels[Channel.PISTON_POSITION], -chunk.time)


def test_a_reader_that_waits_is_woken():
    queue = SampleQueue(CHANNELS, 100)
    got = []
    reader = Thread(target=lambda: got.append(queue.take(60.0)))
    reader.start()
    queue.say(Event(EventKind.CONNECTED, "there"))
    reader.join()
    assert got[0].events[0].kind is EventKind.CONNECTED


def test_a_full_queue_drops_one_long_piece_and_says_it_once():
    queue = SampleQueue(CHANNELS, 100)
    readings = []
    for start in range(0, 1000, 10):
        if start in (500, 600):
            readings += everything(queue)
        put(queue, start, n=4 if start > 300 else 10)
        put(queue, start + 4, n=6 if start > 300 else 0)
    readings += everything(queue)
    time = np.concatenate([reading.chunk.time for reading in readings])
    events = [event for reading in readings for event in reading.events]
    gaps = np.flatnonzero(np.diff(time) != 1)
    assert [(time[at], time[at + 1]) for at in gaps] == [(99, 500)]
    assert sum(event.count for event in events) == 1000 - time.size
    assert [event.kind for event in events if not event.is_silent] == [EventKind.DROPPED] * 2


def test_a_fault_of_the_connection_is_raised_to_the_reader():
    queue = SampleQueue(CHANNELS, 100)
    queue.fail(RuntimeError("fault"))
    with pytest.raises(RuntimeError, match="fault"):
        queue.take(1.0)
