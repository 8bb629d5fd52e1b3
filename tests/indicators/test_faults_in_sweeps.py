"""Indicators that fail in a sweep: a sentence, exit code 1, and the reason in the report of a study."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from hydrofdi.indicators import Indicator, Output, registry
from hydrofdi.records import Channel, RecordBatch
from tests.commands import run, run_json

POINTS = "sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}\n"
STUDY = "study: {healthy: {fit: 3, test: 2}}\n"


class Raising(Indicator[Any]):
    name: ClassVar[str] = "raising"
    version, summary, source = 1, "Fails.", "none"
    channels = frozenset({Channel.CHAMBER_1_PRESSURE})
    outputs = (Output("swing", "Pa", "swing"),)

    def measure(self, records: RecordBatch) -> dict[str, Any]:
        raise ValueError("no swing at all")


class Overflowing(Raising):
    name: ClassVar[str] = "overflowing"

    def measure(self, records: RecordBatch) -> dict[str, Any]:
        return {"swing": np.full(records.n_record, np.inf)}


@pytest.fixture(autouse=True)
def _added(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    points = tuple(
        EntryPoint(kind.name, f"{__name__}:{kind.__name__}", registry.GROUP)
        for kind in (Raising, Overflowing)
    )
    monkeypatch.setattr(registry, "_points", lambda: points)
    for cached in (registry._added, registry.indicator_kind):
        cached.cache_clear()
    yield
    for cached in (registry._added, registry.indicator_kind):
        cached.cache_clear()


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("raising", "raising: indicator 'raising' raised ValueError: no swing at all"),
        ("overflowing", "overflowing: indicator 'overflowing' gives infinite numbers"),
    ],
)
@pytest.mark.parametrize("points", [POINTS, STUDY])
def test_a_sweep_says_it_once_and_exits_with_1(tmp_path: Path, name: str, sentence: str, points: str) -> None:
    file, out = tmp_path / "faulty.yaml", tmp_path / "out"
    file.write_text(f"name: faulty\nrecord: {{duration: 2 s}}\nindicators: [dwt, {name}]\n{points}")
    for _ in range(2):  # computed, and stored before
        done = run("sweep", file, "--out", out, "--engine", "in-process", check=1)
        assert done.stderr.count(sentence) == 1
    logged = [json.loads(line) for line in (out / "run.log").read_text().splitlines()]
    assert any(sentence.partition(": ")[2] in each.get("message", "") for each in logged)
    assert run_json("sweep", file, "--out", out, check=1)["faults"].keys() == {name}
    if points == STUDY:
        report = run("report", out, "--format", "markdown").stdout
        assert sentence.partition(": ")[2] in report
