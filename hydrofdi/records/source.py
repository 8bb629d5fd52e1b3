"""Where records come from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from hydrofdi.records.batch import RecordBatch


class RecordSource(Protocol):
    """Records, batch by batch: simulated, stored or measured."""

    @property
    def name(self) -> str:
        """What a person calls it: a file or a folder."""
        ...

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records, each once, in an order that does not change; one batch in memory at a time.

        Parameters
        ----------
        labels : bool
            Whether batches say what is known of their records. Only an evaluation asks for it.

        Raises
        ------
        DataError
            A measured file cannot be used.
        StoreError
            A stored file cannot be read.
        """
        ...
