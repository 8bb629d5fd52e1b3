"""HDF5, and MAT files of version 7.3, which are HDF5: columns by the path of their dataset."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from hydrofdi.records.measured.formats.arrays import ArrayTable
from hydrofdi.records.measured.formats.content import Content
from hydrofdi.records.measured.rejection import damage_named

_MISSING = {"_FillValue", "missing_value"}
_PACKING = {"scale_factor", "add_offset"} | _MISSING
"""Attributes by which NetCDF packs numbers."""


@contextmanager
def hdf5_table(place: str, content: Content) -> Iterator[ArrayTable]:
    """The datasets of a file; units from their attribute ``units`` or ``unit``."""
    import h5py

    with damage_named("HDF5"):
        file = h5py.File(content, "r")
    with file:
        datasets: dict[str, Any] = {}

        def keep(name: str | bytes, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.shape is not None:
                datasets[_text(name)] = item

        with damage_named("HDF5"):
            file.visititems(keep)
            shapes = {name: item.shape for name, item in datasets.items()}
        yield ArrayTable(
            place, "HDF5", shapes, lambda name: _unpacked(datasets[name]), lambda name: _unit(datasets[name])
        )


def _unpacked(dataset: Any) -> Any:
    """Values of a dataset; fill values, scale and offset of NetCDF applied."""
    values, attributes = dataset[()], dataset.attrs
    if not _PACKING & attributes.keys() or np.asarray(values).dtype.kind not in "iuf":
        return values
    missing = np.isin(values, [attributes[key] for key in _MISSING & attributes.keys()])
    scale, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)
    return np.where(missing, np.nan, np.asarray(values, dtype=np.float64) * scale + offset)


def _unit(dataset: Any) -> str:
    found = next((dataset.attrs[key] for key in ("units", "unit") if key in dataset.attrs), "")
    return _text(found) if isinstance(found, str | bytes) else ""


def _text(text: str | bytes) -> str:
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else text
