"""A fleet over a real broker: killed, stopped, divided, and with machines that come and go."""

import json
import random
import signal
import subprocess
import time
from collections import defaultdict
from contextlib import contextmanager
from itertools import islice

import pytest
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from hydrofdi.monitor import topics
from hydrofdi.monitor.mqtt import payload_of
from hydrofdi.monitor.store import StateStore, WindowLog
from tests.commands import COMMAND, wait_until
from tests.monitor.brokers import client_at, needs_mosquitto
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
    write_fleet,
)
from tests.monitor.streams import part

pytestmark = needs_mosquitto

MACHINES = made(5)
BLOCKS = blocks_of(MACHINES)
EXPECTED = expected(MACHINES, is_over=False)


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
def fleet(broker, tmp_path):
    """A fleet that the broker knows, so that it keeps messages."""
    path = write_fleet(tmp_path, broker.address("plant/+/samples"))
    known(path)
    return path


@pytest.fixture
def log(fleet):
    return fleet.with_name("fleet.jsonl")


def known(path, **options):
    life = Life(path, **options)
    wait_until(lambda: life.events(event="connected") or life.failure)
    life.end()


def test_killed_again_and_again_no_window_of_any_machine_is_lost_or_twice(broker, fleet, log, monkeypatch):
    """Before or after states are stored, the log is written, and messages are acknowledged."""
    methods = (StateStore, "write"), (WindowLog, "write"), (topics.Topics, "acknowledge")
    kills = Kills(monkeypatch, 3, 9, *methods)
    with sender(broker) as publish:
        bad = [("m0", b"no JSON"), ("m9", b'{"time": 0}'), ("m1", b"\xff")]
        blocks = iter([*BLOCKS[:100], *bad, *BLOCKS[100:]])
        for number in range(15):
            life = kills.begin(fleet, is_last=number == 14)
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
    assert found == EXPECTED


def is_done(log):
    return n_window(logged(log)) == len(MACHINES) * N_WINDOW


def test_few_messages_stay_unacknowledged_and_in_the_end_none(broker, fleet, log, monkeypatch):
    """A machine that stops in the middle of a window holds up no others."""
    monkeypatch.setattr(topics, "MOST_KEPT", 40)
    depths, acknowledge = [], topics.Topics.acknowledge

    def noted(self):
        acknowledge(self)
        depths.append(len(self._open))

    monkeypatch.setattr(topics.Topics, "acknowledge", noted)
    life = Life(fleet)
    send(broker, [("halted", payload_of(part(MACHINES["m0"], 0, 100))), *BLOCKS])
    wait_until(lambda: is_done(log))
    wait_until(lambda: broker.log.count("Received PUBACK from hydrofdi") == len(BLOCKS) + 1)
    life.end()
    assert logged(log) == EXPECTED
    assert max(depths) <= 40


def test_when_no_message_comes_the_broker_keeps_none(broker, fleet, log):
    """Also if no window ends; after a restart the window continues."""
    blocks = blocks_of({"m0": MACHINES["m0"]})
    life = Life(fleet)
    for number in (1, 5):  # the first ones are stored with the event of the start
        send(broker, blocks[:1] if number == 1 else blocks[1:5])
        wait_until(lambda number=number: broker.log.count("Received PUBACK from hydrofdi") == number)
    life.end()
    life = Life(fleet)
    send(broker, blocks[5:])
    wait_until(lambda: n_window(logged(log)) == N_WINDOW)
    life.end()
    assert logged(log) == {"m0": EXPECTED["m0"]}


def test_machines_come_and_go(broker, fleet, log, tmp_path):
    """A silent one is released; it continues in the middle of its window, on a broker that started again."""
    write_fleet(tmp_path, broker.address("plant/+/samples"), idle="1 s", most_machines=2)
    blocks = blocks_of({"m1": MACHINES["m1"]})
    life = Life(fleet)
    send(broker, blocks[:55])
    wait_until(lambda: life.events("m1", "stopped"))
    send(broker, blocks[55:60])
    wait_until(lambda: n_window(logged(log)) == 6)
    broker.stop()
    broker.start()
    send(broker, blocks[60:])
    wait_until(lambda: n_window(logged(log)) == N_WINDOW)
    life.end()
    assert logged(log) == {"m1": EXPECTED["m1"]}
    said = [line["event"] for line in life.events("m1")]
    assert said[:2] == ["started", "alarm_raised"]
    assert said.index("stopped") < said.index("resumed")


def files_of(folder, k, name=""):
    """Options of a process with a partition, a state and a log of its own."""
    place = folder / (name or str(k))
    return {"partition": f"{k}/3", "state": place.with_suffix(".db"), "log": place.with_suffix(".jsonl")}


def command_of(fleet, own):
    return [*COMMAND, "monitor", str(fleet), *(f"--{key}={value}" for key, value in own.items())]


def test_a_second_process_of_a_partition_is_refused_until_the_first_has_ended(broker, fleet, tmp_path):
    """Also if it has another state and log; the end of the first may be a kill."""

    def begun(name):
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen(command_of(fleet, files_of(tmp_path, 1, name)), **pipes)

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


def test_a_fleet_that_falls_behind_says_so_with_the_age_of_the_samples(broker, fleet, tmp_path):
    """When it begins, when it has caught up, and at the end."""

    def sent(seconds, names):
        now = time.time() - seconds
        return [(name, payload_of(later(part(MACHINES["m0"], 0, 100), now))) for name in names]

    def ages(*, is_end):
        return [each["details"]["age_s"] for each in life.events(event="behind") if each["is_end"] == is_end]

    life = Life(fleet, metrics="127.0.0.1:0")
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
def test_sigkill_fifty_times_changes_no_window_of_three_processes(broker, fleet, tmp_path):
    """Twenty machines in three processes, one of which is killed at a random moment, again and again."""
    draw, machines = random.Random(7), made(20, n_window=30)
    blocks, lives, parts = blocks_of(machines), {}, range(1, 4)
    for k in parts:
        known(fleet, **files_of(tmp_path, k))

    def start(k):
        command = command_of(fleet, files_of(tmp_path, k))
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
