"""Fleets for tests: machines of one detector, what is expected of them, and lives that end at once."""

import json
import random
import threading
import urllib.request
from itertools import zip_longest

from prometheus_client.parser import text_string_to_metric_families

from hydrofdi.api.streams import monitor_fleet
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text
from hydrofdi.detectors.lines import is_said, line_record
from hydrofdi.records.streams import Chunk
from tests.monitor import streams
from tests.monitor.streams import P1, Killed, lines_of, made_detector, part, payload_of, stream
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
    return {
        name: [
            line_record(line, FILE.unit)
            for line in lines_of(Detector(FILE), [chunk], is_over=is_over)
            if is_said(line)
        ]
        for name, chunk in machines.items()
    }


def logged(path, **options):
    """Name → lines of a machine in a log, which do not tell of one life alone."""
    found = {}
    for record in streams.logged(path, **options):
        record.pop("digest", None)
        if (name := record.pop("machine")) is not None:
            found.setdefault(name, []).append(record)
    return found


def n_window(found):
    return sum(each["line"] == "window" for lines in found.values() for each in lines)


def served(lines):
    """Name of a metric → its samples, of the server that lines name."""
    (url,) = (line["text"].split()[-1] for line in lines if "metrics are served" in line.get("text", ""))
    with urllib.request.urlopen(url, timeout=30) as answer:
        families = text_string_to_metric_families(answer.read().decode())
    return {family.name.removeprefix("hydrofdi_"): family.samples for family in families}


class Kills:
    """Ends the process at one of the next lines about windows, or before or after such a call, by chance."""

    def __init__(self, patch, seed, most, *methods):
        self._draw, self._most, self._left = random.Random(seed), most, {}
        for kind, name in methods:
            patch.setattr(kind, name, self._counted(getattr(kind, name)))

    def _counted(self, call):
        self._left[call] = 0

        def counted(*arguments):
            self._left[call] -= 1
            if self._left[call] == 0 and self._draw.random() < 0.5:
                raise Killed
            call(*arguments)
            if self._left[call] == 0:
                raise Killed

        return counted

    def begin(self, path, *, is_last, **options):
        """A life, which ends unless it is the last one."""
        where = None if is_last else self._draw.choice(["lines", *self._left])
        place = self._draw.randint(1, self._most)
        self._left = {call: place * (call is where) for call in self._left}
        return Life(path, n_line=place * (where == "lines"), **options)


def blocks_of(machines):
    """Name and payload of each message. The machines take turns, and their windows end in different ones."""
    turns = []
    for place, (name, chunk) in enumerate(machines.items()):
        parts = (part(chunk, first, first + 100) for first in range(0, chunk.n_time, 100))
        turns.append([None] * (3 * place) + [(name, payload_of(each)) for each in parts])
    return [message for turn in zip_longest(*turns) for message in turn if message is not None]


class Life(threading.Thread):
    """A fleet in a thread of its own; `end` asks it to stop. It is killed at its n-th line about a window."""

    def __init__(self, path, n_line=0, **options):
        super().__init__(daemon=True)
        self.failure, self._is_ending, self._path, self._options = None, False, path, options
        self.lines, self._n_line = [], n_line
        self.start()

    def run(self):
        try:
            monitor_fleet(self._path, stop=lambda: self._is_ending, on_line=self._take, **self._options)
        except BaseException as failure:
            self.failure = failure

    def _take(self, record):
        self.lines.append(record)
        self._n_line -= record["line"] == "window"
        if record["line"] == "window" and self._n_line == 0:
            raise Killed

    def end(self):
        self._is_ending = True
        self.finish()

    def finish(self):
        self.join(60.0)
        assert not self.is_alive()
        if self.failure is not None and not isinstance(self.failure, Killed):
            raise self.failure

    def events(self, machine=None, event=None):
        """Its lines about events: those of a machine, those of this kind."""
        return [
            line for line in self.lines
            if "event" in line and machine in (None, line["machine"]) and event in (None, line["event"])
        ]  # fmt: skip
