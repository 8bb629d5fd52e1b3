"""Reading of stored studies: records and scores of each design, and what is left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.run_table.expansion import study_roles
from hydrofdi.config.study.detection import DetectionConfig
from hydrofdi.config.study.table import StudyTable
from hydrofdi.detectors.registry import score_kind
from hydrofdi.detectors.scores.configuration import ScoreConfig, belongs
from hydrofdi.detectors.scores.features import EXTRA, has_extra
from hydrofdi.errors import ReportError
from hydrofdi.indicators import Indicator
from hydrofdi.physics.leakage import REFERENCE_DROP, internal_leakage_flow
from hydrofdi.records import Channel
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.folder.provenance import read_costs
from hydrofdi.store.layout.names import LEAKAGE_COEFFICIENT, MEAN_LEAKAGE_FLOW, OBSTACLE, STATUS
from hydrofdi.store.records import SIGNAL_OF_CHANNEL
from hydrofdi.studies.made_scores import made_scores, usual_scores
from hydrofdi.studies.paired import changes_since_before
from hydrofdi.studies.records import Scored, StudyRecords


def within(scored: Scored, sensors: Collection[str]) -> bool:
    """Whether a score needs only these sensors; an empty collection means all sensors."""
    return not sensors or set(scored.channels) <= set(sensors)


def makeable_within(score: ScoreConfig, numbers: Sequence[Scored], kept: Sequence[Scored]) -> bool:
    """Whether a score uses no number that is omitted because of its channels."""
    kept_names = {each.name for each in kept}
    lacking = [each.name for each in numbers if each.name not in kept_names]
    return not any(belongs(number, name) for name in (*score.of, *score.by) for number in lacking)


def sensor_remark(label: str, scored: Scored, sensors: Collection[str]) -> str:
    """Message why an indicator is omitted."""
    lacking = ", ".join(Channel(name).symbol for name in scored.channels if name not in sensors)
    return f"{label} is left out: it needs {lacking}, not among detection.sensors"


def asks_for_extra(detection: DetectionConfig) -> bool:
    """Whether any score of a study needs scikit-learn."""
    return detection.usual_scores or any(
        score_kind(score.kind).needs_extra for score in detection.scores.values()
    )


def makeable(wanted: Mapping[str, ScoreConfig]) -> tuple[dict[str, ScoreConfig], tuple[str, ...]]:
    """Scores that can be made, and a remark on those that cannot, if any."""
    lacking = [label for label, score in wanted.items() if score_kind(score.kind).needs_extra]
    if not lacking or has_extra():
        return dict(wanted), ()
    remark = f"omitted because they need the extra ({EXTRA}): {', '.join(lacking)}"
    return {label: score for label, score in wanted.items() if label not in lacking}, (remark,)


_SEVERITIES = {
    "leakage.internal_flow": (MEAN_LEAKAGE_FLOW, "m^3/s"),
    "leakage.internal_coefficient": (LEAKAGE_COEFFICIENT, "m^3.5/kg^0.5"),
}
"""Parameter of the faults → variable with the true severity of each run, and its unit."""

_DEPENDENT_DRAWS = (
    "Actuators are points of a {method}, so they are not independent: binomial limits do not apply to rates."
)
_METHODS = {"sobol": "Sobol sequence", "lhs": "Latin hypercube"}


@dataclass(frozen=True, eq=False)
class StudyDesign:
    """A design of a study with its measured scores.

    Attributes
    ----------
    records : StudyRecords
    scores : tuple of Scored
        All outputs of the evaluated indicators; with common actuators also their changes since the earlier
        record; and the scores made of these.
    """

    records: StudyRecords
    scores: tuple[Scored, ...]


def read_study(data: ExperimentData) -> tuple[StudyDesign, ...]:
    """Read the designs of a stored study.

    Severity is the true mean leakage flow over the whole record, or K_i if the faults are specified by it, or
    the level if the study requests this. Severity and scores of failed runs are NaN. Runs that are not
    computed yet are omitted.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    ConfigError
        A score uses numbers that are not measured.
    """
    roles, measured = stored_roles(data), tuple(_measured(data))
    return tuple(_design(data, roles, measured, design) for design in range(len(roles.designs)))


def study_designs(data: ExperimentData) -> Iterator[tuple[StudyRecords, NDArray[np.intp]]]:
    """Records of each design of a stored study, and their rows in the file.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    roles = stored_roles(data)
    for design in range(len(roles.designs)):
        yield _records(data, roles, design), _rows(data, roles, design)


def _design(data: ExperimentData, roles: StudyTable, measured: Sequence[Scored], design: int) -> StudyDesign:
    records, detection = _records(data, roles, design), data.experiment.detection
    raw = [replace(number, values=number.values[_rows(data, roles, design)]) for number in measured]
    owned = [each for each in raw if within(each, detection.sensors)]
    numbers = [*owned, *changes_since_before(records, owned)]
    judged = [each for each in numbers if not detection.indicators or _label(each) in detection.indicators]
    usual = usual_scores(records, owned) if detection.usual_scores else {}
    asked = {label: score for label, score in detection.scores.items() if makeable_within(score, raw, owned)}
    wanted, remarks = makeable(usual | asked)
    remarks = (*_sensor_remarks(data, raw), *remarks)
    records = replace(records, remarks=(*records.remarks, *remarks))
    return StudyDesign(records, (*judged, *made_scores(records, numbers, wanted)))


def _sensor_remarks(data: ExperimentData, numbers: Sequence[Scored]) -> Iterator[str]:
    """Remarks on indicators, and on scores made of them, that the sensors do not allow."""
    experiment, sensors = data.experiment, data.experiment.detection.sensors
    owned = [each for each in numbers if within(each, sensors)]
    without = {_label(each): each for each in numbers if not within(each, sensors)}
    for label, scored in without.items():
        yield sensor_remark(label, scored, sensors)
    for label, score in experiment.detection.scores.items():
        if not makeable_within(score, numbers, owned):
            yield f"the score {label} is left out: it uses numbers that detection.sensors do not allow"


def _label(number: Scored) -> str:
    return number.name.partition(".")[0]


def stored_roles(data: ExperimentData) -> StudyTable:
    """Roles of the runs of a stored study.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    if data.experiment.study is None:
        raise ReportError(f"{data.path}: the experiment has no 'study:'")
    roles = study_roles(data.experiment)
    if len(roles.of_run) != data.n_run:
        raise ReportError(
            f"{data.path}: contains {counted(data.n_run, 'run')}, but its study"
            f" has {len(roles.of_run):,}; sweep again"
        )
    return roles


def _rows(data: ExperimentData, roles: StudyTable, design: int) -> NDArray[np.intp]:
    """Rows of the computed runs of a design."""
    is_there = np.asarray(data.columns[STATUS]).astype(str) != MISSING
    return np.flatnonzero((roles.design_of_run == design) & is_there)


def _records(data: ExperimentData, roles: StudyTable, design: int) -> StudyRecords:
    study, rows = data.experiment.study, _rows(data, roles, design)
    assert study is not None
    parameter = study.faults.parameter if study.faults else "leakage.internal_flow"
    variable, unit = _SEVERITIES[parameter]
    severity = np.asarray(data.columns[variable][rows], dtype=float)
    if study.faults and study.faults.severity == "level":
        nominal = np.array([population.severity for population in roles.populations])[roles.of_run[rows]]
        severity = np.where(np.isnan(severity), np.nan, nominal)
    method = study.population.method
    remarks = () if method == "random" else (_DEPENDENT_DRAWS.format(method=_METHODS[method]),)
    return StudyRecords(
        roles.populations,
        roles.of_run[rows],
        severity,
        unit,
        None if roles.actuators is None else tuple(roles.actuators[row] for row in rows.tolist()),
        roles.designs[design],
        remarks,
        _per_mean_flow(data, rows),
    )


def _per_mean_flow(data: ExperimentData, rows: NDArray[np.intp]) -> float:
    """Flow of leaks at the reference drop per mean flow; NaN without leaks, or with a law that is laminar."""
    mean, coefficient = (
        np.asarray(data.columns[name][rows], dtype=float) for name in (MEAN_LEAKAGE_FLOW, LEAKAGE_COEFFICIENT)
    )
    if data.experiment.leakage.law == "laminar" or not (leaks := mean > 0.0).any():
        return float("nan")
    return float(np.median(internal_leakage_flow(REFERENCE_DROP, coefficient[leaks]) / mean[leaks]))


def _measured(data: ExperimentData) -> Iterator[Scored]:
    """All outputs of the indicators, over all designs."""
    experiment, costs = data.experiment, read_costs(data.path.parent)
    for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items():
        yield from _numbers(data, label, indicator, costs.get(label))


def _numbers(
    data: ExperimentData, label: str, indicator: Indicator[Any], cost: float | None
) -> Iterator[Scored]:
    channels = needed_channels(indicator)
    note = _why_not_measured(data, label)
    for output in indicator.outputs:
        values = data.columns.get(f"{label}.{output.name}")
        if values is None or not output.is_score:
            continue
        for place in np.ndindex(values.shape[1:]):
            index = "".join(f"[{part}]" for part in place)
            yield Scored(
                f"{label}.{output.name}{index}",
                np.asarray(values[(slice(None), *place)], dtype=float),
                channels,
                output.unit,
                output.long_name,
                output.direction,
                cost,
                note,
                indicator.name,
            )


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
