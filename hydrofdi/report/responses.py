"""Responses: median and range of each feature over the values of each parameter that varies."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import expand_runs
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.config.sweep import count_points
from hydrofdi.config.values import shown_modulus, shown_parameter
from hydrofdi.evaluation.scores import comparable
from hydrofdi.report.document import Block
from hydrofdi.report.indicators import MeasuredIndicator
from hydrofdi.report.runs import Array, baseline_changes, litres_per_minute, signed, with_minus
from hydrofdi.settings.messages import HOLE, K_I_UNIT, convert, typeset
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.tables.table import Column, Table, finite

_MANY = 2_000

MOST_VALUES = 12
"""Most different values that are shown one by one; more are divided into fifths."""

_FIFTHS = 5

MANY_RUNS = 40
"""Groups of at least this many runs show the range from 5 to 95 %, others the smallest and the largest."""

RANGES = f"minimum and maximum, of {MANY_RUNS} runs or more 5 to 95 %"

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Quantiles that are shown in place of the numbers of many runs."""

AGAINST = {"fixed": "the fixed baseline", "matched": "the sealed actuator under the same conditions"}
"""What δ is taken against."""

_LEGEND = (
    "Each cell: the median of the runs with that value, and in brackets their range. δ: the fall of the RMS"
    " of a detail in percent of the healthy RMS, positive if it fell."
)
_GAP = "\N{NO-BREAK SPACE}"


def fifths(values: NDArray[np.float64]) -> list[tuple[float, float, NDArray[np.bool_]]]:
    """Values by size, in fifths of equal number: the ends of each, and which values belong to it."""
    edges = np.quantile(values, np.linspace(0.0, 1.0, _FIFTHS + 1))
    # Equal values get the same, largest rank, so that no value is in two fifths.
    rank = np.searchsorted(np.sort(values), values, side="right") - 1
    fifth = np.minimum(_FIFTHS * rank // max(values.size - 1, 1), _FIFTHS - 1)
    return [(float(edges[k]), float(edges[k + 1]), fifth == k) for k in range(_FIFTHS)]


@dataclass(frozen=True)
class Group:
    """Runs, shape (n_run,), with one value [SI], or with a range of values, whose `value` is None."""

    value: Any
    text: str
    rows: NDArray[np.bool_]


@dataclass(frozen=True)
class VariedParameter:
    """A parameter that varies: its runs by value in ascending order, by fifths if there are many values.

    `numbers`: the values of all runs in SI, NaN for runs that belong to no group; None if they are words.
    `text`: value → what people read under the header. `against`: the baseline of δ; empty without δ.
    """

    name: str
    header: str
    groups: tuple[Group, ...]
    numbers: NDArray[np.float64] | None
    text: Callable[[Any], str]
    against: str = ""
    responses: tuple[FeatureResponse, ...] = ()

    @property
    def drawn(self) -> NDArray[np.float64] | None:
        """The numbers if the groups are ranges of them."""
        return self.numbers if self.groups[0].value is None else None


def _swept_runs(data: ExperimentData) -> NDArray[np.bool_]:
    """Runs that the experiment requests; the others were added as healthy baselines.

    Many unconditional points are taken to be different: expanding is slow.
    """
    blocks = (data.experiment.ensemble, data.experiment.sweep)
    # The runs of the grid come first, baselines that were added after them.
    n_swept = math.prod(count_points(block) for block in blocks)
    if n_swept <= _MANY or any(block.where or block.union for block in blocks):
        n_swept = expand_runs(data.experiment).n_swept
    return np.arange(data.n_run) < n_swept


def _axis(data: ExperimentData, name: str, kept: NDArray[np.bool_]) -> VariedParameter:
    """A swept parameter over the runs that are kept."""
    text: Callable[[Any], str]
    if name in INTERNAL_LEAKAGE_FORMS:
        is_flow = name == "leakage.internal_flow"
        header = "Leakage [L/min]" if is_flow else f"K_i [{typeset(K_I_UNIT)}]"
        number = litres_per_minute if is_flow else "{:.4g}".format
        values, text = data.leakage_requests.tolist(), lambda value: number(value) if value else "sealed"
    else:
        values = data.values(name)
        is_modulus = name == "fluid.bulk_modulus"
        shown = shown_modulus() if is_modulus else shown_parameter(name, values)
        header, text = f"EBM [{shown.unit}]" if is_modulus else shown.header, shown.text
    different = dict.fromkeys(value for value, is_kept in zip(values, kept, strict=True) if is_kept)
    if not all(isinstance(value, int | float) for value in different):
        rows_of = {value: kept & np.array([each == value for each in values]) for value in different}
        words = (Group(v, HOLE if v is None else text(v), rows) for v, rows in rows_of.items())
        return VariedParameter(name, header, tuple(words), None, text)
    numbers = np.array([v if isinstance(v, int | float) else np.nan for v in values], dtype=float)
    numbers[~kept] = np.nan
    groups = [Group(value, text(value), numbers == value) for value in sorted(different)]
    if len(different) > MOST_VALUES:
        groups = []
        for low, high, members in fifths(numbers[kept]):
            rows = kept.copy()
            rows[kept] = members
            groups.append(Group(None, f"{text(low)} … {text(high)}", rows))
    return VariedParameter(name, header, tuple(group for group in groups if group.rows.any()), numbers, text)


@dataclass(frozen=True)
class RunFeature:
    """A number of each run, shape (n_run,), in a unit for people; `own_unit` is SI, or ``%`` of a change."""

    name: str
    unit: str
    values: Array
    own_unit: str = "%"

    def own(self, value: float) -> float:
        """A number in `unit`, in `own_unit`."""
        return value / convert(1.0, self.unit, self.own_unit)

    @property
    def header(self) -> str:
        """Name and unit."""
        return f"{self.name} [{typeset(self.unit)}]" if self.unit else self.name

    @property
    def is_change(self) -> bool:
        """Whether it is a change against a healthy run."""
        return self.name.startswith("δ")


@dataclass(frozen=True)
class GroupSpread:
    """Median and range of a feature over the runs of a group: 5 and 95 % of `MANY_RUNS` or more."""

    median: float
    low: float
    high: float
    n_run: int


@dataclass(frozen=True)
class FeatureResponse:
    """A feature over the groups of an axis."""

    feature: RunFeature
    over: tuple[GroupSpread, ...]

    @property
    def reach(self) -> float:
        """Range of the medians, as a share of the spread of the feature over all runs."""
        medians = np.array([spread.median for spread in self.over])
        known, values = medians[np.isfinite(medians)], self.feature.values
        whole = values[np.isfinite(values)]
        is_varied = known.size and np.ptp(comparable(whole))
        return float(comparable(np.ptp(known) / np.ptp(whole))) if is_varied else 0.0


@dataclass(frozen=True)
class ResponseStudy:
    """Responses over the runs that an experiment asks for, shape (n_run,), without added baselines.

    `details`: δ of the details against each baseline, and with the key ``""`` their RMS; `measured`: outputs
    of the other indicators.
    """

    axes: tuple[VariedParameter, ...]
    runs: NDArray[np.bool_]
    details: dict[str, tuple[RunFeature, ...]]
    measured: tuple[RunFeature, ...]


def study_responses(data: ExperimentData, indicators: tuple[MeasuredIndicator, ...] = ()) -> ResponseStudy:
    """The responses of an experiment.

    Leakage is compared with the sealed actuator under the same conditions, so that the leak alone is seen;
    all else with the fixed baseline. Where every run is its own baseline, the RMS stand in place of δ.
    """
    runs = _swept_runs(data)
    details = _details(data)
    measured = tuple(_indicator_features(indicators))
    axes = []
    for axis in (_axis(data, name, runs) for name in dict.fromkeys(data.experiment.varied_names)):
        if len(axis.groups) < 2:
            continue
        wanted = ("matched", "fixed") if axis.name.startswith("leakage.") else ("fixed",)
        against = next((name for name in wanted if details[name]), "")
        responses = (
            FeatureResponse(feature, tuple(spread(feature.values[group.rows]) for group in axis.groups))
            for feature in (*details[against], *measured)
        )
        axes.append(replace(axis, against=against, responses=tuple(responses)))
    return ResponseStudy(tuple(axes), runs, details, measured)


def _details(data: ExperimentData) -> dict[str, tuple[RunFeature, ...]]:
    """δ of the details of P_1 against each baseline that is another run, and their RMS."""
    features: dict[str, tuple[RunFeature, ...]] = {"": (), "fixed": (), "matched": ()}
    if not data.has_details:
        return features
    sizes = data.columns[names.DETAIL_RMS].T * convert(1.0, "kPa")
    features[""] = tuple(RunFeature(f"RMS of d{k}", "kPa", values, "Pa") for k, values in enumerate(sizes, 1))
    for name, changes in baseline_changes(data).items():
        rows = data.baselines[name]
        if ((rows != names.NO_BASELINE) & (rows != np.arange(data.n_run))).any():
            features[name] = tuple(RunFeature(f"δd{k}", "%", values) for k, values in enumerate(changes.T, 1))
    return features


def _indicator_features(indicators: tuple[MeasuredIndicator, ...]) -> Iterator[RunFeature]:
    """Outputs of the further indicators, except standard errors, that differ between any two runs."""
    for output in (output for measured in indicators for output in measured.outputs):
        known = output.means[np.isfinite(output.means)]
        if not output.output.name.endswith("_error") and known.size and np.ptp(comparable(known)) > 0.0:
            yield RunFeature(output.title, output.unit, output.shown(output.means), output.output.unit)


def spread(values: Array) -> GroupSpread:
    """Median and range of the finite numbers."""
    known = values[np.isfinite(values)]
    if not known.size:
        return GroupSpread(math.nan, math.nan, math.nan, 0)
    ends = (0.05, 0.95) if known.size >= MANY_RUNS else (0.0, 1.0)
    median, low, high = np.quantile(known, [0.5, *ends]).tolist()
    return GroupSpread(median, low, high, known.size)


def strongest_table(study: ResponseStudy, most: int) -> Table:
    """The features that move most as a share of their spread, at least one for each parameter."""
    pairs = [
        [(axis, each) for each in sorted(axis.responses, key=lambda each: -each.reach)] for axis in study.axes
    ]
    first, rest = [own[0] for own in pairs if own], [pair for own in pairs for pair in own[1:]]
    shown = [*first, *sorted(rest, key=lambda pair: -pair[1].reach)][:most]
    shown = [(axis, each) for axis, each in shown if each.reach > 0.0]
    texts = [
        (axis.groups[0].text.partition(" … ")[0], axis.groups[-1].text.rpartition(" … ")[2])
        for axis, _ in shown
    ]
    columns = [
        Column("Feature", [each.feature.header for _, each in shown], is_text=True),
        Column("over", [axis.header for axis, _ in shown], is_text=True),
        Column("from … to", [" … ".join(ends) for ends in texts], is_text=True),
    ]
    for title, at in (("there", 0), ("and there", -1)):
        medians = [_number(each.over[at].median, each.feature.is_change) for _, each in shown]
        columns.append(Column(title, medians))
    title = "Clearest responses, least hidden by what else varies: medians at the ends of each parameter"
    return Table(tuple(columns), title, "strongest")


def responses_block(study: ResponseStudy) -> Block | None:
    """A table for each axis."""
    tables = tuple(_axis_table(axis) for axis in study.axes if axis.responses)
    return Block("responses", "Responses", (_LEGEND,), tables, ("responses",)) if tables else None


def _axis_table(axis: VariedParameter) -> Table:
    features = [response.feature for response in axis.responses]
    against = f"; δ against {AGAINST[axis.against]}" if axis.against else ""
    columns = [Column("Feature", ["runs", *(feature.header for feature in features)], is_text=True)]
    for index, group in enumerate(axis.groups):
        over = [response.over[index] for response in axis.responses]
        known, count = max(each.n_run for each in over), int(group.rows.sum())
        runs = f"{known:,} of {count:,}" if known < count else f"{count:,}"
        texts = (_spread_text(o, f.is_change) for o, f in zip(over, features, strict=True))
        columns.append(Column(group.text, [runs, *texts]))
    several = any(group.rows.sum() > 1 for group in axis.groups)
    notes = (f"Brackets: {RANGES}.",) if several else ()
    return Table(tuple(columns), f"Over {axis.header}{against}", f"responses-{axis.name}", notes)


def _spread_text(spread: GroupSpread, is_change: bool) -> str:
    """``+3.7 [+1.9…+25.2]`` without a break; the median alone where all are equal."""
    median, low, high = (_number(value, is_change) for value in (spread.median, spread.low, spread.high))
    return median if low == high == median else f"{median} [{low}…{high}]".replace(" ", _GAP)


def _number(value: float, is_change: bool) -> str:
    return signed(value) if is_change else HOLE if math.isnan(value) else with_minus(f"{value:.4g}")


def responses_record(study: ResponseStudy) -> dict[str, Any]:
    """``varied`` and ``responses`` for JSON; numbers in SI, changes in percent."""
    return {
        "varied": [_varied(axis) for axis in study.axes],
        "responses": [_response(axis, response) for axis in study.axes for response in axis.responses],
    }


def _varied(axis: VariedParameter) -> dict[str, Any]:
    """A parameter: its values with their runs, or quantiles if there are many values."""
    counts = [int(group.rows.sum()) for group in axis.groups]
    named = {"name": axis.name, "unit": parameter_unit(axis.name) if axis.name in parameter_names() else None}
    if axis.drawn is None:
        return {**named, "values": [group.value for group in axis.groups], "n": counts}
    known = axis.drawn[np.isfinite(axis.drawn)]
    quantiles = dict(zip(map(str, QUANTILES), np.quantile(known, QUANTILES).tolist(), strict=True))
    return {**named, "quantiles": quantiles, "n": sum(counts)}


def _response(axis: VariedParameter, response: FeatureResponse) -> dict[str, Any]:
    feature = response.feature
    groups = [
        _ends(axis, group)
        | {name: finite(feature.own(getattr(spread, name))) for name in ("median", "low", "high")}
        | {"n": spread.n_run}
        for group, spread in zip(axis.groups, response.over, strict=True)
    ]
    return {
        "axis": axis.name,
        "baseline": axis.against or None if feature.is_change else None,
        "feature": feature.name,
        "unit": feature.own_unit,
        "groups": groups,
    }


def _ends(axis: VariedParameter, group: Group) -> dict[str, Any]:
    """The value of a group, or the smallest and the largest value of a fifth."""
    if axis.drawn is None:
        return {"value": group.value}
    values = axis.drawn[group.rows]
    return {"from": float(np.nanmin(values)), "to": float(np.nanmax(values))}
