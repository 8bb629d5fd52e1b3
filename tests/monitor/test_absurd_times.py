"""One absurd time stamp costs its samples and nothing else: it is counted, and the state stays readable."""

import json

import pytest

from hydrofdi.monitor.loop import monitor
from hydrofdi.monitor.sinks.log import WindowLog
from hydrofdi.monitor.state import StateFile
from hydrofdi.monitor.watch import Watch
from tests.commands import run
from tests.monitor.brokers import needs_mosquitto
from tests.monitor.machines import make_machine
from tests.monitor.mqtt_streams import client_at, published, source_at
from tests.monitor.streams import made_detector


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    return make_machine(tmp_path_factory.mktemp("machine"))


def records(log):
    return [json.loads(line) for line in log.read_text().splitlines()]


def of_kind(log, *kinds):
    return [each for each in records(log) if each.get("event", "window") in kinds]


def with_absurd_times(lines, is_json):
    """Three of them in the midst of a stream, the last one at its end."""
    header, *rows = lines
    absurd = [f"{stamp},1\n" for stamp in ("1e300", "-1e12", "1e11")]
    absurd[-1] = absurd[-1].replace("1e11", "1.0001e11")
    rows = [*rows[:5000], *absurd[:2], *rows[5000:], absurd[2]]
    if not is_json:
        return [header, *rows]
    pairs = (row.strip().split(",") for row in rows)
    return [f'{{"time [s]": {time}, "P1 [bar]": {pressure}}}\n' for time, pressure in pairs]


@pytest.mark.parametrize("is_json", [False, True], ids=["CSV", "JSON lines"])
def test_in_a_file_it_is_counted_and_changes_no_window(machine, is_json, tmp_path):
    stream, log = tmp_path / "stream", tmp_path / "log"
    run("monitor", machine.detector, machine.stream, "--no-follow", "--log", tmp_path / "expected", check=0)
    stream.write_text("".join(with_absurd_times(machine.lines, is_json)))
    files = ("--no-follow", "--state", tmp_path / "state", "--log", log)
    done = run("monitor", machine.detector, stream, *files, check=0)
    assert "Traceback" not in done.stderr
    assert of_kind(log, "window") == of_kind(tmp_path / "expected", "window")
    assert sum(each["count"] for each in of_kind(log, "malformed")) == 3
    assert not of_kind(log, "not_stored")
    with stream.open("a") as file:
        file.write(with_absurd_times(machine.lines, is_json)[-1])
    run("monitor", machine.detector, stream, *files, check=0)
    assert len(of_kind(log, "resumed")) == 1
    assert sum(each["count"] for each in of_kind(log, "malformed")) == 4


@needs_mosquitto
def test_from_a_broker_it_is_acknowledged_and_does_not_come_again(broker, tmp_path):
    file, log, client = made_detector(), tmp_path / "log", client_at(broker)

    def watch_until(kind):
        source = source_at(broker.address(), is_open=False)
        state_file = StateFile(tmp_path / "state", file, source.name)
        kept = {"state_file": state_file, "log": WindowLog(log, file.unit)}
        monitor(Watch(file), source, **kept, stop=lambda: log.exists() and bool(of_kind(log, kind)))

    def send(time, frequency):
        block = {"time": time, "sampling_frequency": frequency, "P1 [Pa]": [1, 2]}
        published(client, "press/samples", json.dumps(block))

    watch_until("connected")
    send(0, 1e-300)
    watch_until("malformed")
    send(100, 1e3)
    watch_until("gap")
    assert [each["count"] for each in of_kind(log, "malformed")] == [1]
    assert not of_kind(log, "not_stored")
    assert len(of_kind(log, "resumed")) == 2
