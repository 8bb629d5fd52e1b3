"""A machine that begins to leak, as a stream of text, and a detector trained on it while it was healthy."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hydrofdi.api.run import simulate
from hydrofdi.config import load_experiment
from tests.commands import run
from tests.records.measuring import csv_of

START, ONSET, END = 2.0, 22.0, 42.0
"""The start of the motion is left out; a leak sets in at the onset [s]."""
WINDOW = 2.0


@dataclass(frozen=True)
class Machine:
    """Files of a machine that begins to leak at `ONSET`."""

    detector: Path
    stream: Path

    @property
    def lines(self):
        """The stream, line by line, its header first."""
        return self.stream.read_text().splitlines(keepends=True)

    @property
    def n_window(self):
        return round((END - START) / WINDOW)


def make_machine(folder):
    """Simulate it twice, and train a detector on the healthy record."""
    healthy, leaking = folder / "healthy.csv", folder / "leaking.csv"
    time, pressure = _pressure()
    _write(healthy, time, pressure)
    _write(leaking, time, np.where(time < ONSET, pressure, _pressure("leakage.internal_coefficient=5e-9")[1]))
    detector = folder / "detector.json"
    options = ("--output", "d2", "--direction", "falling", "--false-alarm-rate", "10 %")
    run("train", healthy, *options, "--window", f"{WINDOW} s", "--out", detector, check=0)
    file = json.loads(detector.read_text())
    file["limits"]["low"] *= 0.95  # healthy windows stay clear of the limit; those of a leak do not
    detector.write_text(json.dumps(file))
    return Machine(detector, leaking)


def _pressure(*settings):
    common = (f"record.duration={END} s", "pressure_1_sensor.noise=20 kPa")
    columns = simulate(load_experiment(settings=[*common, *settings])).columns
    return np.ravel(columns["time"]), np.ravel(columns["chamber_1_pressure"])


def _write(path, time, pressure):
    kept = time >= START
    path.write_text(csv_of(("time [s]", time[kept]), ("P1 [bar]", pressure[kept] / 1e5)))
