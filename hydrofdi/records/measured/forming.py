"""Which files match, the names in their paths, and batches of their records."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path, PurePath, PurePosixPath

import numpy as np

from hydrofdi.records.batch import RecordBatch, RejectedRecord
from hydrofdi.records.measured.recording import Recording

_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
OWN_NAMES = ("folder", "file", "direction")
"""Names that every record has."""


def path_pattern(template: str) -> re.Pattern[str]:
    """The regular expression of a template of paths."""
    if not template or "(?P<" in template:
        return re.compile(f"(?:{template})$" if template else "")
    pieces = _FIELD.split(template)
    texts, names = [re.escape(piece) for piece in pieces[::2]], pieces[1::2]
    # a name ends where the text behind it first occurs; only the last one may have to look further
    fields = [f"(?P<{name}>[^/](?:(?!{text})[^/])*+)" for name, text in zip(names, texts[1:], strict=True)]
    fields[-1:] = [f"(?P<{name}>[^/]+?)" for name in names[-1:]]
    return re.compile("".join(a + b for a, b in zip(texts, [*fields, ""], strict=True)) + "$")


def names_of_path(place: str, pattern: re.Pattern[str]) -> dict[str, str] | None:
    """Name → value in a path; None if it does not match."""
    match = pattern.search(place)
    if match is None:
        return None
    path = PurePosixPath(place)
    own = {"folder": path.parent.name, "file": path.name}
    return own | {name: value or "" for name, value in match.groupdict().items()}


def fields_of(template: str) -> list[str]:
    """Names in braces in a template."""
    return _FIELD.findall(template)


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with its names replaced."""
    return _FIELD.sub(lambda match: values[match[1]], template)


MOST_SAMPLES = 2**22
"""Most samples, over all channels, of a batch with more than one record: 32 MiB."""


def batched(
    records: Iterable[Recording | RejectedRecord],
    drive_period: float | None,
    labels: bool,
    most_samples: int = MOST_SAMPLES,
) -> Iterator[RecordBatch]:
    """Batches of consecutive records that fit together; rejected records come with the next batch.

    A batch of more than one record has at most `most_samples` over all channels.
    """
    waiting: list[Recording] = []
    rejected: list[RejectedRecord] = []
    for record in records:
        if isinstance(record, RejectedRecord):
            rejected.append(record if labels else replace(record, label=""))
            continue
        n_sample = (len(waiting) + 1) * record.n_time * len(record.channels)
        if waiting and (_shape(record) != _shape(waiting[0]) or n_sample > most_samples):
            yield _batch(waiting, rejected, drive_period, labels)
            waiting, rejected = [], []
        waiting.append(record)
    if waiting or rejected:
        yield _batch(waiting, rejected, drive_period, labels)


def _shape(record: Recording) -> Hashable:
    return record.n_time, record.sampling_frequency, record.start_time, record.relative


def _batch(
    records: list[Recording],
    rejected: list[RejectedRecord],
    drive_period: float | None,
    labels: bool,
) -> RecordBatch:
    if not records:
        return RecordBatch({}, 1.0, (), rejected=tuple(rejected), labels=() if labels else None)
    first = records[0]
    return RecordBatch(
        channels={
            channel: np.stack([record.channels[channel] for record in records])
            if len(records) > 1
            else first.channels[channel][np.newaxis]
            for channel in first.channels
        },
        sampling_frequency=first.sampling_frequency,
        start_time=first.start_time,
        record_ids=tuple(record.record_id for record in records),
        sources=tuple(record.source for record in records),
        groups=tuple(record.group for record in records),
        drive_period=drive_period,
        relative=first.relative,
        normalized=first.normalized,
        remarks=tuple(record.remarks for record in records),
        rejected=tuple(rejected),
        units={channel: frozenset(record.units[channel] for record in records) for channel in first.units},
        labels=tuple(record.label for record in records) if labels else None,
        dates=tuple(record.date for record in records),
    )


_DIGITS = re.compile(r"(\d+)")


def matching_files(folder: Path, pattern: str) -> list[Path]:
    """Files that match a pattern relative to a folder, in natural order: run 2 before run 10.

    Leading parts of the pattern that exist literally are taken literally, including brackets and stars.
    """
    parts = PurePath(pattern).parts
    literal = 0
    while literal < len(parts) and os.path.lexists(folder.joinpath(*parts[: literal + 1])):
        literal += 1
    start = folder.joinpath(*parts[:literal])
    if literal == len(parts):
        return [start] if start.is_file() else []
    found = glob.glob(os.path.join(*parts[literal:]), root_dir=start, recursive=True)
    return in_natural_order(start / name for name in found if (start / name).is_file())


def in_natural_order(paths: Iterable[Path]) -> list[Path]:
    """Paths in natural order: numbers in them are sorted by value."""
    return sorted(paths, key=lambda path: _natural(path.as_posix()))


def _natural(text: str) -> tuple[list[tuple[str, int]], str]:
    pieces = _DIGITS.split(text)
    numbers = [int(piece) for piece in pieces[1::2]] + [0]
    return list(zip(pieces[::2], numbers, strict=True)), text
