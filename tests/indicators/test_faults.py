"""Indicators that other people wrote, and what becomes of the faults in them."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

from hydrofdi.errors import Issue
from hydrofdi.indicators import Indicator, Output, make_indicators, measure
from hydrofdi.records import Channel, RecordBatch

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
    ("gives", "sentence"),
    [
        (fails, "indicator 'swing' raised ValueError: no swing at all (test_faults.py:"),
        (lambda batch: {"range": batch[P1].T}, "gives 'range' of shape (512, 3), not (3,)"),
        (lambda batch: {"range": 1.0}, "gives 'range' as float, not as an array of shape (3,)"),
        (lambda batch: {"range": np.ones(3, complex)}, "gives 'range' of type complex128, not of real"),
        (lambda batch: {"range": np.array(["1", "2", "3"])}, "gives 'range' of type <U1, not of real"),
        (lambda batch: {}, "gives no 'range'"),
        (lambda batch: {"range": np.ones(3), "rnge": np.ones(3)}, "gives 'rnge', which is not one of"),
        (lambda batch: None, "gives NoneType, not a mapping"),
    ],
)
def test_a_fault_is_a_sentence_of_every_record_and_the_others_go_on(gives: Any, sentence: str) -> None:
    measured = measure(records(), {"swing": swing(gives), **make_indicators(["dwt"])})
    assert sentence in measured.faults["swing"]
    assert measured.obstacles["swing"] == (measured.faults["swing"],) * 3
    assert np.isnan(measured.values["swing.range"]).tolist() == [True] * 3
    assert np.isfinite(measured.values["dwt.d1"]).all()
    assert measured.obstacles["dwt"] == (None,) * 3
