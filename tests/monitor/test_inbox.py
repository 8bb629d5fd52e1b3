from threading import Thread

import pytest

from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.sources.contract import Inbox


def put(inbox, start, n=10, **options):
    inbox.put(range(start, start + n), n, count=n, **options)


def everything(inbox):
    numbers, events = [], []
    while True:
        items, more = inbox.take(0.0, 1000)
        if not items and not more:
            return numbers, events
        numbers += [number for item in items for number in item]
        events += more


def test_a_full_inbox_drops_one_long_piece_and_says_it_once():
    inbox, numbers, events = Inbox(100), [], []
    for start in range(0, 1000, 10):
        if start in (500, 600):
            more = everything(inbox)
            numbers, events = numbers + more[0], events + more[1]
        put(inbox, start, n=4 if start > 300 else 10)
        put(inbox, start + 4, n=6 if start > 300 else 0)
    more = everything(inbox)
    numbers, events = numbers + more[0], events + more[1]
    assert numbers == [*range(100), *range(500, 700)]
    assert sum(event.count for event in events) == 1000 - len(numbers)
    assert [event.kind for event in events if not event.is_silent] == [EventKind.DROPPED] * 2


def test_a_piece_that_would_fit_does_not_split_the_gap():
    inbox = Inbox(100)
    put(inbox, 0, n=95)
    put(inbox, 95, n=10)
    put(inbox, 105, n=3)
    numbers, events = everything(inbox)
    assert len(numbers) == 95
    assert sum(event.count for event in events) == 13


def test_a_sender_that_waits_goes_on_when_there_is_room_or_it_is_closed():
    inbox = Inbox(10)
    put(inbox, 0)
    sender = Thread(target=lambda: [put(inbox, start, waits=True) for start in (10, 20)])
    sender.start()
    assert inbox.take(60.0, 10)[0] == [range(10)]
    inbox.close()
    sender.join(60.0)
    assert everything(inbox) == ([*range(10, 30)], [])


def test_a_fault_of_the_connection_is_raised_to_the_reader():
    inbox = Inbox(100)
    inbox.fail(RuntimeError("fault"))
    with pytest.raises(RuntimeError, match="fault"):
        inbox.take(1.0, 1)
