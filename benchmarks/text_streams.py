"""Rows of text per second of processor time, with time and four channels: CSV, JSON lines, and payloads.

``python benchmarks/text_streams.py``: medians of rounds, each over 200,000 rows in pieces of 128 KiB. For
comparison: conversion of the same cells by ``float`` alone, an upper bound for text readers.
"""

from __future__ import annotations

import json
import statistics
import time

import numpy as np

from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.growing_file import BLOCK
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.monitor.text_lines import TextLines

N_ROW, N_ROUND = 200_000, 5
TITLES = ["time [s]", "P1 [bar]", "P2 [bar]", "Ps [bar]", "x [mm]"]


def processor_time(work):
    began = time.process_time()
    work()
    return time.process_time() - began


def read_text(data):
    lines = TextLines(MonitorConfig(), "benchmark", {})
    n_row = 0
    for first in range(0, len(data), BLOCK):
        chunk = lines.read(data[first : first + BLOCK])
        n_row += 0 if chunk is None else chunk.n_time
    assert n_row > 0.99 * N_ROW


def read_payloads(payloads):
    reader = PayloadReader(MonitorConfig())
    for payload in payloads:
        reader.read_all([payload])


def main():
    random = np.random.default_rng(1)
    values = random.normal(size=(N_ROW, len(TITLES))) * 100.0
    values[:, 0] = np.arange(N_ROW) / 1000
    short, full = np.round(values, 3).tolist(), values.tolist()
    header = ",".join(TITLES)
    csv, exact = (
        "\n".join([header, *(",".join(map(repr, row)) for row in rows), ""]).encode()
        for rows in (short, full)
    )
    spoilt = csv.split(b"\n")
    spoilt[500::1000] = [b"garbage"] * len(spoilt[500::1000])
    objects = [json.dumps(dict(zip(TITLES, row, strict=True))).encode() for row in short]
    cells = exact.decode().partition("\n")[2].replace("\n", ",").rstrip(",").split(",")
    works = {
        "CSV, three decimals": lambda: read_text(csv),
        "CSV, all digits": lambda: read_text(exact),
        "float alone, all digits": lambda: np.fromiter(map(float, cells), np.float64, len(cells)),
        "CSV, one line in 1,000 malformed": lambda: read_text(b"\n".join(spoilt)),
        "JSON lines": lambda: read_text(b"\n".join(objects) + b"\n"),
        "JSON payloads, one sample each": lambda: read_payloads(objects),
    }
    taken = {name: [] for name in works}
    for _ in range(N_ROUND):
        for name, work in works.items():
            taken[name].append(processor_time(work))
    for name, times in taken.items():
        print(f"{name:34} {N_ROW / statistics.median(times):9,.0f} rows/s")


if __name__ == "__main__":
    main()
