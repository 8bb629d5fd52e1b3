"""Program that reads arrays of HDF5 and MAT files for another process, which starts it by its path.

It imports nothing of this package, so that it starts fast. Requests on standard input and answers on standard
output are pickled; what is read from a file never is.
"""

from __future__ import annotations

import faulthandler
import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from io import BytesIO
from typing import Any, cast

import numpy as np

_MISSING = {"_FillValue", "missing_value"}
_PACKING = {"scale_factor", "add_offset"} | _MISSING
"""Attributes by which NetCDF packs numbers."""


def open_hdf5(content: Any) -> Any:
    """Open an HDF5 file, which may come from somebody else, for reading."""
    import h5py

    file: Any = h5py.File(content, "r")

    def is_elsewhere(name: bytes, link: Any) -> bool | None:
        if link.type != h5py.h5l.TYPE_HARD:
            return link.type != h5py.h5l.TYPE_SOFT or None
        item = h5py.h5o.open(file.id, name)
        if not isinstance(item, h5py.h5d.DatasetID):
            return None
        stored = item.get_create_plist()
        return stored.get_layout() == h5py.h5d.VIRTUAL or stored.get_external_count() > 0 or None

    try:
        if file.id.links.visit(is_elsewhere, info=True):
            raise OSError("it refers to data in other files; copy them into one")
    except Exception as error:
        file.close()
        raise OSError(*error.args) from None
    return file


Opened = tuple[Mapping[str, Any], dict[str, str], Callable[[], None]]
"""Name → array or dataset, name → unit if one is stated, and what releases the file."""


def _hdf5(content: str | BytesIO) -> Opened:
    """Datasets of HDF5 by their path."""
    import h5py

    file, datasets = open_hdf5(content), dict[str, Any]()

    def keep(name: str | bytes, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.shape is not None:
            datasets[_text(name)] = item

    file.visititems(keep)
    found = {
        name: next((item.attrs[key] for key in ("units", "unit") if key in item.attrs), "")
        for name, item in datasets.items()
    }
    units = {name: _text(unit) for name, unit in found.items() if isinstance(unit, str | bytes)}
    return datasets, units, file.close


def _unpacked(dataset: Any) -> Any:
    """Values of a dataset, with fill values, scale and offset of NetCDF applied."""
    values, attributes = dataset[()], dataset.attrs
    if not _PACKING & attributes.keys() or np.asarray(values).dtype.kind not in "iuf":
        return values
    missing = np.isin(values, [attributes[key] for key in _MISSING & attributes.keys()])
    scale, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)
    return np.where(missing, np.nan, np.asarray(values, dtype=np.float64) * scale + offset)


def _mat(content: str | BytesIO) -> Opened:
    """Variables of MAT files up to version 7, and fields of structures as ``structure/field``.

    The unit of a variable is the field with its name in the structure ``units`` beside it: ``rig/units/P1``
    for ``rig/P1``.
    """
    from scipy.io import loadmat

    try:
        variables = loadmat(cast(Any, content), appendmat=False, simplify_cells=True)
    except (NotImplementedError, ValueError):  # of version 7.3
        return _hdf5(content)
    own = {name: value for name, value in variables.items() if not name.startswith("__")}
    leaves = dict(_leaves("", own))
    places = {name: "/".join((*name.split("/")[:-1], "units", name.split("/")[-1])) for name in leaves}
    stated = {name: leaves[place] for name, place in places.items() if place in leaves}
    units = {name: str(unit) for name, unit in stated.items() if unit.dtype.kind == "U" and unit.size == 1}
    arrays = leaves.keys() - {places[name] for name in units}
    return {name: leaves[name] for name in leaves if name in arrays}, units, lambda: None


def main() -> None:
    """Serve until standard input ends: open, give an array, close; each within a time limit."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    opened: Opened = {}, {}, lambda: None
    while True:
        try:
            seconds, *request = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        faulthandler.dump_traceback_later(seconds, exit=True)
        try:
            answer: Any = None
            if len(request) == 2:
                kind, content = request
                given = content if isinstance(content, str) else BytesIO(content)
                opened = _hdf5(given) if kind == "HDF5" else _mat(given)
                answer = {name: array.shape for name, array in opened[0].items()}, opened[1]
            elif request:
                answer = _plain(opened[0][request[0]])
            else:
                opened[2]()
        except Exception as error:
            answer = OSError(" ".join(str(error).split())[:120] or type(error).__name__)
        pickle.dump(answer, answers, protocol=5)
        answers.flush()
        faulthandler.cancel_dump_traceback_later()


def _plain(array: Any) -> Any:
    """Values of an array or a dataset without objects of a library: numbers, dates or texts."""
    values = np.asarray(_unpacked(array) if hasattr(array, "attrs") else array)
    if values.dtype.kind in "biufcSU":
        return values
    return np.array([_text(value) for value in values.reshape(-1).tolist()], dtype=object).reshape(
        values.shape
    )


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}/{name}" if path else str(name), inner)
    else:
        yield path, np.asarray(value)


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    main()
