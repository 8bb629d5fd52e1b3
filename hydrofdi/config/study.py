"""The ``study`` section: populations of actuators; and ``detection``: how their records are judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from hydrofdi.config.sweeps.sweep import Axes, CorrelationConfig, Distribution, argument_values, require_drawn
from hydrofdi.detectors.rules import ChartConfig, Rules
from hydrofdi.detectors.scores.configuration import ScoreConfig
from hydrofdi.records import Channel
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

    method: Literal["random", "sobol", "lhs"] = "random"
    """``random``: independent draws. Points of a Sobol sequence or a Latin hypercube depend on each other, so
    binomial limits of rates do not apply; the report says so."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of all draws of the study."""

    over: dict[str, Distribution] = Field(default_factory=dict)
    """Dotted parameter → its distribution, as in ``sample``: variation between actuators."""

    per_record: dict[str, Distribution] = Field(default_factory=dict)
    """Variation between records of one actuator: drawn for each record, also with ``pairing: common``.
    Unless the file names them, these are drawn: ``measurement.seed``; ``wavelet.phase``, where ``dwt`` is
    measured; ``input.seed``, where the input is pseudo-random; ``load.seed``, where the force is."""

    correlation: CorrelationConfig | None = None
    """Parameters of ``over`` that are drawn jointly; by default all are independent."""

    @model_validator(mode="after")
    def _parameters_are_drawn_once(self) -> Self:
        if twice := sorted(self.over.keys() & self.per_record.keys()):
            raise ValueError(f"{twice[0]} is drawn under both over and per_record")
        require_drawn(self.correlation, self.over)
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
    """Leaks to be found. ``leakage.internal_flow: [0.1 L/min, …]`` is short for ``over:
    {leakage.internal_flow: …}``.
    """

    over: Axes = Field(default_factory=dict)
    """``leakage.internal_flow`` or ``leakage.internal_coefficient`` → levels, in all forms of an axis."""

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
        if [name.startswith(SEAL) for name in self.over] != [True]:
            raise ValueError("a fault is one leak: leakage.internal_flow or leakage.internal_coefficient")
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
    leaks = study.faults.over if study.faults else {}
    yield from ((name, level) for name, levels in leaks.items() for level in levels)
    for changes in (population.over, population.per_record, *others):
        for name, value in changes.items():
            stated = argument_values(dict(value)) if isinstance(value, Mapping) else [value]
            yield from ((name, each) for each in stated)


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
