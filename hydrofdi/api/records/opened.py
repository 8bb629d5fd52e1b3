"""What a path on the command line means as a source of records: its content decides, not its name."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

from hydrofdi.errors import ConfigError, DataError, StoreError
from hydrofdi.records import Channel, RecordSource
from hydrofdi.settings.ready import located, ready_hint, warn_if_shadowing

_HEAD_BYTES = 65_536
_KEY = re.compile(r"[A-Za-z_][\w.]*\s*:(\s|$)|---\s*$|\{")
"""How the first line of a YAML file with settings begins."""

_FILES = re.compile(rb"^files\s*:", re.MULTILINE)
_MEASURED_KEYS = {"files", "channels"}
"""Keys that a description of measured files has, and an experiment has not."""


def open_source(
    path: Path,
    channels: Collection[Channel] = tuple(Channel),
    sampling_frequency: float | None = None,
    settings: Sequence[str] = (),
) -> RecordSource:
    """Records of results, an experiment, a description of measured files, a data file, or a folder of them.

    Parameters
    ----------
    path : Path
        Or the name of a ready configuration.
    channels : collection of Channel
        What is needed of simulated records; the others are not read.
    sampling_frequency : float, optional
        Of a measured file by itself [Hz].
    settings : sequence of str
        ``KEY=VALUE`` of an experiment that is simulated.

    Raises
    ------
    ConfigError
        A YAML file has mistakes, a sampling frequency is given where the source has its own, or settings
        if nothing is simulated.
    DataError
        The file cannot be a source.
    StoreError
        Results cannot be read.
    """
    if path.is_dir():
        warn_if_shadowing(path, path)
        _refuse_settings(path, settings)
        return _folder(path, channels, sampling_frequency)
    name, path = str(path), located(path)
    if not path.exists():
        raise DataError(f"{path}: no such file or folder{ready_hint(path)}")
    head = _head(path)
    if head.startswith(b"\x89HDF\r\n\x1a\n") and _is_experiment(path):
        _refuse_frequency(path, sampling_frequency)
        _refuse_settings(path, settings)
        return _stored(path, channels)
    if path.suffix.lower() in (".yaml", ".yml") or _is_settings(head):
        _refuse_frequency(path, sampling_frequency)
        return _described(path, name, channels, settings)
    _refuse_settings(path, settings)
    from hydrofdi.records.measured import plain_file_source

    return plain_file_source(path, sampling_frequency)


def _folder(path: Path, channels: Collection[Channel], sampling_frequency: float | None) -> RecordSource:
    from hydrofdi.api.stored import require_single, results_files
    from hydrofdi.records.measured import plain_files, plain_folder_source
    from hydrofdi.store.request import REQUEST_FILE

    is_sweep, results = (path / REQUEST_FILE).exists(), results_files(path)
    if results and not is_sweep:
        require_single(path, [*results, *plain_files(path)])
    if results or is_sweep:
        _refuse_frequency(path, sampling_frequency)
        return _stored(path, channels)
    within = sorted(file.parent for file in path.glob(f"*/{REQUEST_FILE}"))
    if within:
        raise DataError(f"{path}: contains results folders; name one, for example {within[0]}")
    if descriptions := [file for file in sorted(path.glob("*.y*ml")) if _FILES.search(_head(file))]:
        raise DataError(f"{path}: contains a description of measured files; name it: {descriptions[0]}")
    if found := plain_folder_source(path, sampling_frequency):
        return found
    raise DataError(
        f"{path}: contains no results of hydrofdi and no measured files such as .csv; describe other measured"
        " files in a YAML (docs/measured.md)"
    )


def _stored(path: Path, channels: Collection[Channel]) -> RecordSource:
    from hydrofdi.api.stored import read_results
    from hydrofdi.store.records import StoredRecords

    return StoredRecords(read_results(path), str(path), channels)


def _is_experiment(path: Path) -> bool:
    from hydrofdi.store.files import is_experiment_file
    from hydrofdi.store.shard import SHARDS

    if path.parent.name == SHARDS:
        raise StoreError(f"{path}: is a shard; name the folder of its experiment, {path.parent.parent}")
    return is_experiment_file(path)


def _described(path: Path, name: str, channels: Collection[Channel], settings: Sequence[str]) -> RecordSource:
    from hydrofdi.settings.validation import read_yaml

    keys = set(read_yaml(path, "a description of measured files or an experiment").data or {})
    if keys & _MEASURED_KEYS:
        _refuse_settings(path, settings)
        from hydrofdi.records.measured import measured_source

        return measured_source(path)
    from hydrofdi.api.records.simulated import SimulatedRecords
    from hydrofdi.config import load_experiment

    return SimulatedRecords(load_experiment(path, settings), name, channels)


def _refuse_frequency(path: Path, sampling_frequency: float | None) -> None:
    if sampling_frequency is not None:
        raise ConfigError(f"sampling_frequency: {path} states its own; the option is for a plain data file")


def _refuse_settings(path: Path, settings: Sequence[str]) -> None:
    if settings:
        raise ConfigError(f"settings: {path} is not simulated; settings are for an experiment file")


def _head(path: Path) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read(_HEAD_BYTES)
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror}") from None


def _is_settings(head: bytes) -> bool:
    """Whether a file is YAML with keys; measured data may begin with such lines, but do not go on so."""
    from hydrofdi.settings.yaml_source import parse_yaml

    is_whole = len(head) < _HEAD_BYTES
    try:
        text = head.decode("utf-8", errors="strict" if is_whole else "ignore")
    except UnicodeDecodeError:
        return False
    lines = (line for line in text.splitlines() if line.strip() and not line.startswith("#"))
    begins_so = _KEY.match(next(lines, "")) is not None
    return begins_so and (not is_whole or isinstance(parse_yaml(text, "").data, dict))
