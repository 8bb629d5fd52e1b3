"""Indicators that other people wrote: what they see, and what becomes of the faults in them."""

import json
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from hydrofdi.errors import Issue
from hydrofdi.indicators import Indicator, Output, make_indicators, measure, registry
from hydrofdi.indicators.measuring import measure_sources
from hydrofdi.records import Channel, RecordBatch, RejectedRecord
from hydrofdi.records.source import measured_source
from tests.commands import run, run_json

P1 = Channel.CHAMBER_1_PRESSURE


class Swing(Indicator[Any]):
    name: ClassVar[str] = "swing"
    version, summary, source = 1, "Largest less least P_1.", "none"
    channels = frozenset({P1})
    outputs = (Output("range", "Pa", "range"),)
    gives: ClassVar[Any] = None

    def measure(self, records: RecordBatch) -> Any:
        return self.gives(records)


def swing(gives: Any) -> Swing:
    return type("Faulty", (Swing,), {"gives": staticmethod(gives)})()


def records(remarks: tuple[tuple[Issue, ...], ...] = ()) -> RecordBatch:
    signal = np.random.default_rng(1).normal(size=(3, 512))
    return RecordBatch({P1: signal}, 500.0, ("a", "b", "c"), remarks=remarks)


def in_place(batch: RecordBatch) -> dict[str, Any]:
    pressure = batch[P1]
    pressure -= pressure.mean(axis=1, keepdims=True)
    return {"range": np.ptp(pressure, axis=1)}


@pytest.mark.parametrize("is_unusable", [False, True])
def test_one_that_works_in_place_changes_no_signal_and_no_other_indicator(is_unusable: bool) -> None:
    batch = records(((Issue("stuck", kind="stuck", is_unusable=is_unusable),), (), ()))
    before = batch[P1].copy()
    own = make_indicators(["pressure_statistics"])
    measured = measure(batch, {"swing": swing(in_place), **own})
    np.testing.assert_array_equal(batch[P1], before)
    np.testing.assert_array_equal(
        measured.values["pressure_statistics.mean"], measure(batch, own).values["pressure_statistics.mean"]
    )
    assert "read-only" in measured.faults["swing"]


def fails(batch: RecordBatch) -> dict[str, Any]:
    raise ValueError("no swing\nat all")


@pytest.mark.parametrize(
    "gives",
    [
        fails, lambda batch: {"range": batch[P1].T}, lambda batch: {"range": 1.0},
        lambda batch: {"range": np.ones(3, complex)}, lambda batch: {},
        lambda batch: {"range": np.ones(3), "rnge": np.ones(3)}, lambda batch: None,
    ],
)  # fmt: skip
def test_a_fault_is_a_sentence_of_every_record_and_the_others_go_on(gives: Any) -> None:
    measured = measure(records(), {"swing": swing(gives), **make_indicators(["dwt"])})
    assert "swing" in measured.faults["swing"]
    assert "\n" not in measured.faults["swing"]
    assert measured.obstacles["swing"] == (measured.faults["swing"],) * 3
    assert np.isnan(measured.values["swing.range"]).tolist() == [True] * 3
    assert np.isfinite(measured.values["dwt.d1"]).all()
    assert measured.obstacles["dwt"] == (None,) * 3


class Raising(Swing):
    name: ClassVar[str] = "raising"
    gives: ClassVar[Any] = staticmethod(fails)


class Overflowing(Swing):
    name: ClassVar[str] = "overflowing"
    gives: ClassVar[Any] = staticmethod(lambda batch: {"range": np.full(batch.n_record, np.inf)})


@pytest.fixture
def _added(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    kinds = (Raising, Overflowing)
    points = [EntryPoint(kind.name, f"{__name__}:{kind.__name__}", registry.GROUP) for kind in kinds]
    monkeypatch.setattr(registry, "entry_points", lambda **_: points)
    for cached in (registry._added, registry.indicator_kind):
        cached.cache_clear()
    yield
    for cached in (registry._added, registry.indicator_kind):
        cached.cache_clear()


STUDY = "study: {healthy: {fit: 3, test: 2}}\n"


@pytest.mark.usefixtures("_added")
@pytest.mark.parametrize(
    ("name", "points"),
    [("raising", STUDY), ("overflowing", "sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}\n")],
)
def test_a_sweep_says_it_once_and_exits_with_1(tmp_path: Path, name: str, points: str) -> None:
    file, out, sentence = tmp_path / "faulty.yaml", tmp_path / "out", f"indicator '{name}' "
    file.write_text(f"name: faulty\nrecord: {{duration: 2 s}}\nindicators: [dwt, {name}]\n{points}")
    for _ in range(2):  # computed, and stored before
        done = run("sweep", file, "--out", out, "--engine", "in-process", check=1)
        assert done.stderr.count(sentence) == 1
    logged = [json.loads(line) for line in (out / "run.log").read_text().splitlines()]
    assert any(sentence in each.get("message", "") for each in logged)
    assert run_json("sweep", file, "--out", out, check=1)["faults"].keys() == {name}
    if points == STUDY:
        assert sentence in run("report", out, "--format", "markdown").stdout


class Curious(Swing):
    """Keeps every text that it can reach."""

    name, outputs = "curious", (Output("mean", "Pa", "mean pressure"),)

    def __init__(self):
        super().__init__()
        self.seen = []

    def obstacle(self, records):
        self.seen.append((records.record_ids, texts_in(records)))

    def measure(self, records):
        self.obstacle(records)
        return {"mean": records[P1].mean(axis=1)}


def texts_in(thing):
    """Every text in a batch but the names of channels."""
    if isinstance(thing, str):
        return set() if isinstance(thing, Channel) else {thing}
    if is_dataclass(thing):
        inner = [getattr(thing, field.name) for field in fields(thing)]
    elif isinstance(thing, dict):
        inner = [*thing, *thing.values()]
    else:
        inner = thing if isinstance(thing, tuple | list | set | frozenset) else []
    return set().union(*map(texts_in, inner))


def test_an_indicator_sees_no_file_name_group_or_label(tmp_path):
    for name in ("Base_7", "Leak_7", "Leak_8"):
        (tmp_path / f"{name}.csv").write_text("P1\n" + "".join(f"{row % 5 + 1}\n" for row in range(20)))
    (tmp_path / "rig.yaml").write_text(
        'files: "*.csv"\nsampling_frequency: 100 Hz\n'
        "channels: {chamber_1_pressure: {column: P1, unit: bar}}\n"
        'path: "{condition}_{unit}.csv"\ngroup: "rig {unit}"\nlabel: "{condition}"\n'
    )
    curious = Curious()
    _, records = measure_sources([measured_source(tmp_path / "rig.yaml")], {"curious": curious})
    told = list(records)
    assert {record.label for record in told} == {"Base", "Leak"}, "a person sees them"
    assert {record.record_id.partition("#")[0] for record in told} >= {"Base_7.csv", "Leak_8.csv"}
    assert curious.seen
    for ids, texts in curious.seen:
        assert texts - set(ids) <= {""}
        assert all(name.isdecimal() for name in ids)


def test_what_is_rejected_or_remarked_is_not_handed_on_but_counts():
    remark = Issue("Leak_2.csv has a gap", kind="gap", is_unusable=True)
    records = RecordBatch(
        {P1: np.arange(20.0).reshape(2, 10)}, 100.0, ("Base_1.csv", "Leak_2.csv"), remarks=((), (remark,)),
        rejected=(RejectedRecord("Leak_3.csv", "rig", "unit 3", remark, "Leak"),), labels=("Base", "Leak"),
    )  # fmt: skip
    curious = Curious()
    measures = measure(records, {"curious": curious})
    assert measures.obstacles["curious"] == (None, "Leak_2.csv has a gap")
    np.testing.assert_array_equal(measures.values["curious.mean"], [4.5, np.nan])
    assert {text for _, texts in curious.seen for text in texts} <= {"", "0", "1"}
