"""A machine, a broker, and things that are closed behind a test."""

import json
import subprocess
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.api.run import simulate
from hydrofdi.config import load_experiment
from hydrofdi.monitor import sources
from tests.commands import run
from tests.monitor.brokers import SECRET, Broker
from tests.records.measuring import csv_of


@dataclass(frozen=True)
class Machine:
    """A machine that begins to leak, as a stream of text, and a detector trained on it while it was healthy.

    The start of the motion is left out; the leak sets in at the onset [s].
    """

    detector: Path
    healthy: Path
    stream: Path
    start, onset, end, window = 2.0, 22.0, 42.0, 2.0

    @property
    def lines(self):
        """The stream, line by line, its header first."""
        return self.stream.read_text().splitlines(keepends=True)

    @property
    def n_window(self):
        return round((self.end - self.start) / self.window)


def simulated(*settings):
    common = (f"record.duration={Machine.end} s", "pressure_1_sensor.noise=20 kPa")
    columns = simulate(load_experiment(settings=[*common, *settings])).columns
    return np.ravel(columns["time"]), np.ravel(columns["chamber_1_pressure"])


@pytest.fixture(scope="session")
def machine(tmp_path_factory):
    folder = tmp_path_factory.mktemp("machine")
    made = Machine(*(folder / name for name in ("detector.json", "healthy.csv", "leaking.csv")))
    time, pressure = simulated()
    leaking = np.where(time < made.onset, pressure, simulated("leakage.internal_coefficient=5e-9")[1])
    kept = time >= made.start
    for file, samples in ((made.healthy, pressure), (made.stream, leaking)):
        file.write_text(csv_of(("time [s]", time[kept]), ("P1 [bar]", samples[kept] / 1e5)))
    options = ("--output", "d2", "--direction", "falling", "--false-alarm-rate", "10 %", "--window", "2 s")
    run("train", made.healthy, *options, "--out", made.detector, check=0)
    file = json.loads(made.detector.read_text())
    file["limits"]["low"] *= 0.95  # healthy windows stay clear of the limit; those of a leak do not
    made.detector.write_text(json.dumps(file))
    return made


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """The second attempt to connect comes soon."""
    monkeypatch.setattr(sources, "FIRST_WAIT", 0.05)


@pytest.fixture
def broker(tmp_path):
    with Broker(tmp_path) as running:
        yield running


@pytest.fixture
def guarded(tmp_path):
    """A broker that asks for a password: user ``press`` may read nothing but ``press/#``."""
    file, rules = tmp_path / "passwords", tmp_path / "rules"
    broker = Broker(tmp_path, f"password_file {file}", f"acl_file {rules}", anonymous=False)
    file.write_text(f"press:{SECRET}\n")
    subprocess.run(["mosquitto_passwd", "-U", file], check=True, capture_output=True)
    rules.write_text("user press\ntopic readwrite press/#\n")
    for each in (file, rules):
        each.chmod(0o644)
    with broker:
        yield broker


@pytest.fixture
def closing():
    """Calls ``close`` of what a test opened: ``source = closing(source_at(…))``."""
    with ExitStack() as stack:

        def keep(thing):
            stack.callback(thing.close)
            return thing

        yield keep
