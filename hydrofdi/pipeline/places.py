"""Folders of experiments, and the versions that made them."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import hydrofdi
from hydrofdi.config import ExperimentConfig
from hydrofdi.errors import ConfigError, ReportError, StoreError
from hydrofdi.store.request import REQUEST_FILE

RESULTS = Path("results")
"""Folder for experiments, below the working directory."""

_MOST_SHOWN = 6

_LIBRARIES = ("h5py", "numba", "numpy", "pywavelets", "scipy")


def experiment_directory(experiment: ExperimentConfig, out: Path | None = None) -> Path:
    """Folder of an experiment: `out`, or ``results/<name>``.

    Raises
    ------
    ConfigError
        `out` is the working directory itself.
    """
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
    """Check that a folder without a sweep contains a single file with records, so that none is ignored.

    Raises
    ------
    StoreError
        It contains several files.
    """
    if len(files) < 2:
        return
    names = [file.name for file in files]
    shown = names if len(names) <= _MOST_SHOWN else [*names[: _MOST_SHOWN - 1], "…", names[-1]]
    raise StoreError(
        f"{directory}: contains {len(files):,} files with records ({', '.join(shown)}) and is not the folder"
        f" of a sweep; name the files, such as {files[0]}"
    )


def newest_directory() -> Path:
    """The folder below ``results/`` that was swept last.

    Raises
    ------
    ReportError
        There is none.
    """
    finished = list(RESULTS.glob("*/[!.]*.h5"))
    folders = {file.parent for file in finished}
    requested = [file for file in RESULTS.glob(f"*/{REQUEST_FILE}") if file.parent not in folders]
    files = finished + requested
    if not files:
        raise ReportError(f"no experiment file in {RESULTS}/*; run 'hydrofdi sweep CONFIG' first")
    return max(files, key=lambda file: file.stat().st_mtime_ns).parent


def library_versions() -> dict[str, str]:
    """Versions of hydrofdi, Python and the libraries that numbers depend on."""
    versions = {name: version(name) for name in _LIBRARIES}
    return versions | {"hydrofdi": hydrofdi.__version__, "python": platform.python_version()}
