"""Where experiments are stored, and experiments read back, finished or not."""

from __future__ import annotations

import platform
import re
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.config.runs import PHYSICS_VERSION, run_identities
from hydrofdi.errors import ConfigError, ReportError, StoreError
from hydrofdi.settings.messages import counted, similar
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import columns_of, read_experiment
from hydrofdi.store.folder import REQUEST_FILE, read_failures, read_request, request_record
from hydrofdi.store.names import RUN_ID
from hydrofdi.store.shards import ShardIndex, ShardResults, read_index
from hydrofdi.version import __version__

RESULTS = Path("results")
"""Folder for experiments, below the working directory."""

_RANGE = re.compile(r"(\d+)-(\d+)")

_LIBRARIES = ("h5py", "numba", "numpy", "pywavelets", "scipy")


def experiment_directory(experiment: ExperimentConfig, out: Path | None = None) -> Path:
    """Folder of an experiment: `out`, or ``results/<name>``."""
    if out is None:
        return RESULTS / experiment.name
    if out.resolve() == Path.cwd():
        raise ConfigError("out: name a separate folder, not the working directory")
    return out


def experiment_file(directory: Path, experiment: ExperimentConfig) -> Path:
    """The experiment file in its folder."""
    return directory / f"{experiment.name}.h5"


def results_files(directory: Path) -> list[Path]:
    """The files in a folder that are named like experiment files, sorted."""
    return sorted(directory.glob("[!.]*.h5"))


def require_single(directory: Path, files: Sequence[Path]) -> None:
    """Check that a folder without a sweep contains a single file with records, so that none is ignored."""
    if len(files) < 2:
        return
    raise StoreError(
        f"{directory}: contains {len(files):,} files with records and is not the folder of a sweep; name the"
        f" files, such as {files[0]}"
    )


def newest_directory() -> Path:
    """The folder below ``results/`` that was swept last."""
    finished = list(RESULTS.glob("*/[!.]*.h5"))
    folders = {file.parent for file in finished}
    requested = [file for file in RESULTS.glob(f"*/{REQUEST_FILE}") if file.parent not in folders]
    files = finished + requested
    if not files:
        raise ReportError(f"no experiment file in {RESULTS}/*; run 'hydrofdi sweep CONFIG' first")
    return max(files, key=lambda file: file.stat().st_mtime_ns).parent


def read_results(place: Path | None = None) -> ExperimentData:
    """An experiment as far as it is stored."""
    if place is not None and not place.is_dir():
        if not place.exists():
            own, folders = RESULTS / place, [str(folder) for folder in sorted(RESULTS.glob("*/"))]
            meant = f"; did you mean '{own}'?" if own.exists() else similar(place.name, folders)
            raise StoreError(f"{place}: no such file{meant}")
        return read_experiment(place)
    directory = newest_directory() if place is None else place
    if (directory / REQUEST_FILE).exists():
        return _read_requested(directory)
    files = results_files(directory)
    if not files:
        raise ReportError(f"no experiment file in {directory}; run 'hydrofdi sweep CONFIG' first")
    require_single(directory, files)
    return read_experiment(files[0])


def _read_requested(directory: Path) -> ExperimentData:
    """What the latest sweep on a folder has stored: from its file, or else from the shards."""
    experiment = read_request(directory)
    file = experiment_file(directory, experiment)
    data = _read_same(file, directory)
    if data is not None and data.is_whole and data.physics_version == PHYSICS_VERSION:
        return data
    index = read_index(directory)
    if file.exists() and not index.runs:
        return read_experiment(file)
    physics_version = max(index.physics_versions, default=PHYSICS_VERSION)
    if data is not None and data.is_whole and data.physics_version >= physics_version:
        return data
    return _read_shards(experiment, file, index, physics_version)


def _read_same(file: Path, directory: Path) -> ExperimentData | None:
    """The experiment file, if it is sound and holds the latest request of the folder."""
    try:
        data = read_experiment(file)
    except StoreError:
        return None
    return data if data.configuration == request_record(directory)[0] else None


def stored_run_ids(directory: Path, experiment: ExperimentConfig) -> tuple[str, ...] | None:
    """The identities of all runs in the latest request; None if only its indicators tell."""
    data = _read_same(experiment_file(directory, experiment), directory)
    if data is not None:
        return tuple(map(str, data.columns[RUN_ID]))
    runs = _stored_table(experiment, directory).runs
    return run_identities(runs) if runs.choice.stored_identity else None


def _stored_table(experiment: ExperimentConfig, directory: Path) -> RunTable:
    """The runs of a stored experiment, whose plug-ins are not needed."""
    table = expand_runs(experiment)
    choice = replace(table.runs.choice, stored_identity=request_record(directory)[1])
    return replace(table, runs=replace(table.runs, choice=choice))


def _read_shards(
    experiment: ExperimentConfig, file: Path, index: ShardIndex, physics_version: int
) -> ExperimentData:
    """The runs of an experiment as far as their shards go; those without a result contain the reason."""
    table = _stored_table(experiment, file.parent)
    run_ids = run_identities(table.runs, physics_version)
    results = ShardResults(run_ids, index, read_failures(file.parent))
    columns = {variable.name: values for variable, values in columns_of(results, table).items()}
    data = ExperimentData(
        file, experiment, columns, library_versions(), results, physics_version=physics_version
    )
    if index.runs and index.runs.keys().isdisjoint(run_ids):
        remark = (
            f"None of the {counted(len(index.runs), 'stored run')} is one of this experiment: the request or "
            f"a default has changed since then; 'hydrofdi sweep' computes the current request."
        )
        data = replace(data, remarks=(remark,))
    return data


def rows_named(wanted: str, run_ids: Sequence[str], record_ids: Sequence[str], place: str) -> Sequence[int]:
    """Rows of runs that a position, a range such as ``3-9``, or the beginning of an identity names."""
    if wanted.isdecimal() and wanted not in (*run_ids, *record_ids):
        if int(wanted) < len(run_ids):
            return [int(wanted)]
        if not any(each.startswith(wanted) for each in (*run_ids, *record_ids)):
            raise StoreError(f"{place}: has no row {wanted}, but rows 0 to {len(run_ids) - 1}")
    if ends := _RANGE.fullmatch(wanted):
        first, last = map(int, ends.groups())
        if first > last:
            raise StoreError(f"{place}: the range {wanted} runs backwards; write {last}-{first}")
        if last < len(run_ids):
            return range(first, last + 1)
    of_record = {record_id: row for row, record_id in reversed([*enumerate(record_ids)])}
    rows = [row for row, run_id in enumerate(run_ids) if run_id.startswith(wanted)]
    rows = rows or [row for record_id, row in of_record.items() if record_id.startswith(wanted)]
    if len(rows) != 1:
        found = counted(len(rows), "run") if rows else "no run"
        raise StoreError(f"{place}: has {found} whose identity begins with {wanted!r}")
    return rows


def library_versions() -> dict[str, str]:
    """Versions of hydrofdi, Python and the libraries that numbers depend on."""
    versions = {name: version(name) for name in _LIBRARIES}
    return versions | {"hydrofdi": __version__, "python": platform.python_version()}


def external_coefficients(data: ExperimentData) -> NDArray[np.float64]:
    """K_e of chamber 1 and 2 of each run [m³/(s·Pa)], shape (n_run, 2)."""
    either, *own = (data.values(f"leakage.external_coefficient{chamber}") for chamber in ("", "_1", "_2"))
    rows = [
        [common if value is None else value for value, common in zip(values, either, strict=True)]
        for values in own
    ]
    return np.array(rows, dtype=float).T
