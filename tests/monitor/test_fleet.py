"""A fleet of files: each machine is judged as by itself, and nothing that happens to one disturbs another."""

import json
import random
import sqlite3
import urllib.request
from contextlib import suppress
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from prometheus_client.parser import text_string_to_metric_families

from hydrofdi.api.streams import monitor_fleet
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.monitor import machines as machines_module
from hydrofdi.monitor.configuration import MonitorConfig, Pattern, load_fleet_config
from hydrofdi.monitor.loop import Ending
from hydrofdi.monitor.mqtt import Message
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.monitor.sources import joined
from hydrofdi.monitor.store import StateStore, StoredMachine, WindowLog
from hydrofdi.monitor.topics import TopicSource
from tests.commands import run
from tests.monitor.fleets import (
    expected,
    killed_at,
    later,
    logged,
    made,
    n_window,
    once,
    write_csv,
    write_fleet,
)
from tests.monitor.streams import P1, Killed, made_detector, part, stream

MACHINES = made(3)


@pytest.fixture
def fleet(tmp_path):
    for name, chunk in MACHINES.items():
        write_csv(tmp_path / "press" / f"{name}.csv", chunk)
    return write_fleet(tmp_path, "press/*.csv")


def test_each_machine_is_judged_as_by_itself_and_broken_ones_disturb_none(fleet, tmp_path):
    (tmp_path / "press" / "headless.csv").write_text("1;2;3\n4;5;6\n")
    (tmp_path / "press" / "text.csv").write_text("time [s],P1 [bar]\n" + "no row\n" * 500)
    slow = stream(3)
    slow.time[:] *= 3.0
    write_csv(tmp_path / "press" / "slow.csv", slow)
    write_csv(tmp_path / "press" / "later.csv", later(MACHINES["m0"], 1.7e9))
    write_fleet(tmp_path, ["press/*.csv", "gone.csv"])
    said = []
    assert monitor_fleet(fleet, follow=False, on_line=said.append) is Ending.OVER
    assert "behind" not in {line.get("event") for line in said}, "files of another day are not late"
    found = logged(tmp_path / "fleet.jsonl", without=("started", "stopped"))
    assert {name: found[name] for name in MACHINES} == expected(MACHINES)
    kinds = {name: {each["event"] for each in found[name] if "event" in each} for name in found}
    assert kinds["headless"] == kinds["gone"] == {"disconnected"}
    assert kinds["text"] == {"malformed"}
    assert "rate_changed" in kinds["slow"]


@pytest.mark.parametrize("seed", range(3))
def test_killed_at_any_place_each_window_of_each_machine_is_logged_once(fleet, tmp_path, monkeypatch, seed):
    draw = random.Random(seed)
    monkeypatch.setattr("hydrofdi.monitor.growing_file.BLOCK", 3000)
    write, write_log = StateStore.write, WindowLog.write
    left = {"state": 0, "log": 0}

    def counted(name, function):
        def call(self, *arguments):
            function(self, *arguments)
            left[name] -= 1
            if left[name] == 0:
                raise Killed

        return call

    monkeypatch.setattr(StateStore, "write", counted("state", write))
    monkeypatch.setattr(WindowLog, "write", counted("log", write_log))
    write_fleet(tmp_path, "press/*.csv", store_every="10 ms")
    for life in count():
        where = draw.choice(["lines", "state", "log"]) if life < 12 else ""
        left.update(dict.fromkeys(left, 0) | {where: draw.randint(1, 3)})
        on_line = killed_at(draw.randint(1, 5)) if where == "lines" else None
        with suppress(Killed):
            monitor_fleet(fleet, follow=False, on_line=on_line)
            break
    assert life > 3
    assert logged(tmp_path / "fleet.jsonl") == expected(MACHINES)


def test_samples_that_cannot_be_judged_are_lost_with_an_event_of_their_machine(fleet, tmp_path, monkeypatch):
    monkeypatch.setattr("hydrofdi.monitor.growing_file.BLOCK", 20_000)
    step, n_failed = Detector.step, [0]

    def fails(self, state, chunk):
        is_second = chunk.time[0] > 2.0 and np.isin(chunk.channels["chamber_1_pressure"], first).any()
        if is_second and n_failed[0] < 3:
            n_failed[0] += 1
            raise ZeroDivisionError("a bug")
        return step(self, state, chunk)

    first = MACHINES["m0"].channels["chamber_1_pressure"]
    monkeypatch.setattr(Detector, "step", fails)
    assert monitor_fleet(fleet, follow=False) is Ending.OVER
    found, alone = logged(tmp_path / "fleet.jsonl"), expected(MACHINES)
    assert [each["event"] for each in found["m0"] if "event" in each][:2] == ["dropped", "gap"]
    assert n_window({"m0": found["m0"]}) < n_window({"m0": alone["m0"]})
    assert {name: found[name] for name in ("m1", "m2")} == {name: alone[name] for name in ("m1", "m2")}


def test_a_source_that_failed_is_tried_again_and_its_reason_said_once(fleet, tmp_path, monkeypatch):
    monkeypatch.setattr(machines_module, "RETRY", 0.0)
    broken, said = tmp_path / "press" / "broken.csv", []
    broken.write_text("1;2;3\n")

    def take(record):
        said.append(record)
        if record["machine"] == "m2" and record.get("number") == 11:
            write_csv(broken, MACHINES["m0"])

    stop = once(lambda: sum(each["machine"] == "broken" and each["line"] == "window" for each in said) == 12)
    assert monitor_fleet(fleet, on_line=take, stop=stop) is Ending.STOPPED
    events = [each["event"] for each in said if each["machine"] == "broken" and "event" in each]
    assert events[:2] == ["started", "disconnected"]
    assert events.count("disconnected") == 1
    assert logged(tmp_path / "fleet.jsonl")["broken"] == expected({"m": MACHINES["m0"]}, is_over=False)["m"]


def test_patterns_choose_detectors_and_with_a_new_one_a_machine_goes_on_counting(fleet, tmp_path):
    (tmp_path / "fine.json").write_text(detector_text(made_detector(every=0.5)))
    said, chosen = [], {"m0": "fine.json", "m[1]": "detector.json"}
    for detectors in (chosen, "fine.json"):
        write_fleet(tmp_path, "press/*.csv", detectors=detectors, most_machines=2)
        monitor_fleet(fleet, follow=False, on_line=said.append)
        numbers = {
            name: [each["number"] for each in lines if each["line"] == "window"]
            for name, lines in logged(tmp_path / "fleet.jsonl").items()
        }
        assert numbers["m0"] == [*range(23)]
        assert numbers["m1"] == [*range(12 if detectors == chosen else 12 + 23)]
    notices = [each for each in said if each.get("event") == "notice"]
    assert "m2.csv" in notices[0]["text"]


def test_new_files_are_new_machines_while_it_runs(fleet, tmp_path, monkeypatch):
    monkeypatch.setattr("hydrofdi.monitor.opening._LOOK_EVERY", 0.0)
    said = []

    def take(record):
        said.append(record)
        if len(said) == 5:
            write_csv(tmp_path / "press" / "late.csv", part(MACHINES["m0"], 0, 3000))

    stop = once(lambda: sum(each["machine"] == "late" for each in said) == 4)
    monitor_fleet(fleet, on_line=take, stop=stop)
    assert n_window({"late": logged(tmp_path / "fleet.jsonl")["late"]}) == 3


def test_processes_share_the_machines_by_partitions_and_refuse_the_state_of_another(fleet, tmp_path):
    """It lacks machines that others had."""
    config = load_fleet_config(fleet)
    names = [f"press-{number}" for number in range(3000)]
    parts = [
        {name for name in names if config.model_copy(update={"partition": f"{k}/3"}).owns(name)}
        for k in (1, 2, 3)
    ]
    assert sorted(name for each in parts for name in each) == sorted(names)
    assert min(map(len, parts)) > 900
    for k in (1, 2, 3):
        monitor_fleet(fleet, follow=False, partition=f"{k}/3", state=tmp_path / f"{k}.db")
    assert logged(tmp_path / "fleet.jsonl") == expected(MACHINES)
    path = tmp_path / "1.db"
    content = path.read_bytes()
    for other in ("2/3", "1/2", None):
        with pytest.raises(StoreError, match="partition 1/3"):
            monitor_fleet(fleet, follow=False, state=path, partition=other)
    assert path.read_bytes() == content
    monitor_fleet(fleet, follow=False, state=path, partition="1/3")
    monitor_fleet(fleet, follow=False, state=tmp_path / "whole.db")
    monitor_fleet(fleet, follow=False, state=tmp_path / "whole.db", partition="1/1")


def test_a_state_comes_back_with_the_same_bits(tmp_path):
    draw, store = np.random.default_rng(1), StateStore(tmp_path / "state")
    state = {
        "a.held": draw.standard_normal((5, 7)), "a.none": np.empty((3, 0)), "b.n": np.array(-3),
        "b.flag": np.array([True, False]), "b.nan": np.array([np.nan, -np.inf]), "b.count": np.zeros(2, int),
    }  # fmt: skip
    machine = StoredMachine("topic", "digest", {"seen": [1, 2]}, state)
    with store.opened():
        store.write({"m'1": machine, "other": machine}, {"place": 3})
    with store.opened():
        found = store.read("m'1")
        assert store.read("unknown") is None
        assert store.read_log() == {"place": 3}
    assert (found.source, found.detector, found.position) == ("topic", "digest", {"seen": [1, 2]})
    assert found.state.keys() == state.keys()
    for name, array in state.items():
        assert (found.state[name].dtype, found.state[name].shape) == (array.dtype, array.shape)
        assert found.state[name].tobytes() == array.tobytes()


def executed(command):
    def change(path):
        with sqlite3.connect(path) as database:
            database.execute(command)

    return change


@pytest.mark.parametrize(("is_state", "change"), [
    (False, lambda path: path.write_text("notes of mine, longer than the header of a database" * 20)),
    (False, executed("create table mine (a)")), (True, executed("pragma user_version = 3")),
    (True, executed("update machine set state = substr(state, 2)")),
    (True, lambda path: path.write_bytes(path.read_bytes()[:-4096])),
], ids=["text", "database", "version", "row", "cut"])  # fmt: skip
def test_what_is_no_state_of_a_fleet_is_refused_and_left_whole(is_state, change, fleet, tmp_path):
    path = tmp_path / "fleet.db"
    if is_state:
        monitor_fleet(fleet, follow=False)
    change(path)
    content = path.read_bytes()
    with pytest.raises(StoreError, match=r"fleet\.db"):
        monitor_fleet(fleet, follow=False)
    assert path.read_bytes() == content


def test_metrics_have_the_machine_as_a_label(fleet):
    seen = {}

    def take(record):
        if "metrics are served" in record.get("text", ""):
            seen["url"] = record["text"].split()[-1]
        if record["machine"] == "m2" and record.get("number") == 11:
            with urllib.request.urlopen(seen["url"], timeout=30) as answer:
                seen["text"] = answer.read().decode()

    monitor_fleet(fleet, follow=False, metrics="127.0.0.1:0", on_line=take)
    families = {family.name: family for family in text_string_to_metric_families(seen["text"])}
    windows = families["hydrofdi_windows_judged"].samples
    assert {sample.labels["machine"] for sample in windows} == {*MACHINES}
    assert sum(sample.value for sample in windows if sample.labels["machine"] == "m0") == 11
    alarms = {sample.labels["machine"]: sample.value for sample in families["hydrofdi_alarms"].samples}
    assert set(alarms) == {*MACHINES}
    assert families["hydrofdi_fleet_events"].samples[0].labels == {"machine": "", "kind": "started"}


def test_the_command_watches_a_fleet_or_says_what_is_missing(fleet, tmp_path):
    done = run("monitor", fleet, "--no-follow", check=0)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert (lines[0]["event"], lines[-1]["event"]) == ("started", "stopped")
    assert n_window({"all": lines}) == 36
    log = (tmp_path / "fleet.jsonl").read_text()
    assert log == done.stdout
    write_fleet(tmp_path, "mqtt://h/plant/+", events="mqtt://h/plant/events")
    run("monitor", fleet, check=2)
    write_fleet(tmp_path, "press/*.csv")
    for arguments in (
        [tmp_path / "detector.json"], [fleet, "--config", fleet], [fleet, "--partition", "0/3"],
        [tmp_path / "detector.json", tmp_path / "press" / "m0.csv", "--partition", "1/3"],
        [fleet, "--state", "same", "--log", "same"],
    ):  # fmt: skip
        run("monitor", *arguments, cwd=tmp_path, check=2)
    write_fleet(tmp_path, "gone.csv", state="other.db")
    run("monitor", fleet, "--no-follow", check=1)


@pytest.mark.parametrize(("key", "value"), [
    ("machines", "mqtt://h/$share/g/+/samples"), ("machines", "mqtt://h/+/+/samples"), ("machines", "mqtt://h/a+"),
    ("machines", "mqtt://h/a/#"), ("machines", "opc.tcp://h"), ("machines", "*/*.csv"), ("machines", []),
    ("partition", "3/2"), ("interval", "20 s"), ("detector", "d.json"), ("events", ["http://h"]),
])  # fmt: skip
def test_what_is_wrong_in_the_file_is_said_with_its_key_and_line(key, value, tmp_path):
    path = tmp_path / "fleet.yaml"
    lines = {"machines": "a.csv", "detectors": "d.json"} | {key: value}
    path.write_text("".join(f"{name}: {json.dumps(each)}\n" for name, each in lines.items()))
    line = [*lines].index(key) + 1
    with pytest.raises(ConfigError, match=rf"fleet\.yaml:{line}: {key}"):
        load_fleet_config(path)


PAYLOADS = [
    b'{"time": 0.1, "P1 [bar]": 1}', b'{"time": [0.2, 0.3], "P1 [bar]": [1, null]}',
    b'{"time": 1, "sampling_frequency": "1 kHz", "P1 [bar]": [1, 2, 3]}', b'{"time": 2, "P1 [bar]": [1, 2]}',
    b'{"time": 3, "sampling_frequency": 500, "P1 [bar]": [4, 5]}', b'{"P1 [bar]": 1, "time": 5}', b"no JSON",
    b'{"time": "2026-01-31T12:00:00Z", "P1 [bar]": 7}', b'{"time": 8, "P1 [psi]": 7}', b"\xff", b"",
    b'{"time": 8.1, "P1 [bar]": 7}\n{"time": 8.2, "P1 [bar]": 8}', b'{"time": 9, "P1 [bar]": "x"}',
]  # fmt: skip
"""Forms of messages, some of which are wrong."""


@given(st.lists(st.sampled_from(PAYLOADS), min_size=1, max_size=5))
def test_messages_read_at_once_give_the_samples_of_each(payloads):
    at_once = PayloadReader(MonitorConfig(), needed=[P1]).read_all(payloads)
    alone = joined([PayloadReader(MonitorConfig(), needed=[P1]).read_all([each]) for each in payloads])
    assert at_once.time.tobytes() == alone.time.tobytes()
    for chunk in (at_once, alone):
        assert chunk.n_time == 0 or not chunk.channels or [*chunk.channels] == [P1]
    if alone.channels:
        assert at_once.channels[P1].tobytes() == alone.channels[P1].tobytes()
    assert at_once.unread == alone.unread


@pytest.mark.parametrize(("source", "place", "name"), [
    ("mqtt://h/plant/+/samples", "plant/press 3/samples", "press 3"),
    ("mqtt://h/plant/+/samples", "plant/a/b/samples", None),
    ("mqtt://h/plant/+/samples", "plant//samples", None),
    ("mqtt://h/plant/+", "plant/a", "a"), ("mqtt://h/+", "a", "a"),
    ("mqtt://h/one/topic", "one/topic", "one/topic"), ("mqtt://h/one/topic", "one/other", None),
    ("logs/*.csv", "/x/logs/a.csv", "a"), ("logs/*/s.csv", "/x/logs/b/s.csv", "b"),
    ("one.csv", "/x/one.csv", "one"), ("/data/p-*.csv", "/data/p-1.csv", "1"),
    ("/data/p-*.csv", "/data/q-1.csv", None),
])  # fmt: skip
def test_a_wildcard_stands_for_the_name(source, place, name):
    assert Pattern.parse(source, Path("/x")).name_in(place) == name


@given(st.data())
def test_of_messages_that_come_again_exactly_those_in_the_state_are_left_out(data):
    """However many were acknowledged, how often the process ended, and what the clock says."""
    draw = lambda most: data.draw(st.integers(0, most))  # noqa: E731
    times = data.draw(st.lists(st.integers(0, 3), min_size=1, max_size=30))
    messages = [json.dumps({"time": time, "P1 [bar]": 1}).encode() for time in times]
    read, position, n_stored, n_acknowledged, n_sent = [], {}, 0, 0, 0
    while n_stored < len(messages):
        source, client = TopicSource("t", MonitorConfig(), [P1]), object()
        source.open(position)
        del read[n_stored:]
        for number in range(n_acknowledged, min(len(messages), n_stored + 1 + draw(9))):
            source.take(number, client, Message("t", messages[number], number + 1, 1, number < n_sent))
            n_sent = max(n_sent, number + 1)
            if draw(1):
                continue
            chunk = source.read(0.0)
            read += [] if chunk is None else chunk.time.tolist()
            position, n_stored = source.position, max(n_stored, number + 1)
            for _ in range(draw(number + 1 - n_acknowledged)):
                source.acknowledged()
                n_acknowledged += 1
    assert read == times
