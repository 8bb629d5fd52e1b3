"""MAT files up to version 7: variables, and fields of structures as ``structure/field``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hydrofdi.records.measured.formats.arrays import ArrayTable
from hydrofdi.records.measured.formats.content import Content
from hydrofdi.records.measured.rejection import damage_named


def mat_table(place: str, content: Content) -> ArrayTable:
    """The variables of a file."""
    from scipy.io import loadmat

    opened: Any = content
    with damage_named("MAT"):
        variables = loadmat(opened, simplify_cells=True)
        own = {name: value for name, value in variables.items() if not name.startswith("__")}
        arrays = dict(_leaves("", own))
    return ArrayTable(place, "MAT", {name: array.shape for name, array in arrays.items()}, arrays.__getitem__)


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}/{name}" if path else str(name), inner)
    else:
        yield path, np.asarray(value)
