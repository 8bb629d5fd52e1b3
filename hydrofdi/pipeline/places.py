"""Folders of experiments, and the versions that made them."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

import hydrofdi
from hydrofdi.config import ExperimentConfig
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.settings.naming import command, setting
from hydrofdi.store.request import REQUEST_FILE

RESULTS = Path("results")
"""Folder for experiments, below the working directory."""

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
        raise ConfigError(f"{setting('out')}: name a separate folder, not the working directory")
    return out


def experiment_file(directory: Path, experiment: ExperimentConfig) -> Path:
    """The experiment file in its folder."""
    return directory / f"{experiment.name}.h5"


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
        raise ReportError(f"no experiment file in {RESULTS}/*; run {command('sweep CONFIG')} first")
    return max(files, key=lambda file: file.stat().st_mtime_ns).parent


def library_versions() -> dict[str, str]:
    """Versions of hydrofdi, Python and the libraries that numbers depend on."""
    versions = {name: version(name) for name in _LIBRARIES}
    return versions | {"hydrofdi": hydrofdi.__version__, "python": platform.python_version()}
