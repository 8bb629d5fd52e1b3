"""Speed, latency and memory of a monitor, compared with `measure` alone.

    python benchmarks/monitor.py [INDICATOR ...]

Five channels at 1 kHz, adjacent windows of 10 s, one core. The monitor writes JSON
lines, log and state.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import Line, WindowLine
from hydrofdi.detectors.training import windows_along
from hydrofdi.detectors.verdicts import records_of
from hydrofdi.errors import HydrofdiError
from hydrofdi.indicators import indicator_names, measure
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.growing_file import GrowingFile, StandardInput
from hydrofdi.monitor.loop import single_monitor
from hydrofdi.monitor.machines import MachineKind, Receiver
from hydrofdi.monitor.sources import Position, StreamSource
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk

FREQUENCY, WINDOW = 1000.0, 10.0
N_SAMPLE = round(WINDOW * FREQUENCY)
CHANNELS = (
    Channel.CHAMBER_1_PRESSURE,
    Channel.CHAMBER_2_PRESSURE,
    Channel.PISTON_POSITION,
    Channel.SPOOL_POSITION,
    Channel.INPUT_VOLTAGE,
)
N_AT_ONCE = 65_536
"""Samples per chunk, as from files."""
LIVE = 20
"""Samples per chunk, as from live sources."""
ROUNDS = 5
N_LIVE = 100_000
"""Number of samples in small chunks."""
N_TEXT, PIPED = 200_000, 15.0
"""Number of samples of a recorded file, and duration of a stream through a pipe, in real time [s]."""
LONG = 10_000_000
"""Number of samples over which memory is measured."""


def signals(n_sample: int, seed: int) -> dict[Channel, Array]:
    """Synthetic signals of a moving actuator."""
    draw = np.random.default_rng(seed)
    drive = np.sign(np.sin(2.0 * np.pi * 0.5 * np.arange(n_sample) / FREQUENCY + 0.1))
    swing = np.convolve(drive, np.exp(-np.arange(200) / 40.0) / 40.0)[:n_sample]
    noise = draw.standard_normal((3, n_sample))
    position = 0.3 + 0.05 * np.cumsum(swing) / FREQUENCY + 1e-5 * noise[2]
    pressures = 9e6 + 2e6 * swing + 2e4 * noise[0], 8e6 - 2e6 * swing + 2e4 * noise[1]
    rows = (*pressures, position, 1e-4 * drive, 5.0 * drive)
    return dict(zip(CHANNELS, rows, strict=True))


class Healthy:
    """Windows as independent records."""

    name = "benchmark"
    data_sheet: ClassVar[dict[str, float]] = {}

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """A single batch."""
        each = [signals(N_SAMPLE, 1000 + seed) for seed in range(120)]
        rows = {channel: np.stack([record[channel] for record in each]) for channel in CHANNELS}
        yield RecordBatch(rows, FREQUENCY, tuple(map(str, range(120))))


class InMemory(StreamSource):
    """A stream from memory: repeats the same samples with increasing time."""

    def __init__(self, samples: dict[Channel, Array], n_total: int, n_at_once: int) -> None:
        super().__init__("benchmark")
        self._samples, self._n_total, self._n_at_once = samples, n_total, n_at_once
        self._n_own, self._place = samples[CHANNELS[0]].size, 0
        self.handed_over = 0.0

    def read(self, timeout: float) -> Chunk:
        """Return the next chunk."""
        first = self._place
        here = first % self._n_own
        stop = min(here + self._n_at_once, self._n_own, here + self._n_total - first)
        self._place += stop - here
        chunk = Chunk(
            np.arange(first, self._place) / FREQUENCY,
            {channel: row[here:stop] for channel, row in self._samples.items()},
        )
        self.handed_over = time.perf_counter()
        self.is_over = self._place >= self._n_total
        return chunk

    @property
    def position(self) -> Position:
        """Number of samples so far."""
        return {"place": self._place}


@dataclass
class Clock:
    """View of the lines: records the delay from the last sample of a window to its line."""

    source: InMemory
    delays: list[float]

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Record the time."""
        if any(isinstance(line, WindowLine) for line in lines):
            self.delays.append(time.perf_counter() - self.source.handed_over)

    def close(self) -> None:
        """Nothing to close."""


def clocks() -> Array:
    """Wall time and processor time [s]."""
    return np.array([time.perf_counter(), time.process_time()])


def rows(samples: dict[Channel, Array], n_sample: int) -> list[str]:
    """Lines of CSV with a header: time, the channels and two more, with all digits."""
    more = np.random.default_rng(2).standard_normal((2, n_sample))
    columns = (np.arange(n_sample) / FREQUENCY, *(row[:n_sample] for row in samples.values()), *more)
    titles = ("time [s]", *(f"{channel.symbol} [{channel.unit}]" for channel in samples), "y", "z")
    return [",".join(titles), *(",".join(map(repr, row)) for row in np.column_stack(columns).tolist())]


def recorded(file: DetectorFile, lines: Sequence[str]) -> Array:
    """Wall and processor time for a recorded file [s]."""
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        path = Path(folder) / "run.csv"
        path.write_text("\n".join([*lines, ""]))
        return run(file, GrowingFile(path, follow=False, needed=file.channels))


def piped(file: DetectorFile, lines: Sequence[str]) -> float:
    """Share of a core for a pipe into which another process writes small pieces in real time."""
    reader, writer = os.pipe()
    if not os.fork():
        began = time.monotonic()
        for first in range(0, len(lines), LIVE):
            time.sleep(max(0.0, began + first / FREQUENCY - time.monotonic()))
            os.write(writer, "\n".join([*lines[first : first + LIVE], ""]).encode())
        os._exit(0)
    os.close(writer)
    wall, busy = run(file, StandardInput(descriptor=reader, needed=file.channels))
    os.close(reader)
    os.wait()
    return float(busy / wall)


def run(file: DetectorFile, source: StreamSource, view: Receiver = None) -> Array:
    """Run a complete monitor with log, state and JSON lines; return wall and processor time [s]."""
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder, open(os.devnull, "w") as nowhere:
        files = {"state": Path(folder) / "state", "log": Path(folder) / "log.jsonl"}
        began = clocks()
        kind = MachineKind(file, MonitorConfig())
        single_monitor(kind, source, view or nowhere, **files).run(lambda: False)
        return clocks() - began


def measured(file: DetectorFile, samples: dict[Channel, Array]) -> Array:
    """Wall and processor time of `measure` alone, for the same windows in one batch [s]."""
    stream = RecordBatch({channel: row[None] for channel, row in samples.items()}, FREQUENCY, ("stream",))
    windower = file.config.window.windower(file.n_sample, file.channels, FREQUENCY, file.drive)
    windows = [*windows_along(stream, 0, windower)]
    records = records_of(windows, file.channels, FREQUENCY)
    began = clocks()
    measure(records, {"it": file.feature.indicator})
    return clocks() - began


def compare(name: str, samples: dict[Channel, Array]) -> DetectorFile | None:
    """Compare one indicator and print a line."""
    settings = {"direction": "both", "false_alarm_rate": "2 %", "chart": None, "accept": True}
    config = DetectorConfig.model_validate({"indicator": name, **settings})
    try:
        file = Detector.fit(Healthy(), config).file
    except HydrofdiError as refusal:
        print(f"{name:22} {refusal}")
        return None
    n_sample = samples[CHANNELS[0]].size
    wholes, alones = [], []
    for _ in range(ROUNDS):
        wholes.append(run(file, InMemory(samples, n_sample, N_AT_ONCE)))
        alones.append(measured(file, samples))
    (wall, busy), (_, alone) = np.median(wholes, axis=0), np.median(alones, axis=0)
    lines = rows(samples, N_TEXT)
    from_file = N_TEXT / FREQUENCY / np.median([recorded(file, lines) for _ in range(ROUNDS)], axis=0)
    source = InMemory(samples, N_LIVE, LIVE)
    clock = Clock(source, [])
    live = run(file, source, clock)[1]
    delays = 1e3 * np.array(clock.delays[1:])
    speeds = [n_sample / FREQUENCY / duration for duration in (wall, busy, alone)]
    shares = 100.0 * live / (N_LIVE / FREQUENCY), 100.0 * piped(file, lines[: round(PIPED * FREQUENCY)])
    numbers = [*(f"{x:9,.0f}" for x in (*speeds, *from_file)), *(f"{x:8.2f}" for x in shares)]
    late = [np.median(delays), np.quantile(delays, 0.99)]
    print(f"{name:20}", *numbers, *(f"{x:8.1f}" for x in late), flush=True)
    return file


def resident() -> float:
    """Memory of this process [MiB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main(names: Sequence[str]) -> None:
    """Print tables."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    cheap = [name for name in indicator_names() if sound_indicator(name, {}).is_cheap]
    chosen = names or cheap
    samples = signals(1_000_000, 1)
    print(
        "speed relative to real time: of the monitor by wall and by processor time, of `measure` of the same"
    )
    print(
        "windows alone, of the monitor with a recorded file of 8 columns by wall and by processor time; share"
    )
    print(f"of a core in pieces of {LIVE} samples, from memory and through a pipe [%]; time from last sample")
    print("to line [ms]")
    heads = ("wall", "monitor", "measure", "file wall", "file")
    print(" " * 20, *(f"{x:>9}" for x in heads), *(f"{x:>8}" for x in ("small", "pipe", "median", "99 %")))
    files = [file for name in chosen if (file := compare(name, samples)) is not None]
    run(files[0], InMemory(samples, LONG // 10, N_AT_ONCE))
    before = resident()
    duration = run(files[0], InMemory(samples, LONG, N_AT_ONCE))
    memory = f"{before:.1f} MiB before, {resident():.1f} MiB after"
    print(f"{LONG:,} samples: memory {memory}; {duration[0]:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
