"""Studies as records and scores: of stored runs, and of measured records with labels and groups."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.machine import flow_at_reference
from hydrofdi.config.request import parameter_unit
from hydrofdi.config.runs import study_roles
from hydrofdi.config.study import DetectionConfig, StudyTable
from hydrofdi.detectors.rules import CHANGE, ScoreConfig, belongs, combined_numbers, make_score, score_kind
from hydrofdi.detectors.scores.contract import EXTRA, Score, cross_fitted_scores, has_extra, known_numbers
from hydrofdi.errors import ConfigError, Issue, NotStatedError, ReportError
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.indicators import Indicator, Output
from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures
from hydrofdi.records import Channel
from hydrofdi.settings.messages import counted, similar
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL, ExperimentData
from hydrofdi.store.folder import read_costs
from hydrofdi.store.names import LEAKAGE_COEFFICIENT, MEAN_LEAKAGE_FLOW, MISSING, OBSTACLE, STATUS
from hydrofdi.studies.records import Scored, StudyRecords


def within(scored: Scored, sensors: Collection[str]) -> bool:
    """Whether a score needs only these sensors; an empty collection means all sensors."""
    return not sensors or set(scored.channels) <= set(sensors)


def uses_extra(detection: DetectionConfig) -> bool:
    """Whether any score of a study needs scikit-learn, which is installed."""
    kinds = (score.kind for score in detection.scores.values())
    return (detection.usual_scores or any(score_kind(kind).needs_extra for kind in kinds)) and has_extra()


_SEVERITIES = {
    "leakage.internal_flow": (MEAN_LEAKAGE_FLOW, "m^3/s"),
    "leakage.internal_coefficient": (LEAKAGE_COEFFICIENT, "m^3.5/kg^0.5"),
}
"""Parameter of the faults → variable with the true severity of each run, and its unit."""


Design = tuple[StudyRecords, tuple[Scored, ...]]
"""Records of one design of a study, and their scores; a measured study has one."""


def read_study(data: ExperimentData) -> tuple[Design, ...]:
    """Read the designs of a stored study.

    Severity is the true mean leakage flow over the whole record, or K_i if the faults are specified by it, or
    the level if the study requests this. Severity and scores of failed runs are NaN. Runs that are not
    computed yet are omitted.
    """
    measured = tuple(_measured(data))
    roles, is_there = stored_roles(data), np.asarray(data.columns[STATUS]).astype(str) != MISSING
    runs = [np.flatnonzero((roles.design_of_run == index) & is_there) for index in range(len(roles.designs))]
    return tuple(
        _design(data, measured, _records(data, roles, index, rows)) for index, rows in enumerate(runs)
    )


def _design(data: ExperimentData, measured: Sequence[Scored], records: StudyRecords) -> Design:
    """The scores that the sensors allow; remarks name the others."""
    detection, remarks = data.experiment.detection, [*records.remarks]
    raw = [replace(number, values=number.values[records.runs]) for number in measured]
    owned = [each for each in raw if within(each, detection.sensors)]
    numbers = [*owned, *changes_since_before(records, owned)]
    judged = [each for each in numbers if not detection.indicators or _label(each) in detection.indicators]
    without = [each for each in raw if not within(each, detection.sensors)]
    for label, channels in {_label(each): each.channels for each in without}.items():
        lacking = ", ".join(Channel(name).symbol for name in channels if name not in detection.sensors)
        remarks.append(f"{label} is left out: it needs {lacking}, not among detection.sensors")
    wanted = usual_scores(records, owned) if detection.usual_scores else {}
    for label, score in detection.scores.items():
        if any(belongs(each.name, name) for name in (*score.of, *score.by) for each in without):
            remarks.append(
                f"the score {label} is left out: it uses numbers that detection.sensors do not allow"
            )
        else:
            wanted[label] = score
    lacking_extra = [label for label, score in wanted.items() if score_kind(score.kind).needs_extra]
    if lacking_extra and not has_extra():
        wanted = {label: score for label, score in wanted.items() if label not in lacking_extra}
        remarks.append(f"omitted because they need the extra ({EXTRA}): {', '.join(lacking_extra)}")
    records = replace(records, remarks=tuple(remarks))
    return records, (*judged, *made_scores(records, numbers, wanted))


def _label(number: Scored) -> str:
    return number.name.partition(".")[0]


def stored_roles(data: ExperimentData) -> StudyTable:
    """Roles of the runs of a stored study."""
    if data.experiment.study is None:
        raise ReportError(f"{data.path}: the experiment has no 'study:'")
    roles = study_roles(data.experiment)
    if len(roles.of_run) != data.n_run:
        raise ReportError(
            f"{data.path}: contains {counted(data.n_run, 'run')}, but its study"
            f" has {len(roles.of_run):,}; sweep again"
        )
    return roles


def _records(data: ExperimentData, roles: StudyTable, design: int, rows: NDArray[np.intp]) -> StudyRecords:
    study = data.experiment.study
    assert study is not None
    parameter = study.faults.parameter if study.faults else "leakage.internal_flow"
    variable, unit = _SEVERITIES.get(parameter, (MEAN_LEAKAGE_FLOW, parameter_unit(parameter) or "1"))
    severity = np.asarray(data.columns[variable][rows], dtype=float)
    if study.faults and (study.faults.severity == "level" or parameter not in _SEVERITIES):
        nominal = np.array([population.severity for population in roles.populations])[roles.of_run[rows]]
        severity = np.where(np.isnan(severity), np.nan, nominal)
    return StudyRecords(
        roles.populations,
        roles.of_run[rows],
        severity,
        unit,
        None if roles.actuators is None else tuple(roles.actuators[row] for row in rows.tolist()),
        roles.designs[design],
        per_mean_flow=_per_mean_flow(data, rows),
        runs=rows,
    )


def _per_mean_flow(data: ExperimentData, rows: NDArray[np.intp]) -> float:
    """Flow of leaks at the reference drop per mean flow; NaN without leaks, or with a law that is laminar."""
    mean, coefficient = (
        np.asarray(data.columns[name][rows], dtype=float) for name in (MEAN_LEAKAGE_FLOW, LEAKAGE_COEFFICIENT)
    )
    if data.experiment.leakage.law == "laminar" or not (leaks := mean > 0.0).any():
        return float("nan")
    return float(np.median(flow_at_reference(coefficient[leaks]) / mean[leaks]))


def _measured(data: ExperimentData) -> Iterator[Scored]:
    """All outputs of the indicators, over all designs."""
    costs = read_costs(data.path.parent)
    for label, indicator in data.indicators.items():
        channels, note = needed_channels(indicator), _why_not_measured(data, label)
        for output in (output for output in indicator.outputs if output.is_score):
            values = data.columns.get(f"{label}.{output.name}", np.empty(0))
            for number in _numbers(f"{label}.{output.name}", values, channels, output) if values.size else ():
                yield replace(number, cost=costs.get(label), note=note, indicator=indicator.name)


def _numbers(name: str, values: Array, channels: tuple[str, ...], output: Output) -> Iterator[Scored]:
    """Each number of an output, whose values have the shape (n_record, …)."""
    for index in np.ndindex(values.shape[1:]):
        own = np.asarray(values[(slice(None), *index)], dtype=float)
        full = f"{name}{''.join(f'[{part}]' for part in index)}"
        yield Scored(full, own, channels, output.unit, output.direction)


def needed_channels(indicator: Indicator[Any]) -> tuple[str, ...]:
    """Channels that an indicator uses of a simulated machine, in the order of `hydrofdi.records.Channel`."""
    seen = indicator.channels | (indicator.optional_channels & SIGNAL_OF_CHANNEL.keys())
    return tuple(channel.value for channel in Channel if channel in seen)


def _why_not_measured(data: ExperimentData, label: str) -> str:
    """Most frequent reason why an indicator has no value for a record; empty if it has all values."""
    obstacles = data.columns.get(f"{label}{OBSTACLE}")
    if obstacles is None:
        return ""
    told = Counter(str(each) for each in obstacles[data.columns[STATUS] == "ok"] if each)
    if not told:
        return ""
    ((reason, count),) = told.most_common(1)
    return f"not measured in {count} of {counted(data.n_run, 'record')}: {reason}"


_DETAILS = tuple(f"dwt.d{level}" for level in range(1, 6))


def usual_scores(
    records: StudyRecords, scores: Sequence[Scored], *, tested_teach: bool = False
) -> dict[str, ScoreConfig]:
    """Default scores: for every set of sensors, a score of all numbers that these sensors give.

    ``mahalanobis`` from healthy fit records, and ``lda`` if there are faulty fit records; in addition the
    rule of the paper, the largest fall of d1 … d5.
    """
    teachers = records.chosen(Kind.FAULT, is_fit=True)
    if tested_teach:
        teachers += records.chosen(Kind.FAULT, is_fit=False)
    kinds = ["mahalanobis", *(["lda"] if teachers else [])]
    made: dict[str, ScoreConfig] = {}
    for sensors in dict.fromkeys(each.channels for each in scores if each.channels):
        names = [each.name for each in scores if each.channels and set(each.channels) <= set(sensors)]
        if len(names) > 1:
            title = " ".join(Channel(channel).symbol for channel in sensors)
            made |= {
                f"{kind}({title})": ScoreConfig.model_validate({"kind": kind, "of": names}) for kind in kinds
            }
    details = [each.name for each in scores if each.name in _DETAILS]
    if len(details) == len(_DETAILS):
        made["largest_change(d1 … d5)"] = ScoreConfig(kind="largest_change", of=details)
    return made


_TRAINING = (Kind.HEALTHY, Kind.FAULT)


def made_scores(
    records: StudyRecords,
    measured: Sequence[Scored],
    wanted: Mapping[str, ScoreConfig],
    *,
    tested_teach: bool = False,
) -> Iterator[Scored]:
    """Make the scores of a study, cross-fitted over its fit records.

    Fit records are scored by models that were not trained on their group, the others by the model of all fit
    records. ``compensated`` gives one score for each of its numbers. If the fit records do not support a
    score, it has no values, and its note says why.

    Parameters
    ----------
    measured : sequence of Scored
        Numbers that the scores combine.
    wanted : mapping of str to ScoreConfig
        Label → configuration of the score.
    tested_teach : bool
        Whether faulty test records are used to train scores that need faulty records, because there are no
        others. Each is then scored by a model that was not trained on its group, so groups are required.
    """
    for label, config in wanted.items():
        score, known = make_score(config.kind, config.options), {each.name: each for each in measured}
        combined = combined_numbers(config, [*known], label)
        for names in combined:
            numbers = [known[name] for name in names]
            name = label if len(combined) == 1 else f"{label}.{names[0]}"
            made = _made(records, name, score, numbers, tested_teach)
            if config.kind == "compensated":
                made = replace(made, unit=numbers[0].unit, direction=numbers[0].direction)
            yield replace(made, made_by=config.model_copy(update={"of": names[:1]}) if config.by else config)


def _made(
    records: StudyRecords, name: str, score: Score, numbers: Sequence[Scored], tested_teach: bool
) -> Scored:
    population = [records.populations[each] for each in records.of_record]
    is_faulty = np.array([each.kind is Kind.FAULT for each in population])
    is_fit = np.array([each.is_fit and each.kind in _TRAINING for each in population])
    is_shared = tested_teach and score.needs_faulty
    # Faulty test records may teach: each is scored by a model without its group.
    is_fit |= is_shared & is_faulty
    learning = is_fit & (score.needs_faulty | ~is_faulty)
    values = np.stack([each.values for each in numbers], axis=1)
    known = known_numbers(values[learning])
    kept = [numbers[index] for index in known]
    left_out = [
        f"{each.name} is left out: too many fit records lack it." for each in numbers if each not in kept
    ]
    notes = [score.caution, *left_out]
    try:
        if is_shared:
            why = f"the score {score.name} is cross-fitted on test records"
            if records.groups is None:
                raise NotStatedError(f"{why}: it needs groups, and no record has one")
            for kind, own in (("healthy", ~is_faulty), ("faulty", is_faulty)):
                n_group = len({records.groups[row] for row in np.flatnonzero(is_fit & own).tolist()})
                if n_group < 2:
                    needs = f"it needs at least two groups with {kind} records"
                    raise NotStatedError(f"{why}: {needs}, not {n_group}", 2)
        scores = cross_fitted_scores(score, values[:, known], is_faulty, records.groups, is_fit=is_fit)
    except NotStatedError as refusal:
        scores, notes = np.full(is_fit.size, np.nan), [f"{refusal}.", *left_out]
    used = {channel for each in kept for channel in each.channels}
    return Scored(
        name,
        scores,
        tuple(channel.value for channel in Channel if channel.value in used),
        direction=score.direction,
        cost=_cost(kept),
        note=" ".join(notes),
    )


def _cost(numbers: Sequence[Scored]) -> float | None:
    """Total cost of the indicators, each once; None if one was not measured."""
    costs = {each.name.partition(".")[0]: each.cost for each in numbers}
    known = [cost for cost in costs.values() if cost is not None]
    return sum(known) if len(known) == len(costs) else None


NONE = -1

NOTE = "minus its value in an earlier healthy record of the same actuator"


def changes_since_before(records: StudyRecords, scores: Sequence[Scored]) -> Iterator[Scored]:
    """Change of each score since the earlier record of the same group.

    This removes constants of an actuator, such as the null leakage of its valve or the bias of a sensor.
    There are no changes if there are no earlier records; they are NaN for records of a group without one.
    """
    before = _before(records)
    if before is None:
        return
    for scored in scores:
        earlier = np.where(before == NONE, np.nan, scored.values[before])
        yield replace(
            scored,
            name=f"{scored.name}{CHANGE}",
            values=scored.values - earlier,
            note="; ".join(filter(None, (scored.note, NOTE))),
        )


def _before(records: StudyRecords) -> NDArray[np.intp] | None:
    """Row of the earlier record of each record, or ``NONE``; None if there are no earlier records."""
    populations = [each for each in records.populations if each.kind is Kind.BEFORE]
    if records.groups is None or not populations:
        return None
    rows = np.concatenate([records.rows(each) for each in populations]).tolist()
    # Of several earlier records of an actuator the last counts.
    row_of_group = {records.groups[row]: row for row in rows}
    return np.array([row_of_group.get(group, NONE) for group in records.groups], dtype=np.intp)


SEED = 0
"""Seed of the random split of healthy records without groups."""


def measured_study(
    columns: Sequence[MeasuredOutput],
    measured: Iterable[RecordMeasures],
    healthy: Collection[str],
    severity: Mapping[str, float],
) -> Design:
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
    labels = dict.fromkeys(record.label for record in labelled)
    if not labels:
        raise ConfigError("no record has a label; set 'label:' in the description")
    if not healthy:
        raise ConfigError(f"{WHICH}; found {', '.join(map(repr, sorted(labels)[:10]))}")
    require_labels((("healthy", label) for label in healthy), labels)
    is_healthy = np.array([record.label in healthy for record in labelled])
    groups = None
    if any(record.group for record in labelled):  # a record without a group is its own group
        groups = tuple(record.group or f"record {record.record_id}" for record in labelled)
    has_groups = groups is not None and len({groups[row] for row in np.flatnonzero(is_healthy)}) > 1
    faults = {
        label: Population(label, Kind.FAULT, severity=severity.get(label, 0.0))
        for label in labels
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
    why = "no record has a group" if groups is None else "there is only one healthy group"
    split = (
        f"{why}: healthy records are split into random halves (seed {SEED}): one sets thresholds, the other"
        " is tested; false alarms on another unit or day are unknown"
    )
    remarks = [*([] if has_groups else [split]), *_confounded(groups, is_healthy)]
    records = StudyRecords(
        populations, of_record, severities, groups=groups, remarks=tuple(remarks), is_labelled=True
    )
    return records, tuple(_scores(columns, labelled))


WHICH = "which records are healthy? State it: --healthy LABEL, or 'healthy: [LABEL]' in the description"


def require_labels(stated: Iterable[tuple[str, str]], labels: Collection[str]) -> None:
    """Check that records have every label that is stated."""
    known = sorted({*labels} - {""})
    names = ", ".join(map(repr, known[:10])) or "none"
    mistakes = [
        Issue(f"no record has the label {label!r}; found {names}{similar(label, known)}", key)
        for key, label in stated
        if label not in labels
    ]
    if mistakes:
        raise ConfigError(mistakes)


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
        nothing = np.full(tuple(column.output.dims.values()), np.nan)
        values = np.array([record.values.get(column.name, nothing) for record in records], dtype=float)
        channels = tuple(channel.value for channel in column.channels)
        for number in _numbers(column.name, values, channels, column.output):
            if np.isfinite(number.values).any():
                yield replace(number, unit=column.unit)
