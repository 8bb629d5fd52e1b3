"""Objects with records, as sources: paths, results, arrays, data frames, datasets."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from hydrofdi.errors import ConfigError, DataError, StoreError
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.memory import held, known_text, records_of
from hydrofdi.records.source import HeldSource, MeasuredSource, measured_source, plain_source
from hydrofdi.settings.arguments import Names, Texts, path_of, positive_of, refusal
from hydrofdi.settings.files import located, ready_hint
from hydrofdi.settings.messages import counted


class Samples(TypedDict, total=False):
    """Keywords on samples in memory."""

    sampling_frequency: str | float | None
    channel: Names
    unit: Names


class LabelledSamples(Samples, total=False):
    """Keywords on samples of several records in memory."""

    label: Texts
    group: Texts


@dataclass(frozen=True)
class Described:
    """Descriptions of data by keywords that `hydrofdi.measure` and others share: of arrays one ``channel``
    and ``unit`` for all columns, or column → name; ``label`` and ``group`` of records in memory;
    ``KEY=VALUE`` ``settings`` of an experiment that is simulated.
    """

    sampling_frequency: str | float | None = None
    channel: Names = None
    unit: Names = None
    label: Texts = None
    group: Texts = None
    settings: Sequence[str] = ()

    @property
    def frequency(self) -> float | None:
        """The sampling frequency [Hz]."""
        given = self.sampling_frequency
        expected = "a number in Hz, or a text such as '1 kHz'"
        return None if given is None else positive_of("sampling_frequency", given, "Hz", expected)


def open_records(
    data: Any, channels: Collection[Channel] = tuple(Channel), said: Described = Described()
) -> list[RecordSource]:
    """The records in files, results or memory: a source for each part of `data`."""
    parts = _parts(data)
    if all(isinstance(each, str | PathLike) for each in parts):
        for name in ("channel", "unit", "label", "group"):
            if getattr(said, name) is not None:
                raise ConfigError(f"{name}: is for arrays; describe files in a YAML file (docs/measured.md)")
        parts = [*{os.path.realpath(each): each for each in parts}.values()]  # a file named twice is one
    numbers = range(1, len(parts) + 1) if len(parts) > 1 else [None]
    found = [_source(each, number, channels, said) for each, number in zip(parts, numbers, strict=True)]
    if all(isinstance(each, MeasuredSource) and not each.config.channels for each in found):
        first = next(iter(found[0].batches())).rejected[0]
        raise DataError(f"{found[0].name}: {first.remark.message}")
    named = iter(_named([source for source in found if isinstance(source, HeldSource)], said))
    return [next(named) if isinstance(source, HeldSource) else source for source in found]


def _parts(data: Any) -> list[Any]:
    """The parts of data: several sources in a list, or a single one."""
    if not isinstance(data, list | tuple) or not data:
        return [data]
    are_whole = [isinstance(each, str | PathLike | Mapping) or _is_whole(each) for each in data]
    is_one_array = not any(are_whole) and len({np.shape(each) for each in data}) == 1
    has_numbers = any(
        np.ndim(each) == 0 for each, is_whole in zip(data, are_whole, strict=True) if not is_whole
    )
    return [data] if is_one_array or has_numbers else list(data)


def _is_whole(data: Any) -> bool:
    """Whether data are more than samples: a frame, a dataset, results, an experiment."""
    return any(hasattr(data, name) for name in ("columns", "coords", "record_source", "model_fields"))


def _source(data: Any, number: int | None, channels: Collection[Channel], said: Described) -> RecordSource:
    if isinstance(data, str | PathLike):
        return _source_at(path_of(data), channels, said)
    if hasattr(data, "record_source"):
        source: RecordSource = data.record_source(channels)
        return source
    config = sys.modules.get("hydrofdi.config")
    if config is not None and isinstance(data, config.ExperimentConfig):
        from hydrofdi.execution.simulated import SimulatedRecords

        return SimulatedRecords(data, data.name, channels)
    table = held(data, number)
    records = records_of(table, said.frequency, said.channel, said.unit)
    if not records.config.channels.keys() & set(channels):
        found = ", ".join(records.config.channels)
        raise DataError(f"{table.place}: has no {' and no '.join(sorted(channels))}; found {found}")
    return records


def _named(sources: Sequence[HeldSource], said: Described) -> list[HeldSource]:
    """Records in memory with labels, groups, and names that differ."""
    n_record = sum(len(source.table.record_ids) for source in sources)
    labels, groups = (_texts(name, getattr(said, name), n_record) for name in ("label", "group"))
    named, first = list[HeldSource](), 0
    for source in sources:
        table, stop = source.table, first + len(source.table.record_ids)
        record_ids = [
            str(row) if len(sources) > 1 and record_id.isdecimal() else record_id
            for row, record_id in enumerate(table.record_ids, first)
        ]
        table = replace(
            table,
            record_ids=record_ids,
            groups=groups[first:stop] or table.groups,
            labels=labels[first:stop] or table.labels,
        )
        named.append(replace(source, table=table))
        first = stop
    return named


def _texts(name: str, given: Texts, n_record: int) -> list[str]:
    """A text for each record; none if nothing is given."""
    if given is None or isinstance(given, str):
        return [] if given is None else [given] * n_record
    if not isinstance(given, Iterable):
        raise refusal(name, "a text, or one for each record", given)
    texts = [known_text(each) for each in given]
    if len(texts) != n_record:
        raise DataError(f"{name}: found {len(texts)}; expected one for each of {counted(n_record, 'record')}")
    return texts


_HEAD_BYTES = 65_536
_FILES = re.compile(rb"^files\s*:", re.MULTILINE)
_MEASURED_KEYS = {"files", "channels"}
"""Keys that a description of measured files has, and an experiment has not."""


def _source_at(path: Path, channels: Collection[Channel], said: Described) -> RecordSource:
    """Records of results, an experiment, a description of measured files, a data file, or a folder."""
    name, path, frequency = str(path), path if path.is_dir() else located(path), said.frequency
    kind = kind_of(path)
    if frequency is not None and kind != "measured":
        raise ConfigError(f"sampling_frequency: {path} states its own; the option is for a plain data file")
    if said.settings and kind != "experiment":
        raise ConfigError(f"settings (--set): {path} is not simulated; they are for an experiment file")
    if kind == "results":
        from hydrofdi.store.experiment_data import StoredRecords
        from hydrofdi.store.results import read_results

        return StoredRecords(read_results(path), str(path), channels)
    if kind == "experiment":
        from hydrofdi.config import load_experiment
        from hydrofdi.execution.simulated import SimulatedRecords

        return SimulatedRecords(load_experiment(path, said.settings), name, channels)
    return measured_source(path) if kind == "description" else plain_source(path, frequency)


def kind_of(path: Path) -> str:
    """What stands at a path: ``results``, an ``experiment``, a ``description``, or ``measured`` files."""
    if path.is_dir():
        return _kind_of_folder(path)
    if not path.exists():
        raise DataError(f"{path}: no such file or folder{ready_hint(path)}")
    if not path.is_file():  # opening a pipe without a writer would wait for ever
        raise DataError(f"{path}: is not a regular file")
    head = _head(path)
    if head.startswith(b"\x89HDF\r\n\x1a\n") and _is_experiment(path):
        return "results"
    if path.suffix.lower() in (".yaml", ".yml"):
        from hydrofdi.settings.files import read_yaml

        keys = set(read_yaml(path, "a description of measured files or an experiment").data or {})
        return "description" if keys & _MEASURED_KEYS else "experiment"
    return "measured"


def _kind_of_folder(path: Path) -> str:
    from hydrofdi.records.source import plain_files
    from hydrofdi.store.folder import REQUEST_FILE
    from hydrofdi.store.results import require_single, results_files

    is_sweep, results = (path / REQUEST_FILE).exists(), results_files(path)
    if results and not is_sweep:
        require_single(path, [*results, *plain_files(path)])
    if results or is_sweep:
        return "results"
    if within := sorted(file.parent for file in path.glob(f"*/{REQUEST_FILE}")):
        raise DataError(f"{path}: contains results folders; name one, for example {within[0]}")
    if descriptions := [file for file in sorted(path.glob("*.y*ml")) if _FILES.search(_head(file))]:
        raise DataError(f"{path}: contains a description of measured files; name it: {descriptions[0]}")
    return "measured"


def _is_experiment(path: Path) -> bool:
    from hydrofdi.store.files import is_experiment_file
    from hydrofdi.store.shards import SHARDS

    if path.parent.name == SHARDS:
        raise StoreError(f"{path}: is a shard; name the folder of its experiment, {path.parent.parent}")
    return is_experiment_file(path)


def _head(path: Path) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read(_HEAD_BYTES)
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror}") from None
