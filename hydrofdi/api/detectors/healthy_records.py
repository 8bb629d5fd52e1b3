"""The healthy records of any sources; what is not known to be healthy is left out and counted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.config import expand_runs
from hydrofdi.config.run_table.expansion import study_roles
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.populations import Kind
from hydrofdi.indicators.record_measures import samples_digest
from hydrofdi.records import RecordBatch, RecordSource
from hydrofdi.records.measured.source import HeldSource, MeasuredSource
from hydrofdi.report.runs import external_coefficients
from hydrofdi.settings.messages import nearest
from hydrofdi.store.records import StoredRecords
from hydrofdi.studies.reading import stored_roles

_LEAKS = (
    "internal_flow",
    "internal_coefficient",
    "external_coefficient",
    "external_coefficient_1",
    "external_coefficient_2",
)

STUDY_LABEL = "healthy (fit)"


@dataclass
class LeftOut:
    """Records that teach nothing.

    Attributes
    ----------
    n_leaking : int
        Records with another label, runs with a leak, and of a study all but the healthy fit records.
    n_unlabelled, n_rejected, n_repeated : int
        Without a label among labelled ones, not usable at all, with the samples of another.
    first_rejection, first_repeat : str
    """

    n_leaking: int = 0
    n_unlabelled: int = 0
    n_rejected: int = 0
    n_repeated: int = 0
    first_rejection: str = ""
    first_repeat: str = ""


@dataclass
class HealthyRecords:
    """Healthy records of several sources, each record once.

    Attributes
    ----------
    sources : sequence of RecordSource
    healthy : sequence of str
        Labels of healthy records, beside those that descriptions name.
    left_out : LeftOut
        Counted while the batches are read.
    is_unlabelled : bool
        Whether no source says which of its records are healthy.
    """

    sources: Sequence[RecordSource]
    healthy: Sequence[str] = ()
    left_out: LeftOut = field(default_factory=LeftOut)

    @property
    def name(self) -> str:
        """All of them."""
        return ", ".join(source.name for source in self.sources)

    @property
    def is_unlabelled(self) -> bool:
        """Whether all records are taken as healthy because nothing is known of any."""
        return not any(_is_labelled(source) for source in self.sources)

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """Healthy records.

        Raises
        ------
        ConfigError
            Records have labels, and none is known to mean a healthy one.
        """
        self.left_out, found, seen = LeftOut(), set[str](), dict[bytes, str]()
        for source in self.sources:
            for batch in self._of_source(source, found):
                self.left_out.n_rejected += len(batch.rejected)
                for each in batch.rejected[:1]:
                    first = f"{each.record_id}: {each.remark.message}"
                    self.left_out.first_rejection = self.left_out.first_rejection or first
                distinct = self._distinct(batch, seen)
                if distinct.n_record:
                    yield distinct if labels else replace(distinct, labels=None)
        self._require_found(found)

    def _of_source(self, source: RecordSource, found: set[str]) -> Iterator[RecordBatch]:
        if not isinstance(source, SimulatedRecords | StoredRecords):
            for batch in source.batches(labels=True):
                found |= set(batch.labels or ())
                yield self._healthy(source, batch)
            return
        is_healthy, is_study = _healthy_runs(source)
        self.left_out.n_leaking += int(np.sum(~is_healthy))
        for batch in replace(source, only=np.flatnonzero(is_healthy).tolist()).batches(labels=True):
            yield replace(batch, labels=(STUDY_LABEL,) * batch.n_record) if is_study else batch

    def _healthy(self, source: RecordSource, batch: RecordBatch) -> RecordBatch:
        if not _is_labelled(source):
            return batch
        names = {*labels_of_healthy(source), *self.healthy}
        if not names:
            remedy = "healthy=LABEL, or 'healthy: [LABEL]' in the description"
            raise ConfigError(f"{source.name}: which records are healthy? {remedy}")
        labels = batch.labels or ("",) * batch.n_record
        rows = [row for row, label in enumerate(labels) if label in names]
        n_unlabelled = sum(not label for label in labels)
        self.left_out.n_unlabelled += n_unlabelled
        self.left_out.n_leaking += batch.n_record - len(rows) - n_unlabelled
        return replace(batch.rows(rows), rejected=batch.rejected)

    def _distinct(self, batch: RecordBatch, seen: dict[bytes, str]) -> RecordBatch:
        rows, left = [], self.left_out
        for row, record_id in enumerate(batch.record_ids):
            digest, source = samples_digest(batch, row), batch.sources[row]
            if digest not in seen:
                seen[digest] = record_id if record_id == source else f"{source} {record_id}"
                rows.append(row)
            else:
                left.n_repeated += 1
                left.first_repeat = left.first_repeat or f"{record_id} repeats {seen[digest]}"
        return batch if len(rows) == batch.n_record else batch.rows(rows)

    def _require_found(self, found: set[str]) -> None:
        missing = [label for label in self.healthy if label not in found]
        if missing:
            names = ", ".join(repr(label) for label in sorted(found - {""})[:10]) or "none"
            hint = nearest(missing[0], sorted(found))
            raise ConfigError(f"healthy: no record has the label {missing[0]!r}; found {names}{hint}")


def labels_of_healthy(source: RecordSource) -> tuple[str, ...]:
    """Labels that a source itself calls healthy."""
    return source.config.healthy if isinstance(source, MeasuredSource | HeldSource) else ()


def _healthy_runs(source: SimulatedRecords | StoredRecords) -> tuple[NDArray[np.bool_], bool]:
    """Whether each run of an experiment is healthy, and whether it is one of a study.

    Of a study, its healthy fit records are; of others, all runs without a leak.
    """
    experiment = source.data.experiment if isinstance(source, StoredRecords) else source.experiment
    if experiment.study is not None:
        roles = stored_roles(source.data) if isinstance(source, StoredRecords) else study_roles(experiment)
        are_fit = [each.kind is Kind.HEALTHY and each.is_fit for each in roles.populations]
        return np.array(are_fit)[roles.of_run], True
    if isinstance(source, StoredRecords):
        leaks = [source.data.leakage_requests, *zip(*external_coefficients(source.data), strict=True)]
    else:
        runs = expand_runs(experiment).runs
        leaks = [runs.values(f"leakage.{name}") for name in _LEAKS]
    return ~np.array([any(of_run) for of_run in zip(*leaks, strict=True)], dtype=bool), False


def _is_labelled(source: RecordSource) -> bool:
    return source.is_labelled if isinstance(source, MeasuredSource | HeldSource) else True
