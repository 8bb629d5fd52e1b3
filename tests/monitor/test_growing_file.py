"""A growing file as a stream: it grows, is renamed, cut, not there yet; the reader stops and goes on."""

import json
import os
import tempfile
from pathlib import Path
from threading import Thread
from time import sleep

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.errors import DataError
from hydrofdi.monitor import growing_file
from hydrofdi.monitor.growing_file import GrowingFile, StandardInput
from hydrofdi.records.streams import EventKind
from tests.monitor.streams import config_of, reading_of, samples

HEADER = "time [s],P1 [Pa]\n"
PREAMBLE = "logger 7;v1\n\n0,0\n"


class Follower:
    """A reader that can be stopped and started again, and all it has read."""

    def __init__(self, path, *, follow=True, leaves_unended=False, **options):
        self._path, self._config = path, config_of(**options)
        self.follow, self.leaves_unended = follow, leaves_unended
        self.times, self.events = [], []
        self.start({})

    def start(self, position):
        options = {"follow": self.follow, "leaves_unended": self.leaves_unended}
        self.source = GrowingFile(self._path, self._config, **options)
        self.source.open(position)

    def restart(self):
        position = json.loads(json.dumps(self.source.position))
        self.source.close()
        self.start(position)

    def read(self):
        while True:
            before = self.source.position
            reading = reading_of(self.source, 0.0)
            self.times += reading.chunk.time.tolist() if reading.chunk else []
            self.events += reading.events
            if reading.is_over or self.source.position == before:
                return reading

    @property
    def kinds(self):
        return [event.kind for event in self.events]


def append(path, text):
    with open(path, "a", encoding="utf-8") as file:
        file.write(text)


@pytest.fixture
def log(tmp_path):
    return tmp_path / "press.csv"


@pytest.fixture
def follower(log):
    """It has read the first two of the samples of a file, and half a third one."""
    append(log, HEADER + "1,10\n2,20\n2.5,")
    follower = Follower(log)
    follower.read()
    return follower


def test_a_file_that_is_not_there_yet_is_waited_for_and_the_end_is_the_end_where_nobody_follows(log):
    follower = Follower(log)
    follower.read()
    follower.read()
    assert (follower.source.position, follower.kinds) == ({}, ["notice"])
    append(log, HEADER + "1,10\n")
    follower.read()
    assert (follower.times, follower.kinds) == ([1.0], ["notice", "connected"])
    log.rename(log.with_name("old"))
    append(log, HEADER + "2,20\n3,30")
    follower.follow = False
    follower.restart()
    assert follower.read().is_over
    assert (follower.times, follower.kinds[-1]) == ([1.0, 2.0, 3.0], "notice")


@pytest.mark.parametrize("kind", ["folder", "packed", "pipe", "absent"])
def test_what_cannot_be_followed_is_refused(tmp_path, kind):
    path = {"folder": tmp_path, "packed": tmp_path / "x.csv.gz"}.get(kind, tmp_path / "x.csv")
    if kind == "pipe":
        os.mkfifo(path)
    with pytest.raises(DataError, match=str(path)):
        Follower(path, follow=kind != "absent")


def test_an_unended_last_line_is_left_for_the_next_run(log):
    append(log, HEADER + "1,10\n2,2")
    follower = Follower(log, follow=False, leaves_unended=True)
    for rest in ("0\n3,3", "0\n"):
        assert follower.read().is_over
        append(log, rest)
        follower.restart()
    assert follower.times == [1.0, 2.0]
    assert reading_of(follower.source, 0.0).chunk.channels["chamber_1_pressure"].tolist() == [30.0]


def test_what_is_written_between_the_last_look_and_the_renaming_is_not_lost(log, follower, monkeypatch):
    is_replaced, late = GrowingFile._is_replaced, ["0\n3,30\n"]

    def written_just_before(source, file):
        if late:
            append(log, late.pop())
            log.rename(log.with_name("old"))
            append(log, HEADER + "4,40\n")
        return is_replaced(source, file)

    monkeypatch.setattr(GrowingFile, "_is_replaced", written_just_before)
    follower.read()
    assert follower.times == [1.0, 2.0, 2.5, 3.0, 4.0]


@pytest.mark.parametrize("is_restarted", [False, True])
@pytest.mark.parametrize("later", ["3,30\n", "3,30\n4,40\n5,50\n6,60\n"], ids=["shorter", "longer"])
def test_a_file_that_was_cut_is_read_from_its_beginning(later, is_restarted, log, follower):
    """So is another one with the same inode."""
    log.write_text(HEADER + later, encoding="utf-8")
    if is_restarted:
        follower.restart()
    follower.read()
    append(log, "7,70\n")
    follower.read()
    assert follower.times == [1.0, 2.0, *(float(line[0]) for line in later.splitlines()), 7.0]
    assert follower.kinds == [EventKind.CONNECTED]


def test_a_hole_that_a_writer_leaves_is_no_new_beginning(log, follower):
    with open(log, "r+b") as file:
        file.truncate(0)
        file.seek(len(HEADER) + len("1,10\n2,20\n2.5,"))
        file.write(b"30\n3,30\n")
    follower.read()
    assert follower.times == [1.0, 2.0, 2.5, 3.0]


def test_samples_without_time_are_counted_on_over_restarts_and_renaming(log):
    append(log, "P1 [Pa]\n1\n2\n")
    follower = Follower(log, sampling_frequency=2)
    follower.read()
    append(log, "3\n")
    log.rename(log.with_name("old"))
    append(log, "P1 [Pa]\n4\n")
    follower.restart()
    follower.read()
    assert follower.times == [0.0, 0.5, 1.0, 1.5]


@pytest.mark.parametrize(("later", "n_later"), [("3,30\n4,40\n", 2), (HEADER + "3,30\n", 1)])
def test_a_preamble_is_passed_over_where_a_file_has_one(later, n_later, log):
    append(log, PREAMBLE + HEADER + "1,10\n2,20\n")
    follower = Follower(log, skip=3)
    follower.read()
    log.rename(log.with_name("old"))
    append(log, later)
    follower.read()
    assert follower.times == [1.0, 2.0, 3.0, 4.0][: 2 + n_later]
    assert EventKind.MALFORMED not in follower.kinds


OPERATIONS = "row", "half a row", "other half", "read", "rename", "late row", "restart"


@pytest.mark.parametrize("preamble", ["", PREAMBLE])
@given(operations=st.lists(st.sampled_from(OPERATIONS), max_size=30))
def test_nothing_is_lost_or_read_twice(preamble, operations):
    """A row may come late into a renamed file; names say nothing of the order of files."""
    with tempfile.TemporaryDirectory() as folder:
        log, written, half = Path(folder) / "log.csv", 0, False
        append(log, preamble + HEADER)
        log.with_name("log.csv.8.gz").touch()
        follower = Follower(log, skip=preamble.count("\n"))
        for number, operation in enumerate([*operations, "read"]):
            if operation in ("row", "half a row") and not half:
                written += 1
                half = operation == "half a row"
                append(log, f"{written},1.2" + ("" if half else "5\n"))
            elif operation in ("row", "other half") and half:
                append(log, "5\n")
                half = False
            elif operation in ("rename", "late row") and not half:
                renamed = log.with_name(f"log.csv.{99 - number}")
                log.rename(renamed)
                if operation == "late row":
                    log.touch()
                    follower.read()
                    written += 1
                    append(renamed, f"{written},1.25\n")
                os.utime(renamed, (1e9 + number, 1e9 + number))
                append(log, preamble + HEADER)
            elif operation == "read":
                follower.read()
            elif operation == "restart":
                follower.restart()
        assert follower.times == list(map(float, range(1, written + 1 - half)))
        assert EventKind.MALFORMED not in follower.kinds
        follower.source.close()


@pytest.fixture
def pipe():
    ends = [os.fdopen(end, mode, buffering=0) for end, mode in zip(os.pipe(), ("rb", "wb"), strict=True)]
    yield ends
    for end in ends:
        end.close()


def opened(file, position=(), **options):
    source = StandardInput(config_of(**options), file.fileno())
    source.open(dict(position))
    return source


def test_small_pieces_are_read_together_and_the_end_of_input_ends_the_stream_with_its_last_line(
    pipe, monkeypatch
):
    reader, writer = pipe
    source = opened(reader)
    reading = reading_of(source, 0.01)
    assert (reading.chunk, reading.events, reading.is_over) == (None, [], False)
    monkeypatch.setattr(growing_file, "GATHER", 60.0)

    def write():
        for number in range(20):
            writer.write(b'\n{"time": %d, "P1 [Pa]": 2}' % number)
            sleep(0.001)
        writer.close()

    thread = Thread(target=write)
    thread.start()
    last = reading_of(source, 60.0)
    thread.join()
    assert samples(last.chunk) == {"time": [*range(20)], "P1": [2.0] * 20}
    assert ([event.kind for event in last.events], last.is_over) == (["notice"], True)
    assert reading_of(source, 1.0).chunk is None


def test_counted_samples_go_on_behind_a_gap_after_a_restart(pipe):
    reader, writer = pipe
    first = opened(reader, sampling_frequency=10)
    writer.write(b"P1 [Pa]\n1\n2\n")
    reading_of(first, 1.0)
    second = opened(reader, first.position, sampling_frequency=10)
    writer.write(b"P1 [Pa]\n3\n")
    assert reading_of(second, 1.0).chunk.time.tolist() == [0.4]
