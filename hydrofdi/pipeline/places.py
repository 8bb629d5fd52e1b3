"""Where experiments lie, and what they were made with."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

import hydrofdi
from hydrofdi.config import ExperimentConfig
from hydrofdi.errors import ReportError

RESULTS = Path("results")
"""Folder for experiments, below the working directory."""

_LIBRARIES = ("h5py", "numba", "numpy", "pywavelets", "scipy")


def experiment_directory(experiment: ExperimentConfig, out: Path | None = None) -> Path:
    """Folder of an experiment: `out`, or ``results/<name>``."""
    return RESULTS / experiment.name if out is None else out


def experiment_file(directory: Path) -> Path:
    """The experiment file in its folder."""
    return directory / f"{directory.resolve().name}.h5"


def newest_experiment_file(directory: Path | None) -> Path:
    """The experiment file in a folder, or the newest one below ``results/``.

    Parameters
    ----------
    directory : Path or None
        A folder, or an experiment file itself.

    Raises
    ------
    ReportError
        There is none.
    """
    if directory is not None and not directory.is_dir():
        return directory
    pattern, root = ("*/*.h5", RESULTS) if directory is None else ("*.h5", directory)
    files = [file for file in root.glob(pattern) if not file.name.startswith(".")]
    if files:
        return max(files, key=lambda file: file.stat().st_mtime_ns)
    if directory is not None and (directory / "experiment.json").exists():
        raise ReportError(f"{directory}: the sweep has not ended; run 'hydrofdi collect {directory}' first")
    where = f"{root}/*" if directory is None else str(directory)
    raise ReportError(f"no experiment file in {where}; run 'hydrofdi sweep CONFIG' first")


def library_versions() -> dict[str, str]:
    """Versions of hydrofdi, Python and the libraries that numbers depend on."""
    versions = {name: version(name) for name in _LIBRARIES}
    return versions | {"hydrofdi": hydrofdi.__version__, "python": platform.python_version()}
