"""An experiment → the runs that it asks for, each with the healthy runs to compare it with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.run_table.rows import Expansion
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.config.study.table import StudyTable, populations, study_points, study_table
from hydrofdi.config.sweeps.points import Column, Points, count_points, multiplied, sweep_points
from hydrofdi.config.sweeps.sweep import SweepConfig, distinct_rows
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import counted

MOST_RUNS = 1_000_000
"""Points that one sweep may have."""


NO_RUN = -1
"""Stands for a run that does not exist."""


@dataclass(frozen=True, eq=False)
class RunTable:
    """The runs of an experiment in their order.

    Attributes
    ----------
    runs : Runs, length n_run
        The swept runs in the order of the sweep, scenario by scenario, then the healthy runs
        that the sweep itself lacks, then their replicates.
    axes : dict
        Dotted parameter → its different values in SI, in order of appearance.
    n_swept : int
        How many of the runs belong to the sweep.
    fixed_baseline, matched_baseline : array of int, shape (n_run,)
        Index of the healthy run that a run is compared with: under the baseline's conditions, and under
        its own conditions with the baseline's leakage.
    replicate_of : array of int, shape (n_run,)
        Index of the healthy run that a run is an independent replicate of; −1 for all others.
    study : StudyTable or None
        Who is who among the runs of a study, which have no baselines.
    """

    runs: Runs
    axes: dict[str, tuple[Any, ...]]
    n_swept: int
    fixed_baseline: NDArray[np.intp]
    matched_baseline: NDArray[np.intp]
    replicate_of: NDArray[np.intp]
    study: StudyTable | None = None


def expand_runs(experiment: ExperimentConfig) -> RunTable:
    """The runs of the experiment's sweep and their baselines.

    Points that ask for the same run are one run.

    Raises
    ------
    ConfigError
        A combination of swept values is impossible, or the sweep is empty or too large.
    """
    if experiment.study is not None:
        return _expand_study(experiment, experiment.study)
    _require_countable(count_points(experiment.ensemble) * count_points(experiment.sweep))
    scenarios, swept = (_block_points(experiment, section) for section in ("ensemble", "sweep"))
    points = multiplied(scenarios, swept)
    expansion = Expansion(experiment, points)
    rows = expansion.swept_rows()
    n_swept = rows.shape[1]
    rows, fixed, matched = expansion.with_baselines(rows)
    axes = {name: _appearing(points.columns[name]) for name in points.columns}
    of_run = np.full(len(fixed), NO_RUN)
    healthy = np.unique(np.concatenate([fixed, matched]))
    rows, of_replicate = expansion.with_replicates(rows, healthy)
    fixed, matched = (np.concatenate([baseline, of_replicate]) for baseline in (fixed, matched))
    return RunTable(
        expansion.runs(rows), axes, n_swept, fixed, matched, np.concatenate([of_run, of_replicate])
    )


def _expand_study(experiment: ExperimentConfig, study: StudyConfig) -> RunTable:
    """The runs of all populations, in each design."""
    n_record = sum(each.count for each in populations(study))
    _require_countable(count_points(experiment.sweep) * n_record, "study")
    designs = _block_points(experiment, "sweep")
    points = multiplied(designs, study_points(study))
    table = study_table(study, [designs.values(point) for point in range(designs.n_point)])
    expansion = Expansion(experiment, points, table)
    rows = expansion.swept_rows()
    n_run = rows.shape[1]
    if n_run < points.n_point:
        message = (
            f"draws {points.n_point - n_run:,} of {counted(points.n_point, 'record')}"
            " twice; let more of them vary"
        )
        raise ConfigError([Issue(message, "study.population")])
    none = np.full(n_run, NO_RUN)
    axes = {name: _appearing(points.columns[name]) for name in points.columns}
    return RunTable(expansion.runs(rows), axes, n_run, none, none, none, table)


def study_roles(experiment: ExperimentConfig) -> StudyTable:
    """Who is who among the runs of an experiment with a study; nothing is drawn."""
    assert experiment.study is not None
    designs = _block_points(experiment, "sweep")
    return study_table(experiment.study, [designs.values(point) for point in range(designs.n_point)])


def _require_countable(n_point: int, key: str = "sweep") -> None:
    if n_point > MOST_RUNS:
        raise ConfigError(
            [
                Issue(
                    f"{counted(n_point, 'run')} exceed the limit of {MOST_RUNS:,} per sweep, counted before"
                    f" 'where'; use fewer values, draw a sample, or split the sweep into several experiments",
                    key,
                )
            ]
        )


def _block_points(experiment: ExperimentConfig, section: str) -> Points:
    block: SweepConfig = getattr(experiment, section)
    points = sweep_points(block, experiment.nominal_parameters.value, section)
    if not points.n_point:
        raise ConfigError([Issue("no point satisfies 'where'", section)])
    return points


def _appearing(column: Column) -> tuple[Any, ...]:
    first, _ = distinct_rows([column.index], len(column.index))
    numbers = column.index[first].tolist()
    return tuple(dict.fromkeys(column.values[number] for number in numbers if number >= 0))
