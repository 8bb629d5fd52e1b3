"""The sections ``study``, populations of actuators, and ``detection``, how their records are judged.

Who is who among the runs of a study follows from the experiment alone, whatever was drawn.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from hydrofdi.config.plant import is_foreign
from hydrofdi.config.request import parameter_unit
from hydrofdi.config.sweep import Axes, Points, one_after_the_other, side_by_side
from hydrofdi.config.values import Distribution, argument_values, drawn
from hydrofdi.detectors.rules import ChartConfig, Rules, ScoreConfig
from hydrofdi.evaluation.scores import NOTHING, Kind, Population
from hydrofdi.records import Channel
from hydrofdi.settings.messages import K_I_UNIT, convert, shown_quantity
from hydrofdi.settings.quantities import SI, Section

Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
FitCount = Annotated[int, Field(strict=True, ge=0, le=1_000_000)]

_VALUE_OR_DISTRIBUTION = {"type": ["number", "string", "boolean", "object"]}

Changes = Annotated[
    dict[str, Any], WithJsonSchema({"type": "object", "additionalProperties": _VALUE_OR_DISTRIBUTION})
]
"""Dotted parameter → its value in SI, or its distribution."""

SEAL = "leakage.internal_"
"""How the parameters begin that ``faults`` sets."""


class PopulationConfig(Section):
    """Variation between actuators and between records, without a fault."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of all draws of the study."""

    over: dict[str, Distribution] = Field(default_factory=dict)
    """Dotted parameter → its distribution, as in ``sample``: variation between actuators."""

    per_record: dict[str, Distribution] = Field(default_factory=dict)
    """Variation between records of one actuator: drawn for each record, also with ``pairing: common``.
    Unless the file names them, these are drawn: ``measurement.seed``; ``wavelet.phase``, where ``dwt`` is
    measured; ``input.seed``, where the input is pseudo-random; ``load.seed``, where the force is."""

    @model_validator(mode="after")
    def _parameters_are_drawn_once(self) -> Self:
        if twice := sorted(self.over.keys() & self.per_record.keys()):
            raise ValueError(f"{twice[0]} is drawn under both over and per_record")
        return self


class HealthyConfig(Section):
    """Numbers of records without a seal leak."""

    fit: Count
    """Records that thresholds and models are fitted to; they are never tested."""

    test: Count
    """Records that show the false-alarm rate."""

    shift: Count | None = None
    """Records of each shift; by default as many as ``test``."""

    confusion: Count | None = None
    """Records of each confusion; by default as many as ``test``."""


class FaultsConfig(Section):
    """Leaks to be found, or levels of a parameter of an FMU. ``leakage.internal_flow: [0.1 L/min, …]`` is
    short for ``over: {leakage.internal_flow: …}``.
    """

    over: Axes = Field(default_factory=dict)
    """``leakage.internal_flow``, ``leakage.internal_coefficient`` or ``plant.…`` → levels, in all forms of an
    axis."""

    each: Count
    """Test records of each level."""

    fit: FitCount = 50
    """Further records of each level, used to learn directions and supervised scores; they are never tested.
    0: directions are those stated by the indicators, or both."""

    severity: Literal["record", "level"] = "record"
    """Severity of a leak. ``record``: the mean leakage flow of its own record (or K_i, if it defines the
    levels). ``level``: its level, under the conditions of ``calibration`` and ``baseline``; for motions with
    little leakage, such as a rest test."""

    @property
    def parameter(self) -> str:
        """Dotted name of what varies."""
        return next(iter(self.over))

    @property
    def levels(self) -> list[float]:
        """Its values in SI, ascending."""
        return sorted(self.over[self.parameter])

    @model_validator(mode="after")
    def _leaks_across_the_seal(self) -> Self:
        if [name.startswith(SEAL) or is_foreign(name) for name in self.over] != [True]:
            raise ValueError(
                "a fault is one leak, leakage.internal_flow or leakage.internal_coefficient, or one parameter"
                " of an FMU, plant.…"
            )
        if 0.0 in self.levels:
            raise ValueError("a leak of 0 is not a fault; healthy.test already gives its alarm rate")
        return self


class SensitivityConfig(Section):
    """Further healthy records that show which parameter of ``population.over`` affects which score. They are
    not used for judging or for thresholds.
    """

    alone: FitCount = 0
    """Records in which one parameter varies and the others keep their values, for each parameter, and as many
    in which none varies; 0 or 49 and more. What differs from record to record differs in all of them."""

    @model_validator(mode="after")
    def _counts_carry_what_is_stated(self) -> Self:
        if 0 < self.alone < 49:
            raise ValueError(f"alone: a range of scores needs at least 49 records; found {self.alone}")
        return self


class StudyConfig(Section):
    """Populations of records: healthy, leaking, and healthy under conditions outside the fit records."""

    population: PopulationConfig = PopulationConfig()
    """Variation without a fault."""

    healthy: HealthyConfig
    """Records of actuators without a seal leak."""

    faults: FaultsConfig | None = None
    """Leaks to be found; without it, only false alarms are judged."""

    shifts: dict[str, Changes] = Field(default_factory=dict)
    """Name → parameters that are set, or drawn differently, in healthy actuators outside the fit records:
    other operating conditions. A value may be relative to the nominal one, such as ``+25 %``."""

    confusions: dict[str, Changes] = Field(default_factory=dict)
    """Name → the same for faults other than an internal leak."""

    sensitivity: SensitivityConfig = SensitivityConfig()
    """Which normal variation affects which score."""

    pairing: Literal["independent", "common"] = "independent"
    """``independent``: each record has its own actuator. ``common``: the same actuators are used healthy and
    with each leak, shift and confusion, separately for fit and test records. A healthy record of each is
    taken before, and the change of every score since then is judged beside it; what differs from record to
    record is drawn anew."""

    @property
    def names(self) -> list[str]:
        """Dotted parameters that differ between its records."""
        return list(dict.fromkeys(name for name, _ in study_values(self)))

    @model_validator(mode="after")
    def _seals_are_those_of_faults(self) -> Self:
        drawn = [self.population.over, self.population.per_record]
        for changes in (*drawn, *self.shifts.values(), *self.confusions.values()):
            for name in changes:
                if name.startswith(SEAL):
                    raise ValueError(f"{name} belongs under faults; these actuators have no seal leak")
        if twice := sorted(self.shifts.keys() & self.confusions.keys()):
            raise ValueError(f"{twice[0]!r} is both a shift and a confusion; give each its own name")
        return self

    @model_validator(mode="after")
    def _sensitivity_has_what_it_needs(self) -> Self:
        if self.sensitivity.alone and not self.population.over:
            raise ValueError("sensitivity: nothing varies; give population.over")
        return self


def study_values(study: StudyConfig) -> Iterator[tuple[str, Any]]:
    """The parameters that differ between records, each with every value or end of its distribution."""
    population, others = study.population, (*study.shifts.values(), *study.confusions.values())
    leaks: Mapping[str, Any] = study.faults.over if study.faults else {}
    drawn: list[Mapping[str, Any]] = [leaks, population.over, population.per_record]
    for changes in (*drawn, *others):
        for name, stated in changes.items():
            yield from ((name, value) for value in argument_values(stated))


class WatchedChart(ChartConfig):
    """A control chart: the watched output and the rule."""

    of: str
    """The watched output: ``label.output`` of an indicator that follows records sample by sample and stores
    its trace (option ``trace_duration``), such as ``weak_rls.leakage``."""


class OnlineConfig(Section):
    """Control charts on the traces of a study: false alarms over time, and the delay after the onset."""

    false_alarm_every: Annotated[
        list[Annotated[float, SI("s", above=0, usual=("1 min", "1 year"))]],
        BeforeValidator(lambda given: given if isinstance(given, list) else [given]),
        Field(min_length=1),
    ] = [24.0 * 3600.0]  # noqa: RUF012 (pydantic copies it)
    """Mean times between false alarms for which limits are set on healthy fit records [s]; one, or several
    for a curve of the delay."""

    charts: dict[str, WatchedChart] = Field(min_length=1)
    """Label → chart."""


class DetectionConfig(Rules):
    """Requirements on detectors, and the detectors that are judged."""

    indicators: list[str] = Field(default_factory=list)
    """Labels of the indicators to judge; by default all that are measured. If the file has no ``indicators``,
    these are also the ones measured, in any form that ``indicators`` accepts; ``all`` then means all cheap
    ones."""

    sensors: list[Channel] = Field(default_factory=list)
    """Channels of the machine, by symbol or name, such as ``[P1, P2, x, u]``; scores that need others are
    left out. By default every channel may be used."""

    scores: dict[str, ScoreConfig] = Field(default_factory=dict)
    """Label → score computed from several numbers, or one compensated number. A label has letters, digits,
    ``_`` and ``-``, begins with a letter, has at most 64 characters, and is not the label of an indicator."""

    usual_scores: bool = False
    """Whether to add, for each set of sensors that an indicator needs, a score of all numbers from these
    sensors: ``mahalanobis``, and ``lda`` if there are leaking fit records; also ``largest_change`` of
    ``dwt.d1`` … ``dwt.d5`` if they are measured."""

    online: OnlineConfig | None = None
    """Control charts on the traces of the records: false alarms over time, and the delay after the onset of a
    leak."""

    @field_validator("sensors")
    @classmethod
    def _each_once(cls, given: list[Channel]) -> list[Channel]:
        return list(dict.fromkeys(given))


_PATH = "study.population"


def study_points(study: StudyConfig) -> Points:
    """The points of a study, population by population."""
    return one_after_the_other([_points(study.population, each) for each in populations(study)])


def _points(config: PopulationConfig, each: Drawn) -> Points:
    columns = {
        name: drawn(name, law, _unit(config, each.actuators, name, each.count), f"{_PATH}.over.{name}")
        for name, law in config.over.items()
        if each.varied is None or name in each.varied
    }
    others = f"study.{each.population.kind.value}s.{each.population.name}"
    for path, stated in ((f"{_PATH}.per_record", config.per_record), (others, each.settings)):
        for name, value in stated.items():
            if isinstance(value, Mapping):
                unit = _unit(config, each.identity, name, each.count)
                columns[name] = drawn(name, dict(value), unit, f"{path}.{name}")
            else:
                columns[name] = [value] * each.count
    return side_by_side(columns)


def _unit(config: PopulationConfig, population: str, name: str, count: int) -> NDArray[np.float64]:
    digest = hashlib.sha256(f"{population}\n{name}".encode()).digest()
    key = tuple(np.frombuffer(digest, dtype="<u4").tolist())
    return np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=key)).random(count)


@dataclass(frozen=True)
class Drawn:
    """A population with its records.

    Attributes
    ----------
    actuators : str
        Which stream its actuators are drawn from; populations of one stream have the same ones.
    own : mapping
        Dotted parameter → value in SI, or distribution, in place of what is drawn in healthy actuators.
    varied : tuple of str or None
        What differs from actuator to actuator; None for all of ``population.over``.
    """

    population: Population
    count: int
    actuators: str
    own: Mapping[str, Any]
    varied: tuple[str, ...] | None = None

    @property
    def identity(self) -> str:
        """Name of the stream that all else is drawn from."""
        return _stream(self.population)

    @property
    def settings(self) -> dict[str, Any]:
        """Its own parameters, and a sealed piston unless it leaks."""
        is_leaking = any(name.startswith(SEAL) for name in self.own)
        return ({} if is_leaking else {"leakage.internal_coefficient": 0.0}) | dict(self.own)


@dataclass(frozen=True, eq=False)
class StudyTable:
    """The roles of the runs of a study: population, design (parameter → value in SI) and actuator.

    Runs of one design with the same name in `actuators` are of the same actuator; None if each has its own.
    """

    populations: tuple[Population, ...]
    of_run: NDArray[np.intp]
    designs: tuple[dict[str, Any], ...]
    design_of_run: NDArray[np.intp]
    actuators: tuple[str, ...] | None


def populations(study: StudyConfig) -> tuple[Drawn, ...]:
    """All populations of a study in the order of its runs."""
    healthy, alone = study.healthy, study.sensitivity.alone
    others = (
        (Kind.SHIFT, study.shifts, healthy.shift),
        (Kind.CONFUSION, study.confusions, healthy.confusion),
    )
    judged: list[tuple[Population, int, Mapping[str, Any]]] = [
        (_healthy(True), healthy.fit, {}),
        (_healthy(False), healthy.test, {}),
        *(_faulty(study.faults) if study.faults else ()),
        *(
            (Population(name, kind), count or healthy.test, settings)
            for kind, named, count in others
            for name, settings in named.items()
        ),
    ]
    is_common = study.pairing == "common"
    if is_common:  # a healthy record of every actuator that is judged, taken before
        judged[:0] = [
            (
                Population("before", Kind.BEFORE, is_fit),
                max(count for population, count, _ in judged if population.is_fit is is_fit),
                {},
            )
            for is_fit in (True, False)
        ]
    varied: dict[str, tuple[str, ...]] = {name: (name,) for name in study.population.over} | {NOTHING: ()}
    return (
        *(
            Drawn(population, count, _stream(_healthy(population.is_fit) if is_common else population), own)
            for population, count, own in judged
        ),
        *(
            Drawn(population, alone, _stream(population), {}, own)
            for name, own in (varied if alone else {}).items()
            for population in [Population(name, Kind.ALONE)]
        ),
    )


def _healthy(is_fit: bool) -> Population:
    return Population("healthy", Kind.HEALTHY, is_fit)


def _faulty(faults: FaultsConfig) -> Iterator[tuple[Population, int, Mapping[str, Any]]]:
    for level in faults.levels:
        for is_fit, count in ((True, faults.fit), (False, faults.each)):
            if count:
                name = fault_label(faults.parameter, level)
                yield Population(name, Kind.FAULT, is_fit, level), count, {faults.parameter: level}


def fault_label(parameter: str, level: float) -> str:
    """A level [SI] of what ``faults`` sets, such as ``0.1 L/min``."""
    if parameter == "leakage.internal_flow":
        return f"{convert(level, 'L/min'):.4g} L/min"
    if parameter.startswith(SEAL):
        return f"K_i {shown_quantity(level, K_I_UNIT)}"
    return f"{parameter.partition('.')[2]} {shown_quantity(level, parameter_unit(parameter) or '1')}".strip()


def condition_label(flow: float, coefficient: float, bulk_modulus: float) -> str:
    """Label of a run: its leakage as a flow, or as K_i (NaN), and EBM unless it is unknown (NaN)."""
    form = "leakage.internal_coefficient" if math.isnan(flow) else "leakage.internal_flow"
    level = coefficient if math.isnan(flow) else flow
    leakage = fault_label(form, level) if level else "sealed"
    return leakage if math.isnan(bulk_modulus) else f"{leakage}, {convert(bulk_modulus, 'MPa'):.4g} MPa"


def _stream(population: Population) -> str:
    kind, part = population.kind.value, "fit" if population.is_fit else "test"
    return f"{kind} {population.severity!r} {population.name} {part}"


def study_table(study: StudyConfig, designs: Sequence[dict[str, Any]]) -> StudyTable:
    """The roles of the runs of a study: all populations of the first design, then those of the next."""
    drawn = populations(study)
    counts = [each.count for each in drawn]
    of_run = np.repeat(np.arange(len(drawn)), counts)
    actuators = [f"{each.actuators} {index}" for each in drawn for index in range(each.count)]
    return StudyTable(
        tuple(each.population for each in drawn),
        np.tile(of_run, len(designs)),
        tuple(designs),
        np.repeat(np.arange(len(designs)), len(of_run)),
        None if study.pairing == "independent" else tuple(actuators) * len(designs),
    )
