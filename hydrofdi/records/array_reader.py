"""Program that reads arrays of HDF5 and MAT files for another process, which starts it by its path.

It imports nothing of this package, so that it starts fast. A request is a line of JSON on standard input,
followed by the bytes of a file that has no path. The answer is a line of JSON on standard output, followed by
the bytes of an array.
"""

from __future__ import annotations

import faulthandler
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from io import BytesIO
from typing import Any, BinaryIO, cast

import numpy as np

_MISSING = {"_FillValue", "missing_value"}
_PACKING = {"scale_factor", "add_offset"} | _MISSING
"""Attributes by which NetCDF packs numbers."""


def open_hdf5(content: Any) -> Any:
    """Open an HDF5 file, which may come from somebody else, for reading.

    Parameters
    ----------
    content : str, Path or file object

    Returns
    -------
    h5py.File

    Raises
    ------
    OSError
        It cannot be read, or it refers to other files, which may be any that the user can read.
    """
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


class Hdf5File:
    """Datasets of HDF5 by their path; MAT files of version 7.3 are HDF5."""

    def __init__(self, content: str | BytesIO) -> None:
        import h5py

        self._file = open_hdf5(content)
        self._datasets: dict[str, Any] = {}

        def keep(name: str | bytes, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.shape is not None:
                self._datasets[_text(name)] = item

        self._file.visititems(keep)
        self.shapes = {name: item.shape for name, item in self._datasets.items()}

    def array(self, name: str) -> Any:
        """Values of a dataset, with fill values, scale and offset of NetCDF applied."""
        dataset = self._datasets[name]
        values, attributes = dataset[()], dataset.attrs
        if not _PACKING & attributes.keys() or np.asarray(values).dtype.kind not in "iuf":
            return values
        missing = np.isin(values, [attributes[key] for key in _MISSING & attributes.keys()])
        scale, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)
        return np.where(missing, np.nan, np.asarray(values, dtype=np.float64) * scale + offset)

    def unit(self, name: str) -> str:
        """The attribute ``units`` or ``unit``; empty if there is none."""
        attributes = self._datasets[name].attrs
        found = next((attributes[key] for key in ("units", "unit") if key in attributes), "")
        return _text(found) if isinstance(found, str | bytes) else ""

    def close(self) -> None:
        """Release the file."""
        self._file.close()


class MatFile:
    """Variables of MAT files up to version 7, and fields of structures as ``structure/field``."""

    def __init__(self, content: str | BytesIO) -> None:
        from scipy.io import loadmat

        variables = loadmat(cast(Any, content), appendmat=False, simplify_cells=True)
        own = {name: value for name, value in variables.items() if not name.startswith("__")}
        leaves = dict(_leaves("", own))
        self._units = {name: _stated(leaves, name) for name in leaves}
        stating = {_place_of_unit(name) for name, unit in self._units.items() if unit}
        self._arrays = {name: array for name, array in leaves.items() if name not in stating}
        self.shapes = {name: array.shape for name, array in self._arrays.items()}

    def array(self, name: str) -> Any:
        """Values of a variable."""
        return self._arrays[name]

    def unit(self, name: str) -> str:
        """The field with a variable's name in the structure ``units`` beside it; empty if there is none."""
        return self._units[name]

    def close(self) -> None:
        """Do nothing: the file is not kept open."""


class Server:
    """Answers requests about one file at a time."""

    def __init__(self, requests: BinaryIO, answers: BinaryIO) -> None:
        self._requests, self._answers = requests, answers
        self._file: Hdf5File | MatFile | None = None

    def answer(self, request: Mapping[str, Any]) -> None:
        """Carry out a request and send the result, or the message of what a library raised."""
        actions: dict[str, Callable[..., tuple[dict[str, Any], Any]]] = {
            "open": self._open, "array": self._array, "unit": self._unit, "close": self._close,
        }  # fmt: skip
        try:
            head, body = actions[request["do"]](**request["of"])
            line = json.dumps(head).encode()
        except Exception as error:
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            line, body = json.dumps({"error": reason}).encode(), b""
        self._answers.write(line + b"\n")
        self._answers.write(body)
        self._answers.flush()

    def _open(self, kind: str, path: str | None, size: int) -> tuple[dict[str, Any], Any]:
        content = BytesIO(self._requests.read(size)) if path is None else path
        self._file = Hdf5File(content) if kind == "HDF5" else MatFile(content)
        return {"shapes": self._file.shapes}, b""

    def _array(self, name: str) -> tuple[dict[str, Any], Any]:
        assert self._file is not None
        values = np.asarray(self._file.array(name))
        if values.dtype.kind not in "biufcSU":
            return {
                "texts": [_text(value) for value in values.reshape(-1).tolist()],
                "shape": values.shape,
            }, b""
        head = {"dtype": values.dtype.str, "shape": values.shape}
        return head, np.ascontiguousarray(values).reshape(-1).view(np.uint8) if values.nbytes else b""

    def _unit(self, name: str) -> tuple[dict[str, Any], Any]:
        assert self._file is not None
        return {"unit": self._file.unit(name)}, b""

    def _close(self) -> tuple[dict[str, Any], Any]:
        file, self._file = self._file, None
        if file is not None:
            file.close()
        return {}, b""


def main() -> None:
    """Serve until standard input ends; each request has a time limit, which ends a library that hangs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    server = Server(sys.stdin.buffer, answers)
    for line in iter(sys.stdin.buffer.readline, b""):
        request = json.loads(line)
        faulthandler.dump_traceback_later(request["seconds"], exit=True)
        server.answer(request)
        faulthandler.cancel_dump_traceback_later()


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}/{name}" if path else str(name), inner)
    else:
        yield path, np.asarray(value)


def _place_of_unit(name: str) -> str:
    """Path of a variable's unit in a structure ``units``: ``rig/units/P1`` for ``rig/P1``."""
    structure, slash, variable = name.rpartition("/")
    return f"{structure}{slash}units/{variable}"


def _stated(leaves: Mapping[str, Any], name: str) -> str:
    unit = leaves.get(_place_of_unit(name))
    return str(unit) if unit is not None and unit.dtype.kind == "U" and unit.size == 1 else ""


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    main()
