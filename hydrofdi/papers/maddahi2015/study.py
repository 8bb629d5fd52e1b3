"""What the paper's study says of an experiment, computed once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.papers.maddahi2015.claims import ClaimResult, evaluate_claims
from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm, best_levels, sealed_alarms
from hydrofdi.papers.maddahi2015.deviations import Deviation, compare_reference
from hydrofdi.papers.maddahi2015.grid.arrangement import arrange_modes
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.papers.maddahi2015.scenarios.study import ScenarioStudy, study_scenarios
from hydrofdi.papers.maddahi2015.standings import Standing, standings
from hydrofdi.report.analysis import Analysis, analyze
from hydrofdi.store import ExperimentData

NAME = "maddahi2015"
"""What the key ``paper`` of its experiments says."""


@dataclass(frozen=True)
class Study(Analysis):
    """An experiment with its claims and controls."""

    grid: ModeGrid
    claims: tuple[ClaimResult, ...]
    sealed_alarms: tuple[SealedAlarm, ...]
    best_levels: tuple[BestLevel, ...]
    standings: tuple[Standing, ...]
    """How claims and controls stand over the start phases, as configured and settled."""
    deviations: tuple[Deviation, ...]
    scenarios: ScenarioStudy | None
    """Claims and controls over the scenarios, where the experiment is an ensemble with a grid of modes."""

    @property
    def guarded(self) -> tuple[ClaimResult, ...]:
        """The claims that the experiment file lists."""
        listed = self.data.experiment.claims
        return tuple(result for result in self.claims if result.claim.id in listed)


def is_study(experiment: ExperimentConfig) -> bool:
    """Whether an experiment is the paper's; results of earlier versions say so by their claims alone."""
    return experiment.paper == NAME or bool(experiment.claims or experiment.reference.cells)


def study_experiment(data: ExperimentData) -> Study:
    """Compute claims and controls of an experiment."""
    general, grid = analyze(data), arrange_modes(data)
    scenarios = study_scenarios(grid, data) if data.experiment.has_scenarios and not grid.lack else None
    feasible = None if scenarios is None else np.flatnonzero(scenarios.feasible).tolist()
    alarms, levels = sealed_alarms(general.table), best_levels(general.table)
    return Study(
        data=data,
        table=general.table,
        indicators=general.indicators,
        grid=grid,
        claims=evaluate_claims(grid, data, feasible),
        sealed_alarms=alarms,
        best_levels=levels,
        standings=standings(grid, data, *(((), ()) if scenarios else (alarms, levels)), feasible),
        deviations=compare_reference(general.table, data),
        scenarios=scenarios,
    )
