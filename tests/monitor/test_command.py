"""The commands `monitor` and `replay`: processes, signals, a terminal, and what they refuse."""

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
import time
from fcntl import ioctl
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.api.sources import Described, open_records
from hydrofdi.api.streams import replay
from hydrofdi.detectors.file import load_detector
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.loop import Ending
from hydrofdi.monitor.machines import MachineKind
from hydrofdi.monitor.opening import open_stream
from tests.commands import COMMAND, run, run_json, wait_until
from tests.monitor.streams import read_in_pieces, reader

PATIENCE = 120.0
"""Longest time that anything is waited for [s]."""

END = "\nfrom hydrofdi.cli.app import main\nmain()\n"


def records(text, kind):
    return [record for line in text.splitlines() if (record := json.loads(line))["line"] == kind]


def windows(text):
    return records(text, "window")


def events(text):
    return [record["event"] for record in records(text, "event")]


def start(*arguments, command="monitor", **options):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen([*COMMAND, command, *map(str, arguments)], text=True, **pipes | options)


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
"""
    command = [sys.executable, "-c", before_reading + END, "monitor", str(machine.detector), "-"]
    done = subprocess.run(command, capture_output=True, text=True, input="", timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert events(done.stdout) == ["started", "stopped"]


def test_a_stream_without_a_judged_window_is_exit_code_1_with_a_reason(machine, tmp_path):
    for text in ("", "".join(machine.lines[:90])):
        (tmp_path / "run.csv").write_text(text)
        done = run("monitor", machine.detector, "run.csv", "--no-follow", cwd=tmp_path, check=1)
        assert events(done.stdout)[-1] == "stopped"
        assert done.stderr.splitlines()[1:] == [f"run.csv: {Ending.UNJUDGED}"]


def test_a_last_line_without_line_end_is_doubtful_everywhere(machine, tmp_path):
    (cut := tmp_path / "cut.csv").write_text("".join(machine.lines[:3001])[:-5])
    rows = run_json("detect", machine.detector, cut, cut)["windows"]
    assert [bool(row["doubt"]) for row in rows] == [False, False, True]
    assert run_json("measure", cut)["records"][0]["status"] == "unended"
    for source, text in ((cut, ""), ("-", cut.read_text())):
        done = run("monitor", machine.detector, source, "--no-follow", input=text, check=0)
        assert events(done.stdout).count("notice") == 1


@pytest.mark.parametrize(("source", "options", "named"), [
    ("mqqt://host/x", (), ["mqqt"]), ("results.h5", (), ["results.h5"]),
    ("nothing.csv", ("--no-follow",), ["nothing.csv"]),
    ("mqtt://host/x", ("--sampling-frequency", "1 kHz"), ["sampling"]),
    ("-", ("--config", "absent.yaml"), ["absent.yaml"]),
    ("-", ("--metrics", "here"), ["metrics"]),
    ("-", ("--config", "monitor.yaml"), ["monitor.yaml:1: channels", "monitor.yaml:3: mqtt.keepalive"]),
])  # fmt: skip
def test_what_cannot_be_done_is_refused(machine, source, options, named, tmp_path):
    (tmp_path / "monitor.yaml").write_text("channels: {P9: x}\nmqtt:\n  keepalive: 3 m\n")
    done = run("monitor", machine.detector, source, *options, cwd=tmp_path, check=2)
    assert [name for name in named if name not in done.stderr] == []
    assert windows(done.stdout) == []
    for name in ("absent.json", "monitor.yaml", machine.stream):  # no detectors
        assert str(name) in run("monitor", name, source, cwd=tmp_path, check=2).stderr


@pytest.mark.parametrize(("library", "arguments"), [
    ("paho", ("mqtt://127.0.0.1/x",)), ("prometheus_client", ("-", "--metrics", "127.0.0.1:0")),
    ("asyncua", ("opc.tcp://127.0.0.1", "--config", "monitor.yaml")),
])  # fmt: skip
def test_an_extra_that_is_not_installed_is_named(machine, library, arguments, tmp_path):
    (tmp_path / "monitor.yaml").write_text("channels: {chamber_1_pressure: {column: 'ns=2;s=P1', unit: bar}}")
    without = f"import sys\nsys.modules[{library!r}] = None{END}"
    command = [sys.executable, "-c", without, "monitor", str(machine.detector), *arguments]
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
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        while data := os.read(self._own, 65_536):
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


@pytest.mark.parametrize("address", [
    f"mqt://press:{SECRET}@broker/samples", f"mqtts://press:1/{SECRET}@broker/samples",
    f"mqtt:/press:{SECRET}@broker/samples", f"http//press:{SECRET}@broker/samples",
    f"tcp://press:a {SECRET}@broker/samples", f"press:{SECRET}@broker", f"opc.tcp://press:1/{SECRET}@plc",
])  # fmt: skip
def test_no_message_repeats_credentials_and_no_address_is_waited_for_as_a_file(machine, address):
    with pytest.raises(ConfigError):
        open_stream(address, MachineKind(load_detector(machine.detector), MonitorConfig()))
    stream = ("monitor", machine.detector, machine.stream)
    for arguments in (
        ("monitor", machine.detector, address, "--no-follow"), ("monitor", address, machine.stream),
        (*stream, "--no-follow", "--metrics", address),
        ("replay", address), (*stream, address),
    ):  # fmt: skip
        done = run(*arguments, check=2)
        assert len(done.stderr.splitlines()) == 1
        assert SECRET not in done.stdout + done.stderr


def test_files_that_look_like_addresses_are_read_and_no_detector_keeps_credentials(
    machine, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    file, folder = Path("press:1@night.csv"), Path("http:") / f"me:{SECRET}@host"
    file.write_bytes(machine.stream.read_bytes())
    assert run("monitor", machine.detector, file, "--no-follow", check=0).stdout
    folder.mkdir(parents=True)
    (folder / "healthy.csv").write_bytes(machine.healthy.read_bytes())
    arguments = ("--output", "d2", "--direction", "both", "--false-alarm-rate", "20 %", "--window", "2 s")
    run("train", f"http://me:{SECRET}@host/healthy.csv", *arguments, "--out", "detector.json", check=0)
    assert SECRET not in json.loads(Path("detector.json").read_text())["made"]["command"]


@pytest.fixture
def experiment(tmp_path):
    file = tmp_path / "press.yaml"
    file.write_text("record: {duration: 4 s}\nsweep: {grid: {leakage.internal_flow: [0 L/min, 0.5 L/min]}}\n")
    return file


@pytest.mark.parametrize(("form", "first"), [("csv", 0), ("json", 1)])
def test_samples_are_read_again_to_the_bit_and_records_follow_with_a_gap(experiment, form, first):
    options = ["--record", "2"] if first else []
    done = run("replay", experiment, "--format", form, *options, "--rate", "max", check=0)
    chunk, unread = read_in_pieces(reader(), done.stdout.encode(), range(10_000, len(done.stdout), 9_999))
    assert unread == []
    (source,) = open_records(experiment, said=Described())
    (batch,) = source.batches()
    assert set(chunk.channels) == set(batch.channels)
    for channel, samples in batch.channels.items():
        assert np.array_equal(chunk.channels[channel], samples[first:].ravel(), equal_nan=True), channel
    n_time = batch.time.size
    assert np.array_equal(chunk.time[:n_time], batch.time)
    assert done.stderr.splitlines()[1:] == [f"played {chunk.n_time:,} samples"]
    if not first:
        steps = np.diff(chunk.time)
        assert steps.argmax() == n_time - 1
        assert steps.max() == pytest.approx(10 * steps.min())


def test_nothing_comes_before_it_is_due_and_stamps_of_now_are_even_to_the_bit(experiment, monkeypatch):
    begin = time.monotonic()
    for chunk in replay(np.zeros(60), rate=1000.0, sampling_frequency=10.0):
        assert time.monotonic() - begin >= 0.1 * chunk.time[-1] / 10.0 - 1e-3
    start = 1_700_000_000.3
    monkeypatch.setattr(time, "time", lambda: start)
    blocks = [*replay(experiment, record="1", now=True, settings=["record.duration=1 s"])]
    stamps = np.concatenate([block.time for block in blocks])
    assert np.array_equal(stamps, start + np.arange(stamps.size) / 500.0)


@pytest.mark.parametrize(("arguments", "said"), [
    (["--rate", "0Hz"], "rate"), (["--record", "7"], "'7'"), (["--set", "fluid.nothing=1"], "fluid.nothing"),
])  # fmt: skip
def test_what_a_replay_cannot_do_is_said_in_a_line(experiment, arguments, said):
    done = run("replay", experiment, *arguments, check=2)
    assert said in done.stderr
    assert len([line for line in done.stderr.splitlines() if "simulating" not in line]) == 1
    assert done.stdout == ""


def test_an_interrupt_and_a_reader_that_leaves_end_a_replay(experiment):
    with start(experiment, "--rate", "max", command="replay") as process:
        assert process.stdout.readline().startswith("time [s],P1 [Pa]")
        process.stdout.close()
        assert process.wait(PATIENCE) == 0
    with start(experiment, "--rate", "1Hz", command="replay") as process:
        assert process.stdout.readline().startswith("time [s],P1 [Pa]")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert errors.splitlines()[-1].startswith("stopped after ")
