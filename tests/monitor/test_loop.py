"""A monitor goes on where it was: its log has each window once, whatever happens to process or disk."""

import os
import resource
import signal
from contextlib import contextmanager, suppress
from itertools import count
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.detectors.lines import WindowLine
from hydrofdi.errors import StoreError, interruption
from hydrofdi.monitor import growing_file, loop
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.growing_file import GrowingFile
from hydrofdi.monitor.loop import Ending, single_monitor
from hydrofdi.monitor.machines import MachineKind
from hydrofdi.monitor.opening import Sources
from hydrofdi.monitor.store import StateStore, WindowLog
from hydrofdi.records.streams import Event, EventKind
from tests.monitor.streams import (
    P1,
    Kept,
    Killed,
    Samples,
    live,
    logged,
    made_detector,
    monitor,
    part,
    stream,
)

FILE = made_detector()
MADE = stream(40, leaking=[12, 13, 30], stuck=[20, 21])


@contextmanager
def storing(before=lambda *_: None, after=lambda *_: None):
    """Calls with the number of each storing, and what is stored."""
    write, number = StateStore.write, count(1)

    def noted(self, machines, log):
        place = next(number)
        before(place, machines)
        write(self, machines, log)
        after(place, machines)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StateStore, "write", noted)
        yield


def run(folder, source=None, view=None, stop=lambda: False, file=FILE, kill_after_state=0):
    def killed(number, _):
        if number == kill_after_state:
            raise Killed  # between the state and the log

    with storing(after=killed):
        return live(folder, source or Samples(MADE), view, stop, file)


@pytest.fixture(autouse=True)
def stored_at_once(monkeypatch):
    """Each line is stored before the next reading; the clock advances by a second at each look."""
    monkeypatch.setattr(loop, "STORE_EVERY", 0.0)
    monkeypatch.setattr(loop, "time", SimpleNamespace(monotonic=count().__next__))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    assert run(folder) == Ending.OVER
    lines = logged(folder)
    assert [each["number"] for each in lines if each["line"] == "window"] == list(range(40))
    events = [each["event"] for each in lines if each["line"] == "event"]
    assert events == ["alarm_raised", "stuck", "alarm_cleared", "alarm_raised", "stuck"]
    return lines


@settings(max_examples=8, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 30), st.booleans(), st.integers(1, 9)), min_size=1, max_size=8))
def test_killed_before_or_after_the_state_nothing_is_lost_or_twice(undisturbed, tmp_path_factory, kills):
    folder = tmp_path_factory.mktemp("killed")
    for call, is_stored, every in kills:
        loop.STORE_EVERY = every
        try:
            if is_stored:
                run(folder, kill_after_state=call)
            else:
                run(folder, view=Kept(call))
        except Killed:
            continue
        break
    else:
        run(folder)
    assert logged(folder) == undisturbed


@pytest.mark.parametrize("n_written", [0, 9, -1, None])
def test_a_torn_step_is_completed(undisturbed, n_written, tmp_path):
    with pytest.raises(Killed):
        run(tmp_path, kill_after_state=15)
    store = StateStore(tmp_path / "state", is_fleet=False)
    with store.opened():
        waiting = store.read_log()["waiting"]
    assert waiting
    with open(tmp_path / "log.jsonl", "a") as log:
        log.write(waiting[:n_written])
    run(tmp_path)
    assert logged(tmp_path) == undisturbed


@pytest.mark.parametrize("n_stored", [10, 100])
def test_a_log_that_was_rotated_has_each_window_once_whether_the_state_is_stored_or_not(
    undisturbed, n_stored, tmp_path
):
    def fails(number, _):
        if number == 16:
            (tmp_path / "log.jsonl").rename(tmp_path / "old")
        if number > n_stored:
            raise StoreError("full")

    with pytest.raises(Killed), storing(fails):
        live(tmp_path, Samples(MADE), Kept(30))
    run(tmp_path)
    rest = logged(tmp_path)
    (tmp_path / "old").rename(tmp_path / "log.jsonl")
    assert logged(tmp_path) + rest == undisturbed


def test_monitors_that_share_a_log_lose_no_line_and_never_write_at_once(undisturbed, tmp_path):
    log = tmp_path / "log.jsonl"
    for source in (Samples(MADE), Samples(MADE, name="other"), Samples(MADE)):
        monitor(FILE, source, state=tmp_path / f"{source.name}.state", log=log)
    assert logged(tmp_path) == [*undisturbed, *undisturbed]
    content = log.read_bytes()
    open_one = WindowLog(log)
    open_one.open({})
    with pytest.raises(StoreError):
        run(tmp_path)
    open_one.close()
    assert log.read_bytes() == content


@pytest.mark.parametrize("is_link", [False, True])
def test_what_is_no_log_is_refused_and_left_whole(is_link, tmp_path):
    notes = tmp_path / ("notes" if is_link else "log.jsonl")
    notes.write_text("notes")
    if is_link:
        (tmp_path / "log.jsonl").symlink_to(notes)
    with pytest.raises(StoreError):
        run(tmp_path)
    assert notes.read_text() == "notes"


def test_a_source_that_cannot_go_back_starts_over_and_no_window_comes_twice(undisturbed, tmp_path):
    class FromTheStart(Samples):
        @property
        def position(self):
            return {}

    before, after = Kept(20), Kept()
    with pytest.raises(Killed):
        run(tmp_path, FromTheStart(MADE), before)
    run(tmp_path, FromTheStart(MADE), after)
    assert logged(tmp_path) == undisturbed
    lines = before.lines + after.lines
    assert {line.number for line in lines if isinstance(line, WindowLine)} == {*range(40)}
    assert before.is_closed
    assert after.is_closed


def test_malformed_lines_are_said_alike_whatever_the_blocks_and_the_kills(tmp_path, monkeypatch):
    text, disturbed, undisturbed = (tmp_path / name for name in ("run.csv", "disturbed", "undisturbed"))
    times, samples = MADE.time.tolist(), MADE.channels[P1].tolist()
    rows = [f"{time},{sample}\n" for time, sample in zip(times, samples, strict=True)]
    for place in (30_000, 12_345, 12_300, 700):
        rows[place:place] = ["no row\n"] * (place // 100)
    text.write_text("time [s],P1 [Pa]\n" + "".join(rows))
    for folder in (disturbed, undisturbed):
        folder.mkdir()
    run(undisturbed, GrowingFile(text, follow=False))
    monkeypatch.setattr(growing_file, "BLOCK", 2345)
    for number in range(30):
        kill = {"view": Kept(20 + number)} if number % 2 else {"kill_after_state": 3}
        with suppress(Killed):
            run(disturbed, GrowingFile(text, follow=False), **kill)
            break
    assert logged(disturbed) == logged(undisturbed)
    counts = [each["count"] for each in logged(disturbed) if each.get("event") == "malformed"]
    assert sum(counts) == 300 + 123 + 123 + 7


def test_a_stream_that_ends_without_a_judged_window_says_so_unless_it_had_some_before(tmp_path):
    assert run(tmp_path / "stuck", Samples(part(MADE, 20_000, 22_000))) is Ending.UNJUDGED
    (tmp_path / "run.csv").write_text("time [s],P1 [bar]\n" + "0.0;1\n" * 60_000)
    kept = Kept()
    assert monitor(FILE, GrowingFile(tmp_path / "run.csv", follow=False), kept) is Ending.UNJUDGED
    assert [(line.kind, line.count) for line in kept.lines[1:-1]] == [("malformed", 1), ("malformed", 59_999)]
    for n_sample, ending in ((0, Ending.UNJUDGED), (700, Ending.UNJUDGED), (2300, Ending.OVER)):
        assert run(tmp_path, Samples(part(MADE, 0, n_sample))) is ending
    assert run(tmp_path, Samples(part(MADE, 0, 2300))) is Ending.OVER


@pytest.mark.parametrize("is_output", [False, True])
def test_lines_that_were_delivered_are_stored_whatever_ends_the_monitor(
    undisturbed, is_output, tmp_path, monkeypatch
):
    class Ends(Kept):
        def put(self, chunk, lines):
            if any(isinstance(line, WindowLine) and line.number == 17 for line in lines):
                raise BrokenPipeError if is_output else RuntimeError
            return super().put(chunk, lines)

    monkeypatch.setattr(loop, "STORE_EVERY", 1e9)
    ends, kept = Ends(), Kept()
    with suppress(RuntimeError):
        assert run(tmp_path, view=ends) is Ending.OUTPUT_CLOSED
    numbers = [line.number for line in ends.lines if isinstance(line, WindowLine)]
    assert [each["number"] for each in logged(tmp_path) if "number" in each] == numbers != []
    run(tmp_path, view=kept)
    assert logged(tmp_path) == undisturbed
    assert numbers + [line.number for line in kept.lines if isinstance(line, WindowLine)] == [*range(40)]


def test_what_was_lost_on_the_way_is_summed_up_at_the_end(monkeypatch):
    lost, kept = Event(EventKind.DROPPED, "lost", None, 3), Kept()
    monkeypatch.setattr(Sources, "collect", lambda *_: iter([lost]))
    monitor(FILE, Samples(part(MADE, 0, 3500)), kept)
    *parts, total = [line for line in kept.lines if isinstance(line, Event) and line.kind == "dropped"]
    assert (total.is_end, total.count) == (True, 3 * len(parts))
    assert len(parts) == 5


def test_a_source_may_forget_what_is_stored_alone(tmp_path):
    class Forgets(Samples):
        def confirm(self):
            assert stored[-1] == self.position
            super().confirm()

    source, stored = Forgets(MADE), []
    with storing(after=lambda _, machines: stored.append(machines[""].position)):
        live(tmp_path, source)
    assert source.confirmed[-1] == MADE.n_time
    assert len(source.confirmed) > 30


def test_sigterm_and_a_closed_output_end_it_with_its_state_stored(undisturbed, tmp_path):
    class Asks(Kept):
        def put(self, chunk, lines):
            if any(isinstance(line, WindowLine) and line.number == 17 for line in lines):
                os.kill(os.getpid(), signal.SIGTERM)
            return super().put(chunk, lines)

    with interruption(lambda: None) as asked:
        kept = Asks()
        assert run(tmp_path, view=kept, stop=lambda: bool(asked)) == Ending.STOPPED
    assert asked == [signal.SIGTERM]
    assert kept.lines[-1].kind is EventKind.STOPPED
    assert len(logged(tmp_path)) < len(undisturbed)
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w") as pipe:  # nobody reads its output
        files = {"state": tmp_path / "state", "log": tmp_path / "log.jsonl"}
        found = single_monitor(MachineKind(FILE, MonitorConfig()), Samples(MADE), pipe, **files).run(
            lambda: False
        )
        assert found == Ending.OUTPUT_CLOSED
        os.dup2(os.open(os.devnull, os.O_WRONLY), pipe.fileno())
    run(tmp_path)
    assert logged(tmp_path) == undisturbed


def test_a_full_disk_is_said_once_and_it_goes_on(undisturbed, tmp_path):
    """The size of files is limited for a while: the log does not fit, later it does."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    class Fills(Kept):
        def put(self, chunk, lines):
            numbers = [line.number for line in lines if isinstance(line, WindowLine)]
            if 10 in numbers:
                resource.setrlimit(resource.RLIMIT_FSIZE, (4000, hard))
            if 25 in numbers:
                resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
            return super().put(chunk, lines)

    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        kept = Fills()
        run(tmp_path, view=kept)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
        signal.signal(signal.SIGXFSZ, previous)
    full, again = (
        line for line in kept.lines if isinstance(line, Event) and line.kind is EventKind.NOT_STORED
    )
    assert "cannot be written" in full.text
    assert again.is_end
    assert [each for each in logged(tmp_path) if each.get("event") != "not_stored"] == undisturbed


def test_the_state_of_another_source_or_detector_or_in_use_is_refused(tmp_path):
    run(tmp_path)
    store = StateStore(tmp_path / "state", is_fleet=False)
    with store.opened(), pytest.raises(StoreError, match="another monitor"):
        run(tmp_path)
    with pytest.raises(StoreError, match="another source"):
        run(tmp_path, Samples(MADE, name="other"))
    with pytest.raises(StoreError, match="another detector"):
        run(tmp_path, file=made_detector(every=0.5))
    (tmp_path / "state").write_bytes(b"0" * 64 + b"\n{}\nof an earlier version")
    with pytest.raises(StoreError, match="version"):
        run(tmp_path)
