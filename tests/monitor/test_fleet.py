"""Fleets of files and over a real broker: each machine is judged as by itself, whatever happens to others."""

import json
import random
import signal
import subprocess
import time
from collections import defaultdict
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from hydrofdi.api.streams import monitor_fleet
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.monitor import machines as machines_module
from hydrofdi.monitor import topics
from hydrofdi.monitor.configuration import MonitorConfig, Pattern, load_fleet_config
from hydrofdi.monitor.loop import Ending
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.monitor.sources import joined
from hydrofdi.monitor.store import StateStore, WindowLog
from hydrofdi.monitor.topics import Message, TopicSource
from tests.commands import COMMAND, run, wait_until
from tests.monitor.brokers import client_at
from tests.monitor.fleets import (
    N_WINDOW,
    Kills,
    Life,
    blocks_of,
    expected,
    later,
    logged,
    made,
    n_window,
    served,
    write_csv,
    write_fleet,
)
from tests.monitor.streams import P1, made_detector, part, payload_of, stream

MACHINES = made(5)
BLOCKS = blocks_of(MACHINES)
OVER, STOPPED = (expected(MACHINES, is_over=is_over) for is_over in (True, False))


@pytest.fixture
def fleet(tmp_path):
    for name, chunk in MACHINES.items():
        write_csv(tmp_path / "press" / f"{name}.csv", chunk)
    return write_fleet(tmp_path, "press/*.csv")


@pytest.fixture
def log(tmp_path):
    return tmp_path / "fleet.jsonl"


def test_each_machine_is_judged_as_by_itself_and_broken_ones_disturb_none(fleet, log, tmp_path):
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
    found = logged(log, without=("started", "stopped"))
    assert {name: found[name] for name in MACHINES} == OVER
    kinds = {name: {each["event"] for each in found[name] if "event" in each} for name in found}
    assert kinds["headless"] == kinds["gone"] == {"disconnected"}
    assert kinds["text"] == {"malformed"}
    assert "rate_changed" in kinds["slow"]


def test_samples_that_cannot_be_judged_are_lost_with_an_event_of_their_machine(fleet, log, monkeypatch):
    monkeypatch.setattr("hydrofdi.monitor.growing_file.BLOCK", 20_000)
    step, first, n_failed = Detector.step, MACHINES["m0"].channels[P1], [0]

    def fails(self, state, chunk):
        if chunk.time[0] > 2.0 and np.isin(chunk.channels[P1], first).any() and n_failed[0] < 3:
            n_failed[0] += 1
            raise ZeroDivisionError("a bug")
        return step(self, state, chunk)

    monkeypatch.setattr(Detector, "step", fails)
    assert monitor_fleet(fleet, follow=False) is Ending.OVER
    found = logged(log)
    lines = found.pop("m0")
    assert [each["event"] for each in lines if "event" in each][:2] == ["dropped", "gap"]
    assert n_window({"m0": lines}) < 12
    assert found == {name: OVER[name] for name in MACHINES if name != "m0"}


def test_a_source_that_failed_is_tried_again_and_its_reason_said_once(fleet, log, tmp_path, monkeypatch):
    monkeypatch.setattr(machines_module, "RETRY", 0.0)
    broken = tmp_path / "press" / "broken.csv"
    broken.write_text("1;2;3\n")
    life = Life(fleet)
    wait_until(lambda: n_window(logged(log)) == 60)
    write_csv(broken, MACHINES["m0"])
    wait_until(lambda: n_window(logged(log)) == 72)
    life.end()
    events = [each["event"] for each in life.events("broken")]
    assert events[:2] == ["started", "disconnected"]
    assert events.count("disconnected") == 1
    assert logged(log)["broken"] == STOPPED["m0"]


def test_patterns_choose_detectors_and_with_a_new_one_a_machine_goes_on_counting(fleet, log, tmp_path):
    (tmp_path / "fine.json").write_text(detector_text(made_detector(every=0.5)))
    said, chosen = [], {"m0": "fine.json", "m[1]": "detector.json"}
    for detectors in (chosen, "fine.json"):
        write_fleet(tmp_path, "press/*.csv", detectors=detectors, most_machines=2)
        monitor_fleet(fleet, follow=False, on_line=said.append)
        numbers = {
            name: [each["number"] for each in lines if each["line"] == "window"]
            for name, lines in logged(log).items()
        }
        assert numbers["m0"] == [*range(23)]
        assert numbers["m1"] == [*range(12 if detectors == chosen else 12 + 23)]
    notices = [each for each in said if each.get("event") == "notice"]
    assert "m2.csv" in notices[0]["text"]


def test_new_files_are_new_machines_while_it_runs_and_metrics_have_the_machine_as_a_label(
    fleet, log, tmp_path, monkeypatch
):
    monkeypatch.setattr("hydrofdi.monitor.opening._LOOK_EVERY", 0.0)
    life = Life(fleet, metrics="127.0.0.1:0")
    wait_until(lambda: n_window(logged(log)) == 60)
    write_csv(tmp_path / "press" / "late.csv", part(MACHINES["m0"], 0, 3000))
    wait_until(lambda: n_window(logged(log)) == 63)
    metrics = served(life.lines)
    life.end()
    assert n_window({"late": logged(log)["late"]}) == 3
    counts = dict.fromkeys([*MACHINES, "late"], 0.0)
    for sample in metrics["windows_judged"]:
        counts[sample.labels["machine"]] += sample.value
    assert counts == dict.fromkeys(MACHINES, 11.0) | {"late": 3.0}
    assert {sample.labels["machine"] for sample in metrics["alarms"]} == {*counts}
    assert metrics["fleet_events"][0].labels == {"machine": "", "kind": "started"}


def test_processes_share_the_machines_by_partitions_and_refuse_the_state_of_another(fleet, log, tmp_path):
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
    assert logged(log) == OVER
    path = tmp_path / "1.db"
    content = path.read_bytes()
    for other in ("2/3", "1/2", None):
        with pytest.raises(StoreError, match="partition 1/3"):
            monitor_fleet(fleet, follow=False, state=path, partition=other)
    assert path.read_bytes() == content
    monitor_fleet(fleet, follow=False, state=path, partition="1/3")
    for whole in (None, "1/1"):
        monitor_fleet(fleet, follow=False, state=tmp_path / "whole.db", partition=whole)


def test_the_command_watches_a_fleet_or_says_what_is_missing(fleet, log, tmp_path):
    done = run("monitor", fleet, "--no-follow", check=0)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert (lines[0]["event"], lines[-1]["event"]) == ("started", "stopped")
    assert n_window({"all": lines}) == 60
    assert log.read_text() == done.stdout
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
    ("partition", "3/2"), ("interval", "20 s"), ("detector", "d.json"),
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


@contextmanager
def sender(broker):
    """A client that sends, all of it before it ends; each message has properties that nobody needs."""
    properties = Properties(PacketTypes.PUBLISH)
    properties.UserProperty = ("line", "3" * 200)
    with client_at(broker) as client:
        sent = []
        yield lambda name, payload: sent.append(
            client.publish(f"plant/{name}/samples", payload, 1, properties=properties)
        )
        for each in sent:
            each.wait_for_publish(30.0)


def send(broker, blocks):
    with sender(broker) as publish:
        for block in blocks:
            publish(*block)


@pytest.fixture
def plant(broker, tmp_path):
    """A fleet that the broker knows, so that it keeps messages."""
    path = write_fleet(tmp_path, broker.address("plant/+/samples"))
    known(path)
    return path


def known(path, **options):
    life = Life(path, **options)
    wait_until(lambda: life.events(event="connected") or life.failure)
    life.end()


def test_killed_again_and_again_no_window_of_any_machine_is_lost_or_twice(broker, plant, log, monkeypatch):
    """Before or after states are stored, the log is written, and messages are acknowledged."""
    methods = (StateStore, "write"), (WindowLog, "write"), (topics.Topics, "acknowledge")
    kills = Kills(monkeypatch, 3, 9, *methods)
    with sender(broker) as publish:
        bad = [("m0", b"no JSON"), ("m9", b'{"time": 0}'), ("m1", b"\xff")]
        blocks = iter([*BLOCKS[:100], *bad, *BLOCKS[100:]])
        for number in range(15):
            life = kills.begin(plant, is_last=number == 14)
            for _ in range(10):
                for block in islice(blocks, None if number == 14 else 4):
                    publish(*block)
                life.join(0.05)
            if number == 14:
                wait_until(lambda: is_done(log))
            life.end()
    found = logged(log)
    assert found.pop("m9")[0]["event"] == "malformed"
    counts = defaultdict(int)
    for name in ("m0", "m1"):
        for each in [each for each in found[name] if each.get("event") == "malformed"]:
            counts[name] += each["count"]
            found[name].remove(each)
    assert counts == {"m0": 1, "m1": 1}
    assert found == STOPPED


def is_done(log):
    return n_window(logged(log)) == len(MACHINES) * N_WINDOW


def test_few_messages_stay_unacknowledged_and_in_the_end_none(broker, plant, log, monkeypatch):
    """A machine that stops in the middle of a window holds up no others."""
    monkeypatch.setattr(topics, "MOST_KEPT", 40)
    depths, acknowledge = [], topics.Topics.acknowledge

    def noted(self):
        acknowledge(self)
        depths.append(len(self._open))

    monkeypatch.setattr(topics.Topics, "acknowledge", noted)
    life = Life(plant)
    send(broker, [("halted", payload_of(part(MACHINES["m0"], 0, 100))), *BLOCKS])
    wait_until(lambda: is_done(log))
    wait_until(lambda: broker.log.count("Received PUBACK from hydrofdi") == len(BLOCKS) + 1)
    life.end()
    assert logged(log) == STOPPED
    assert max(depths) <= 40


def test_when_no_message_comes_the_broker_keeps_none(broker, plant, log):
    """Also if no window ends; after a restart the window continues."""
    blocks = blocks_of({"m0": MACHINES["m0"]})
    life = Life(plant)
    for first, stop in ((0, 1), (1, 5)):  # the first one is stored with the event of the start
        send(broker, blocks[first:stop])
        wait_until(lambda n=stop: broker.log.count("Received PUBACK from hydrofdi") == n)
    life.end()
    life = Life(plant)
    send(broker, blocks[5:])
    wait_until(lambda: n_window(logged(log)) == N_WINDOW)
    life.end()
    assert logged(log) == {"m0": STOPPED["m0"]}


def test_machines_come_and_go(broker, plant, log, tmp_path):
    """A silent one is released; it continues in the middle of its window, on a broker that started again."""
    write_fleet(tmp_path, broker.address("plant/+/samples"), idle="1 s", most_machines=2)
    blocks = blocks_of({"m1": MACHINES["m1"]})
    life = Life(plant)
    send(broker, blocks[:55])
    wait_until(lambda: life.events("m1", "stopped"))
    send(broker, blocks[55:60])
    wait_until(lambda: n_window(logged(log)) == 6)
    broker.stop()
    broker.start()
    send(broker, blocks[60:])
    wait_until(lambda: n_window(logged(log)) == N_WINDOW)
    life.end()
    assert logged(log) == {"m1": STOPPED["m1"]}
    said = [line["event"] for line in life.events("m1")]
    assert said[:2] == ["started", "alarm_raised"]
    assert said.index("stopped") < said.index("resumed")


def files_of(folder, k, name=""):
    """Options of a process with a partition, a state and a log of its own."""
    place = folder / (name or str(k))
    return {"partition": f"{k}/3", "state": place.with_suffix(".db"), "log": place.with_suffix(".jsonl")}


def command_of(plant, own):
    return [*COMMAND, "monitor", str(plant), *(f"--{key}={value}" for key, value in own.items())]


def test_a_second_process_of_a_partition_is_refused_until_the_first_has_ended(broker, plant, tmp_path):
    """Also if it has another state and log; the end of the first may be a kill."""

    def begun(name):
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen(command_of(plant, files_of(tmp_path, 1, name)), **pipes)

    for number, end in enumerate((signal.SIGKILL, signal.SIGTERM)):
        with begun(f"first{number}") as first:
            try:
                assert any(json.loads(line).get("event") == "connected" for line in first.stdout)
                with begun("second") as second:
                    _, errors = second.communicate(timeout=120)
                assert second.returncode == 2
                assert "partition" in errors
                assert first.poll() is None
                first.send_signal(end)
                first.communicate(timeout=120)
            finally:
                first.kill()


def test_a_fleet_that_falls_behind_says_so_with_the_age_of_the_samples(broker, plant, tmp_path):
    """When it begins, when it has caught up, and at the end."""

    def sent(seconds, names):
        now = time.time() - seconds
        return [(name, payload_of(later(part(MACHINES["m0"], 0, 100), now))) for name in names]

    def ages(*, is_end):
        return [each["details"]["age_s"] for each in life.events(event="behind") if each["is_end"] == is_end]

    life = Life(plant, metrics="127.0.0.1:0")
    send(broker, sent(500.0, ["m0"]))
    wait_until(lambda: ages(is_end=False))
    send(broker, sent(-60.0, ["m0"]))
    wait_until(lambda: ages(is_end=True))
    (sample,) = served(life.lines)["behind_seconds"]
    assert sample.labels == {"machine": ""}
    assert sample.value < 10.0
    send(broker, sent(300.0, ["m1"]))
    wait_until(lambda: len(ages(is_end=False)) == 2)
    life.end()
    assert [ages(is_end=False)[0], ages(is_end=True)[0]] == pytest.approx([500.0] * 2, abs=60.0)
    assert len(ages(is_end=True)) == 2


@pytest.mark.long
def test_sigkill_fifty_times_changes_no_window_of_three_processes(broker, plant, tmp_path):
    """Twenty machines in three processes, one of which is killed at a random moment, again and again."""
    draw, machines = random.Random(7), made(20, n_window=30)
    blocks, lives, parts = blocks_of(machines), {}, range(1, 4)
    for k in parts:
        known(plant, **files_of(tmp_path, k))

    def start(k):
        command = command_of(plant, files_of(tmp_path, k))
        with (tmp_path / "errors").open("a") as errors:
            lives[k] = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors)

    try:
        for k in parts:
            start(k)
        for number in range(50):
            first, stop = (len(blocks) * each // 50 for each in (number, number + 1))
            send(broker, blocks[first:stop])
            time.sleep(draw.uniform(0.0, 2.0))  # any moment, also before it is connected
            k = draw.choice(parts)
            assert lives[k].poll() is None, (tmp_path / "errors").read_text()
            lives[k].kill()
            lives[k].wait()
            start(k)
        logs = [tmp_path / f"{k}.jsonl" for k in parts]
        wait_until(lambda: sum(n_window(logged(log)) for log in logs) >= 20 * 30)
        for life in lives.values():
            life.send_signal(signal.SIGTERM)
            assert life.wait(60) == 0, (tmp_path / "errors").read_text()
    finally:
        for life in lives.values():
            life.kill()
    found = {name: lines for log in logs for name, lines in logged(log).items()}
    assert found == expected(machines, is_over=False)
