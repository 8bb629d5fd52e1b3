"""What a file is, told from its beginning, for messages on a file that was given in the place of another."""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path

_HEAD_BYTES = 65_536


class FileKind(StrEnum):
    """Kinds of files that commands take, and some that they are given by mistake."""

    EXPERIMENT = "an experiment file"
    MEASURED = "a description of measured files"
    MONITOR = "a configuration of a monitor"
    DETECTOR = "a detector file"
    REPORT = "a report"
    HDF5 = "an HDF5 file"
    RESULTS = "a results folder"
    PICTURE = "a picture"
    SPREADSHEET = "a spreadsheet"
    DATA = "a data file"


USE = {
    FileKind.EXPERIMENT: ("sweep {path}", "runs it"),
    FileKind.MEASURED: ("inspect {path}", "reads it"),
    FileKind.MONITOR: ("monitor", "takes it as its configuration"),
    FileKind.DETECTOR: ("detect {path} RECORDS", "judges records with it"),
    FileKind.HDF5: ("inspect {path}", "reads it"),
    FileKind.RESULTS: ("report {path}", "shows it"),
    FileKind.DATA: ("inspect {path}", "reads it"),
}
"""Kind → the command that takes it, and what that does."""

_CURE = {
    FileKind.PICTURE: "name the file with the data",
    FileKind.SPREADSHEET: "save it as CSV",
    FileKind.REPORT: "name the experiment file or the results folder that it was made from",
}
"""Kind that no command takes → what to do."""

_MAGIC = {
    FileKind.HDF5: (b"\x89HDF\r\n\x1a\n",),
    FileKind.PICTURE: (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"%PDF", b"<svg"),
    FileKind.SPREADSHEET: (b"\xd0\xcf\x11\xe0",),
}
"""Kind → how the bytes begin."""

_SUFFIXES = {
    FileKind.PICTURE: (".png", ".jpg", ".jpeg", ".gif", ".svg", ".pdf"),
    FileKind.SPREADSHEET: (".xlsx", ".xls", ".ods"),
    FileKind.DATA: (".csv", ".tsv", ".mat", ".npz", ".parquet", ".pq"),
}

KEYS = {
    FileKind.EXPERIMENT: {
        "name", "actuator", "supply", "fluid", "valve", "friction", "leakage", "load", "input", "control",
        "record", "analysis", "sweep", "study", "baseline", "detection",
    },
    FileKind.MEASURED: {"files", "time", "format"},
    FileKind.MONITOR: {"text", "mqtt", "opcua"},
}  # fmt: skip
"""Kind → keys that no other kind has."""

_KEY = re.compile(r"^([A-Za-z_]\w*)\s*:", re.MULTILINE)
_NAME = re.compile(r"^name\s*:\s*[\"']?([\w.-]+)", re.MULTILINE)
_DETECTOR = re.compile(r'"schema"\s*:\s*"hydrofdi\.detector"')
_REPORT = re.compile(r'\s*\{\s*"experiment"\s*:\s*"')


def other_kind(path: Path, wanted: FileKind) -> str:
    """What is wrong with a file that is clearly not of the kind that is wanted, and its use; else empty."""
    found = _kind(path, wanted)
    is_stored = wanted is FileKind.RESULTS and found is FileKind.HDF5
    if found is None or found is wanted or is_stored:
        return ""
    return f"{path}: is {found}, not {wanted}; {_use(path, found, wanted)}"


def _kind(path: Path, wanted: FileKind) -> FileKind | None:
    """The kind of a file or folder; the one that is wanted if it may be that; None if nothing tells it."""
    if path.is_dir():
        return FileKind.RESULTS if (path / "experiment.json").is_file() else None
    head = _head(path)
    for kind, starts in _MAGIC.items():
        if head.startswith(starts):
            return kind
    by_suffix = (kind for kind, suffixes in _SUFFIXES.items() if path.suffix.lower() in suffixes)
    is_settings = wanted in KEYS or path.suffix.lower() in (".yaml", ".yml", ".json")
    text = head.decode("utf-8", errors="replace") if is_settings else ""
    return _settings_kind(text, wanted) or next(by_suffix, None)


def _use(path: Path, found: FileKind, wanted: FileKind) -> str:
    if wanted is FileKind.DETECTOR:
        return "name the detector first, then the records"
    if found is FileKind.EXPERIMENT and wanted is FileKind.RESULTS:
        stated = _NAME.search(_head(path).decode("utf-8", errors="replace"))
        return f"give its results folder: results/{stated[1] if stated else path.stem}"
    if found is FileKind.MEASURED and wanted is FileKind.MONITOR:
        return (
            "keep 'channels', write 'text:' for 'format:', put 'sampling_frequency' and 'time' into it, and"
            " leave the rest out"
        )
    if found in _CURE:
        return _CURE[found]
    name, does = USE[found]
    return f"'hydrofdi {name.format(path=path)}' {does}"


def _settings_kind(text: str, wanted: FileKind) -> FileKind | None:
    if _DETECTOR.search(text):
        return FileKind.DETECTOR
    if _REPORT.match(text):
        return FileKind.REPORT
    keys = {*_KEY.findall(text)}
    return next((kind for kind in (wanted, *KEYS) if keys & KEYS.get(kind, set())), None)


def _head(path: Path) -> bytes:
    """How a file begins; nothing of a pipe, which can be read only once."""
    if not path.is_file():
        return b""
    try:
        with open(path, "rb") as file:
            return file.read(_HEAD_BYTES)
    except OSError:
        return b""
