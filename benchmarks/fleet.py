"""Processor time, memory and latency of a fleet of machines that send over mosquitto.

    PYTHONPATH=. python benchmarks/fleet.py [--machines 200] [--block 100] [--seconds 30] [--together]

Each machine sends four channels at 1 kHz as JSON, `block` samples a message at quality of service 1, evenly
spread over time, with Unix time. Windows last 10 s; those of the machines end at different times, unless all
begin together. The latency is the time from the sending of the last sample of a window to its line on
standard output, and in the log. `hydrofdi monitor`, the broker and the senders run on one machine; of the
first two, processor time by duration of the samples is stated. `--monitor` is another command than ``python
-m hydrofdi``.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, Any

import numpy as np

from benchmarks.monitor import FREQUENCY, N_SAMPLE, WINDOW, Healthy, signals
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text
from hydrofdi.monitor.configuration import load_fleet_config
from hydrofdi.records import Array, Channel

N_SENDER = 2
BROKER = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin") or "mosquitto"
TICK = os.sysconf("SC_CLK_TCK")

Lines = list[tuple[float, dict[str, Any]]]
"""When each line came [s], and the line."""


@dataclass(frozen=True)
class Load:
    """So many machines, which send these blocks again and again for a time [s], the last one later [s]."""

    n_machine: int
    blocks: Sequence[str]
    seconds: float
    later: float

    @property
    def period(self) -> float:
        """Duration of a block [s]."""
        return WINDOW / len(self.blocks)

    def begin(self, machine: int, count: int) -> float:
        """Instant of the first sample of a block of a machine [s]."""
        return count * self.period + self.later * machine / self.n_machine


def blocks(channels: Sequence[Channel], n_block: int) -> list[str]:
    """The channels of each block of a window as JSON, without their time: six digits, in SI."""
    rows, texts = {channel: signals(N_SAMPLE, 1)[channel] for channel in channels}, []
    for first in range(0, N_SAMPLE, n_block):
        parts = (
            f'"{channel}": [{", ".join(f"{sample:.6g}" for sample in row[first : first + n_block])}]'
            for channel, row in rows.items()
        )
        texts.append(", ".join(parts))
    return texts


def packet(topic: str, number: int, payload: bytes) -> bytes:
    """A message of MQTT 5 at quality of service 1."""
    name = topic.encode()
    body = len(name).to_bytes(2, "big") + name + (1 + number % 65_535).to_bytes(2, "big") + b"\0" + payload
    head, length = bytearray([0x32]), len(body)
    while length > 127:
        head.append(128 | length % 128)
        length //= 128
    return bytes([*head, length]) + body


def send(port: int, load: Load, sender: int, start: float, lags: Connection) -> None:
    """Send the blocks of some of the machines, each when its last sample is due; the largest delay [s]."""
    machines, counts = range(sender, load.n_machine, N_SENDER), range(round(load.seconds / load.period))
    due = sorted((load.begin(machine, count), machine, count) for machine in machines for count in counts)
    lag = 0.0
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(bytes([0x10, 15]) + b"\0\4MQTT\5\2\0\0\0\0\2s%d" % sender)
        for number, (begin, machine, count) in enumerate(due):
            text = load.blocks[count % len(load.blocks)]
            content = f'{{"time": {start + begin:.6f}, "sampling_frequency": {FREQUENCY}, {text}}}'
            message = packet(f"plant/m{machine}/samples", number, content.encode())
            if (early := start + begin + load.period - time.time()) > 0.0:
                time.sleep(early)
            connection.sendall(message)
            lag = max(lag, -early)
            if number % 10 == 0:
                with suppress(BlockingIOError):
                    connection.recv(1 << 16, socket.MSG_DONTWAIT)  # acknowledgements
        time.sleep(1.0)
    lags.send(lag)


def usage(process: int) -> tuple[float, float]:
    """Processor time [s] and resident memory [MB] of a process."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2].split()
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return (int(fields[11]) + int(fields[12])) / TICK, pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def written(process: int) -> float:
    """What a process wrote to the disk [MB]."""
    fields = dict(line.split(": ") for line in Path(f"/proc/{process}/io").read_text().splitlines())
    return int(fields["write_bytes"]) / 1e6


def note(lines: IO[str] | Iterator[str], found: Lines) -> None:
    """Note when each line comes."""
    for line in lines:
        found.append((time.time(), json.loads(line)))


def followed(path: Path, ended: threading.Event) -> Iterator[str]:
    """Lines of a file that grows."""
    with path.open() as file:
        rest = ""
        while not ended.is_set():
            rest += file.read()
            *whole, rest = rest.split("\n")
            yield from whole
            time.sleep(0.005)


def run(folder: Path, load: Load, command: Sequence[str], interval: float, partition: str) -> dict[str, Any]:
    """Shares of a core, memory [MB], and latencies [s] of a fleet."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    rules = f"listener {port} 127.0.0.1\nallow_anonymous true\nmax_queued_messages 0\n"
    (folder / "broker.conf").write_text(rules)
    (folder / "fleet.yaml").write_text(
        f"machines: mqtt://127.0.0.1:{port}/plant/+/samples\ndetectors: detector.json\n"
        f"interval: {interval} s\nstate: fleet.db\nlog: fleet.jsonl\nmetrics: 127.0.0.1:0\n"
    )
    (folder / "fleet.db").unlink(missing_ok=True)
    (folder / "fleet.jsonl").write_text("")
    broker = subprocess.Popen([BROKER, "-c", folder / "broker.conf"], stderr=subprocess.DEVNULL)
    time.sleep(0.5)
    fleet = subprocess.Popen(
        [*command, "monitor", str(folder / "fleet.yaml"), "--partition", partition],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert fleet.stdout is not None
    printed, logged, ended = Lines(), Lines(), threading.Event()
    for lines, found in ((fleet.stdout, printed), (followed(folder / "fleet.jsonl", ended), logged)):
        threading.Thread(target=note, args=(lines, found), daemon=True).start()
    while not any(line.get("event") == "connected" for _, line in printed):
        time.sleep(0.05)
    start = time.time() + 1.0
    lags, lag = multiprocessing.Pipe(duplex=False)
    senders = [
        multiprocessing.Process(target=send, args=(port, load, each, start, lag)) for each in range(N_SENDER)
    ]
    for sender in senders:
        sender.start()
    busy, broker_busy, wrote = usage(fleet.pid)[0], usage(broker.pid)[0], written(fleet.pid)
    for sender in senders:
        sender.join()
    owns = load_fleet_config(folder / "fleet.yaml", partition=partition).owns
    n_expected = sum(owns(f"m{each}") for each in range(load.n_machine)) * int(load.seconds / WINDOW)
    while sum(line["line"] == "window" for _, line in [*logged]) < n_expected:
        time.sleep(0.1)
    (busy_then, memory), broker_then = usage(fleet.pid), usage(broker.pid)[0]
    n_megabyte = written(fleet.pid) - wrote
    for process in (fleet, broker):
        process.terminate()
        process.wait()
    ended.set()
    delays = [latencies(found) for found in (printed, logged)]
    assert [each.size for each in delays] == [n_expected] * 2, ([each.size for each in delays], n_expected)
    return {
        "monitor": (busy_then - busy) / load.seconds,
        "broker": (broker_then - broker_busy) / load.seconds,
        "memory": memory,
        "written": n_megabyte / load.seconds,
        "lag": max(lags.recv() for _ in senders),
        "latency": dict(zip(("line", "log"), delays, strict=True)),
    }


def latencies(found: Lines) -> Array:
    """Time from the sending of the last sample of each window to its line [s]."""
    windows = [(when, line) for when, line in found if line["line"] == "window"]
    assert all(line["alarm"] is not None for _, line in windows), windows[0]
    return np.array([when - line["end"] - 1.0 / FREQUENCY for when, line in windows])


def main() -> None:
    """Print the figures."""
    options = argparse.ArgumentParser()
    options.add_argument("--machines", type=int, default=200)
    options.add_argument("--block", type=int, default=100)
    options.add_argument("--seconds", type=float, default=30.0)
    options.add_argument("--interval", type=float, default=0.25)
    options.add_argument("--together", action="store_true")
    options.add_argument("--indicator", default="weak_rls")
    options.add_argument("--partition", default="1/1")
    options.add_argument("--monitor", default=f"{sys.executable} -m hydrofdi")
    given = options.parse_args()
    stated = {"indicator": given.indicator, "direction": "both", "false_alarm_rate": "2 %", "accept": True}
    config = DetectorConfig.model_validate({**stated, "chart": None})
    file = Detector.fit(Healthy(), config).file
    later = given.block / FREQUENCY if given.together else WINDOW
    load = Load(given.machines, blocks(file.channels, given.block), given.seconds, later)
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as name:
        folder, command = Path(name), given.monitor.split()
        (folder / "detector.json").write_text(detector_text(file))
        few = run(folder, replace(load, n_machine=10, seconds=WINDOW + 1.0), command, given.interval, "1/1")
        found = run(folder, load, command, given.interval, given.partition)
    each = (found["memory"] - few["memory"]) / max(1, given.machines - 10)
    print(f"{given.machines} machines, {given.block} samples a message, {given.indicator}, {given.partition}")
    print(f"processor: monitor {found['monitor']:.2f} of a core, broker {found['broker']:.2f}")
    print(f"disk: {found['written']:.1f} MB/s; a message has {len(load.blocks[0]) / 1e3:.1f} kB")
    print(f"largest delay of a sender: {found['lag']:.2f} s")
    print(f"memory: {found['memory']:.0f} MB; {each:.2f} MB for each machine beyond ten")
    for what, delays in found["latency"].items():
        shown = (f"{np.quantile(delays, share):.2f} ({100 * share:g} %)" for share in (0.5, 0.99, 1.0))
        print(f"latency to the {what} [s]: {', '.join(shown)}")


if __name__ == "__main__":
    main()
