"""A monitor goes on where it was: its log has each window once, whatever happens to process or disk."""

import json
import os
import resource
import signal
import sqlite3
from contextlib import closing, suppress
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.errors import StoreError, interruption
from hydrofdi.monitor import growing_file, loop
from hydrofdi.monitor.growing_file import GrowingFile
from hydrofdi.monitor.loop import Ending
from hydrofdi.monitor.opening import Sources
from hydrofdi.monitor.store import StateStore, StoredMachine, WindowLog
from hydrofdi.records.streams import Event, EventKind
from tests.monitor.streams import (
    P1,
    Kept,
    Killed,
    Samples,
    logged,
    made_detector,
    monitor,
    numbers_of,
    part,
    stream,
)

FILE = made_detector()
MADE = stream(40, leaking=[12, 13, 30], stuck=[20, 21])


def run(folder, source=None, view=None, stop=lambda: False, file=FILE, storing=None):
    """One life with its state and its log in a folder; `storing` gets the number of each storing, what is
    stored, and what stores it."""
    write, number = StateStore.write, count(1)

    def stored(self, *what):
        storing(next(number), what[0], lambda: write(self, *what))

    with pytest.MonkeyPatch.context() as patch:
        if storing is not None:
            patch.setattr(StateStore, "write", stored)
        files = {"state": folder / "state", "log": folder / "log.jsonl"}
        return monitor(file, source or Samples(MADE), view, stop, **files)


def killed_at(place):
    """The process ends between the state and the log."""

    def storing(number, _, store):
        store()
        if number == place:
            raise Killed

    return storing


def said(folder):
    return logged(folder / "log.jsonl")


@pytest.fixture(autouse=True)
def stored_at_once(monkeypatch):
    """Each line is stored before the next reading; the clock advances by a second at each look."""
    monkeypatch.setattr(loop, "STORE_EVERY", 0.0)
    monkeypatch.setattr(loop, "time", SimpleNamespace(monotonic=count().__next__))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    assert run(folder) == Ending.OVER
    lines = said(folder)
    assert [each["number"] for each in lines if each["line"] == "window"] == list(range(40))
    events = [each["event"] for each in lines if each["line"] == "event"]
    assert events == ["alarm_raised", "stuck", "alarm_cleared", "alarm_raised", "stuck"]
    return lines


@settings(max_examples=8, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 30), st.booleans(), st.integers(1, 9)), min_size=1, max_size=8))
def test_killed_before_or_after_the_state_nothing_is_lost_or_twice(undisturbed, tmp_path_factory, kills):
    folder = tmp_path_factory.mktemp("killed")
    for place, is_stored, every in kills:
        loop.STORE_EVERY = every
        with suppress(Killed):
            run(folder, view=None if is_stored else Kept(place), storing=killed_at(place * is_stored))
            break
    else:
        run(folder)
    assert said(folder) == undisturbed


@pytest.mark.parametrize("n_written", [0, 9, -1, None])
def test_a_torn_step_is_completed(undisturbed, n_written, tmp_path):
    with pytest.raises(Killed):
        run(tmp_path, storing=killed_at(15))
    store = StateStore(tmp_path / "state")
    with store.opened():
        waiting = store.read_log()["waiting"]
    assert waiting
    with open(tmp_path / "log.jsonl", "a") as log:
        log.write(waiting[:n_written])
    run(tmp_path)
    assert said(tmp_path) == undisturbed


@pytest.mark.parametrize("is_stored", [False, True])
def test_a_log_that_was_rotated_has_each_window_once_whether_the_state_is_stored_or_not(
    undisturbed, is_stored, tmp_path
):
    def storing(number, _, store):
        if number == 16:
            (tmp_path / "log.jsonl").rename(tmp_path / "old")
        if number > 10 and not is_stored:
            raise StoreError("full")
        store()

    with pytest.raises(Killed):
        run(tmp_path, view=Kept(30), storing=storing)
    run(tmp_path)
    rest = said(tmp_path)
    (tmp_path / "old").rename(tmp_path / "log.jsonl")
    assert said(tmp_path) + rest == undisturbed


def test_monitors_that_share_a_log_lose_no_line_and_never_write_at_once(undisturbed, tmp_path):
    log = tmp_path / "log.jsonl"
    for source in (Samples(MADE), Samples(MADE, name="other"), Samples(MADE)):
        monitor(FILE, source, state=tmp_path / f"{source.name}.state", log=log)
    assert said(tmp_path) == [*undisturbed, *undisturbed]
    content = log.read_bytes()
    open_one = WindowLog(log)
    open_one.open({})
    with pytest.raises(StoreError):
        run(tmp_path)
    open_one.close()
    assert log.read_bytes() == content


def test_a_source_that_cannot_go_back_starts_over_and_no_window_comes_twice(undisturbed, tmp_path):
    class FromTheStart(Samples):
        position = {}  # noqa: RUF012

    before, after = Kept(20), Kept()
    with pytest.raises(Killed):
        run(tmp_path, FromTheStart(MADE), before)
    run(tmp_path, FromTheStart(MADE), after)
    assert said(tmp_path) == undisturbed
    assert {*numbers_of(before.lines + after.lines)} == {*range(40)}
    assert before.is_closed
    assert after.is_closed


def test_malformed_lines_are_said_alike_whatever_the_blocks_and_the_kills(tmp_path, monkeypatch):
    times, samples = MADE.time.tolist(), MADE.channels[P1].tolist()
    rows = [f"{time},{sample}\n" for time, sample in zip(times, samples, strict=True)]
    for place in (30_000, 12_345, 12_300, 700):
        rows[place:place] = ["no row\n"] * (place // 100)
    text = tmp_path / "run.csv"
    text.write_text("time [s],P1 [Pa]\n" + "".join(rows))
    run(tmp_path / "undisturbed", GrowingFile(text, follow=False))
    monkeypatch.setattr(growing_file, "BLOCK", 2345)
    for number in range(30):
        kill = {"view": Kept(20 + number)} if number % 2 else {"storing": killed_at(3)}
        with suppress(Killed):
            run(tmp_path / "disturbed", GrowingFile(text, follow=False), **kill)
            break
    lines = said(tmp_path / "disturbed")
    assert lines == said(tmp_path / "undisturbed")
    counts = [each["count"] for each in lines if each.get("event") == "malformed"]
    assert sum(counts) == 300 + 123 + 123 + 7


def test_a_stream_that_ends_without_a_judged_window_says_so_unless_it_had_some_before(tmp_path):
    assert run(tmp_path / "stuck", Samples(part(MADE, 20_000, 22_000))) is Ending.UNJUDGED
    (tmp_path / "run.csv").write_text("time [s],P1 [bar]\n" + "0.0;1\n" * 60_000)
    kept = Kept()
    assert monitor(FILE, GrowingFile(tmp_path / "run.csv", follow=False), kept) is Ending.UNJUDGED
    assert [(line.kind, line.count) for line in kept.lines[1:-1]] == [("malformed", 1), ("malformed", 59_999)]
    for n_sample, ending in (
        (0, Ending.UNJUDGED), (700, Ending.UNJUDGED), (2300, Ending.OVER), (2300, Ending.OVER),
    ):  # fmt: skip
        assert run(tmp_path, Samples(part(MADE, 0, n_sample))) is ending


@pytest.mark.parametrize("error", [BrokenPipeError, RuntimeError])
def test_lines_that_were_delivered_are_stored_whatever_ends_the_monitor(
    undisturbed, error, tmp_path, monkeypatch
):
    def fails():
        raise error

    monkeypatch.setattr(loop, "STORE_EVERY", 1e9)
    ends, kept = Kept(at_17=fails), Kept()
    with suppress(RuntimeError):
        assert run(tmp_path, view=ends) is Ending.OUTPUT_CLOSED
    numbers = numbers_of(ends.lines)
    assert [each["number"] for each in said(tmp_path) if "number" in each] == numbers != []
    run(tmp_path, view=kept)
    assert said(tmp_path) == undisturbed
    assert numbers + numbers_of(kept.lines) == [*range(40)]


def test_what_was_lost_on_the_way_is_summed_up_at_the_end(monkeypatch):
    lost, kept = Event(EventKind.DROPPED, "lost", None, 3), Kept()
    monkeypatch.setattr(Sources, "collect", lambda *_: iter([lost]))
    monitor(FILE, Samples(part(MADE, 0, 3500)), kept)
    *parts, total = kept.events("dropped")
    assert (total.is_end, total.count) == (True, 3 * len(parts))
    assert len(parts) == 5


def test_a_source_may_forget_what_is_stored_alone(tmp_path):
    class Forgets(Samples):
        def confirm(self):
            assert stored[-1] == self.position
            super().confirm()

    source, stored = Forgets(MADE), []
    run(tmp_path, source, storing=lambda _, row, store: store() or stored.append(row[""].position))
    assert source.confirmed[-1] == MADE.n_time
    assert len(source.confirmed) > 30


def test_sigterm_and_a_closed_output_end_it_with_its_state_stored(undisturbed, tmp_path):
    with interruption(lambda: None) as asked:
        kept = Kept(at_17=lambda: os.kill(os.getpid(), signal.SIGTERM))
        assert run(tmp_path, view=kept, stop=lambda: bool(asked)) == Ending.STOPPED
    assert asked == [signal.SIGTERM]
    assert kept.lines[-1].kind is EventKind.STOPPED
    assert len(said(tmp_path)) < len(undisturbed)
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w") as pipe:  # nobody reads its output
        assert run(tmp_path, view=pipe) == Ending.OUTPUT_CLOSED
        os.dup2(os.open(os.devnull, os.O_WRONLY), pipe.fileno())
    run(tmp_path)
    assert said(tmp_path) == undisturbed


def test_a_full_disk_is_said_once_and_it_goes_on(undisturbed, tmp_path):
    """The size of files is limited for a while: the log does not fit, later it does."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def limited(size):
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))

    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        kept = Kept(at_10=limited(4000), at_25=limited(hard))
        run(tmp_path, view=kept)
    finally:
        limited(hard)()
        signal.signal(signal.SIGXFSZ, previous)
    full, again = kept.events("not_stored")
    assert "cannot be written" in full.text
    assert again.is_end
    assert [each for each in said(tmp_path) if each.get("event") != "not_stored"] == undisturbed


def test_what_is_no_log_is_refused_and_left_whole(tmp_path):
    log, notes = tmp_path / "log.jsonl", tmp_path / "notes"
    notes.write_text("notes")
    for make in (log.symlink_to, notes.rename):
        make(log if make == notes.rename else notes)
        with pytest.raises(StoreError):
            run(tmp_path)
        assert log.read_text() == "notes"


def test_the_state_of_another_source_or_detector_or_in_use_is_refused(tmp_path):
    run(tmp_path)
    store = StateStore(tmp_path / "state")
    with store.opened(), pytest.raises(StoreError, match="another monitor"):
        run(tmp_path)
    with pytest.raises(StoreError, match="another source"):
        run(tmp_path, Samples(MADE, name="other"))
    with pytest.raises(StoreError, match="another detector"):
        run(tmp_path, file=made_detector(every=0.5))


@pytest.fixture
def stored(tmp_path):
    store = StateStore(tmp_path / "state")
    with store.opened():
        store.write({"": StoredMachine("made", "digest", {"seen": [1, 2]}, {"number": np.array(4)})}, {})
    return store


def execute(path, command, *values):
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(command, values)


@pytest.mark.parametrize("change", [
    *(f"update machine set {each} = 'text'" for each in ("name", "source", "detector", "position", "state")),
    "update machine set state = cast('text' as blob)", "pragma user_version = 3",
    "pragma application_id = 0x4846464D", lambda path: path.write_text("longer than the header" * 20),
    lambda path: path.unlink() or execute(path, "create table mine (a)"),
    lambda path: path.write_bytes(path.read_bytes()[:-4096]),
    lambda path: path.write_bytes(b"0" * 64 + b"\n{}\nof an earlier version"),
])  # fmt: skip
def test_what_is_damaged_or_no_state_is_refused_and_left_whole(stored, change, tmp_path):
    if callable(change):
        change(stored.path)
    else:
        execute(stored.path, change)
    content = stored.path.read_bytes()
    with pytest.raises(StoreError, match="state: "):
        run(tmp_path)
    assert stored.path.read_bytes() == content


@pytest.mark.parametrize(("column", "forged"), [
    ("position", '"text"'), ("position", "{"), ("state", b""),
    ("state", json.dumps([["number", "|O", []]]).encode() + b"\n" + bytes(8)),
])  # fmt: skip
def test_a_forged_state_is_refused(stored, monkeypatch, column, forged):
    monkeypatch.setattr("hydrofdi.monitor.store._checksum", lambda *row: 0)
    execute(stored.path, f"update machine set {column} = ?, checksum = 0", forged)
    with stored.opened(), pytest.raises(StoreError):
        stored.read("")
