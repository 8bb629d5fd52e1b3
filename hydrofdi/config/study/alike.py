"""Records of a study that are the same although their draws differ: what differs has no effect."""

from __future__ import annotations

import numpy as np

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.idle_parameters import idle_draws
from hydrofdi.config.study.draws import study_points
from hydrofdi.config.study.table import populations
from hydrofdi.config.sweeps.distinct import distinct_rows
from hydrofdi.evaluation.populations import Kind

_JUDGED = (Kind.HEALTHY, Kind.FAULT, Kind.SHIFT, Kind.CONFUSION)


def records_alike(experiment: ExperimentConfig) -> list[str]:
    """A sentence where records of a population that is judged are others of it once more."""
    study = experiment.study
    if study is None:
        return []
    points, drawn = study_points(study), populations(study)
    idle = idle_draws(experiment, points.columns)
    columns = [column.index for name, column in points.columns.items() if name not in idle]
    n_record = n_alike = 0
    for each, rows in zip(drawn, _rows([each.count for each in drawn]), strict=True):
        if each.population.kind in _JUDGED:
            first, _ = distinct_rows([column[rows] for column in columns], each.count)
            n_record, n_alike = n_record + each.count, n_alike + each.count - len(first)
    if not n_alike:
        return []
    reason = f" ({', '.join(sorted(idle))} has no effect in any run)" if idle else ""
    return [
        f"study: {n_alike:,} of {n_record:,} records are others of their population once more{reason}: rates"
        " and intervals hold for independent records; let more vary, or give sensors noise"
    ]


def _rows(counts: list[int]) -> list[slice]:
    ends = np.cumsum(counts).tolist()
    return [slice(end - count, end) for end, count in zip(ends, counts, strict=True)]
