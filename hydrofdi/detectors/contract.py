"""What a detector is."""

from __future__ import annotations

from typing import Protocol, TypeVar

from hydrofdi.records import Array, RecordBatch

Model = TypeVar("Model")
State = TypeVar("State")


class Detector(Protocol[Model]):
    """Something that learns from healthy records and scores others."""

    def fit(self, healthy: RecordBatch) -> Model:
        """What healthy records teach; they have no labels."""
        ...

    def score(self, model: Model, records: RecordBatch) -> Array:
        """Scores (n_record,): larger is leakier. NaN if a record cannot be scored."""
        ...


class OnlineDetector(Detector[Model], Protocol[Model, State]):
    """A detector of streams. Whatever the chunks, the scores of a stream are the same to the bit."""

    def start(self, model: Model, records: RecordBatch) -> State:
        """The state before the first sample of streams that have the channels and sampling of `records`."""
        ...

    def step(self, state: State, chunk: RecordBatch) -> tuple[State, Array]:
        """The state behind a chunk, and the scores (n_record, n_instant) that came with it."""
        ...
