"""`hydrofdi monitor` as a command: processes, signals, a growing file, a terminal, and what it refuses."""

import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import threading
from fcntl import ioctl
from pathlib import Path

import pytest

from hydrofdi.detectors.file import load_detector
from hydrofdi.errors import ConfigError, without_credentials
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.loop import Ending
from hydrofdi.monitor.machines import MachineKind
from hydrofdi.monitor.opening import open_stream
from tests.commands import COMMAND, run, run_json, run_process, wait_until
from tests.monitor.machines import ONSET

WITHOUT = """
import sys
sys.modules[sys.argv.pop(1)] = None
from hydrofdi.cli.app import main
main()
"""
"""The command where a library is not installed."""

PATIENCE = 120.0
"""Longest time that anything is waited for [s]."""


def records(text):
    return [json.loads(line) for line in text.splitlines()]


def windows(text):
    return [record for record in records(text) if record["line"] == "window"]


def events(text):
    return [record["event"] for record in records(text) if record["line"] == "event"]


def start(*arguments, **options):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen([*COMMAND, "monitor", *map(str, arguments)], text=True, **pipes | options)


def test_a_leak_that_sets_in_raises_an_alarm_within_two_windows(machine):
    done = run_process("monitor", machine.detector, "-", input=machine.stream.read_text())
    assert done.returncode == 0, done.stderr
    assert len(windows(done.stdout)) == machine.n_window
    (raised,) = [record for record in records(done.stdout) if record.get("event") == "alarm_raised"]
    assert ONSET < raised["time"] < ONSET + 4.1
    assert windows(done.stdout)[-1]["condition"] == "alarm"
    assert events(done.stdout)[0] == "started"
    assert events(done.stdout)[-1] == "stopped"
    assert done.stderr.count("--state") == 1


def test_the_description_that_inspect_wrote_serves_a_file_and_a_pipe(machine, tmp_path):
    text = "press 4, hall 2\nserial: 7\n" + machine.stream.read_text()
    (tmp_path / "run.csv").write_text(text)
    run("inspect", "run.csv", "--write", "rig.yaml", cwd=tmp_path, check=0)
    assert "skip: 2" in (tmp_path / "rig.yaml").read_text()
    expected = windows(run("monitor", machine.detector, machine.stream, "--no-follow", check=0).stdout)
    for source, given in (("run.csv", None), ("-", text)):
        options = ("--no-follow", "--config", "rig.yaml")
        done = run("monitor", machine.detector, source, *options, cwd=tmp_path, input=given, check=0)
        assert windows(done.stdout) == expected
        assert "malformed" not in events(done.stdout)


def test_a_growing_file_gives_the_windows_of_the_whole_one_and_ends_on_sigterm(machine, tmp_path):
    growing, lines = tmp_path / "growing.csv", machine.lines
    with open(tmp_path / "out", "w+") as out, start(machine.detector, growing, stdout=out) as process:
        for first, last in ((0, 3000), (3000, 3001), (3001, len(lines))):
            with open(growing, "a") as file:
                file.writelines(lines[first:last])
            n_whole = (last - 1) // 1000
            wait_until(lambda n=n_whole: out_text(out).count('"window"') == n, process)
        process.terminate()
        assert process.wait(PATIENCE) == 0
        text = out_text(out)
    whole = run("monitor", machine.detector, machine.stream, "--no-follow", check=0)
    assert windows(text) == windows(whole.stdout)
    assert events(text)[-1] == "stopped"


def out_text(file):
    file.seek(0)
    return file.read()


def test_state_and_log_are_regular_files_of_their_own_and_a_link_to_a_state_stays(machine, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    command = ("monitor", machine.detector, machine.stream, "--no-follow")
    for options in (("--state", "pipe"), ("--log", "pipe"), ("--state", "s", "--log", "./s")):
        run(*command, *options, cwd=tmp_path, check=2)
    assert (tmp_path / "pipe").is_fifo()
    (tmp_path / "s").symlink_to(tmp_path / "kept")
    run(*command, "--state", "s", cwd=tmp_path, check=0)
    assert (tmp_path / "s").is_symlink()
    assert (tmp_path / "kept").stat().st_size


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full, which Linux has")
def test_a_full_disk_behind_standard_output_is_no_bug(machine):
    with open("/dev/full", "w") as full, start(machine.detector, machine.stream, stdout=full) as done:
        errors = done.communicate(timeout=PATIENCE)[1]
    assert done.returncode == 2
    assert "Traceback" not in errors


def test_sigterm_before_the_detector_is_read_is_exit_code_0(machine):
    before_reading = """
import os, signal, sys
from hydrofdi.api.detector import Detector
read = Detector.load
Detector.load = lambda file: (os.kill(os.getpid(), signal.SIGTERM), read(file))[1]
from hydrofdi.cli.app import main
main()
"""
    command = [sys.executable, "-c", before_reading, "monitor", str(machine.detector), "-"]
    done = subprocess.run(command, capture_output=True, text=True, input="", timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert events(done.stdout) == ["started", "stopped"]


def test_a_stream_without_a_judged_window_is_exit_code_1_with_a_reason(machine, tmp_path):
    for text in ("", "time [s],P1 [bar]\n", "".join(machine.lines[:90])):
        (tmp_path / "run.csv").write_text(text)
        done = run("monitor", machine.detector, "run.csv", "--no-follow", cwd=tmp_path, check=1)
        assert events(done.stdout)[-1] == "stopped"
        assert done.stderr.splitlines()[1:] == [f"run.csv: {Ending.UNJUDGED}"]


def test_a_last_line_without_line_end_is_doubtful_everywhere(machine, tmp_path):
    (tmp_path / "cut.csv").write_text("".join(machine.lines[:3001])[:-5])
    rows = run_json("detect", machine.detector, tmp_path / "cut.csv", tmp_path / "cut.csv")["windows"]
    assert [bool(row["doubt"]) for row in rows] == [False, False, True]
    assert run_json("measure", tmp_path / "cut.csv")["records"][0]["status"] == "unended"
    for source, text in ((tmp_path / "cut.csv", ""), ("-", (tmp_path / "cut.csv").read_text())):
        done = run("monitor", machine.detector, source, "--no-follow", input=text, check=0)
        assert [each for each in events(done.stdout) if each == "notice"] == ["notice"]


@pytest.mark.parametrize(
    ("source", "options", "named"),
    [
        ("mqqt://host/x", (), ["mqqt"]),
        ("results.h5", (), ["results.h5"]),
        ("nothing.csv", ("--no-follow",), ["nothing.csv"]),
        ("mqtt://host/x", ("--sampling-frequency", "1 kHz"), ["sampling"]),
        ("-", ("--config", "absent.yaml"), ["absent.yaml"]),
        ("-", ("--events", "ftp://host/x"), ["events"]),
        ("-", ("--metrics", "here"), ["metrics"]),
        ("-", ("--config", "monitor.yaml"), ["monitor.yaml:1: channels", "monitor.yaml:3: mqtt.keepalive"]),
    ],
)
def test_what_cannot_be_done_is_refused(machine, source, options, named, tmp_path):
    (tmp_path / "monitor.yaml").write_text("channels: {P9: x}\nmqtt:\n  keepalive: 3 m\n")
    done = run("monitor", machine.detector, source, *options, cwd=tmp_path, check=2)
    assert [name for name in named if name not in done.stderr] == []
    assert windows(done.stdout) == []
    for name in ("absent.json", "monitor.yaml", machine.stream):  # no detectors
        assert str(name) in run("monitor", name, source, cwd=tmp_path, check=2).stderr


@pytest.mark.parametrize(
    ("library", "arguments"),
    [
        ("paho", ("mqtt://127.0.0.1/x",)),
        ("prometheus_client", ("-", "--metrics", "127.0.0.1:0")),
        ("asyncua", ("opc.tcp://127.0.0.1", "--config", "monitor.yaml")),
    ],
)
def test_an_extra_that_is_not_installed_is_named(machine, library, arguments, tmp_path):
    (tmp_path / "monitor.yaml").write_text("channels: {chamber_1_pressure: {column: 'ns=2;s=P1', unit: bar}}")
    command = [sys.executable, "-c", WITHOUT, library, "monitor", str(machine.detector), *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 2, done.stderr
    assert "pip install 'hydrofdi[monitor]'" in done.stderr
    assert "Traceback" not in done.stderr


class Terminal:
    """A terminal of 80 columns and 24 lines, and what was written to it."""

    def __init__(self):
        self._own, self.descriptor = pty.openpty()
        ioctl(self.descriptor, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        self.text = ""
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self):
        while True:
            try:
                data = os.read(self._own, 65_536)
            except OSError:
                return
            self.text += re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", data.decode(errors="replace"))


def test_on_a_terminal_a_leak_is_seen_when_it_sets_in(machine):
    terminal = Terminal()
    environment = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "COLUMNS")}
    lines, summary = machine.lines, f"{machine.n_window} windows judged"
    with start(
        machine.detector, "-", stdout=terminal.descriptor, stderr=terminal.descriptor,
        env=environment | {"TERM": "xterm-256color", "LC_ALL": "C.UTF-8"},
    ) as process:  # fmt: skip
        wait_until(lambda: "waiting for samples" in terminal.text, process)
        process.stdin.writelines(lines[:9000])
        process.stdin.flush()
        wait_until(lambda: " HEALTHY " in terminal.text, process)
        assert " ALARM " not in terminal.text
        process.stdin.writelines(lines[9000:])
        process.stdin.flush()
        wait_until(lambda: " ALARM " in terminal.text and summary in terminal.text, process)
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
    assert '"line"' not in terminal.text
    assert "MPa" in terminal.text
    wait_until(lambda: summary in terminal.text.rpartition("standard input, watched for")[2])


SECRET = "hunter2"


ADDRESSES = (
    f"mqt://press:{SECRET}@broker/samples", f"mqtts://press:1/{SECRET}@broker/samples",
    f"mqtt:/press:{SECRET}@broker/samples", f"http//press:{SECRET}@broker/samples",
    f"tcp://press:a {SECRET}@broker/samples", f"press:{SECRET}@broker", f"opc.tcp://press:1/{SECRET}@plc",
)  # fmt: skip


@pytest.mark.parametrize("address", ADDRESSES)
def test_no_message_repeats_credentials_and_no_address_is_waited_for_as_a_file(machine, address):
    with pytest.raises(ConfigError):
        open_stream(address, MachineKind(load_detector(machine.detector), MonitorConfig()))
    stream = ("monitor", machine.detector, machine.stream)
    for arguments in (
        ("monitor", machine.detector, address, "--no-follow"), ("monitor", address, machine.stream),
        (*stream, "--no-follow", "--events", address), (*stream, "--no-follow", "--metrics", address),
        ("replay", machine.stream, "--to", address), ("replay", address), (*stream, address),
    ):  # fmt: skip
        done = run(*arguments, check=2)
        assert len(done.stderr.splitlines()) == 1
        assert SECRET not in done.stdout + done.stderr


def test_files_that_look_like_addresses_are_read_and_no_detector_keeps_credentials(
    machine, tmp_path, monkeypatch
):
    for name in ("runs@night.csv", "a/b@c.csv", "day.csv:3: x@y is no number", "x: y@z"):
        assert without_credentials(name) == name
    monkeypatch.chdir(tmp_path)
    file, folder = Path("press:1@night.csv"), Path("http:") / f"me:{SECRET}@host"
    file.write_bytes(machine.stream.read_bytes())
    assert run("monitor", machine.detector, file, "--no-follow", check=0).stdout
    folder.mkdir(parents=True)
    (folder / "healthy.csv").write_bytes(machine.stream.with_name("healthy.csv").read_bytes())
    arguments = ("--output", "d2", "--direction", "both", "--false-alarm-rate", "20 %", "--window", "2 s")
    run("train", f"http://me:{SECRET}@host/healthy.csv", *arguments, "--out", "detector.json", check=0)
    assert SECRET not in json.loads(Path("detector.json").read_text())["made"]["command"]
