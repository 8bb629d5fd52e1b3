"""NPZ archives of NumPy: columns by the name of their array. Pickled objects are never loaded."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from hydrofdi.records.measured.formats.arrays import ArrayTable
from hydrofdi.records.measured.formats.content import Content
from hydrofdi.records.measured.rejection import RejectionError, damage_named


@contextmanager
def npz_table(place: str, content: Content) -> Iterator[ArrayTable]:
    """The arrays of an archive."""
    with damage_named("NPZ"):
        archive: Any = np.load(content, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise RejectionError("damaged", "cannot be read as NPZ: it is not an archive of arrays")
    with archive:
        with damage_named("NPZ"):
            arrays = {name: np.asarray(archive[name]) for name in archive.files}
        shapes = {name: array.shape for name, array in arrays.items()}
        yield ArrayTable(place, "NPZ", shapes, arrays.__getitem__)
