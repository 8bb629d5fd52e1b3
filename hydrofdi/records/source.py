"""Sources of records."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from hydrofdi.records.batch import RecordBatch


class RecordSource(Protocol):
    """Records, batch by batch: simulated, stored or measured."""

    @property
    def name(self) -> str:
        """Name for display: a file or a folder."""
        ...

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records, each once, in a fixed order; one batch in memory at a time.

        Parameters
        ----------
        labels : bool
            Whether batches contain the labels of their records. Only evaluations request them.

        Raises
        ------
        DataError
            A measured file cannot be used.
        StoreError
            A stored file cannot be read.
        """
        ...
