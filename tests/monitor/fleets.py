"""Fleets for tests: machines of one detector, what is expected of them, and lives that end at once."""

import json
import threading
import time
from itertools import zip_longest

from hydrofdi.api.streams import monitor_fleet
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text
from hydrofdi.detectors.lines import is_said, line_record
from hydrofdi.monitor.mqtt import payload_of
from hydrofdi.records.streams import Chunk
from tests.monitor.streams import P1, Killed, made_detector, part, stream
from tests.records.measuring import csv_of

FILE = made_detector()
N_WINDOW = 12


def made(n_machine, n_window=N_WINDOW):
    """Name → samples of a machine; some leak, some are stuck."""
    return {
        f"m{number}": stream(n_window, number + 1, leaking=[4, 5, 9][: number + 1], stuck=[7])
        for number in range(n_machine)
    }


def write_fleet(folder, machines, **keys):
    """A detector and a fleet file that reads these sources; its path."""
    (folder / "detector.json").write_text(detector_text(FILE))
    usual = {"detectors": "detector.json", "state": "fleet.db", "log": "fleet.jsonl", "interval": "10 ms"}
    path = folder / "fleet.yaml"
    path.write_text(json.dumps({"machines": machines, "store_every": "50 ms", **usual, **keys}))
    return path


def later(chunk, seconds):
    return Chunk(chunk.time + seconds, chunk.channels)


def write_csv(path, chunk):
    path.parent.mkdir(exist_ok=True)
    path.write_text(csv_of(("time [s]", chunk.time), ("P1 [Pa]", chunk.channels[P1])))


def expected(machines, *, is_over=True):
    """Name → what the batch says of the samples of a machine; at a stop, episodes go on."""
    found = {}
    for name, chunk in machines.items():
        watch = Detector(FILE)
        state, lines = watch.step(watch.start(), chunk)
        lines += watch.end(state)[1] if is_over else []
        found[name] = [line_record(line, FILE.unit) for line in lines if is_said(line)]
    return found


def logged(path, without=("started", "resumed", "stopped", "connected", "disconnected")):
    """Name → lines of a machine in a log, which do not tell of one life alone."""
    found = {}
    for line in path.read_text().splitlines() if path.exists() else []:
        record = json.loads(line)
        name = record.pop("machine")
        record.pop("digest", None)
        if record.get("event") not in without and name is not None:
            found.setdefault(name, []).append(record)
    return found


def n_window(found):
    return sum(each["line"] == "window" for lines in found.values() for each in lines)


def killed_at(count):
    """A receiver of lines that ends the process at the n-th line about a window."""
    left = [count]

    def take(record):
        left[0] -= record["line"] == "window"
        if left[0] == 0:
            raise Killed

    return take


def once(condition, timeout=60.0):
    """Asks whether a condition holds; not for ever."""
    end = time.monotonic() + timeout

    def ask():
        assert time.monotonic() < end, "nothing happened"
        return condition()

    return ask


def blocks_of(machines, n_sample=100):
    """Name and payload of each message. The machines take turns, and their windows end in different ones."""
    turns = []
    for place, (name, chunk) in enumerate(machines.items()):
        parts = (part(chunk, first, first + n_sample) for first in range(0, chunk.n_time, n_sample))
        turns.append([None] * (3 * place) + [(name, payload_of(each)) for each in parts])
    return [message for turn in zip_longest(*turns) for message in turn if message is not None]


class Life(threading.Thread):
    """A fleet in a thread of its own; `end` asks it to stop."""

    def __init__(self, path, **options):
        super().__init__(daemon=True)
        self.failure, self._is_ending, self._path, self._options = None, False, path, options
        self.lines = []
        self.start()

    def run(self):
        try:
            monitor_fleet(
                self._path, stop=lambda: self._is_ending, **{"on_line": self.lines.append} | self._options
            )
        except BaseException as failure:
            self.failure = failure

    def end(self):
        self._is_ending = True
        self.join(60.0)
        assert not self.is_alive()
        if self.failure is not None and not isinstance(self.failure, Killed):
            raise self.failure

    def has_said(self, event):
        return any(line.get("event") == event for line in self.lines)
