"""``hydrofdi monitor`` and ``replay`` over a broker with a password."""

import json
from pathlib import Path

import pytest

from tests.commands import COMMAND, run
from tests.monitor.brokers import SECRET, needs_mosquitto
from tests.monitor.machines import make_machine
from tests.monitor.mqtt_streams import connected, killed, source_at, wait_for

pytestmark = [needs_mosquitto, pytest.mark.long]


def windows(log):
    """What a log says of windows, with their instants to the microsecond: those of a replay are made anew."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    records = [record for line in lines if (record := json.loads(line))["line"] == "window"]
    return [each | {key: round(each[key], 6) for key in ("start", "end")} for each in records]


def test_a_killed_monitor_gives_the_windows_of_the_file_and_shows_no_password(guarded, tmp_path, monkeypatch):
    machine, folder = make_machine(tmp_path), tmp_path / "life"
    folder.mkdir()
    run("monitor", machine.detector, machine.stream, "--no-follow", "--log", tmp_path / "expected", check=0)
    expected = windows(tmp_path / "expected")
    assert len(expected) == machine.n_window
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    before = source_at(guarded.address(), detector=machine.detector)
    connected(before)
    before.close()
    run("replay", machine.stream, "--rate", "max", "--to", guarded.address(), check=0)
    files = ["--state", "state", "--log", "log", "--events", guarded.address("press/events")]
    command = [*COMMAND, "monitor", str(machine.detector), guarded.address(), *files]
    arguments = []
    with (folder / "output").open("ab") as output:
        for number in (5, machine.n_window):
            with killed(command, cwd=folder, stdout=output, stderr=output) as life:
                wait_for(lambda number=number: len(windows(folder / "log")) >= number, timeout=120.0)
                arguments.append(Path(f"/proc/{life.pid}/cmdline").read_text())
    assert windows(folder / "log") == expected
    shown = [file.read_bytes() for file in folder.iterdir()] + [guarded.log.encode()]
    assert len(shown) >= 4
    assert not [text for text in shown if SECRET.encode() in text]
    assert SECRET not in "".join(arguments)
