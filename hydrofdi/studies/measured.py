"""Study from measured records with labels and groups."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures
from hydrofdi.settings.messages import similar
from hydrofdi.studies.records import Scored, StudyDesign, StudyRecords

SEED = 0
"""Seed of the random split of healthy records without groups."""


def measured_study(
    columns: Sequence[MeasuredOutput],
    measured: Iterable[RecordMeasures],
    healthy: Collection[str],
    severity: Mapping[str, float],
) -> StudyDesign:
    """Build a study of healthy and faulty records from their labels.

    With groups, all healthy records are fit records, and each healthy group is tested at the threshold of the
    others. With fewer than two healthy groups, healthy records are split into random halves, with a remark.

    Parameters
    ----------
    measured : iterable of RecordMeasures
        Measured records; rejected records and records without a label are omitted.
    healthy : collection of str
        Labels of healthy records; all others are faulty.
    severity : mapping of str to float
        Label → severity of the fault [m³/s], if known.
    """
    labelled = [record for record in measured if record.label and not record.is_rejected]
    found = dict.fromkeys(record.label for record in labelled)
    if not found:
        raise ConfigError("no record has a label; set 'label:' in the description")
    if not healthy:
        raise ConfigError(f"{WHICH}; found {', '.join(map(repr, sorted(found)[:10]))}")
    require_labels((("healthy", label) for label in healthy), found)
    is_healthy = np.array([record.label in healthy for record in labelled])
    groups = _groups(labelled)
    has_groups = groups is not None and len({groups[row] for row in np.flatnonzero(is_healthy)}) > 1
    faults = {
        label: Population(label, Kind.FAULT, severity=severity.get(label, 0.0))
        for label in found
        if label not in healthy
    }
    fit = Population("healthy" if has_groups else "healthy (fit)", Kind.HEALTHY, is_fit=True)
    tested = () if has_groups else (Population("healthy", Kind.HEALTHY),)
    populations = (fit, *tested, *faults.values())
    of_label = {label: populations.index(fault) for label, fault in faults.items()}
    of_record = np.array([of_label.get(record.label, 0) for record in labelled], dtype=np.intp)
    if not has_groups:
        rows = np.random.default_rng(SEED).permutation(np.flatnonzero(is_healthy))
        of_record[rows[: rows.size // 2]] = 1
    known = {**severity, **dict.fromkeys(healthy, 0.0)}
    severities = np.array([known.get(record.label, np.nan) for record in labelled])
    remarks = [*([] if has_groups else [_split_remark(groups)]), *_confounded(groups, is_healthy)]
    records = StudyRecords(
        populations, of_record, severities, groups=groups, remarks=tuple(remarks), is_labelled=True
    )
    return StudyDesign(records, tuple(_scores(columns, labelled)))


WHICH = "which records are healthy? State it: --healthy LABEL, or 'healthy: [LABEL]' in the description"


def require_labels(stated: Iterable[tuple[str, str]], found: Collection[str]) -> None:
    """Check that records have every label that is stated."""
    known = sorted({*found} - {""})
    names = ", ".join(map(repr, known[:10])) or "none"
    mistakes = [
        Issue(f"no record has the label {label!r}; found {names}{similar(label, known)}", key)
        for key, label in stated
        if label not in found
    ]
    if mistakes:
        raise ConfigError(mistakes)


def _groups(records: Sequence[RecordMeasures]) -> tuple[str, ...] | None:
    """Groups of records; a record without a group is its own group."""
    if not any(record.group for record in records):
        return None
    return tuple(record.group or f"record {record.record_id}" for record in records)


def _split_remark(groups: Sequence[str] | None) -> str:
    why = "no record has a group" if groups is None else "there is only one healthy group"
    return (
        f"{why}: healthy records are split into random halves (seed {SEED}): one sets thresholds, the other"
        " is tested; false alarms on another unit or day are unknown"
    )


def _confounded(groups: Sequence[str] | None, is_healthy: NDArray[np.bool_]) -> Iterator[str]:
    if groups is None or is_healthy.all():
        return
    healthy = {group for group, is_sound in zip(groups, is_healthy, strict=True) if is_sound}
    faulty = {group for group, is_sound in zip(groups, is_healthy, strict=True) if not is_sound}
    if not healthy & faulty:
        yield (
            "no group has both healthy and faulty records: they may differ only by unit or day;"
            " compare areas with those of healthy groups against each other"
        )


def _scores(columns: Sequence[MeasuredOutput], records: Sequence[RecordMeasures]) -> Iterator[Scored]:
    """All numbers that at least one record has."""
    for column in (column for column in columns if column.output.is_score):
        shape = tuple(column.output.dims.values())
        nothing = np.full(shape, np.nan)
        values = np.array([record.values.get(column.name, nothing) for record in records], dtype=float)
        for place in np.ndindex(shape):
            own = values[(slice(None), *place)]
            if np.isfinite(own).any():
                yield Scored(
                    f"{column.name}{''.join(f'[{part}]' for part in place)}",
                    own,
                    tuple(channel.value for channel in column.channels),
                    column.unit,
                    column.output.long_name,
                    column.output.direction,
                )
