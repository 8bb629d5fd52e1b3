"""An experiment's folder besides its results: locks, and the provenance of a sweep, never inside the data."""

from __future__ import annotations

import fcntl
import json
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from io import FileIO
from pathlib import Path
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.drive import without_contents
from hydrofdi.config.loading import stored_experiment
from hydrofdi.config.runs import PHYSICS_VERSION
from hydrofdi.errors import StoreError, without_credentials
from hydrofdi.store.files import open_own, reason, write_all, write_whole_text

_FILE = ".lock"
_OWN = b'{"pid": '


@contextmanager
def experiment_lock(directory: Path, tell: Callable[[str], None], part: str = "") -> Iterator[None]:
    """Lock the folder of an experiment, or one part of its sweep, which shares the folder with others."""
    own = directory / (f".part{part}.lock" if part else _FILE)
    with _shared(directory) if part else nullcontext(), file_lock(own, _busy(directory)) as holder:
        if holder:
            tell(f"took over a stale lock of a sweep that was killed{holder}")
        yield


@contextmanager
def _shared(directory: Path) -> Iterator[None]:
    """Keep whole sweeps away from a folder, but no parts."""
    with open_own(directory / _FILE, _OWN, "a lock") as file:
        take_lock(file, _busy(directory), fcntl.LOCK_SH)
        file.truncate(0)
        yield


@contextmanager
def file_lock(path: Path, refusal: str) -> Iterator[str]:
    """Lock a file; the operating system releases the lock when this process ends."""
    with open_own(path, _OWN, "a lock") as file:
        take_lock(file, refusal)
        holder = _holder(file)
        owner = _OWN + f'{os.getpid()}, "host": {json.dumps(socket.gethostname())}}}'.encode()
        try:
            file.truncate(0)
            write_all(file, owner)
        except OSError as error:
            raise StoreError(f"{path}: cannot be written: {reason(error)}") from None
        try:
            yield holder
        finally:
            file.truncate(0)


def take_lock(file: FileIO, refusal: str, kind: int = fcntl.LOCK_EX) -> None:
    """Lock an open file until it is closed."""
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except OSError as error:
        is_held = isinstance(error, BlockingIOError)
        raise StoreError(refusal + (_holder(file) if is_held else f": {reason(error)}")) from None


def require_unlocked(directory: Path, *, shared: bool) -> None:
    """Check, without creating files, that no sweep has locked the folder; none but parts if it is shared."""
    try:
        file = FileIO(directory / _FILE, "r+")
    except OSError:
        return
    with file:
        take_lock(file, _busy(directory), fcntl.LOCK_SH if shared else fcntl.LOCK_EX)


def _busy(directory: Path) -> str:
    return f"{directory}: another sweep is at work there"


def _holder(file: FileIO) -> str:
    try:
        entry = json.loads(os.pread(file.fileno(), 1000, 0))
        return f" (process {entry['pid']} on {entry['host']})"
    except (ValueError, KeyError, TypeError):
        return ""


_FOLDER = "failures"


@dataclass(frozen=True)
class Failure:
    """A run without a result: ``error``, ``timeout`` or ``killed``, a sentence, and the worker's output."""

    run_id: str
    status: str
    message: str
    log: str = ""


def write_failure(directory: Path, failure: Failure) -> None:
    """Store a failure below an experiment's folder."""
    write_whole_text(directory / _FOLDER / f"{failure.run_id}.json", json.dumps(asdict(failure), indent=2))


def read_failures(directory: Path) -> dict[str, Failure]:
    """Identity of a run → stored failure; unreadable files are ignored."""
    failures = {}
    for path in sorted((directory / _FOLDER).glob("*.json")):
        with suppress(TypeError):
            failure = Failure(**(_read_json(path) or {}))
            failures[failure.run_id] = failure
    return failures


def forget_failure(directory: Path, run_id: str) -> None:
    """Delete the stored failure of a run, if any."""
    (directory / _FOLDER / f"{run_id}.json").unlink(missing_ok=True)


_CALIBRATIONS = "calibrations.json"


def _read_json(path: Path) -> Any:
    """The content of a JSON file; None if it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def read_calibrations(directory: Path) -> dict[str, float]:
    """Identity of a calibration → K_i [m^3.5/kg^0.5]; empty if no readable file exists."""
    try:
        return {key: float(value) for key, value in _read_json(directory / _CALIBRATIONS).items()}
    except (ValueError, TypeError, AttributeError):
        return {}


def write_calibrations(directory: Path, coefficients: dict[str, float]) -> None:
    """Add solved coefficients to those stored."""
    every = read_calibrations(directory) | coefficients
    write_whole_text(directory / _CALIBRATIONS, json.dumps(every, indent=0, sort_keys=True))


_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def environment_record(experiment: ExperimentConfig) -> dict[str, Any]:
    """Current configuration, command, code, libraries and machine."""
    return {
        "started": now(),
        "command": [without_credentials(argument) for argument in sys.argv],
        "configuration": without_contents(json.loads(experiment.model_dump_json())),
        "physics": PHYSICS_VERSION,
        "git": _git_state(Path(__file__).parent),
        "python": platform.python_version(),
        "libraries": _installed(),
        "machine": {
            "host": socket.gethostname(),
            "system": platform.platform(),
            "processor": _processor(),
            "cores": os.cpu_count(),
        },
        "threads": {name: os.environ[name] for name in _THREAD_VARIABLES if name in os.environ},
    }


def _installed() -> dict[str, str]:
    """Name → version of all distributions, by the names of their folders; reading their contents is slow."""
    folders = (path.stem for entry in sys.path for path in Path(entry).glob("*.dist-info"))
    return dict(sorted(folder.split("-", 1) for folder in folders if "-" in folder))


def add_provenance(directory: Path, record: dict[str, Any], part: str = "") -> None:
    """Append the provenance record of a sweep, or of a part of one, to the earlier records."""
    path = directory / f"provenance{part}.json"
    write_whole_text(path, json.dumps([*(_read_json(path) or []), record], indent=2))


def read_provenance(directory: Path) -> list[dict[str, Any]]:
    """Provenance records of all sweeps on an experiment's folder, and of their parts."""
    records = (record for path in directory.glob("provenance*.json") for record in _read_json(path) or [])
    return sorted(records, key=lambda record: record["started"])


def read_costs(directory: Path) -> dict[str, float]:
    """Label of an indicator → CPU time per record [s], from the latest sweep that measured it."""
    measured = [record["costs"] for record in read_provenance(directory) if record.get("costs")]
    return dict(measured[-1]) if measured else {}


def now() -> str:
    """Current UTC time in ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _git_state(folder: Path) -> dict[str, Any] | None:
    """Commit of the code, and whether its files are changed; None if the folder is not a checkout."""
    command = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return None
    commit, _, changes = done.stdout.strip().partition("-")
    return {"commit": commit, "dirty": bool(changes)}


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor()


def write_log(path: Path, event: str, **details: Any) -> None:
    """Append an event with a time stamp to a log."""
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps({"time": now(), "event": event, **details}) + "\n")
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {reason(error)}") from None


REQUEST_FILE = "experiment.json"
"""Name of the request file in an experiment's folder."""

_IDENTITY = "identity_of_indicators"
"""Key of the request that is not one of an experiment."""


def write_request(directory: Path, experiment: ExperimentConfig) -> None:
    """Store the resolved configuration of a sweep, and what only the files of its plug-ins tell."""
    record = json.loads(experiment.model_dump_json())
    if experiment.plugins:
        record[_IDENTITY] = experiment.indicator_choice.identity
    write_whole_text(directory / REQUEST_FILE, json.dumps(record, indent=2, ensure_ascii=False) + "\n")


def require_same_experiment(directory: Path, experiment: ExperimentConfig) -> None:
    """Check that a folder does not contain an experiment with a different name."""
    if directory.exists() and not directory.is_dir():
        raise StoreError(f"{directory}: is a file, not a folder; give another 'out'")
    if not (directory / REQUEST_FILE).exists():
        return
    held = read_request(directory).name
    if held != experiment.name:
        raise StoreError(
            f"{directory}: contains the experiment {held!r}, not {experiment.name!r}; give another 'out'"
        )


def request_record(directory: Path) -> tuple[dict[str, Any], str]:
    """The latest request as written, in SI, and `IndicatorChoice.identity` if it has plug-ins; else empty."""
    path = directory / REQUEST_FILE
    try:
        record = dict(json.loads(path.read_text(encoding="utf-8")))
        return record, str(record.pop(_IDENTITY, ""))
    except FileNotFoundError:
        return {}, ""
    except (OSError, ValueError, TypeError) as error:
        raise StoreError(f"{path}: cannot be read: {reason(error)}") from None


def read_request(directory: Path) -> ExperimentConfig:
    """The resolved configuration of the latest sweep on a folder."""
    record, _ = request_record(directory)
    if not record:
        raise StoreError(f"{directory}: is not the folder of an experiment (it has no {REQUEST_FILE})")
    return stored_experiment(json.dumps(record), str(directory / REQUEST_FILE))
