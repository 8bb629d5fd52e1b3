"""Interfaces of detectors."""

from __future__ import annotations

from typing import Protocol, TypeVar

from hydrofdi.records import Array, RecordBatch

Model = TypeVar("Model")
State = TypeVar("State")


class Detector(Protocol[Model]):
    """Interface of a detector: it learns from healthy records and scores other records."""

    def fit(self, healthy: RecordBatch) -> Model:
        """Fit a model to healthy records."""
        ...

    def score(self, model: Model, records: RecordBatch) -> Array:
        """Scores (n_record,); larger scores mean larger leaks, NaN if a record cannot be scored."""
        ...


class OnlineDetector(Detector[Model], Protocol[Model, State]):
    """Interface of an on-line detector: scores are bit-identical however a stream is split into chunks."""

    def start(self, model: Model, records: RecordBatch) -> State:
        """State before the first sample of streams with the channels and sampling of `records`."""
        ...

    def step(self, state: State, chunk: RecordBatch) -> tuple[State, Array]:
        """State after a chunk, and the scores (n_record, n_instant) within it."""
        ...
