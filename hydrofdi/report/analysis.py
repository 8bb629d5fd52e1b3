"""Everything that a report says of an experiment, worked out once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.report.claims import Verdict, judge_claims
from hydrofdi.report.controls import BestLevel, SealedAlarm, best_levels, sealed_alarms
from hydrofdi.report.deviations import Deviation, compare_reference
from hydrofdi.report.external import ExternalStudy, study_external
from hydrofdi.report.modes import ModeGrid, arrange_modes
from hydrofdi.report.phases import Standing, standings
from hydrofdi.report.readings import ReadingsStudy, study_readings
from hydrofdi.report.replicates import ReplicateStudy, study_replicates
from hydrofdi.report.table import SensitivityTable, summarize_table
from hydrofdi.store import ExperimentData, names


@dataclass(frozen=True)
class Analysis:
    """An experiment with its table, verdicts and controls."""

    data: ExperimentData
    table: SensitivityTable
    grid: ModeGrid
    verdicts: tuple[Verdict, ...]
    sealed_alarms: tuple[SealedAlarm, ...]
    best_levels: tuple[BestLevel, ...]
    standings: tuple[Standing, ...]
    """How claims and controls stand over the start phases, as configured and settled."""
    deviations: tuple[Deviation, ...]
    external: ExternalStudy | None
    """What external leakage does to the approximation, where the experiment varies it."""
    readings: ReadingsStudy | None
    """Claims and controls over the readings, where the experiment is an ensemble with a grid of modes."""

    replicates: ReplicateStudy | None
    """Rows against healthy replicates, where the experiment asks for any."""

    @property
    def has_baseline(self) -> bool:
        """Whether there is a healthy run that the others are compared with."""
        return bool((self.data.fixed_baseline != names.NO_BASELINE).any())

    @property
    def guarded(self) -> tuple[Verdict, ...]:
        """The verdicts on the claims that the experiment file lists."""
        listed = self.data.experiment.claims
        return tuple(verdict for verdict in self.verdicts if verdict.claim.id in listed)


def analyze(data: ExperimentData) -> Analysis:
    """Work out tables, verdicts and controls of an experiment."""
    table, grid = summarize_table(data), arrange_modes(data)
    study = study_readings(grid, data) if data.experiment.has_readings and not grid.lack else None
    feasible = None if study is None else np.flatnonzero(study.feasible).tolist()
    alarms, levels = sealed_alarms(table), best_levels(table)
    return Analysis(
        data=data,
        table=table,
        grid=grid,
        verdicts=judge_claims(grid, data, feasible),
        sealed_alarms=alarms,
        best_levels=levels,
        standings=standings(grid, data, *(((), ()) if study else (alarms, levels)), feasible),
        deviations=compare_reference(table, data),
        external=study_external(table),
        readings=study,
        replicates=study_replicates(table, data),
    )
