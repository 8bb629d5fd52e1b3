"""The healthy records of any sources, and what studies and training leave out of them, counted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.runs import study_roles
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.scores import Kind
from hydrofdi.indicators.measuring import Counted, RecordMeasures
from hydrofdi.records import RecordBatch, RecordSource
from hydrofdi.records.copies import Copies, pairs, sketch_of
from hydrofdi.records.source import MeasuredSource
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.results import external_coefficients
from hydrofdi.studies.reading import WHICH, require_labels, stored_roles

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
    """Records that teach nothing: with another label, with a leak, and of a study all but the healthy fit
    records (``n_leaking``); without a label among labelled ones; not usable at all; with the samples of
    another.
    """

    n_leaking: int = 0
    n_unlabelled: int = 0
    n_rejected: int = 0
    n_repeated: int = 0
    first_rejection: str = ""
    repeats: list[str] = field(default_factory=list)


@dataclass
class HealthyRecords:
    """Healthy records of several sources, each record once; or, if ``is_faulty``, the others: those with
    another label, runs with a leak, faulty fit records of a study. What is taken and left out is counted
    while the batches are read. ``healthy``: labels of healthy records, beside those that descriptions name.
    """

    sources: Sequence[RecordSource]
    healthy: Sequence[str] = ()
    is_faulty: bool = False
    n_taken: int = 0
    left_out: LeftOut = field(default_factory=LeftOut)

    @property
    def name(self) -> str:
        """All of them."""
        return ", ".join(source.name for source in self.sources)

    @property
    def data_sheet(self) -> Mapping[str, Any]:
        """That of the first."""
        return self.sources[0].data_sheet

    @property
    def is_unlabelled(self) -> bool:
        """Whether all records are taken as healthy because nothing is known of any."""
        return not any(_is_labelled(source) for source in self.sources)

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """Healthy records."""
        self.n_taken, self.left_out, labels_seen = 0, LeftOut(), set[str]()
        copies, names = Copies(), list[str]()
        for source in self.sources:
            for batch in self._of_source(source, labels_seen):
                self.left_out.n_rejected += len(batch.rejected)
                for each in batch.rejected[:1]:
                    first = f"{each.record_id}: {each.remark.message}"
                    self.left_out.first_rejection = self.left_out.first_rejection or first
                distinct = self._distinct(batch, copies, names, is_near=isinstance(source, MeasuredSource))
                self.n_taken += distinct.n_record
                if distinct.n_record:
                    yield distinct if labels else replace(distinct, labels=None)
        require_labels((("healthy", label) for label in self.healthy), labels_seen)

    def _of_source(self, source: RecordSource, labels_seen: set[str]) -> Iterator[RecordBatch]:
        experiment = experiment_of(source)
        if experiment is None:
            for batch in source.batches(labels=True):
                labels_seen |= set(batch.labels or ())
                yield self._healthy(source, batch)
            return
        runs: Any = source
        are_meant, groups = _runs(runs, experiment, is_faulty=self.is_faulty)
        self.left_out.n_leaking += int(np.sum(~are_meant))
        only = np.flatnonzero(are_meant).tolist()
        for batch in analysed_batches(replace(runs, only=only), labels=True):
            if groups is None:
                yield batch
            else:
                named = (STUDY_LABEL,) * batch.n_record
                own = tuple(groups.get(record_id, "") for record_id in batch.record_ids)
                yield replace(batch, labels=named, groups=own)

    def _healthy(self, source: RecordSource, batch: RecordBatch) -> RecordBatch:
        if not _is_labelled(source):
            return batch.rows([]) if self.is_faulty else batch
        names = {*labels_of_healthy(source), *self.healthy}
        if not names:
            raise ConfigError(f"{source.name}: {WHICH}")
        labels = batch.labels or ("",) * batch.n_record
        rows = [row for row, label in enumerate(labels) if (label in names) != self.is_faulty and label]
        n_unlabelled = sum(not label for label in labels)
        self.left_out.n_unlabelled += n_unlabelled
        self.left_out.n_leaking += batch.n_record - len(rows) - n_unlabelled
        return replace(batch.rows(rows), rejected=batch.rejected)

    def _distinct(
        self, batch: RecordBatch, copies: Copies, names: list[str], *, is_near: bool
    ) -> RecordBatch:
        rows, left = [], self.left_out
        for row, record_id in enumerate(batch.record_ids):
            number, source = copies.find(sketch_of(batch, row, is_near=is_near)), batch.sources[row]
            if number is None:
                names.append(record_id if record_id == source else f"{source} {record_id}")
                rows.append(row)
            else:
                left.n_repeated += 1
                left.repeats.append(f"{record_id} repeats {names[number]}")
        return batch if len(rows) == batch.n_record else batch.rows(rows)


def labels_of_healthy(source: RecordSource) -> tuple[str, ...]:
    """Labels that a source itself calls healthy."""
    return source.config.healthy if isinstance(source, MeasuredSource) else ()


def _runs(
    source: Any, experiment: ExperimentConfig, *, is_faulty: bool
) -> tuple[NDArray[np.bool_], dict[str, str] | None]:
    """Whether each run of an experiment is healthy (or faulty), and the groups of the records of a study.

    Of a study, its fit records in the first design are; of others, all runs without a leak (or with one).
    """
    if experiment.study is not None:
        roles = stored_roles(source.data) if isinstance(source, StoredRecords) else study_roles(experiment)
        kind = Kind.FAULT if is_faulty else Kind.HEALTHY
        are_fit = np.array([each.kind is kind and each.is_fit for each in roles.populations])
        groups: dict[str, str] = {}
        if roles.actuators is not None:
            groups = dict(zip(source.record_ids, roles.actuators, strict=True))
        return are_fit[roles.of_run] & (roles.design_of_run == 0), groups
    if isinstance(source, StoredRecords):
        leaks = [source.data.leakage_requests, *zip(*external_coefficients(source.data), strict=True)]
    else:
        leaks = [source.runs.values(f"leakage.{name}") for name in _LEAKS]
    are_leaking = np.array([any(of_run) for of_run in zip(*leaks, strict=True)], dtype=bool)
    return are_leaking if is_faulty else ~are_leaking, None


def experiment_of(source: RecordSource) -> ExperimentConfig | None:
    """The experiment behind simulated records; None of measured ones."""
    return (
        source.data.experiment if isinstance(source, StoredRecords) else getattr(source, "experiment", None)
    )


def is_of_study(source: RecordSource) -> bool:
    """Whether records are those of a study."""
    experiment = experiment_of(source)
    return experiment is not None and experiment.study is not None


def analysed_batches(source: RecordSource, *, labels: bool = False) -> Iterator[RecordBatch]:
    """Batches of a source; of a study, without the samples that its analysis discards."""
    experiment = experiment_of(source)
    n_discarded = 0
    if experiment is not None and experiment.study is not None:
        n_discarded = experiment.nominal_parameters.n_discarded
    for batch in source.batches(labels=labels):
        yield batch.window(n_discarded) if n_discarded else batch


def _is_labelled(source: RecordSource) -> bool:
    return source.is_labelled if isinstance(source, MeasuredSource) else True


@dataclass
class Left(Counted):
    """Records that are not evaluated: also repeats of another, and those without a label."""

    n_repeated: int = 0
    n_unlabelled: int = 0
    repeats: list[str] = field(default_factory=list)
    labels: set[str] = field(default_factory=set)
    _copies: Copies = field(default_factory=Copies)
    _firsts: list[RecordMeasures] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, without those that repeat the samples of another."""
        for record in super().count(records):
            self.labels |= {record.label} - {""}
            if record.has_numbers and self._is_repeat(record):
                continue
            self.n_unlabelled += not (record.is_rejected or record.label)
            yield replace(record, sketch=None)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records that are left out."""
        yield from super().sentences()
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_repeated:
            yield f"left out: {self.n_repeated:,} {of} have the samples of another: {pairs(self.repeats)}"
        if self.n_unlabelled:
            yield f"without a label, left out: {self.n_unlabelled:,} {of}"

    def _is_repeat(self, record: RecordMeasures) -> bool:
        if record.sketch is None:
            return False
        number = self._copies.find(record.sketch)
        if number is None:
            self._firsts.append(replace(record, values={}))
            return False
        first = self._firsts[number]
        if record.label and first.label and record.label != first.label:
            if first.sketch is None or record.sketch.digest != first.sketch.digest:
                return False  # a fault may have been made of a healthy record
            raise ConfigError(
                f"{first.record_id} ({first.label}) and {record.record_id} ({record.label}) have the same"
                " samples; one of the labels is wrong"
            )
        self.n_repeated += 1
        self.repeats.append(f"{record.record_id} repeats {first.record_id}")
        return True
